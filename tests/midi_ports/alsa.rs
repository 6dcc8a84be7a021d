//! ALSA's sequencer, and instruments that are its clients.

use std::ffi::CString;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use alsa::Direction;
use alsa::seq::{Addr, ClientIter, Event, EventType, MidiEvent, PortCap, PortType, Seq};
use pacinian::io::midi_in::PortNews;
use pacinian::io::session::Session;

use crate::{Heard, goes, opens, playing, skipped, usb, wait};

/// Frames that the session is asked for at a time: an emulated processor, where the test may run, is late by some 5 ms now and then.
pub const BLOCK: u32 = 1024;

/// What share of the time the virtual card may leave out while it is flooded: an emulated processor does not keep up.
pub const BEHIND: f64 = 0.75;

/// The kernel's.
pub struct System;

impl System {
    /// `None` where there is none, which is said.
    pub fn start() -> Option<Self> {
        if std::path::Path::new("/dev/snd/seq").exists() {
            return Some(Self);
        }
        skipped::skipped(
            "there is no /dev/snd/seq (sudo modprobe snd-seq, or tests/devices/kernel.sh, which boots one)",
        );
        None
    }

    /// What no other system has.
    pub fn what_is_its_own(&mut self, session: &Session, heard: &Receiver<PortNews>) {
        whatever_comes_is_read_or_counted(session, heard);
        one_that_somebody_disconnects_is_let_go_of(session, heard);
        usb::a_cable_is_pulled_and_plugged_in(session);
    }
}

/// A client with one port.
pub struct Instrument {
    seq: Seq,
    port: i32,
}

impl Instrument {
    /// A port of that name.
    pub fn new(name: &str) -> Self {
        let seq = Seq::open(None, Some(Direction::Playback), false).unwrap();
        seq.set_client_name(c"somebody").unwrap();
        let name = CString::new(name).unwrap();
        let caps = PortCap::READ | PortCap::SUBS_READ;
        let port = seq.create_simple_port(&name, caps, PortType::MIDI_GENERIC).unwrap();
        Self { seq, port }
    }

    /// Sends it at once: a message, or a piece of a system exclusive.
    pub fn send(&mut self, bytes: &[u8]) {
        self.send_to(None, bytes);
    }

    /// The same to somebody who did not ask for it.
    fn send_to(&mut self, whom: Option<Addr>, bytes: &[u8]) {
        let mut coder = MidiEvent::new(64).unwrap();
        let mut event = match bytes.first() {
            None | Some(0..0x80 | 0xF0 | 0xF7) => Event::new_ext(EventType::Sysex, bytes),
            _ => coder.encode(bytes).unwrap().1.unwrap(),
        };
        event.set_source(self.port);
        event.set_direct();
        match whom {
            None => event.set_subs(),
            Some(addr) => event.set_dest(addr),
        }
        // Where nobody listens, or has no room, it is lost, as on any cable.
        let _ = self.seq.event_output_direct(&mut event);
    }
}

/// Where pacinian hears.
fn ears() -> Addr {
    let seq = Seq::open(None, None, false).unwrap();
    let client = ClientIter::new(&seq).find(|client| client.get_name().is_ok_and(|name| name == "pacinian"));
    Addr { client: client.unwrap().get_client(), port: 0 }
}

/// However late it is fetched, a message came when the kernel had it: while it was sent. Whoever hears is slow, so that all but the first wait for up to
/// half a second.
pub fn what_came_has_its_time() {
    let mut heard = Heard::by(Duration::from_millis(30));
    let mut sent = Vec::new();
    for _ in 0..20 {
        let before = Instant::now();
        heard.keys.send(&[0xF8]);
        sent.push((before, Instant::now()));
        std::thread::sleep(Duration::from_millis(5));
    }
    let times = heard.times(sent.len());
    // Two clocks are compared by readings one after the other, between which an emulated machine may stand still.
    let slack = Duration::from_millis(4);
    let within = |(at, (before, after)): (&Instant, &(Instant, Instant))| {
        *at + slack >= *before && *at <= *after + slack
    };
    let within = times.iter().zip(&sent).filter(|pair| within(*pair)).count();
    assert!(within >= 15, "{within} of {} came while they were sent", sent.len());
}

/// An empty system exclusive, one of 40,000 bytes at once, one of 80,000, one that never ends, and what is sent past all connections.
fn whatever_comes_is_read_or_counted(session: &Session, heard: &Receiver<PortNews>) {
    let mut keys = Instrument::new("keys");
    opens(heard);
    let board = session.board();
    assert!(wait(20, || {
        keys.send(&[0x90, 60, 100]);
        std::thread::sleep(Duration::from_millis(50));
        board.voices.get() > 0
    }));
    let counts = || (board.midi.skipped.get(), board.midi.gaps.get());
    let (skipped, gaps) = counts();
    keys.send(&[]);
    let long: Vec<u8> = [0xF0].into_iter().chain([1; 40_000]).chain([0xF7]).collect();
    keys.send(&long);
    assert!(wait(10, || counts() == (skipped + 1, gaps)), "{:?} after {:?}", counts(), (skipped, gaps));
    // More than the kernel holds: it drops it, and all that waits with the next that comes.
    let gigantic: Vec<u8> = [0xF0].into_iter().chain([1; 80_000]).chain([0xF7]).collect();
    keys.send(&gigantic);
    keys.send(&[0xF8]);
    assert!(wait(10, || board.midi.gaps.get() == gaps + 1), "{:?} after {:?}", counts(), (skipped, gaps));
    assert!(wait(10, || board.voices.get() == 0), "its key may have gone up in what was dropped");
    assert!(wait(10, || {
        keys.send(&[0x90, 60, 100]);
        std::thread::sleep(Duration::from_millis(50));
        board.voices.get() > 0
    }));
    let gaps = board.midi.gaps.get();
    keys.send(&[0xF0]);
    for _ in 0..2_000 {
        keys.send(&[1; 256]);
        std::thread::sleep(Duration::from_micros(200));
    }
    // Somebody else's connection to it is none of ours.
    let seq = Seq::open(None, None, false).unwrap();
    let caps = PortCap::WRITE | PortCap::SUBS_WRITE;
    let other = seq.create_simple_port(c"other", caps, PortType::MIDI_GENERIC).unwrap();
    let sender = Addr { client: keys.seq.client_id().unwrap(), port: keys.port };
    let dest = Addr { client: seq.client_id().unwrap(), port: other };
    let link = alsa::seq::PortSubscribe::empty().unwrap();
    link.set_sender(sender);
    link.set_dest(dest);
    seq.subscribe_port(&link).unwrap();
    seq.unsubscribe_port(sender, dest).unwrap();
    let gone = heard.recv_timeout(Duration::from_millis(1_500)).is_ok();
    assert!(!gone, "another's connection was taken for ours");
    keys.send(&[0x80, 60, 0]);
    assert!(wait(10, || board.voices.get() == 0), "a key goes up after an endless message");
    assert_eq!(board.midi.gaps.get(), gaps);
    let mut other = Instrument::new("other");
    let before = board.midi.skipped.get();
    other.send_to(Some(ears()), &[0x90, 60, 100]);
    assert!(
        wait(10, || board.midi.skipped.get() == before + 1),
        "{} after {before}",
        board.midi.skipped.get()
    );
    assert_eq!(board.voices.get(), 0, "nobody listens to that port");
    drop(keys);
    goes(heard);
}

/// Somebody disconnects it by hand while its key is down: the key is let go of, and the port is connected anew.
fn one_that_somebody_disconnects_is_let_go_of(session: &Session, heard: &Receiver<PortNews>) {
    let keys = playing(session, heard);
    let sender = Addr { client: keys.seq.client_id().unwrap(), port: keys.port };
    let patchbay = Seq::open(None, None, false).unwrap();
    patchbay.unsubscribe_port(sender, ears()).unwrap();
    goes(heard);
    opens(heard);
    let board = session.board();
    assert!(wait(5, || board.voices.get() == 0 && board.is_panicked()), "it had promised to stay");
    session.handle().send(pacinian::live::signal::Signal::Calm).unwrap();
    assert!(wait(5, || board.shut.get() == 0));
    drop(keys);
    goes(heard);
}
