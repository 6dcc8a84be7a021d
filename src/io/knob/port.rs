//! The serial port.

use std::io::{ErrorKind as Io, Read, Write};
use std::time::{Duration, Instant};

use serialport::{ErrorKind, SerialPort};

use super::line::{Line, LineError, Trouble};
use super::ports::{Usb, list};

/// Bits a second of a SmartKnob's line. Over USB alone an ODrive takes any.
pub const SMART_KNOB_BAUD: u32 = 921_600;

/// So long a device may take no bytes.
const PATIENCE: Duration = Duration::from_millis(100);

/// A serial port: eight bits, no parity, one stop bit, no flow control, for nobody else meanwhile.
pub struct Port {
    path: String,
    baud: u32,
    /// What was there at first; `None` if it is not on USB.
    usb: Option<Usb>,
    /// Whether to say that a terminal is ready.
    ready: bool,
    open: Option<Box<dyn SerialPort>>,
}

impl Port {
    /// Opens `path` with so many bits a second.
    ///
    /// # Errors
    /// Why it cannot be opened.
    pub fn open(path: &str, baud: u32) -> Result<Self, LineError> {
        let usb = list().into_iter().find(|found| found.path == path).and_then(|found| found.usb);
        let mut port = Self { path: path.into(), baud, usb, ready: false, open: None };
        port.open_again()?;
        Ok(port)
    }

    /// Says to the device that a terminal is ready (DTR), which some wait for. Not for a SmartKnob: on its board DTR and RTS reset it.
    #[must_use]
    pub fn say_ready(mut self) -> Self {
        self.ready = true;
        self.raise();
        self
    }

    /// Where the port was last.
    pub fn path(&self) -> &str {
        &self.path
    }

    fn raise(&mut self) {
        if let (true, Some(open)) = (self.ready, &mut self.open) {
            // A pseudo-terminal has no such wire, and goes without.
            let _ = open.write_data_terminal_ready(true);
        }
    }

    /// Where the device is now that was there at first.
    fn find(&self) -> Result<String, LineError> {
        let Some(before) = &self.usb else { return Ok(self.path.clone()) };
        let there = list();
        let is = |found: &&super::ports::Found| {
            found.usb.as_ref().is_some_and(|usb| usb.is(before, found.path == self.path))
        };
        if let Some(found) = there.iter().find(is) {
            return Ok(found.path.clone());
        }
        match there.iter().find(|found| found.path == self.path).and_then(|found| found.usb.as_ref()) {
            Some(other) => Err(LineError {
                kind: Trouble::Other,
                message: format!(
                    "{} is now {other}, and was {before}; no other is driven in its place",
                    self.path
                ),
                help: "plug it in again",
            }),
            None => Err(LineError {
                kind: Trouble::Missing,
                message: format!("{before} is not there"),
                help: "plug it in again",
            }),
        }
    }
}

/// What the system says when `path` cannot be opened.
fn refused(path: &str, error: &serialport::Error) -> LineError {
    let (kind, help) = match error.kind() {
        ErrorKind::Io(Io::PermissionDenied) => (
            Trouble::Forbidden,
            "on Linux, add yourself to the group dialout: sudo usermod -aG dialout $USER, then log in again",
        ),
        ErrorKind::Io(Io::NotFound) => {
            (Trouble::Missing, "plug the device in; `pacinian devices` lists what is there")
        }
        ErrorKind::NoDevice => (
            Trouble::Busy,
            "close the program that has it; where that is none, plug the device out and in again",
        ),
        _ => (Trouble::Failed, "see whether it is a serial port; `pacinian devices` lists what is there"),
    };
    LineError { kind, message: format!("{path}: {error}"), help }
}

/// Whether it is the terminal that this program is spoken to in: who opened that as a serial port would take the person's keys for a device's words,
/// and leave it without echo.
#[cfg(unix)]
fn is_own_terminal(path: &str) -> bool {
    use std::io::IsTerminal;
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    let device = |path: &str| {
        let about = std::fs::metadata(path).ok()?;
        about.file_type().is_char_device().then(|| about.rdev())
    };
    let Some(this) = device(path) else { return false };
    let own = [
        ("/dev/tty", true),
        ("/dev/stdin", std::io::stdin().is_terminal()),
        ("/dev/stdout", std::io::stdout().is_terminal()),
        ("/dev/stderr", std::io::stderr().is_terminal()),
    ];
    own.iter().any(|(path, is_terminal)| *is_terminal && device(path) == Some(this))
}

impl Line for Port {
    fn read(&mut self, to: &mut [u8], wait: Duration) -> Result<usize, String> {
        let open = self.open.as_mut().ok_or("it is closed")?;
        let read = open.set_timeout(wait).map_err(std::io::Error::from).and_then(|()| open.read(to));
        match read {
            Ok(0) => {}
            Ok(count) => return Ok(count),
            Err(error) if matches!(error.kind(), Io::TimedOut | Io::Interrupted | Io::WouldBlock) => {
                return Ok(0);
            }
            Err(error) => {
                self.open = None;
                return Err(error.to_string());
            }
        }
        self.open = None;
        Err("it was hung up".into())
    }

    fn write(&mut self, mut bytes: &[u8]) -> Result<(), String> {
        let open = self.open.as_mut().ok_or("it is closed")?;
        let until = Instant::now() + PATIENCE;
        let failed = loop {
            if bytes.is_empty() {
                return Ok(());
            }
            let wait = until.saturating_duration_since(Instant::now());
            match open.set_timeout(wait).map_err(std::io::Error::from).and_then(|()| open.write(bytes)) {
                Ok(count) => bytes = &bytes[count..],
                Err(error) if error.kind() == Io::Interrupted => {}
                Err(error) if error.kind() == Io::TimedOut => break "it takes no bytes".into(),
                Err(error) => break error.to_string(),
            }
            if wait.is_zero() && !bytes.is_empty() {
                break "it takes no bytes".into();
            }
        };
        self.open = None;
        Err(failed)
    }

    fn open_again(&mut self) -> Result<(), LineError> {
        self.open = None;
        let path = self.find()?;
        #[cfg(unix)]
        if is_own_terminal(&path) {
            return Err(LineError {
                kind: Trouble::Other,
                message: format!("{path} is the terminal that this program runs in"),
                help: "name the port of the device; `pacinian devices` lists what is there",
            });
        }
        let builder = serialport::new(&path, self.baud).timeout(Duration::ZERO);
        let open = builder.open().map_err(|error| refused(&path, &error))?;
        self.path = path;
        self.open = Some(open);
        self.raise();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Port, refused};
    use crate::io::knob::line::Trouble;
    use serialport::{Error, ErrorKind};

    #[test]
    fn each_trouble_has_its_fix() {
        let denied =
            refused("/dev/x", &Error::new(ErrorKind::Io(std::io::ErrorKind::PermissionDenied), "no"));
        assert_eq!((denied.kind, denied.exit_code()), (Trouble::Forbidden, 77));
        assert!(denied.message.contains("/dev/x") && denied.help.contains("usermod -aG dialout $USER"));
        let busy = refused("/dev/x", &Error::new(ErrorKind::NoDevice, "locked"));
        assert_eq!((busy.kind, busy.exit_code()), (Trouble::Busy, 75));
        let missing = Port::open("/dev/no-such-port", 115_200).err().unwrap();
        assert_eq!((missing.kind, missing.exit_code()), (Trouble::Missing, 69));
    }
}
