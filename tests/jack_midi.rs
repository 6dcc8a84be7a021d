//! MIDI through a JACK server, a real one with its dummy driver: what another program plays is heard, and let go of when it leaves.
#![cfg(target_os = "linux")]

mod common;
#[path = "common/skipped.rs"]
mod skipped;

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use midir::os::unix::VirtualOutput;
use midir::{MidiOutput, MidiOutputConnection};
use pacinian::graph::scene::{Options, scene};
use pacinian::io::device::choose::Chosen;
use pacinian::io::midi_in::{MidiPorts, PortNews};
use pacinian::io::session::{Beginning, Session};
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::text::Problem;

const PATCH: &str = "[voice.hum]\noutput = \"o\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = \"event.frequency * touch.bend\" }\n\
    e = { type = \"envelope\", attack = 0.005, release = 0.02 }\no = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n\
    [[trigger]]\non = \"midi.note\"\nplay = \"hum\"\n";

/// A server under a name of its own, which ends with this.
struct Server(Child);

impl Server {
    /// `None` where there is no JACK, which is said.
    fn start() -> Option<Self> {
        let name = format!("pacinian-{}", std::process::id());
        // SAFETY: this is the only test here, and no other thread reads the environment yet.
        unsafe {
            std::env::set_var("JACK_DEFAULT_SERVER", &name);
            std::env::set_var("JACK_NO_AUDIO_RESERVATION", "1");
            std::env::set_var("JACK_NO_START_SERVER", "1");
        }
        let Ok(child) = launched(&name) else {
            skipped::skipped("there is no jackd (apt-get install jackd2)");
            return None;
        };
        let server = Self(child);
        let ready = answers();
        if !ready {
            skipped::skipped("jackd does not run here");
        }
        ready.then_some(server)
    }
}

impl Server {
    /// It dies, and nobody is told.
    fn dies(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// Another one comes in its place.
    fn comes_back(&mut self) {
        self.0 = launched(&std::env::var("JACK_DEFAULT_SERVER").unwrap()).unwrap();
        assert!(answers(), "no server any more");
    }
}

fn launched(name: &str) -> std::io::Result<Child> {
    let mut command = Command::new("jackd");
    command.args(["-r", "-p", "128", "-n", name, "-d", "dummy", "-r", "48000", "-p", "256"]);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()
}

fn answers() -> bool {
    wait(10, || MidiOutput::new("are you there").is_ok())
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = Command::new("kill").arg(self.0.id().to_string()).status();
        let gone = wait(5, || matches!(self.0.try_wait(), Ok(Some(_))));
        if !gone {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
        for folder in ["/dev/shm"] {
            let mine = format!("pacinian-{}", std::process::id());
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                if entry.file_name().to_string_lossy().contains(&mine) {
                    let path: PathBuf = entry.path();
                    let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
                }
            }
        }
    }
}

/// Whether it comes about within so many seconds.
fn wait(seconds: u64, mut what: impl FnMut() -> bool) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(seconds) {
        if what() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    false
}

#[test]
fn a_note_of_a_client_sounds_until_its_port_is_gone() {
    let Some(mut server) = Server::start() else { return };
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let (patch, rig) = (Arc::new(common::patch(PATCH)), Arc::new(Rig::default_for(2)));
    let session = Session::start(Beginning {
        block: Some(64),
        ..Beginning::of(
            Reload {
                scene: scene(&patch, &rig, &options, &NoAssets).unwrap(),
                patch,
                rig,
                files: Box::new(|path| Err(Problem::of_file(path))),
                provenance: None,
            },
            Chosen::Virtual(None),
        )
    })
    .unwrap();
    let (news, heard) = channel();
    let told = Box::new(move |what: PortNews| drop(news.send(what)));
    let _ports = MidiPorts::listen(session.handle(), Some("keys".into()), told).unwrap();

    for round in 0..2 {
        let mut keys = MidiOutput::new("somebody").unwrap().create_virtual("keys").unwrap();
        let opened = heard.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(matches!(&opened, PortNews::Opened(name) if name.contains("keys")), "{round}: {opened:?}");
        let voices = || session.board().voices.get();
        // A port may be listed before it is connected: what came first may be lost, as of any cable that is plugged in.
        assert!(
            wait(20, || {
                let _ = keys.send(&[0xE0, 0, 0x50]);
                let _ = keys.send(&[0x90, 60, 100]);
                std::thread::sleep(Duration::from_millis(50));
                voices() > 0
            }),
            "{round}: nothing sounds"
        );
        std::thread::sleep(Duration::from_millis(300));
        assert!(voices() > 0, "{round}: a key holds its voice");
        drop(keys);
        let gone = heard.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(matches!(&gone, PortNews::Gone(name) if name.contains("keys")), "{round}: {gone:?}");
        assert!(wait(10, || voices() == 0), "{round}: it is not let go of");
    }
    a_lost_cable_shuts_the_output(&session, &heard);
    a_server_that_dies_lets_go(&mut server, &session, &heard);
    // A server that stands still leaves out periods, and with them what somebody sends then.
    let before = session.board().midi.gaps.get();
    let signal = |name: &str| {
        assert!(Command::new("kill").args([name, &server.0.id().to_string()]).status().unwrap().success())
    };
    let counted = wait(20, || {
        signal("-STOP");
        std::thread::sleep(Duration::from_millis(200));
        signal("-CONT");
        std::thread::sleep(Duration::from_millis(200));
        session.board().midi.gaps.get() > before
    });
    assert!(counted, "nobody counts what JACK leaves out");
    let told = session.board().midi.trouble().unwrap();
    assert!(told.contains("left out by JACK, whose messages are lost"), "{told}");
}

/// An instrument of another program, whose key is down, and that has promised to stay.
fn playing(session: &Session, heard: &Receiver<PortNews>) -> MidiOutputConnection {
    let mut keys = MidiOutput::new("somebody").unwrap().create_virtual("keys").unwrap();
    let opened = heard.recv_timeout(Duration::from_secs(20)).unwrap();
    assert!(matches!(&opened, PortNews::Opened(_)), "{opened:?}");
    let board = session.board();
    let sounds = wait(20, || {
        let _ = keys.send(&[0xFE]);
        let _ = keys.send(&[0x90, 60, 100]);
        std::thread::sleep(Duration::from_millis(50));
        board.voices.get() > 0
    });
    assert!(sounds && board.shut.get() == 0 && !board.is_panicked());
    keys
}

/// A cable that promises to stay (0xFE), and then says nothing any more, while its key is down.
fn a_lost_cable_shuts_the_output(session: &Session, heard: &Receiver<PortNews>) {
    let mut keys = playing(session, heard);
    let board = session.board();
    // For as long as it keeps its word, all is well: a system exclusive in pieces, without an end so far.
    let (begin, mut last, mut longest) = (Instant::now(), Instant::now(), Duration::ZERO);
    let _ = keys.send(&[0xF0, 0x7D]);
    while begin.elapsed() < Duration::from_millis(1000) {
        std::thread::sleep(Duration::from_millis(100));
        let _ = keys.send(&[1; 32]);
        longest = longest.max(std::mem::replace(&mut last, Instant::now()).elapsed());
    }
    // Where this thread itself did not keep its word, nothing is known.
    if longest < Duration::from_millis(250) {
        assert!(!board.is_panicked() && board.voices.get() > 0, "it says that it is there");
    }
    assert!(wait(5, || board.is_panicked() && board.shut.get() == 1), "its key is down still");
    assert!(wait(5, || board.voices.get() == 0));
    // It comes back to life: what it plays is not heard until somebody says so.
    let _ = keys.send(&[0xF7]);
    let _ = keys.send(&[0x90, 62, 100]);
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(board.shut.get(), 1);
    session.handle().send(Signal::Calm).unwrap();
    assert!(wait(5, || board.shut.get() == 0));
    drop(keys);
    let gone = heard.recv_timeout(Duration::from_secs(20)).unwrap();
    assert!(matches!(&gone, PortNews::Gone(_)), "{gone:?}");
    assert!(!board.is_panicked(), "nothing was promised since");
}

/// The server is killed while a key is down: it is let go of, and what comes with the next server is heard.
fn a_server_that_dies_lets_go(server: &mut Server, session: &Session, heard: &Receiver<PortNews>) {
    // One that is back before anybody has looked, and one that is missed first.
    for missed in [false, true] {
        let keys = playing(session, heard);
        server.dies();
        // JACK's library crashes where one takes leave of a server that has ended.
        std::mem::forget(keys);
        if !missed {
            server.comes_back();
        }
        let gone = heard.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(matches!(&gone, PortNews::Gone(_)), "{missed}: {gone:?}");
        let board = session.board();
        assert!(
            wait(5, || board.voices.get() == 0 && board.is_panicked()),
            "{missed}: it had promised to stay"
        );
        session.handle().send(Signal::Calm).unwrap();
        assert!(wait(5, || board.shut.get() == 0));
        if missed {
            let none = heard.recv_timeout(Duration::from_secs(20)).unwrap();
            assert!(matches!(&none, PortNews::None(_)), "{none:?}");
            server.comes_back();
        }
    }
    drop(playing(session, heard));
    let gone = heard.recv_timeout(Duration::from_secs(20)).unwrap();
    assert!(matches!(&gone, PortNews::Gone(_)), "{gone:?}");
    session.handle().send(Signal::Calm).unwrap();
}
