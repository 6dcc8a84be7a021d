//! MIDI from real ports: what another program plays is heard, and let go of when it leaves. Through ALSA's sequencer, where the system has one; with
//! the feature `midi-jack` through a JACK server with its dummy driver.
#![cfg(target_os = "linux")]

#[cfg(not(feature = "midi-jack"))]
mod alsa;
#[path = "../common/mod.rs"]
mod common;
#[cfg(feature = "midi-jack")]
mod jack;
#[path = "../common/skipped.rs"]
mod skipped;
#[cfg(not(feature = "midi-jack"))]
mod usb;

#[cfg(feature = "cli")]
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::midi_in::{MidiPorts, PortNews, Word};
use pacinian::io::session::{Beginning, Session};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::live::way::Way;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;

#[cfg(not(feature = "midi-jack"))]
use crate::alsa as system;
#[cfg(feature = "midi-jack")]
use crate::jack as system;
use system::{Instrument, System};

const PATCH: &str = "[voice.hum]\noutput = \"o\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = \"event.frequency * touch.bend\" }\n\
    e = { type = \"envelope\", attack = 0.005, release = 0.02 }\no = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n\
    [[trigger]]\non = \"midi.note\"\nplay = \"hum\"\n";

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
    let Some(mut system) = System::start() else { return };
    let swaps = Arc::<AtomicU64>::default();
    let counts = Arc::clone(&swaps);
    let session = Session::start(Beginning {
        block: Some(system::BLOCK),
        audience: Box::new(move |told| {
            if matches!(told, Told::Reloaded) {
                counts.fetch_add(1, Ordering::Relaxed);
            }
        }),
        ..Beginning::of(reload(PATCH), Chosen::Virtual(None))
    })
    .unwrap();
    let (ports, heard) = listen(&session);
    for round in 0..2 {
        let mut keys = Instrument::new("keys");
        opens(&heard);
        let voices = || session.board().voices.get();
        // A port may be listed before it is connected: what came first may be lost, as of any cable that is plugged in.
        assert!(
            wait(20, || {
                keys.send(&[0xE0, 0, 0x50]);
                keys.send(&[0x90, 60, 100]);
                std::thread::sleep(Duration::from_millis(50));
                voices() > 0
            }),
            "{round}: nothing sounds"
        );
        std::thread::sleep(Duration::from_millis(300));
        assert!(voices() > 0, "{round}: a key holds its voice");
        drop(keys);
        goes(&heard);
        assert!(wait(10, || voices() == 0), "{round}: it is not let go of");
    }
    a_port_that_is_back_at_once_is_heard_anew(&session, &heard);
    a_flood_is_played_or_counted(&session, &heard, &swaps);
    a_lost_cable_shuts_the_output(&session, &heard);
    #[cfg(feature = "cli")]
    what_is_turned_is_learnt();
    whoever_listens_no_more_holds_no_key(&session, &heard, ports);
    let (_ports, heard) = listen(&session);
    whoever_panics_is_told_again();
    opens(&heard);
    goes(&heard);
    system::what_came_has_its_time();
    opens(&heard);
    goes(&heard);
    system.what_is_its_own(&session, &heard);
}

/// Listens to ports for a session, until the first of these is dropped.
fn listen(session: &Session) -> (MidiPorts, Receiver<PortNews>) {
    let (news, heard) = channel();
    let told = Box::new(move |what: PortNews| drop(news.send(what)));
    (MidiPorts::listen(session.handle(), Some("keys".into()), told).unwrap(), heard)
}

/// The next thing told of ports is that one opens, once it is told that there was none of its name.
fn opens(heard: &Receiver<PortNews>) {
    let mut all = std::iter::from_fn(|| heard.recv_timeout(Duration::from_secs(20)).ok());
    let news = all.find(|news| !matches!(news, PortNews::Unknown(_))).unwrap();
    assert!(matches!(&news, PortNews::Opened(name) if name.contains("keys")), "{news:?}");
}

/// The next thing told of ports is that one goes.
fn goes(heard: &Receiver<PortNews>) {
    let news = heard.recv_timeout(Duration::from_secs(20)).unwrap();
    assert!(matches!(&news, PortNews::Gone(name) if name.contains("keys")), "{news:?}");
}

/// An instrument, and when what it plays comes to somebody else than the session.
struct Heard {
    keys: Instrument,
    times: Arc<Mutex<Vec<Instant>>>,
    _ports: MidiPorts,
}

impl Heard {
    /// By somebody who needs so long for each message.
    fn by(pace: Duration) -> Self {
        let times = Arc::<Mutex<Vec<Instant>>>::default();
        let keeps = Arc::clone(&times);
        let ear = Arc::new(move |_: u16, _: &Arc<str>, word: Word, at: Instant| {
            if matches!(word, Word::Message(_)) {
                keeps.lock().unwrap().push(at);
                std::thread::sleep(pace);
            }
        });
        let (news, heard) = channel();
        let told = Box::new(move |what: PortNews| drop(news.send(what)));
        let _ports = MidiPorts::hear(ear, None, Some("keys".into()), told).unwrap();
        let mut keys = Instrument::new("keys");
        opens(&heard);
        assert!(wait(20, || {
            keys.send(&[0xF8]);
            std::thread::sleep(Duration::from_millis(20));
            !times.lock().unwrap().is_empty()
        }));
        std::thread::sleep(10 * pace + Duration::from_millis(100));
        times.lock().unwrap().clear();
        Self { keys, times, _ports }
    }

    /// So many times, once they have come.
    fn times(&self, count: usize) -> Vec<Instant> {
        let come = wait(20, || self.times.lock().unwrap().len() == count);
        let times = self.times.lock().unwrap().clone();
        assert!(come, "{} of {count}", times.len());
        times
    }
}

/// A program that is started anew, so quickly that its port is there whenever somebody looks: the key that was down is let go of, and the next is heard.
fn a_port_that_is_back_at_once_is_heard_anew(session: &Session, heard: &Receiver<PortNews>) {
    let board = session.board();
    let mut keys = None;
    for round in 0..4 {
        let again = keys.take().is_some();
        let mut another = Instrument::new("keys");
        if again {
            goes(heard);
            assert!(wait(10, || board.voices.get() == 0), "{round}: it is not let go of");
        }
        opens(heard);
        let sounds = wait(20, || {
            another.send(&[0x90, 60, 100]);
            std::thread::sleep(Duration::from_millis(50));
            board.voices.get() > 0
        });
        assert!(sounds, "{round}: nothing sounds");
        keys = Some(another);
        // Between two looks as a rule, and what was noted of the last one has been looked at.
        std::thread::sleep(Duration::from_millis(2_300));
    }
    drop(keys);
    goes(heard);
    assert!(wait(10, || board.voices.get() == 0));
}

fn reload(patch: &str) -> Reload {
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Reload::of(common::patch(patch), Rig::default_for(2), &options, &NoAssets).unwrap()
}

/// A hundred thousand messages as quickly as the server takes them to and fro, while patches are taken over: each is played or counted.
fn a_flood_is_played_or_counted(session: &Session, heard: &Receiver<PortNews>, swaps: &AtomicU64) {
    const FLOOD: u64 = 100_000;
    // More than the other program's queue holds would be lost before they come to anybody.
    const ON_THE_WAY: u64 = 1_500;
    let mut keys = Instrument::new("keys");
    opens(heard);
    let board = session.board();
    let met = || board.midi.messages.get() + board.refused.of(Way::Midi).get();
    let before = met();
    assert!(wait(20, || {
        keys.send(&[0xB0, 20, 0]);
        std::thread::sleep(Duration::from_millis(50));
        met() > before
    }));
    assert!(wait(5, || {
        let now = met();
        std::thread::sleep(Duration::from_millis(100));
        met() == now
    }));
    let (before, frames, gaps, swapped) =
        (met(), board.frames.get(), board.midi.gaps.get(), swaps.load(Ordering::Relaxed));
    let (begin, xruns) = (Instant::now(), board.xruns.get());
    let (mut lost, mut seen) = (0, gaps);
    for n in 0..FLOOD {
        let note = (n / 2 % 128) as u8;
        keys.send(&[if n % 2 == 0 { 0x90 } else { 0x80 }, note, 100]);
        if n % 10_000 == 5_000 {
            let other = PATCH.replace("attack = 0.005", &format!("attack = {}", 0.006 + 1e-7 * n as f64));
            assert!(wait(10, || session.handle().send(Signal::Reload(Box::new(reload(&other)))).is_ok()));
        }
        let on_the_way = |lost: u64| (n + 1).saturating_sub(met() - before + lost);
        let waits = Instant::now();
        while on_the_way(lost) >= ON_THE_WAY {
            // What JACK leaves out never comes: it is what has not, once nothing comes any more.
            let (left_out, now) = (board.midi.gaps.get(), met());
            std::thread::sleep(Duration::from_millis(if left_out > seen { 200 } else { 1 }));
            if left_out > seen && met() == now {
                (lost, seen) = (lost + on_the_way(lost), left_out);
            }
            assert!(waits.elapsed() < Duration::from_secs(20), "{} of {n}", met() - before);
        }
    }
    let seconds = begin.elapsed().as_secs_f64();
    let last = wait(10, || met() - before + lost >= FLOOD);
    std::thread::sleep(Duration::from_millis(200));
    println!(
        "{} of {FLOOD} in {seconds:.2} s, {} of them refused",
        met() - before,
        board.refused.of(Way::Midi).get()
    );
    if board.midi.gaps.get() == gaps {
        assert!(last && met() - before == FLOOD, "{} of {FLOOD}: {:?}", met() - before, board.midi.trouble());
    }
    assert!(
        wait(20, || swaps.load(Ordering::Relaxed) > swapped),
        "no patch takes over: {} told",
        swaps.load(Ordering::Relaxed)
    );
    assert!(wait(5, || board.voices.get() == 0), "all keys are up");
    // Playing never stopped: its frames are those of the time.
    let played = (board.frames.get() - frames) as f64 / 48_000.0;
    let passed = begin.elapsed().as_secs_f64();
    let missing = passed - played;
    assert!(missing.abs() < 0.5 + system::BEHIND * passed, "{played} s of {passed}");
    assert!(missing < 0.5 || board.xruns.get() > xruns, "what is missing is counted");
    drop(keys);
    goes(heard);
}

/// An instrument of another program, whose key is down, and that has promised to stay.
fn playing(session: &Session, heard: &Receiver<PortNews>) -> Instrument {
    let mut keys = Instrument::new("keys");
    opens(heard);
    let board = session.board();
    let sounds = wait(20, || {
        keys.send(&[0xFE]);
        keys.send(&[0x90, 60, 100]);
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
    keys.send(&[0xF0, 0x7D]);
    while begin.elapsed() < Duration::from_millis(1000) {
        std::thread::sleep(Duration::from_millis(100));
        keys.send(&[1; 32]);
        longest = longest.max(std::mem::replace(&mut last, Instant::now()).elapsed());
    }
    // Where this thread itself did not keep its word, nothing is known.
    if longest < Duration::from_millis(250) {
        assert!(!board.is_panicked() && board.voices.get() > 0, "it says that it is there");
    }
    assert!(wait(5, || board.is_panicked() && board.shut.get() == 1), "its key is down still");
    assert!(wait(5, || board.voices.get() == 0));
    // It comes back to life: what it plays is not heard until somebody says so.
    keys.send(&[0xF7]);
    keys.send(&[0x90, 62, 100]);
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(board.shut.get(), 1);
    session.handle().send(Signal::Calm).unwrap();
    assert!(wait(5, || board.shut.get() == 0));
    drop(keys);
    goes(heard);
    assert!(!board.is_panicked(), "nothing was promised since");
}

/// A program may listen to ports for a part of a session only. That its key is down, and that it has promised to stay, is nothing to it from then on.
fn whoever_listens_no_more_holds_no_key(session: &Session, heard: &Receiver<PortNews>, ports: MidiPorts) {
    let keys = playing(session, heard);
    let board = session.board();
    drop(ports);
    assert!(wait(10, || board.voices.get() == 0), "its key holds a voice");
    // Longer than a cable may be silent that has promised something.
    std::thread::sleep(Duration::from_millis(600));
    assert!(board.shut.get() == 0 && !board.is_panicked(), "nobody listens for it");
    assert!(heard.try_iter().all(|news| matches!(news, PortNews::Opened(_))), "no port is gone");
    drop(keys);
}

/// What a program does with what comes may panic: the next that comes is brought all the same, once the port is opened anew.
fn whoever_panics_is_told_again() {
    let heard = Arc::<AtomicU64>::default();
    let counts = Arc::clone(&heard);
    let ear = Arc::new(move |_: u16, _: &Arc<str>, word: Word, _: Instant| {
        if matches!(word, Word::Message(_)) && counts.fetch_add(1, Ordering::Relaxed) == 0 {
            panic!("this panic is part of the test");
        }
    });
    let _ports = MidiPorts::hear(ear, None, Some("keys".into()), Box::new(drop)).unwrap();
    let mut keys = Instrument::new("keys");
    let goes_on = wait(20, || {
        keys.send(&[0xF8]);
        heard.load(Ordering::Relaxed) > 1
    });
    assert!(goes_on, "{} messages", heard.load(Ordering::Relaxed));
}

/// A fader of 14 bits and an endless knob, from their port to the bindings that are written.
#[cfg(feature = "cli")]
fn what_is_turned_is_learnt() {
    use std::io::{BufRead, BufReader};

    let folder = std::env::temp_dir().join(format!("pacinian-learnt-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("p.toml");
    let patch = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.depth]\ndefault = 0.5\n[control.rate]\ndefault = 0.5\n\
        [voice.hum]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"100 * rate\", amplitude = \"depth\" }\n";
    std::fs::write(&path, patch).unwrap();
    let mut desk = Instrument::new("desk");
    let mut learn = Command::new(env!("CARGO_BIN_EXE_pacinian"));
    learn.arg("learn").arg(&path).args([
        "--wait",
        "40",
        "--midi-in",
        "desk",
        "--control",
        "depth",
        "--control",
        "rate",
    ]);
    let mut learn = learn.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let (tell, told) = channel();
    let lines = BufReader::new(learn.stderr.take().unwrap());
    std::thread::spawn(move || lines.lines().map_while(Result::ok).for_each(|line| drop(tell.send(line))));
    let mut all = String::new();
    let mut hears = |what: &str, mut moves: Box<dyn FnMut() + '_>| {
        let found = wait(30, || {
            moves();
            all.extend(told.try_iter().map(|line| line + "\n"));
            all.contains(what)
        });
        assert!(found, "no `{what}`: {all}");
    };
    hears("depth (0 to 1): move something", Box::new(|| {}));
    let mut at = 0_u16;
    // Up and down again: what comes before the port is connected is lost.
    let fader = |at: &mut u16, desk: &mut Instrument| {
        *at = (*at + 200) % 32_000;
        let stands = (*at).min(32_000 - *at);
        desk.send(&[0xB2, 16, (stands >> 7) as u8]);
        desk.send(&[0xB2, 48, (stands & 127) as u8]);
    };
    hears("controller 16, 14 bits, on channel 3", Box::new(|| fader(&mut at, &mut desk)));
    hears("rate (0 to 1): move something", Box::new(|| {}));
    // Eight steps one way, and as many back.
    let mut turns = 0;
    let knob = |turns: &mut u8, desk: &mut Instrument| {
        desk.send(&[0xB2, 20, if (*turns / 8).is_multiple_of(2) { 1 } else { 127 }]);
        *turns = turns.wrapping_add(1);
    };
    hears(
        "controller 20, an encoder (twos-complement), on channel 3",
        Box::new(|| knob(&mut turns, &mut desk)),
    );
    assert!(wait(20, || learn.try_wait().unwrap().is_some_and(|status| status.success())));
    let text = std::fs::read_to_string(&path).unwrap();
    for written in [
        "from = \"midi.controller 16\"\ncontrol = \"depth\"\nchannel = 3\n",
        "from = \"midi.controller 20\"\ncontrol = \"rate\"\nchannel = 3\nencoder = \"twos-complement\"\n",
    ] {
        assert!(text.contains(written), "{text}");
    }
    drop(desk);
    let _ = std::fs::remove_dir_all(&folder);
}
