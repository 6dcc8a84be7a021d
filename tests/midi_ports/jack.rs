//! A JACK server of its own, and instruments that are its clients.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use jack::{
    AsyncClient, Client, ClientOptions, Control, Frames, MidiOut, Port, ProcessHandler, ProcessScope, RawMidi,
};
use pacinian::io::midi_in::PortNews;
use pacinian::io::session::Session;
use pacinian::live::signal::Signal;

use crate::{Heard, goes, playing, skipped, wait};

/// Frames a second and a period of the server.
const RATE: f64 = 48_000.0;
const PERIOD: Frames = 256;

/// Frames that the session is asked for at a time.
pub const BLOCK: u32 = 64;

/// What share of the time the virtual card may leave out while it is flooded.
pub const BEHIND: f64 = 0.0;

/// A server under a name of its own, which ends with this.
pub struct System(Child);

impl System {
    /// `None` where there is no JACK, which is said.
    pub fn start() -> Option<Self> {
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

    /// What no other system has.
    pub fn what_is_its_own(&mut self, session: &Session, heard: &Receiver<PortNews>) {
        self.one_that_dies_lets_go(session, heard);
        self.what_it_leaves_out_is_counted(session);
    }

    /// The server is killed while a key is down: it is let go of, and what comes with the next server is heard.
    fn one_that_dies_lets_go(&mut self, session: &Session, heard: &Receiver<PortNews>) {
        // One that is back before anybody has looked, and one that is missed first.
        for missed in [false, true] {
            let keys = playing(session, heard);
            self.dies();
            // JACK's library crashes where one takes leave of a server that has ended.
            std::mem::forget(keys);
            if !missed {
                self.comes_back();
            }
            goes(heard);
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
                self.comes_back();
            }
        }
        drop(playing(session, heard));
        goes(heard);
        session.handle().send(Signal::Calm).unwrap();
    }

    /// A server that stands still leaves out periods, and with them what somebody sends then.
    fn what_it_leaves_out_is_counted(&self, session: &Session) {
        let before = session.board().midi.gaps.get();
        let signal = |name: &str| {
            assert!(Command::new("kill").args([name, &self.0.id().to_string()]).status().unwrap().success())
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
        assert!(told.contains("gaps that ALSA or JACK told of, whose messages are lost"), "{told}");
    }

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
    let period = PERIOD.to_string();
    command.args(["-r", "-p", "128", "-n", name, "-d", "dummy", "-r", "48000", "-p", &period]);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()
}

/// Another program asks: a client of this one would free the session's where its server has ended.
fn answers() -> bool {
    let asks = || Command::new("jack_lsp").stdout(Stdio::null()).stderr(Stdio::null()).status();
    wait(10, || asks().is_ok_and(|status| status.success()))
}

impl Drop for System {
    fn drop(&mut self) {
        let _ = Command::new("kill").arg(self.0.id().to_string()).status();
        let gone = wait(5, || matches!(self.0.try_wait(), Ok(Some(_))));
        if !gone {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
        let mine = format!("pacinian-{}", std::process::id());
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().contains(&mine) {
                let path: PathBuf = entry.path();
                let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
            }
        }
    }
}

/// A client with one port.
pub struct Instrument {
    _client: AsyncClient<(), Keys>,
    send: Sender<(Frames, Vec<u8>)>,
}

struct Keys {
    port: Port<MidiOut>,
    sent: Receiver<(Frames, Vec<u8>)>,
    /// What found no room in a period.
    kept: Option<(Frames, Vec<u8>)>,
}

impl ProcessHandler for Keys {
    fn process(&mut self, _: &Client, scope: &ProcessScope) -> Control {
        let mut writer = self.port.writer(scope);
        // One that is meant for an earlier frame than the last belongs to the next period.
        let mut last = 0;
        while let Some((time, bytes)) = self.kept.take().or_else(|| self.sent.try_recv().ok()) {
            let written = time >= last && writer.write(&RawMidi { time, bytes: &bytes }).is_ok();
            last = time;
            if !written {
                self.kept = Some((time, bytes));
                break;
            }
        }
        Control::Continue
    }
}

impl Instrument {
    /// A port of that name.
    pub fn new(name: &str) -> Self {
        // The session's client hears a moment late that one before has gone, and takes the place of that out of use for this whole program: let it be
        // taken by one that never plays.
        std::mem::forget(Client::new("nobody", ClientOptions::NO_START_SERVER).unwrap());
        let (client, _) = Client::new("somebody", ClientOptions::NO_START_SERVER).unwrap();
        let port = client.register_port(name, MidiOut::default()).unwrap();
        let (send, sent) = channel();
        let _client = client.activate_async((), Keys { port, sent, kept: None }).unwrap();
        Self { _client, send }
    }

    /// Sends it with the next period.
    pub fn send(&mut self, bytes: &[u8]) {
        self.send_at(0, bytes);
    }

    /// At a frame of it.
    fn send_at(&mut self, frame: Frames, bytes: &[u8]) {
        let _ = self.send.send((frame, bytes.to_vec()));
    }
}

/// What is sent at different frames of a period came at different times, and evenly from period to period.
pub fn what_came_has_its_time() {
    const FRAMES: [Frames; 4] = [0, 1, 100, 255];
    let mut heard = Heard::by(Duration::ZERO);
    for _ in 0..20 {
        FRAMES.iter().for_each(|frame| heard.keys.send_at(*frame, &[0xF8]));
    }
    let times = heard.times(20 * FRAMES.len());
    for period in times.chunks(FRAMES.len()) {
        for (time, frame) in period.iter().zip(FRAMES) {
            let off = time.duration_since(period[0]).as_secs_f64() - f64::from(frame) / RATE;
            assert!(off.abs() < 1e-6, "frame {frame}: {off} s off");
        }
    }
    // The server's clock is a filtered one; where it was interrupted meanwhile, periods are left out.
    let begins: Vec<f64> =
        times.iter().step_by(FRAMES.len()).map(|at| at.duration_since(times[0]).as_secs_f64()).collect();
    let period = f64::from(PERIOD) / RATE;
    let even = begins.windows(2).filter(|pair| ((pair[1] - pair[0]) / period - 1.0).abs() < 0.05).count();
    assert!(even >= 12, "{even} of 19 periods are even: {begins:?}");
}
