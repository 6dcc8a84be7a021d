//! Sessions on devices that a program brings along, which here follow a script: they vanish and return, are busy, mute, undead, ask for
//! blocks of any length, and say what real ones say at moments when it is not true.

mod ears;
#[path = "../common/scripted.rs"]
mod scripted;

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use cpal::{ErrorKind, SampleFormat};
use pacinian::graph::scene::Options;
use pacinian::io::device::choose::{Chosen, Wish, heard_among};
use pacinian::io::device::failure::{DeviceError, Trouble};
use pacinian::io::device::keeper::Fate;
use pacinian::io::session::{Beginning, Session, SessionError};
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::player::Player;
use pacinian::{NoAssets, Patch, Rig};
use scripted::{Make, Scripted, System};

const HUM: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.hum]\nstart = \"always\"\noutput = \"s\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n";

fn patch(text: &str) -> Patch {
    Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn options() -> Options {
    Options { rate: Some(48_000.0), live: true, ..Options::default() }
}

fn reload(text: &str, channels: u32) -> Reload {
    Reload::of(patch(text), Rig::default_for(channels), &options(), &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"))
}

type Fates = Arc<Mutex<Vec<Fate>>>;

fn noting(fates: &Fates) -> Box<dyn FnMut(Fate) + Send> {
    let fates = Arc::clone(fates);
    Box::new(move |fate| fates.lock().unwrap().push(fate))
}

fn named(system: &System, name: &str) -> Result<Chosen, DeviceError> {
    Wish::Named(name.into()).choose_among(&system.hosts())
}

/// A hum on the device of a system that has this name.
fn hum(system: &System, name: &str) -> (Session, Fates) {
    let fates = Fates::default();
    let device = named(system, name).unwrap_or_else(|error| panic!("{error}"));
    let beginning = Beginning {
        block: Some(64),
        armed: true,
        fate: noting(&fates),
        ..Beginning::of(reload(HUM, 2), device)
    };
    (Session::start(beginning).unwrap_or_else(|error| panic!("{error}")), fates)
}

/// Waits until something holds, fifteen seconds at most.
fn wait(what: &str, holds: impl Fn() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < Duration::from_secs(15), "{what} did not come");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The clock of a session goes on by so many frames.
fn clock_goes_on(session: &Session, frames: u64) {
    let from = session.board().frames.get();
    wait("more frames", || session.board().frames.get() >= from + frames);
}

fn first_of_two(samples: &[f64]) -> Vec<f64> {
    samples.iter().step_by(2).copied().collect()
}

/// Where a hum of 0.5 begins, after silence, and that it comes in over 20 ms from there on.
fn ramp(hum: &[f64]) -> Option<usize> {
    let first = hum.iter().position(|x| *x != 0.0)?;
    let length = 960.0;
    for (n, pair) in hum[first..].windows(2).take(1_000).enumerate() {
        // The gate's curve, a frame ahead.
        let x = ((n as f64 + 2.0) / length).min(1.0);
        let gain = x * x * (3.0 - 2.0 * x);
        assert!(pair[0].abs() <= 0.5001 * gain, "{} at frame {n} of the ramp", pair[0]);
        // The slope of the hum, and that of the gate.
        let most = 0.5 * (TAU * 100.0 / 48_000.0 + 1.5 / length) * 1.01;
        assert!((pair[1] - pair[0]).abs() < most, "a step of {} at frame {n}", pair[1] - pair[0]);
    }
    Some(first)
}

#[test]
fn a_device_that_comes_and_goes_a_hundred_times_is_played_on_each_time_and_no_other_ever() {
    let card = Scripted::new(Make::default());
    let default = Scripted::new(Make { id: "default", name: "Default", ..Make::default() });
    let twin = Scripted::new(Make { id: "card-2", ..Make::default() });
    let system = System::of(&[&default, &twin, &card]);
    let (mut session, fates) = hum(&system, "custom:card");
    wait("sound", || card.length() > 2 * 12_000);
    for n in 0..100 {
        card.is(|mood| mood.there = false);
        // Every other time it is back before anybody can have looked for it.
        if n % 2 == 0 {
            wait("the loss", || matches!(fates.lock().unwrap().last(), Some(Fate::Lost(_))));
            clock_goes_on(&session, 480);
        } else {
            wait("the end of the stream", || card.latest().gone.is_some());
        }
        card.is(|mood| mood.there = true);
        let full = |all: &[f64]| all.iter().rposition(|x| x.abs() > 0.47).is_some();
        wait("its return", || card.opened() == n + 2);
        wait("its sound", || full(&card.latest().samples));
    }
    clock_goes_on(&session, 4_800);
    session.stop();
    let fates = fates.lock().unwrap();
    assert_eq!(fates.len(), 200, "{fates:?}");
    for pair in fates.chunks(2) {
        assert!(matches!(pair, [Fate::Lost(why), Fate::Back] if why.contains("disconnected")), "{pair:?}");
    }
    assert_eq!((default.opened(), twin.opened()), (0, 0), "never another");
    let stretches = card.stretches();
    assert_eq!(stretches.len(), 101);
    for stretch in &stretches[1..] {
        let hum = first_of_two(&stretch.samples);
        assert!(ramp(&hum).is_some());
        assert!(stretch.samples.iter().skip(1).step_by(2).all(|x| *x == 0.0));
    }
    assert!(stretches[100].samples.iter().rev().take(200).all(|x| *x == 0.0), "it ends in silence");
}

#[test]
fn what_a_lost_device_still_asks_for_is_silence() {
    let card = Scripted::new(Make { formats: vec![SampleFormat::I16], ..Make::default() });
    card.is(|mood| mood.undead = true);
    let (mut session, fates) = hum(&System::of(&[&card]), "Card");
    wait("sound", || card.length() > 2 * 12_000);
    card.is(|mood| mood.there = false);
    wait("the loss", || !fates.lock().unwrap().is_empty());
    session.stop();
    let stretch = card.latest();
    let gone = stretch.gone.unwrap();
    assert!(stretch.samples[..gone].iter().any(|x| x.abs() > 15_000.0));
    assert!(stretch.samples.len() > gone, "it asked for more");
    assert!(stretch.samples[gone..].iter().all(|x| *x == 0.0), "at once");
}

/// What goes on in silence while a device is away says nothing of what that device holds.
#[test]
fn what_a_device_holds_is_what_it_said_itself() {
    let card = Scripted::new(Make { blocks: vec![96], ..Make::default() });
    let (session, fates) = hum(&System::of(&[&card]), "Card");
    wait("sound", || card.length() > 2 * 4_800);
    // The card says a block of its own, and is asked for blocks of 64.
    assert_eq!(session.board().device_delay.get(), Some(2_000_000));
    card.is(|mood| mood.there = false);
    wait("the loss", || !fates.lock().unwrap().is_empty());
    clock_goes_on(&session, 4_800);
    assert_eq!(session.board().device_delay.get(), Some(2_000_000));
}

#[test]
fn a_device_that_takes_a_stream_and_asks_for_nothing_is_lost_and_holds_nothing_up() {
    let card = Scripted::new(Make::default());
    card.is(|mood| mood.mute = true);
    let (mut session, fates) = hum(&System::of(&[&card]), "Card");
    wait("the loss", || !fates.lock().unwrap().is_empty());
    let why = fates.lock().unwrap()[0].clone();
    assert!(matches!(&why, Fate::Lost(why) if why.contains("does not ask for anything")), "{why:?}");
    // It is tried again, and the clock goes on meanwhile.
    wait("another try", || card.opened() == 2);
    for _ in 0..5 {
        clock_goes_on(&session, 480);
    }
    assert_eq!(card.opened(), 2, "it is still being tried");
    wait("a third try", || card.opened() == 3);
    card.is(|mood| mood.mute = false);
    wait("its return", || fates.lock().unwrap().contains(&Fate::Back));
    wait("sound", || card.length() > 2 * 12_000);
    session.stop();
    let fates = fates.lock().unwrap();
    assert!(
        matches!(&fates[..], [_, Fate::Said(why), Fate::Back] if why.contains("does not ask")),
        "{fates:?}"
    );
    assert!(ramp(&first_of_two(&card.latest().samples)).is_some());
}

/// A tone on each of three channels, with hard onsets between samples.
const TAPS: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\n[voice.v.nodes]\n\
    s = { type = \"sine\", frequency = \"event.frequency\" }\ne = { type = \"envelope\", attack = 0.003, release = 0.02 }\n\
    o = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n[pattern.p]\nevents = [\n\
    { at = 0.31337, voice = \"v\", level = 0.6, duration = 0.3, place = \"t1\", frequency = 80 },\n\
    { at = 0.37773, voice = \"v\", level = 0.9, duration = 0.3, place = \"t2\", frequency = 170 },\n\
    { at = 0.41111, voice = \"v\", level = 0.2, duration = 0.2, place = \"t3\", frequency = 250 },\n]\n";

#[test]
fn blocks_of_any_length_and_samples_of_every_format_are_what_would_be_rendered() {
    let blocks = vec![1, 7, 64, 0, 111, 150, 128, 0, 0, 0, 0, 4096, 1, 1, 0, 2047, 64, 64, 64];
    let frames = 48_000 * 9 / 10;
    let mut player = Player::new(&patch(TAPS), &Rig::default_for(3), &options(), &NoAssets).unwrap();
    let mut rendered = vec![0.0; 3 * frames];
    player.process(&mut rendered);
    // What plays from the beginning waits for the ramp of 200 ms.
    let lead = 3 * 9_600;
    assert!((0..3).all(|c| rendered.iter().skip(c).step_by(3).any(|x| x.abs() > 0.15)));
    let full = [
        (SampleFormat::F32, 1.0),
        (SampleFormat::I32, 2_147_483_648.0),
        (SampleFormat::I24, 8_388_608.0),
        (SampleFormat::I16, 32_768.0),
    ];
    for (format, full) in full {
        // What comes too late, since the machine stood still, is counted; then it is tried again.
        for attempt in 0..5 {
            let make =
                Make { outputs: vec![3], formats: vec![format], blocks: blocks.clone(), ..Make::default() };
            let card = Scripted::new(make);
            let device = named(&System::of(&[&card]), "Card").unwrap();
            let session =
                Session::start(Beginning { armed: true, ..Beginning::of(reload(TAPS, 3), device) }).unwrap();
            wait("all of it", || card.length() > lead + 3 * frames);
            let late = session.board().late.get();
            drop(session);
            let played = card.latest().samples;
            assert!(played[..lead].iter().all(|x| *x == 0.0));
            let within = |played: f64, rendered: f64| match format {
                SampleFormat::F32 => played.to_bits() == rendered.to_bits(),
                // To the nearest step, and to the even one of two as near.
                _ => played == (rendered * full).round_ties_even(),
            };
            let differs = (0..3 * frames).find(|&n| !within(played[lead + n], f64::from(rendered[n])));
            if differs.is_none() {
                break;
            }
            assert!(late > 0 && attempt < 4, "{format}: sample {differs:?}, {late} late");
        }
    }
}

#[test]
fn what_a_stream_says_on_its_way_out_concerns_nobody_and_a_slow_one_is_waited_for() {
    let card = Scripted::new(Make::default());
    card.is(|mood| (mood.last_words, mood.lets_go) = (true, Duration::from_millis(40)));
    let (mut session, fates) = hum(&System::of(&[&card]), "Card");
    wait("sound", || card.length() > 2 * 4_800);
    for n in 0..3 {
        // The last time, it takes a second.
        card.is(|mood| mood.lets_go = Duration::from_millis(if n == 2 { 1000 } else { 40 }));
        card.is(|mood| mood.there = false);
        wait("the loss", || fates.lock().unwrap().len() == 2 * n + 1);
        card.is(|mood| mood.there = true);
        wait("its return", || fates.lock().unwrap().len() == 2 * n + 2);
        // Until after the last words.
        clock_goes_on(&session, 14_400);
    }
    let told = fates.lock().unwrap().clone();
    assert_eq!(told.len(), 6, "{told:?}");
    assert!(told.chunks(2).all(|pair| matches!(pair, [Fate::Lost(_), Fate::Back])), "{told:?}");
    assert_eq!(card.opened(), 4);
    session.stop();
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(fates.lock().unwrap().len(), 6, "its own end is no loss");
}

/// A stream that is never done, as one whose server has died may be, keeps neither the clock nor what is to be played.
#[test]
fn what_a_stream_does_not_give_back_is_taken_from_it() {
    let card = Scripted::new(Make::default());
    let (mut session, fates) = hum(&System::of(&[&card]), "Card");
    wait("sound", || card.length() > 2 * 4_800);
    card.is(|mood| (mood.there, mood.hangs) = (false, true));
    wait("the loss", || fates.lock().unwrap().len() == 1);
    clock_goes_on(&session, 9_600);
    card.is(|mood| (mood.there, mood.hangs) = (true, false));
    wait("its return", || fates.lock().unwrap().len() == 2);
    clock_goes_on(&session, 4_800);
    assert!(card.latest().samples.iter().any(|x| x.abs() > 0.47), "it sounds again");
    let told = fates.lock().unwrap().clone();
    assert!(matches!(&told[..], [Fate::Lost(_), Fate::Back]), "{told:?}");
    session.stop();
}

#[test]
fn after_a_gap_the_stream_goes_on_and_times_line_up_again() {
    // By how much what the session takes for the time of a callback is ahead of when it came, seconds; the median of several.
    let ahead = |session: &Session, card: &Scripted, epoch: Instant| {
        let mut all: Vec<f64> = (0..9)
            .map(|_| {
                let before = card.latest().callbacks.len();
                wait("a callback", || card.latest().callbacks.len() > before);
                let moment = session.clock().moment().unwrap();
                let callbacks = card.latest().callbacks;
                let (frames, came) = callbacks[callbacks.len() - 2];
                moment.time_of(frames as f64) - (came - epoch).as_secs_f64()
            })
            .collect();
        all.sort_by(f64::total_cmp);
        all[4]
    };
    // A block of 16 ms. The machine may stand still for as long; then it is tried again.
    for attempt in 0..5 {
        let card = Scripted::new(Make { blocks: vec![768], ..Make::default() });
        let (mut session, fates) = hum(&System::of(&[&card]), "Card");
        wait("the clock to settle", || card.length() > 2 * 36_000);
        let epoch = Instant::now();
        let before = ahead(&session, &card, epoch);
        card.is(|mood| {
            mood.says.push_back(ErrorKind::Xrun);
            mood.throws_away = 1;
        });
        wait("the gap", || session.board().xruns.get() == 1);
        wait("the next block", || card.latest().callbacks.len() > 3);
        let moved = ahead(&session, &card, epoch) - before;
        clock_goes_on(&session, 4_800);
        session.stop();
        assert_eq!((card.opened(), session.board().xruns.get()), (1, 1), "it is not opened anew");
        assert!(fates.lock().unwrap().is_empty());
        if moved.abs() < 0.004 {
            return;
        }
        assert!(attempt < 4, "off by {moved} s: a block is 0.016 s");
    }
}

#[test]
fn what_the_system_does_with_a_stream_is_told_and_another_default_is_nobodys_business() {
    let (card, other) = (
        Scripted::new(Make::default()),
        Scripted::new(Make { id: "other", name: "Other", ..Make::default() }),
    );
    let system = System::of(&[&card, &other]);
    assert!(
        matches!(Wish::Default.choose_among(&system.hosts()), Ok(Chosen::Card(_, found)) if found.name == "Card" && found.default)
    );
    let (mut session, fates) = hum(&system, "Card");
    wait("sound", || card.length() > 2 * 4_800);
    system.prefers(1);
    clock_goes_on(&session, 4_800);
    assert!(fates.lock().unwrap().is_empty());
    card.is(|mood| mood.says.extend([ErrorKind::RealtimeDenied]));
    wait("the word", || fates.lock().unwrap().len() == 1);
    // Moved somewhere else, it is let go of at once, and opened again by its own name, at the level it had.
    card.is(|mood| mood.says.extend([ErrorKind::DeviceChanged]));
    wait("its return", || fates.lock().unwrap().len() == 4);
    wait("its sound", || card.latest().samples.iter().any(|x| x.abs() > 0.47));
    // Past the frames that are looked at below.
    clock_goes_on(&session, 4_800);
    session.stop();
    {
        let fates = fates.lock().unwrap();
        assert!(matches!(&fates[..], [Fate::Said(_), Fate::Moved, Fate::Lost(_), Fate::Back]), "{fates:?}");
    }
    assert_eq!((card.opened(), other.opened()), (2, 0));
    assert!(ramp(&first_of_two(&card.latest().samples)).is_some());
    assert!(
        matches!(Wish::Default.choose_among(&system.hosts()), Ok(Chosen::Card(_, found)) if found.name == "Other")
    );
}

/// What the system plays on by default may lead to other devices: after a move or a loss it is at -20 dB, however it was armed.
#[test]
fn a_default_that_was_moved_or_lost_comes_back_as_if_nobody_had_armed_it() {
    lowered(ErrorKind::DeviceChanged, &["moved", "lowered", "lost", "back"]);
    lowered(ErrorKind::DeviceNotAvailable, &["lowered", "lost", "back"]);
}

fn lowered(by: ErrorKind, told: &[&str]) {
    let card = Scripted::new(Make::default());
    let system = System::of(&[&card]);
    let device = Wish::Default.choose_among(&system.hosts()).unwrap_or_else(|error| panic!("{error}"));
    let fates = Fates::default();
    let beginning = Beginning {
        block: Some(64),
        armed: true,
        fate: noting(&fates),
        ..Beginning::of(reload(HUM, 2), device)
    };
    let mut session = Session::start(beginning).unwrap_or_else(|error| panic!("{error}"));
    wait("sound", || card.latest().samples.iter().any(|x| x.abs() > 0.47));
    card.is(|mood| mood.says.extend([by]));
    wait("its return", || fates.lock().unwrap().contains(&Fate::Back));
    wait("sound", || card.latest().samples.iter().any(|x| x.abs() > 0.04));
    clock_goes_on(&session, 9_600);
    let most = |samples: &[f64]| samples.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let quiet = most(&card.latest().samples);
    assert!((0.04..0.0501).contains(&quiet), "{quiet}");
    // Whoever arms it, knows.
    session.handle().send(Signal::Arm(true)).unwrap();
    wait("its level", || most(&card.latest().samples) > 0.47);
    session.stop();
    let fates = fates.lock().unwrap();
    let names = fates.iter().map(|fate| match fate {
        Fate::Moved => "moved",
        Fate::Lowered => "lowered",
        Fate::Lost(_) => "lost",
        Fate::Back => "back",
        Fate::Said(_) => "said",
    });
    assert!(names.eq(told.iter().copied()), "{fates:?}");
    assert_eq!(card.opened(), 2);
}

#[test]
fn a_device_that_is_busy_when_it_is_back_is_tried_again_and_that_is_said_once() {
    let card = Scripted::new(Make::default());
    let (mut session, fates) = hum(&System::of(&[&card]), "Card");
    wait("sound", || card.length() > 2 * 4_800);
    card.is(|mood| mood.there = false);
    wait("the loss", || fates.lock().unwrap().len() == 1);
    // First it cannot even be looked at, then it cannot be opened.
    card.is(|mood| (mood.there, mood.held, mood.busy) = (true, true, 4));
    wait("a word", || fates.lock().unwrap().len() == 2);
    clock_goes_on(&session, 14_400);
    card.is(|mood| mood.held = false);
    wait("its return", || fates.lock().unwrap().contains(&Fate::Back));
    wait("sound", || card.length() > 2 * 2_400);
    session.stop();
    let fates = fates.lock().unwrap();
    assert!(
        matches!(&fates[..], [Fate::Lost(_), Fate::Said(busy), Fate::Back] if busy.contains("busy")),
        "{fates:?}"
    );
}

#[test]
fn what_does_not_fit_is_refused_with_what_would_and_what_is_in_use_is_not_called_missing() {
    let two = Scripted::new(Make { rate: 44_100, ..Make::default() });
    let deaf = Scripted::new(Make { id: "deaf", name: "Deaf", ..Make::default() });
    let ear =
        Scripted::new(Make { id: "ear", name: "Ear", outputs: vec![], inputs: vec![1], ..Make::default() });
    let system = System::of(&[&two, &deaf, &ear]);
    let refused = |channels: u32, name: &str| {
        let beginning = Beginning::of(reload(HUM, channels), named(&system, name).unwrap());
        match Session::start(beginning) {
            Err(SessionError::Device(error)) => (error.kind, error.to_string()),
            Err(error) => panic!("{error}"),
            Ok(_) => panic!("it was taken"),
        }
    };
    let (kind, said) = refused(24, "deaf");
    assert!(kind == Trouble::Unfit && said.contains("24 channels are not offered; it offers 2"), "{said}");
    let (kind, said) = refused(2, "custom:card");
    assert!(kind == Trouble::Unfit && said.contains("48000 Hz are not offered; it offers 44100"), "{said}");
    assert_eq!((two.opened(), deaf.opened()), (0, 0));
    let said = |result: Result<Chosen, DeviceError>| result.err().unwrap().to_string();
    let missing = said(named(&system, "Ear"));
    assert!(
        missing.contains("there is no device `Ear`") && missing.contains("`virtual` is a card"),
        "{missing}"
    );
    let deaf_to = |name: &str| {
        let error = heard_among(&system.hosts(), name).unwrap_err();
        (error.kind, error.to_string())
    };
    // What only plays is nothing to listen to.
    let (kind, said_of) = deaf_to("None");
    assert!(
        kind == Trouble::Missing && said_of.contains("no device `None`") && !said_of.contains("virtual"),
        "{said_of}"
    );
    let (kind, said_of) = deaf_to("virtual");
    assert!(kind == Trouble::Unfit && said_of.contains("hears nothing"), "{said_of}");
    assert!(heard_among(&system.hosts(), "Deaf").unwrap_err().to_string().contains("Deaf has no inputs"));
    assert_eq!(heard_among(&system.hosts(), "default").unwrap().1.name, "Ear");
    deaf.is(|mood| mood.held = true);
    let busy = named(&system, "Deaf").err().unwrap();
    assert!(
        busy.kind == Trouble::Busy && busy.to_string().contains("close the program that plays on it"),
        "{busy}"
    );
    two.is(|mood| mood.held = true);
    let why = Wish::Default.choose_among(&system.hosts()).unwrap();
    assert!(matches!(why, Chosen::Virtual(Some("another program plays on the sound card"))));
    [&two, &deaf, &ear].into_iter().for_each(|card| card.is(|mood| mood.there = false));
    assert!(matches!(
        Wish::Default.choose_among(&system.hosts()),
        Ok(Chosen::Virtual(Some("no sound card is there")))
    ));
    for name in ["default", "Default"] {
        let (kind, said_of) = deaf_to(name);
        assert!(kind == Trouble::Missing && said_of.contains("no sound card that hears"), "{said_of}");
    }
}

/// Nobody has said what hangs on a card that a program plays on: neither the full level nor a steady voltage leaves unless it is asked for.
#[test]
fn a_session_of_a_program_is_as_careful_as_the_one_of_the_command_line() {
    const PRESS: &str = "[voice.press]\nstart = \"always\"\noutput = \"o\"\n[voice.press.nodes]\n\
        tone = { type = \"sine\", frequency = 100, amplitude = 0.25 }\no = { type = \"add\", inputs = [\"tone\", 0.5] }\n";
    let scene = Reload::of(
        patch(&format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{PRESS}")),
        Rig::default_for(2),
        &Options::for_card(48_000.0),
        &NoAssets,
    );
    let scene = scene.unwrap_or_else(|p| panic!("{p}"));
    let card = Scripted::new(Make::default());
    let device = named(&System::of(&[&card]), "Card").unwrap_or_else(|error| panic!("{error}"));
    let mut session = Session::start(Beginning::of(scene, device)).unwrap_or_else(|error| panic!("{error}"));
    wait("two seconds", || card.length() > 2 * 96_000);
    session.handle().arm(true).unwrap();
    wait("two more", || card.length() > 4 * 96_000);
    session.stop();
    let samples = card.latest().samples;
    // A whole number of turns of the tone.
    let last = |second: usize| -> Vec<f64> {
        samples[2 * 48_000 * second - 2 * 4800..2 * 48_000 * second].iter().step_by(2).copied().collect()
    };
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let peak = |part: &[f64]| part.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let (before, after) = (last(2), last(4));
    assert!(mean(&before).abs() < 1e-3 && mean(&after).abs() < 1e-3, "{} {}", mean(&before), mean(&after));
    assert!(
        (peak(&before) - 0.025).abs() < 0.002 && (peak(&after) - 0.25).abs() < 0.02,
        "{} {}",
        peak(&before),
        peak(&after)
    );
}
