//! Which devices there are, and what they offer.

use cpal::traits::{DeviceTrait, HostTrait};
use cpal::{Device, Host, SupportedBufferSize, SupportedStreamConfigRange};

use super::failure::{DeviceError, Trouble};
use crate::text::nearest::nearest;

/// A device that there is.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Names it for good, with its host: `alsa:hw:CARD=Device,DEV=0`.
    pub id: String,
    /// For people.
    pub name: String,
    /// Whether it is the one that the system plays on where nobody says anything.
    pub default: bool,
    /// What it offers to be played on.
    pub output: Option<Offer>,
    /// What it offers to be heard.
    pub input: Option<Offer>,
}

/// What a device offers in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// Numbers of channels, ascending.
    pub channels: Vec<u16>,
    /// Frames a second, least and most.
    pub rates: (u32, u32),
    /// Frames a block, least and most, where it says.
    pub blocks: Option<(u32, u32)>,
    /// Names of sample formats.
    pub formats: Vec<String>,
}

impl Offer {
    fn of(ranges: impl Iterator<Item = SupportedStreamConfigRange>) -> Option<Self> {
        let mut offer: Option<Self> = None;
        for range in ranges {
            let rates = (range.min_sample_rate(), range.max_sample_rate());
            let blocks = match range.buffer_size() {
                SupportedBufferSize::Range { min, max } => Some((*min, *max)),
                SupportedBufferSize::Unknown => None,
            };
            let (channels, format) = (range.channels(), range.sample_format().to_string());
            let all = offer.get_or_insert_with(|| Self { channels: vec![], rates, blocks, formats: vec![] });
            all.rates = (all.rates.0.min(rates.0), all.rates.1.max(rates.1));
            all.blocks = match (all.blocks, blocks) {
                (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
                (a, b) => a.or(b),
            };
            if let Err(place) = all.channels.binary_search(&channels) {
                all.channels.insert(place, channels);
            }
            if !all.formats.contains(&format) {
                all.formats.push(format);
            }
        }
        offer
    }
}

/// The hosts that this program was built with, the best first, each with whether it runs.
pub fn hosts() -> Vec<(String, Option<Host>)> {
    let open = |id: &cpal::HostId| (id.to_string(), cpal::host_from_id(*id).ok());
    cpal::ALL_HOSTS.iter().map(open).collect()
}

/// All devices of a host.
///
/// # Errors
/// A host that does not answer.
pub fn devices(host: &Host) -> Result<Vec<(Device, Found)>, DeviceError> {
    let id = |device: &Device| device.id().map_or_else(|_| device.to_string(), |id| id.to_string());
    let default = host.default_output_device().as_ref().map(id);
    let all = host.devices().map_err(|error| DeviceError::of("the sound system", &error))?;
    let found = all.map(|device| {
        let id = id(&device);
        let found = Found {
            name: device.to_string(),
            default: default.as_ref() == Some(&id),
            output: device.supported_output_configs().ok().and_then(Offer::of),
            input: device.supported_input_configs().ok().and_then(Offer::of),
            id,
        };
        (device, found)
    });
    Ok(found.collect())
}

/// The id of the device that the system records from where nobody says anything.
pub fn default_input() -> Option<String> {
    let id = |host: Host| host.default_input_device().and_then(|device| device.id().ok());
    hosts().into_iter().filter_map(|(_, host)| host).find_map(id).map(|id| id.to_string())
}

/// The device that a person means by `name`: its id, its name, or a part of its name that no other has. Only those for which `fits`
/// says yes are looked at.
///
/// # Errors
/// None of that name, or several.
pub fn find<'a, D>(
    all: &'a [(D, Found)],
    name: &str,
    fits: impl Fn(&Found) -> bool,
) -> Result<&'a (D, Found), DeviceError> {
    let fitting = || all.iter().filter(|(_, found)| fits(found));
    let exact =
        fitting().find(|(_, f)| f.id == name || f.id.split_once(':').is_some_and(|(_, id)| id == name));
    if let Some(found) = exact.or_else(|| fitting().find(|(_, found)| found.name == name)) {
        return Ok(found);
    }
    let lower = name.to_lowercase();
    let part = |found: &Found| {
        found.name.to_lowercase().contains(&lower) || found.id.to_lowercase().contains(&lower)
    };
    let mut parts = fitting().filter(|(_, found)| part(found));
    match (parts.next(), parts.next()) {
        (Some(found), None) => Ok(found),
        (Some((_, a)), Some((_, b))) => {
            Err(DeviceError::new(Trouble::Missing, format!("`{name}` may be {} or {}", a.id, b.id))
                .help("give more of its name"))
        }
        _ => {
            let what = format!("there is no device `{name}`");
            let names: Vec<&str> = fitting().map(|(_, found)| found.name.as_str()).collect();
            let near = nearest(name, names.iter().copied());
            let there = match names.as_slice() {
                [] => "no device is there at all".to_string(),
                names => format!("there is: {}", names.join(", ")),
            };
            let help = near.map_or(there, |near| format!("did you mean `{near}`?"));
            Err(DeviceError::new(Trouble::Missing, what).help(help))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Found, find};

    fn found(id: &str, name: &str) -> ((), Found) {
        ((), Found { id: id.into(), name: name.into(), default: false, output: None, input: None })
    }

    #[test]
    fn a_device_is_found_by_what_people_call_it() {
        let all = [
            found("alsa:hw:CARD=Device,DEV=0", "USB Sound Device, USB Audio"),
            found("alsa:hw:CARD=PCH,DEV=0", "HDA Intel PCH"),
            found("alsa:pipewire", "PipeWire Sound Server"),
        ];
        let id = |name: &str| find(&all, name, |_| true).map(|(_, found)| found.id.clone());
        assert_eq!(id("alsa:pipewire").unwrap(), "alsa:pipewire");
        assert_eq!(id("hw:CARD=PCH,DEV=0").unwrap(), "alsa:hw:CARD=PCH,DEV=0");
        assert_eq!(id("usb").unwrap(), "alsa:hw:CARD=Device,DEV=0");
        assert_eq!(id("HDA Intel PCH").unwrap(), "alsa:hw:CARD=PCH,DEV=0");
        let both = id("sound").unwrap_err();
        assert!(both.what.contains("CARD=Device") && both.what.contains("alsa:pipewire"), "{both}");
        let none = id("HDA Intel PHC").unwrap_err();
        assert!(none.to_string().contains("did you mean `HDA Intel PCH`?"), "{none}");
        assert_eq!(none.kind.exit_code(), 69);
        let empty: [((), Found); 0] = [];
        assert!(find(&empty, "x", |_| true).unwrap_err().to_string().contains("no device is there"));
    }
}
