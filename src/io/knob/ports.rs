//! Which serial ports there are.

use std::fmt;

use serialport::{SerialPortInfo, SerialPortType};

/// A serial port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// How it is opened: `/dev/ttyACM0`, `COM3`.
    pub path: String,
    /// What it says of itself, where it is on USB.
    pub usb: Option<Usb>,
    /// Which knob it may be.
    pub knob: Option<Knob>,
}

/// What a USB device says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Usb {
    /// Vendor.
    pub vendor: u16,
    /// Product of that vendor.
    pub product: u16,
    /// Serial number.
    pub serial: Option<String>,
    /// The product by name.
    pub name: Option<String>,
}

/// Knobs that are known by what they say on USB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knob {
    /// An ODrive, by its own product number.
    ODrive,
    /// A chip that SmartKnobs have, and much else too.
    PerhapsSmartKnob,
}

/// Vendor, product and knob. ODrive: the descriptor in its firmware. SmartKnob: the ids that its own software looks for, which are of
/// the bridge CH340 and of any ESP32-S3.
const KNOWN: [(u16, u16, Knob); 3] = [
    (0x1209, 0x0d32, Knob::ODrive),
    (0x1a86, 0x7523, Knob::PerhapsSmartKnob),
    (0x303a, 0x1001, Knob::PerhapsSmartKnob),
];

impl Usb {
    /// The knob that it may be.
    pub fn knob(&self) -> Option<Knob> {
        let of = |known: &&(u16, u16, Knob)| (known.0, known.1) == (self.vendor, self.product);
        KNOWN.iter().find(of).map(|known| known.2)
    }

    /// Whether it is the same device as one seen before. Two without serial numbers are the same if they are of a kind and on one `path`.
    pub(super) fn is(&self, before: &Self, same_path: bool) -> bool {
        (self.vendor, self.product, &self.serial) == (before.vendor, before.product, &before.serial)
            && (self.serial.is_some() || same_path)
    }
}

impl fmt::Display for Usb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04x}:{:04x}", self.vendor, self.product)?;
        self.name.as_ref().map_or(Ok(()), |name| write!(f, " {name}"))?;
        self.serial.as_ref().map_or(Ok(()), |serial| write!(f, " ({serial})"))
    }
}

impl fmt::Display for Knob {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ODrive => "ODrive",
            Self::PerhapsSmartKnob => "perhaps a SmartKnob",
        })
    }
}

impl From<SerialPortInfo> for Found {
    fn from(info: SerialPortInfo) -> Self {
        let usb = match info.port_type {
            SerialPortType::UsbPort(usb) => {
                Some(Usb { vendor: usb.vid, product: usb.pid, serial: usb.serial_number, name: usb.product })
            }
            _ => None,
        };
        Self { path: info.port_name, knob: usb.as_ref().and_then(Usb::knob), usb }
    }
}

/// All serial ports, by their paths. None on a system that cannot say.
pub fn list() -> Vec<Found> {
    // Where Linux has no such folder, as in some containers, the crate panics.
    if cfg!(target_os = "linux") && !std::path::Path::new("/sys/class/tty").is_dir() {
        return Vec::new();
    }
    let mut found: Vec<Found> =
        serialport::available_ports().unwrap_or_default().into_iter().map(Found::from).collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

#[cfg(test)]
mod tests {
    use super::{Found, Knob, Usb, list};
    use serialport::{SerialPortInfo, SerialPortType, UsbPortInfo};

    fn found(vid: u16, pid: u16) -> Found {
        let (serial_number, manufacturer, product) = (Some("3".into()), None, Some("CDC".into()));
        let usb = UsbPortInfo { vid, pid, serial_number, manufacturer, product };
        SerialPortInfo { port_name: "/dev/ttyACM0".into(), port_type: SerialPortType::UsbPort(usb) }.into()
    }

    #[test]
    fn knobs_are_known_by_what_they_say() {
        assert_eq!(found(0x1209, 0x0d32).knob, Some(Knob::ODrive));
        assert_eq!(found(0x1a86, 0x7523).knob, Some(Knob::PerhapsSmartKnob));
        assert_eq!(found(0x303a, 0x1001).knob, Some(Knob::PerhapsSmartKnob));
        assert_eq!(found(0x303a, 0x1002).knob, None);
        assert_eq!(found(0x1209, 0x0d32).usb.unwrap().to_string(), "1209:0d32 CDC (3)");
        list();
    }

    #[test]
    fn a_device_is_itself_and_no_other() {
        let usb = found(1, 2).usb.unwrap();
        let other = Usb { serial: Some("4".into()), ..usb.clone() };
        let nameless = Usb { serial: None, ..usb.clone() };
        assert!(usb.is(&usb, false) && !usb.is(&other, true) && !usb.is(&nameless, true));
        assert!(nameless.is(&nameless, true) && !nameless.is(&nameless, false));
    }
}
