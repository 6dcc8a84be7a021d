//! The session with a SmartKnob, on a clock of its own.

use pacinian::io::knob::lost::Lost;
use pacinian::io::knob::servo::News;
use pacinian::io::knob::session::{Session, Turn};
use pacinian::io::knob::smartknob::compile::{Device as Measured, compile};
use pacinian::io::knob::smartknob::config::Config;
use pacinian::io::knob::smartknob::{Feel, Remote, Settings, SmartKnob};
use pacinian::knob::effect::detent::Detent;
use pacinian::knob::effect::program::Any;
use pacinian::knob::effect::spring::Spring;
use pacinian::knob::effect::wall::Stops;

use crate::cable::Cable;
use crate::smartknob::{FakeSmartKnob, PER_VOLT};

type Line = Cable<SmartKnob, FakeSmartKnob>;

fn plugged(fork: bool, seed: u32) -> (Line, Remote) {
    let (session, remote) = SmartKnob::new(Settings { seed, parting: None }).unwrap();
    (Cable::new(session, FakeSmartKnob::new(fork)), remote)
}

fn running(fork: bool) -> (Line, Remote) {
    let (mut line, remote) = plugged(fork, 5);
    line.lives(0.5);
    assert!(line.session.is_ready(), "{:?}", line.hand.news);
    (line, remote)
}

fn feel(text: &str) -> Feel {
    // Letters that a knob in plain text takes for commands.
    Feel { config: Config { text: text.into(), ..Config::default() }, origin: 0.0, stay: false }
}

fn in_force(line: &Line, text: &str) -> usize {
    line.hand.news.iter().filter(|news| **news == News::InForce(text.into())).count()
}

fn refused(line: &Line) -> Vec<String> {
    let why = |news: &News| if let News::Refused(_, why) = news { Some(why.clone()) } else { None };
    line.hand.news.iter().filter_map(why).collect()
}

#[test]
fn zeros_go_first_and_no_letter_is_a_command() {
    for fork in [false, true] {
        for seed in 0..256 {
            let (mut line, _remote) = plugged(fork, seed << 24 | seed);
            line.lives(0.1);
            assert!(line.session.is_ready(), "seed {seed}: {:?}", line.hand.news);
            assert_eq!(line.said[0].1, [0; 8]);
            assert!(line.device.commands.is_empty());
            // Even one that had heard none of the zeros.
            assert!(line.said.iter().flat_map(|(_, bytes)| bytes).all(|byte| !(0x20..0x7f).contains(byte)));
        }
    }
}

#[test]
fn both_dialects_are_told_apart_and_spoken() {
    for (fork, named) in [(false, "first"), (true, "SeedLabs")] {
        let (mut line, remote) = running(fork);
        assert!(
            matches!(&line.hand.news[0], News::Ready(what) if what.contains(named)),
            "{:?}",
            line.hand.news
        );
        remote.set(feel("CSC SC")).unwrap();
        line.lives(0.3);
        assert_eq!((in_force(&line, "CSC SC"), line.device.taken.len()), (1, 1), "{:?}", line.hand.news);
        line.device.hand = 0.004;
        line.lives(1.0);
        assert!(line.device.position > 3);
        let (read, counts) = (line.hand.last.unwrap(), line.session.counts());
        assert!(counts.readings > 300 && counts.bad_checksum == 0 && counts.unexpected == 0, "{counts:?}");
        assert!(read.velocity.is_none() && (0.003..0.007).contains(&read.dt), "{read:?}");
        // A state is 5 ms old at most.
        let (angle, speed) = (line.device.plant.angle(), line.device.plant.speed());
        assert!((read.angle - angle).abs() < 1e-4 + 6e-3 * speed.abs(), "{} {angle}", read.angle);
        let trip = line.session.round_trip();
        assert!((3.9e-4..1e-3).contains(&trip.mean), "{trip:?}");
    }
}

#[test]
fn presses_are_counted() {
    let (mut line, _remote) = running(false);
    line.device.press = 255;
    line.lives(0.1);
    line.device.press = 1;
    line.lives(0.1);
    let presses: Vec<&News> = line.hand.news.iter().filter(|news| matches!(news, News::Press(_))).collect();
    assert_eq!(presses, [&News::Press(255), &News::Press(2)]);
}

#[test]
fn a_lost_acknowledgement_is_asked_for_again_and_changes_nothing_twice() {
    let (mut line, remote) = running(false);
    // Those of its first three tries; nor do its states tell that it took it.
    (line.device.mischief.lost_acks, line.device.mischief.hides) = (3, true);
    remote.set(feel("once")).unwrap();
    line.lives(1.0);
    let sent =
        |line: &Line| line.said.iter().filter(|(_, bytes)| bytes.windows(4).any(|w| w == b"once")).count();
    assert_eq!((sent(&line), line.device.taken.len(), in_force(&line, "once")), (4, 1, 0));
    let nonces = &line.device.nonces;
    assert!(nonces[nonces.len() - 4..].windows(2).all(|pair| pair[0] == pair[1]), "{nonces:?}");
    line.device.mischief.hides = false;
    line.lives(1.0);
    assert_eq!(
        (sent(&line), in_force(&line, "once"), refused(&line).len()),
        (4, 1, 0),
        "{:?}",
        line.hand.news
    );
}

#[test]
fn what_its_motor_refuses_is_told_with_its_log() {
    let (mut line, remote) = running(false);
    line.device.mischief.refuses = true;
    remote.set(feel("no")).unwrap();
    line.lives(2.5);
    let why = refused(&line);
    assert!(why.len() == 1 && why[0].contains("Ignoring invalid config"), "{why:?}");
    assert!(line.session.is_ready() && in_force(&line, "no") == 0);
}

#[test]
fn what_is_never_acknowledged_is_given_up() {
    let (mut line, remote) = running(false);
    line.device.mischief.deaf = true;
    remote.set(feel("deaf")).unwrap();
    let before = line.said.len();
    line.lives(5.0);
    let why = refused(&line);
    assert!(why.len() == 1 && why[0].contains("does not acknowledge"), "{why:?}");
    assert_eq!(line.said.len() - before, 8, "tries");
    line.device.mischief.deaf = false;
    remote.set(feel("again")).unwrap();
    line.lives(0.3);
    assert_eq!(in_force(&line, "again"), 1);
}

#[test]
fn the_newest_of_what_it_is_to_be_counts() {
    let (mut line, remote) = running(true);
    (0..100).for_each(|k| remote.set(feel(&format!("number {k}"))).unwrap());
    line.lives(1.0);
    assert_eq!(line.device.taken, [b"number 99"]);
    let broken = Feel { config: Config { width: 0.0, ..Config::default() }, ..feel("x") };
    assert_eq!(remote.set(broken).unwrap_err().field, "width");
}

#[test]
fn one_that_stays_keeps_its_place() {
    let (mut line, remote) = running(false);
    remote.set(feel("first")).unwrap();
    line.device.hand = 0.004;
    line.lives(1.0);
    let before = line.hand.last.unwrap().angle;
    assert!(before > 0.5);
    line.device.hand = 0.0;
    remote.set(Feel { stay: true, ..feel("second") }).unwrap();
    line.lives(0.3);
    assert!(in_force(&line, "second") == 1 && line.hand.last.unwrap().angle >= before - 1e-3);
    remote.set(feel("third")).unwrap();
    line.lives(0.3);
    assert!(in_force(&line, "third") == 1 && line.hand.last.unwrap().angle < 0.5);
}

#[test]
fn silence_is_a_loss_and_what_it_was_it_is_again() {
    let (mut line, remote) = running(false);
    remote.set(feel("kept")).unwrap();
    line.lives(0.3);
    line.device.mischief.stall = Some((line.now, line.now + 20.0));
    let from = line.now;
    let why = line.loses(10.0);
    assert!(
        matches!(why, Lost::Stalled(seconds) if (3.5..4.5).contains(&seconds)) && !why.is_final(),
        "{why:?}"
    );
    assert!(line.now - from < 4.5 && line.session.torque() == 0.0);
    // Each question begins as the first did.
    let asked: Vec<_> = line.said.iter().filter(|(at, _)| *at > from).collect();
    assert!(asked.len() == 8 && asked.iter().all(|(_, bytes)| bytes.starts_with(&[0; 8])), "{asked:?}");
    line.device.mischief.stall = None;
    line.begin();
    line.lives(1.0);
    assert_eq!(in_force(&line, "kept"), 2, "{:?}", line.hand.news);
    assert_eq!(line.session.counts().lost, 1);
}

#[test]
fn one_that_starts_anew_is_woken_and_told_again_without_a_letter() {
    for offset in 0..20 {
        let (mut line, remote) = running(offset % 2 == 0);
        remote.set(feel("CSC SC")).unwrap();
        line.lives(0.3);
        let at = line.now + 0.1;
        line.device.mischief.reset = Some(at);
        // Told to be something else while nobody hears.
        line.lives(0.1 * f64::from(offset));
        if (line.now - at).abs() > 0.05 {
            remote.set(feel("S C other")).unwrap();
        }
        let mut ended = None;
        for _ in 0..100 {
            ended = ended.or(line.run(0.1));
            if matches!(ended.take(), Some(Turn::Lost(why)) if !why.is_final()) {
                line.begin();
            }
        }
        let taken: Vec<_> = line.device.taken.iter().map(|text| String::from_utf8_lossy(text)).collect();
        assert!(line.session.is_ready() && taken.len() >= 2, "{offset}: {taken:?} {:?}", line.hand.news);
        let letters: Vec<u8> =
            line.device.commands.iter().copied().filter(|byte| b"CS ".contains(byte)).collect();
        assert!(letters.is_empty() && !line.device.calibrated, "{offset}: {letters:?}");
        assert_eq!(
            line.device.taken.last(),
            Some(&if taken.iter().any(|t| t == "S C other") {
                b"S C other".to_vec()
            } else {
                b"CSC SC".to_vec()
            })
        );
    }
}

#[test]
fn what_is_sent_again_does_not_run_into_one_that_starts_anew() {
    let (mut line, remote) = running(false);
    line.device.mischief.deaf = true;
    remote.set(feel("CSC SC")).unwrap();
    line.lives(0.1);
    (line.device.mischief.reset, line.device.mischief.deaf) = (Some(line.now + 0.01), false);
    line.lives(4.0);
    assert!(!line.device.calibrated, "{:?}", String::from_utf8_lossy(&line.device.commands));
    assert_eq!(in_force(&line, "CSC SC"), 1, "{:?}", line.hand.news);
}

#[test]
fn noise_is_counted_and_no_more() {
    type Break = fn(&mut FakeSmartKnob);
    let cases: [Break; 3] =
        [|knob| knob.mischief.damaged = 7, |knob| knob.mischief.garbage = 7, |knob| knob.mischief.cut = 7];
    for (k, breaks) in cases.into_iter().enumerate() {
        for pieces in [0, 3] {
            let (mut line, remote) = running(false);
            line.pieces = if pieces == 0 { 0 } else { 40 };
            breaks(&mut line.device);
            remote.set(feel("through")).unwrap();
            line.lives(3.0);
            let counts = line.session.counts();
            assert!(counts.bad_checksum > 20 && counts.readings > 300, "case {k}: {counts:?}");
            assert_eq!((in_force(&line, "through"), counts.lost), (1, 0), "case {k}: {:?}", line.hand.news);
        }
    }
}

#[test]
fn echo_flood_and_strangers_are_named() {
    let (mut line, _remote) = plugged(false, 1);
    line.device.mischief.echo = true;
    assert!(matches!(line.loses(2.0), Lost::Echo(_)));
    let (mut line, _remote) = running(false);
    line.device.mischief.flood = 1e6;
    assert!(matches!(line.loses(2.0), Lost::Flood(_)));
    let (mut line, _remote) = running(false);
    line.device.mischief.chatter = 1e4;
    assert!(matches!(line.loses(2.0), Lost::Flood(_)));
    let (mut line, _remote) = plugged(false, 1);
    line.device.mischief.version = 2;
    let why = line.loses(2.0);
    assert!(matches!(&why, Lost::Dialect(said) if said.contains("version 2")) && why.is_final(), "{why:?}");
    let (mut line, _remote) = plugged(false, 1);
    line.device.mischief.stall = Some((0.0, 99.0));
    assert!(matches!(line.loses(20.0), Lost::Silent(_)));
}

/// Compiled for the simulated knob, which stands at 0.
fn told(line: &mut Line, remote: &Remote, effects: &[Any]) -> Feel {
    let device = Measured { stiffness: 4.0 * PER_VOLT };
    let compiled = compile(effects, &device, line.device.plant.angle(), "compiled").unwrap();
    assert!(compiled.left_out.is_empty(), "{:?}", compiled.left_out);
    remote.set(compiled.feel.clone()).unwrap();
    line.lives(0.5);
    assert_eq!(in_force(line, "compiled"), 1, "{:?}", line.hand.news);
    compiled.feel
}

#[test]
fn a_spring_pulls_as_stiffly_as_it_should() {
    let (mut line, remote) = running(false);
    told(&mut line, &remote, &[Spring { stiffness: 0.08, centre: 0.0 }.into()]);
    line.device.hand = 0.02;
    line.lives(2.0);
    // Beyond its dead zone of a degree.
    let (angle, wanted) = (line.device.plant.angle(), 0.02 / 0.08 + 1_f64.to_radians());
    assert!((angle - wanted).abs() < 2e-3, "{angle} {wanted}");
    assert!((line.hand.last.unwrap().angle - angle).abs() < 2e-3);
}

#[test]
fn detents_hold_and_ends_end() {
    let (mut line, remote) = running(false);
    let effects = [
        Detent::with_stiffness(12.0, 0.1).into(),
        Stops { low: 0.0, high: std::f64::consts::TAU / 4.0, stiffness: 0.2, damping: 0.0 }.into(),
    ];
    told(&mut line, &remote, &effects);
    // Less than it takes to leave a detent: 0.55 of 30 degrees at 0.1 N m/rad.
    line.device.hand = 0.012;
    line.lives(1.0);
    assert_eq!(line.device.position, 0);
    line.device.hand = 0.04;
    line.lives(2.0);
    assert_eq!(line.device.position, 3, "the last");
    let angle = line.device.plant.angle();
    let wanted = std::f64::consts::TAU / 4.0 + 0.04 / 0.2 + 1_f64.to_radians();
    assert!((angle - wanted).abs() < 5e-3, "{angle} {wanted}");
    assert!((line.hand.last.unwrap().angle - angle).abs() < 5e-3);
}

#[test]
fn a_parting_is_sent() {
    let parting = Config { text: "bye".into(), ..Config::default() };
    let (session, _remote) = SmartKnob::new(Settings { seed: 3, parting: Some(parting) }).unwrap();
    let mut line = Cable::new(session, FakeSmartKnob::new(false));
    line.lives(0.5);
    line.session.stop(line.now);
    assert_eq!(line.run(2.0), Some(Turn::Done));
    assert_eq!(line.device.taken, [b"bye"]);
}
