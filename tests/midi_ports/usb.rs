//! An instrument on USB: a gadget of the kernel's, on a bus that the kernel makes up. It needs root, and modules that systems seldom have loaded.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use pacinian::io::midi_in::{MidiPorts, PortNews};
use pacinian::io::session::Session;

use crate::{skipped, wait};

/// The bus.
const BUS: &str = "dummy_udc.0";

struct Gadget(PathBuf);

impl Gadget {
    /// One that is not plugged in. `None` where the kernel has none, which is said.
    fn new() -> Option<Self> {
        let gadgets = Path::new("/sys/kernel/config/usb_gadget");
        if !gadgets.exists() || !Path::new("/sys/class/udc").join(BUS).exists() {
            skipped::skipped(
                "there is no USB gadget (modules dummy_hcd, usb_f_midi; tests/devices/kernel.sh has them)",
            );
            return None;
        }
        let gadget = Self(gadgets.join("pacinian-test"));
        let path = &gadget.0;
        for folder in ["", "strings/0x409", "configs/c.1", "functions/midi.usb0"] {
            fs::create_dir_all(path.join(folder)).unwrap();
        }
        for (file, text) in
            [("idVendor", "0x1d6b"), ("idProduct", "0x0104"), ("strings/0x409/product", "Test Keys")]
        {
            fs::write(path.join(file), text).unwrap();
        }
        let link = path.join("configs/c.1/midi.usb0");
        if !link.exists() {
            std::os::unix::fs::symlink(path.join("functions/midi.usb0"), link).unwrap();
        }
        Some(gadget)
    }

    fn plug(&self) {
        fs::write(self.0.join("UDC"), BUS).unwrap();
    }

    fn pull(&self) {
        fs::write(self.0.join("UDC"), "\n").unwrap();
    }

    /// What the instrument itself writes to.
    fn keys(&self) -> fs::File {
        let mut path = None;
        assert!(wait(10, || {
            let cards = fs::read_dir("/proc/asound").unwrap().flatten().map(|entry| entry.path());
            let id = |card: &PathBuf| fs::read_to_string(card.join("id")).unwrap_or_default();
            let card = cards.into_iter().find(|card| id(card).trim() == "fmidi");
            let number = card.map(|card| card.file_name().unwrap().to_string_lossy().replace("card", ""));
            path = number.map(|number| PathBuf::from(format!("/dev/snd/midiC{number}D0")));
            path.as_ref().is_some_and(|path| path.exists())
        }));
        OpenOptions::new().write(true).open(path.unwrap()).unwrap()
    }
}

impl Drop for Gadget {
    fn drop(&mut self) {
        let _ = fs::write(self.0.join("UDC"), "\n");
        let _ = fs::remove_file(self.0.join("configs/c.1/midi.usb0"));
        for folder in ["functions/midi.usb0", "configs/c.1", "strings/0x409", ""] {
            let _ = fs::remove_dir(self.0.join(folder));
        }
    }
}

/// Its keys sound; pulled while one is down, it is let go of at once; plugged in again, it is heard again.
pub fn a_cable_is_pulled_and_plugged_in(session: &Session) {
    let Some(gadget) = Gadget::new() else { return };
    let (news, heard) = channel();
    let told = Box::new(move |what: PortNews| drop(news.send(what)));
    let _ports = MidiPorts::listen(session.handle(), Some("Test Keys".into()), told).unwrap();
    let board = session.board();
    let next = |heard: &Receiver<PortNews>| {
        // Until there is one, all others have other names.
        let mut all = heard.iter().filter(|news| !matches!(news, PortNews::Unknown(_)));
        all.next().unwrap()
    };
    for round in 0..3 {
        gadget.plug();
        let opened = next(&heard);
        assert!(
            matches!(&opened, PortNews::Opened(name) if name.contains("Test Keys")),
            "{round}: {opened:?}"
        );
        let mut keys = gadget.keys();
        let sounds = wait(20, || {
            keys.write_all(&[0x90, 60, 100]).unwrap();
            std::thread::sleep(Duration::from_millis(100));
            board.voices.get() > 0
        });
        assert!(sounds, "{round}: nothing sounds");
        drop(keys);
        gadget.pull();
        let gone = next(&heard);
        assert!(matches!(&gone, PortNews::Gone(_)), "{round}: {gone:?}");
        assert!(wait(5, || board.voices.get() == 0), "{round}: it is not let go of");
        std::thread::sleep(Duration::from_millis(300));
    }
}
