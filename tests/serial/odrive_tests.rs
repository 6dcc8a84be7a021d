//! The session with an ODrive, on a clock of its own.

use std::f64::consts::TAU;

use pacinian::io::knob::lost::Lost;
use pacinian::io::knob::odrive::{ODrive, Settings};
use pacinian::io::knob::session::{Session, Turn};

use crate::cable::{Cable, Device, STEP};
use crate::hand::Hand;
use crate::odrive::{COUNTS, FakeODrive, Names};

type Line = Cable<ODrive, FakeODrive>;

fn plugged(names: Names, settings: Settings) -> Line {
    Cable::new(ODrive::new(settings).unwrap(), FakeODrive::new(names))
}

/// One that runs, with a spring of 0.05 N m/rad and 2 mN m s/rad.
fn running(names: Names) -> Line {
    let mut line = plugged(names, Settings::default());
    (line.hand.stiffness, line.hand.damping) = (0.05, 2e-3);
    line.lives(0.5);
    assert!(line.session.is_ready(), "{:?}", line.hand.news);
    line
}

/// The motor makes nothing.
fn is_idle(line: &Line) -> bool {
    line.device.torque() == 0.0 && line.session.torque() == 0.0
}

#[test]
fn a_spring_holds_the_knob_where_the_closed_form_says() {
    for names in [Names::Old, Names::New] {
        let mut line = running(names);
        for torque in [0.0, 0.012, -0.02] {
            line.device.hand = torque;
            line.lives(1.0);
            let (angle, wanted) = (line.device.plant.angle(), torque / 0.05);
            assert!((angle - wanted).abs() < 1.5 * TAU / COUNTS, "{angle} {wanted}");
            assert!(line.device.plant.speed().abs() < 0.1);
        }
        let read = line.hand.last.unwrap();
        assert!((read.angle - line.device.angle()).abs() < TAU * 1e-6, "as the device says it");
        assert!(read.velocity.is_some());
        // Twice the cable and a step or two.
        let trip = line.session.round_trip();
        assert!((4e-4..1.2e-3).contains(&trip.mean) && trip.worst < 1.5e-3, "{trip:?}");
        assert!((read.dt - 1e-3).abs() < 5e-4, "{read:?}");
        let counts = line.session.counts();
        assert!(counts.readings > 2_500, "{counts:?}");
        assert_eq!(
            (counts.dropped, counts.bad_checksum, counts.unexpected, counts.late, counts.lost),
            (0, 0, 0, 0, 0)
        );
        assert_eq!(line.hand.news.len(), 1, "{:?}", line.hand.news);
    }
}

#[test]
fn what_is_written_is_in_order_and_with_checksums() {
    let line = running(Names::Old);
    let wanted = [
        "",
        "i",
        "r axis0.error",
        "r axis0.motor.config.torque_lim",
        "w axis0.motor.config.torque_lim 0.05",
        "r axis0.motor.config.torque_lim",
        "r axis0.config.torque_soft_min",
        "r axis0.controller.config.vel_limit",
        "w axis0.controller.config.vel_limit 9.549297",
        "r axis0.controller.config.vel_limit",
        "r axis0.controller.config.control_mode",
        "w axis0.controller.config.control_mode 1",
        "r axis0.controller.config.control_mode",
        "r axis0.controller.config.input_mode",
        "w axis0.controller.config.input_mode 1",
        "r axis0.controller.config.input_mode",
        "r axis0.config.watchdog_timeout",
        "w axis0.config.watchdog_timeout 0.05",
        "r axis0.config.watchdog_timeout",
        "r axis0.config.enable_watchdog",
        "w axis0.config.enable_watchdog 1",
        "r axis0.config.enable_watchdog",
        "w axis0.requested_state 8",
        "r axis0.current_state",
    ];
    let came: Vec<&str> = line.device.lines.iter().map(String::as_str).collect();
    assert_eq!(came[..wanted.len() - 1], wanted[1..]);
    let text = line.text();
    assert!(text.starts_with("\ni *73\n"), "{:?}", &text[..20]);
    assert!(text.contains("c 0 0 *67\nf 0 *86\n"), "an exchange is one write");
    let pair = line
        .said
        .iter()
        .filter(|(_, bytes)| bytes.ends_with(b"f 0 *86\n") && bytes.starts_with(b"c 0 "))
        .count();
    assert!(pair > 300, "{pair}");
    for written in text.lines().filter(|written| !written.is_empty()) {
        let (words, sum) = written.rsplit_once('*').unwrap();
        assert_eq!(words.bytes().fold(0, |x, byte| x ^ byte).to_string(), sum, "{written}");
    }
    assert_eq!(line.device.properties["axis0.config.enable_watchdog"], 1.0);
}

#[test]
fn the_watchdog_stops_the_motor_when_this_side_is_gone() {
    let mut line = running(Names::Old);
    line.hand.forced = Some(0.03);
    line.lives(0.1);
    assert_eq!(line.device.torque(), 0.03);
    let gone = line.now;
    line.quiet(0.2);
    let (at, torque) = *line.device.made.last().unwrap();
    assert_eq!((torque, line.device.state), (0.0, 1));
    assert!(at - gone < 0.05 + 2.0 * line.delay + 2.0 * STEP, "{}", at - gone);
}

#[test]
fn it_ends_with_a_ramp_and_leaves_it_idle() {
    let mut line = running(Names::Old);
    line.hand.forced = Some(0.04);
    line.lives(0.1);
    let (at, ticks) = (line.now, line.hand.ticks);
    line.session.stop(line.now);
    assert_eq!(line.run(1.0), Some(Turn::Done));
    line.quiet(0.2);
    let fall: Vec<f64> =
        line.device.made.iter().filter(|(t, _)| *t > at).map(|(_, torque)| *torque).collect();
    assert!(fall.len() > 10 && fall.windows(2).all(|pair| pair[1] < pair[0]), "{fall:?}");
    assert_eq!((fall.last(), line.device.state, line.device.error), (Some(&0.0), 1, 0));
    assert!(line.now - at < 0.3 && line.hand.ticks <= ticks + 1);
    // And again, on the same line.
    line.hand.forced = None;
    line.begin();
    line.lives(0.5);
    assert!(line.session.is_ready() && line.hand.notes("watchdog") == 0);
}

#[test]
fn a_stall_takes_torque_away_and_is_told() {
    let mut line = running(Names::Old);
    line.hand.forced = Some(0.03);
    line.lives(0.1);
    let from = line.now;
    line.device.mischief.stall = Some((from, from + 0.3));
    while line.session.counts().dropped == 0 {
        assert_eq!(line.step(), None);
    }
    assert!(line.now - from < 0.018 && line.session.torque() == 0.0, "{}", line.now - from);
    let last = String::from_utf8(line.said.last().unwrap().1.clone()).unwrap();
    assert!(last.starts_with("c 0 0 *"), "{last}");
    match line.loses(0.1) {
        Lost::Stalled(seconds) => assert!((0.05..0.06).contains(&seconds), "{seconds}"),
        other => panic!("{other:?}"),
    }
    assert!(!line.session.is_ready());
    line.quiet(0.3);
    assert!(is_idle(&line), "its watchdog");
    // The board is back, with the error of its watchdog.
    line.hand.forced = None;
    line.begin();
    line.lives(1.0);
    assert!(line.session.is_ready(), "{:?}", line.hand.news);
    assert_eq!(line.hand.notes("its watchdog had stopped it"), 1);
}

/// Nobody knows yet whether an answer is late or lost; torque is 0 after an exchange all the same, and is back with the next reading.
#[test]
fn an_answer_that_is_late_has_no_torque() {
    let mut line = running(Names::Old);
    line.hand.forced = Some(0.03);
    line.lives(0.1);
    let (from, settings) = (line.now, Settings::default());
    line.device.mischief.mute = true;
    while line.session.torque() != 0.0 {
        assert_eq!(line.step(), None);
    }
    // The rest of one exchange, and the next one.
    let tick = (1.0 / settings.rate).max(1.25 * line.session.round_trip().worst);
    assert!(line.now - from < 1.0 / settings.rate + tick + 2.0 * STEP, "{}", line.now - from);
    assert!(line.now - from < 0.5 * settings.patience && line.session.counts().dropped == 0);
    let until = line.now + line.delay + 2.0 * STEP;
    while line.now < until {
        assert_eq!(line.step(), None);
    }
    assert!(is_idle(&line), "{} N m", line.device.torque());
    line.device.mischief.mute = false;
    line.lives(0.1);
    assert_eq!((line.session.torque(), line.device.torque()), (0.03, 0.03));
}

#[test]
fn a_short_stall_is_ridden_out() {
    let mut line = running(Names::Old);
    line.device.mischief.stall = Some((line.now, line.now + 0.025));
    line.lives(0.5);
    let counts = line.session.counts();
    assert!(line.session.is_ready() && counts.dropped >= 1 && counts.lost == 0, "{counts:?}");
    let before = counts.readings;
    line.lives(0.1);
    assert!(line.session.counts().readings > before + 80);
}

#[test]
fn a_bad_checksum_costs_one_tick() {
    let mut line = running(Names::Old);
    line.hand.forced = Some(0.03);
    line.lives(0.05);
    line.device.mischief.bad_checksum = 40;
    while line.session.counts().bad_checksum == 0 {
        assert_eq!(line.step(), None);
    }
    assert_eq!(line.session.torque(), 0.0);
    let at = line.now;
    line.quiet(line.delay + 2.0 * STEP);
    assert!(is_idle(&line), "{} after {at}", line.now);
    line.lives(1.0);
    let counts = line.session.counts();
    assert!(counts.bad_checksum > 10 && counts.lost == 0 && counts.readings > 800, "{counts:?}");
}

/// An exchange says the torque that there is when it is written, and none that is newer than a fault: with the same torque all along it is as if it
/// were asked for with readings alone.
#[test]
fn an_exchange_takes_the_newest_torque_and_none_before_a_reading() {
    let said = |newest: Option<f64>, bad_checksum: u64| {
        let mut line = running(Names::Old);
        (line.hand.forced, line.hand.newest) = (Some(0.03), newest);
        line.lives(0.05);
        line.device.mischief.bad_checksum = bad_checksum;
        let from = line.said.len();
        line.lives(0.5);
        line.said.split_off(from)
    };
    for every in [0, 40, 7] {
        assert!(said(None, every) == said(Some(0.03), every), "every {every}");
    }
    let pushes = |said: &[(f64, Vec<u8>)], torque: &str| {
        said.iter().filter(|(_, bytes)| bytes.starts_with(format!("c 0 {torque} ").as_bytes())).count()
    };
    let newer = said(Some(0.004), 0);
    assert!(pushes(&newer, "0.004") > 450 && pushes(&newer, "0.03") == 0, "{}", pushes(&newer, "0.004"));
    // What is no number is 0, and what is too much is held to the limit.
    assert_eq!(pushes(&said(Some(f64::NAN), 0), "0"), newer.len());
    assert_eq!(pushes(&said(Some(9.0), 0), "0.05"), newer.len());
}

#[test]
fn what_is_broken_is_counted_and_the_thread_is_taken_up() {
    type Break = fn(&mut FakeODrive);
    type Count = fn(&Line) -> u64;
    let cases: [(Break, Count); 4] = [
        // What was cut is forgotten before the next answer comes, and spoils no other.
        (
            |device| device.mischief.cut = 30,
            |line| {
                assert_eq!(line.session.counts().bad_checksum, 0);
                line.session.counts().dropped
            },
        ),
        (|device| device.mischief.garbage = 30, |line| line.session.counts().bad_checksum),
        (|device| device.mischief.odd = 30, |line| line.session.counts().unexpected),
        (|device| device.mischief.late = 30, |line| line.session.counts().late),
    ];
    for (k, (breaks, count)) in cases.into_iter().enumerate() {
        let mut line = running(Names::Old);
        line.device.hand = 0.01;
        breaks(&mut line.device);
        line.lives(1.0);
        let counts = line.session.counts();
        assert!(count(&line) >= 5 && counts.lost == 0 && counts.readings > 400, "case {k}: {counts:?}");
        line.device.mischief = Default::default();
        line.lives(1.0);
        assert!(
            (line.device.plant.angle() - 0.2).abs() < 2.0 * TAU / COUNTS,
            "case {k}: {}",
            line.device.plant.angle()
        );
    }
}

#[test]
fn a_late_answer_is_not_taken_for_the_next() {
    let mut line = running(Names::Old);
    // The knob turns, so that an old angle is a wrong one.
    (line.hand.stiffness, line.hand.damping, line.device.hand) = (0.0, 1e-3, 0.01);
    line.device.mischief.late = 50;
    for _ in 0..20_000 {
        let ticks = line.hand.ticks;
        assert_eq!(line.step(), None);
        if line.hand.ticks > ticks {
            let (read, angle) = (line.hand.last.unwrap().angle, line.device.plant.angle());
            let age = (angle - read) / line.device.plant.speed();
            assert!(age < 1.2e-3, "{age} s old at {}", line.now);
        }
    }
    assert!(line.session.counts().late > 10);
}

#[test]
fn pieces_and_clumps_are_the_same_to_it() {
    for (pieces, merged) in [(1, 0.0), (3, 0.0), (0, 2e-3), (5, 1e-3)] {
        let mut line = plugged(Names::Old, Settings::default());
        (line.pieces, line.merged) = (pieces, merged);
        (line.hand.stiffness, line.hand.damping, line.device.hand) = (0.02, 2e-3, 0.004);
        line.lives(3.0);
        assert!(
            (line.device.plant.angle() - 0.2).abs() < 2.0 * TAU / COUNTS,
            "{pieces}: {}",
            line.device.plant.angle()
        );
        let counts = line.session.counts();
        assert_eq!((counts.bad_checksum, counts.unexpected, counts.lost), (0, 0, 0), "{counts:?}");
    }
}

#[test]
fn an_echo_is_no_knob() {
    let mut line = plugged(Names::Old, Settings::default());
    line.device.mischief.echo = true;
    let why = line.loses(1.0);
    assert!(matches!(&why, Lost::Echo(said) if said.contains("i *73")) && why.is_final(), "{why:?}");
    assert!(is_idle(&line));
    let mut line = running(Names::Old);
    line.device.mischief.echo = true;
    assert!(matches!(line.loses(1.0), Lost::Echo(_)) && is_idle(&line));
}

#[test]
fn a_flood_is_refused() {
    for chatter in [false, true] {
        let mut line = running(Names::Old);
        line.hand.forced = Some(0.03);
        line.lives(0.05);
        let mischief = &mut line.device.mischief;
        if chatter {
            mischief.chatter = 1e4
        } else {
            mischief.flood = 1e6
        }
        let why = line.loses(1.0);
        assert!(matches!(why, Lost::Flood(_) | Lost::Stalled(_)) && !why.is_final(), "{why:?}");
        assert!(is_idle(&line));
        assert!(line.device.made.last().unwrap().0 < line.now);
        // And from the beginning on.
        let mut line = plugged(Names::Old, Settings::default());
        line.device.mischief.flood = 1e6;
        assert!(matches!(line.loses(3.0), Lost::Flood(_)));
    }
}

/// From a fault of the line on, torque is sent for as long as nobody can notice it, and not an exchange longer: what says something else than a
/// reading is noticed with the next exchange, and what says nothing, or too much to be heard behind it, with the end of patience. (Lines that
/// nobody asked for between right answers are none until they are too many: `a_flood_is_refused`.)
#[test]
fn no_torque_is_sent_once_a_fault_can_be_noticed() {
    type Do = fn(&mut crate::odrive::Mischief);
    let faults: [(&str, bool, Do); 7] = [
        ("echo", true, |m| m.echo = true),
        ("other words", true, |m| m.says = Some("ok")),
        ("another knob", true, |m| m.says = Some("\u{1}\u{2}knob")),
        ("no checksums", true, |m| m.no_checksum = true),
        ("wrong checksums", true, |m| m.bad_checksum = 1),
        ("silence", false, |m| m.mute = true),
        ("flood", false, |m| m.flood = 1e6),
    ];
    for ((name, at_once, fault), newest) in faults.into_iter().flat_map(|of| [(of, None), (of, Some(0.03))]) {
        let mut line = running(Names::Old);
        (line.hand.forced, line.hand.newest) = (Some(0.03), newest);
        line.lives(0.1);
        let (from, settings) = (line.now, Settings::default());
        fault(&mut line.device.mischief);
        let _ = line.run(0.3);
        line.quiet(1e-3);
        let asks = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes).into_owned();
            text.starts_with("c 0 ") && !text.starts_with("c 0 0 ")
        };
        let pushes = line.said.iter().filter(|(_, bytes)| asks(bytes));
        let last = pushes.map(|(time, _)| *time).fold(0.0, f64::max);
        // Answers to what was asked before, then one exchange.
        let most = 2.0 * line.delay + 2.0 / settings.rate + if at_once { 0.0 } else { settings.patience };
        assert!((from - 2e-3..from + most + STEP).contains(&last), "{name}: {} s", last - from);
        assert!(is_idle(&line), "{name}: {} N m", line.device.torque());
    }
}

#[test]
fn other_dialects_are_named() {
    let cases = [("\u{1}\u{2}knob", false), ("SmartKnob starting", false), ("ok", false), ("ok", true)];
    for (says, bare) in cases {
        let mut line = plugged(Names::Old, Settings::default());
        (line.device.mischief.says, line.device.mischief.no_checksum) = (Some(says), bare);
        let why = line.loses(2.0);
        assert!(matches!(&why, Lost::Dialect(_)) && why.is_final(), "{why:?}");
        assert!(is_idle(&line) && !line.text().contains("requested_state"));
    }
    let mut line = plugged(Names::Old, Settings::default());
    line.device.mischief.mute = true;
    let why = line.loses(2.0);
    assert!(matches!(&why, Lost::Silent(asked) if asked.contains("i *73")) && !why.is_final(), "{why:?}");
}

#[test]
fn a_board_without_names_is_told_and_without_watchdog_refused() {
    for names in [Names::Unwatched, Names::Bare] {
        let mut line = plugged(names, Settings::default());
        let why = line.loses(2.0);
        assert!(
            matches!(&why, Lost::Unwatched(said) if said.contains("watchdog_timeout")) && why.is_final(),
            "{why:?}"
        );
        assert!(is_idle(&line) && line.device.state == 1);
    }
    let mut line = plugged(Names::Unwatched, Settings { unwatched: true, ..Settings::default() });
    (line.hand.stiffness, line.hand.damping, line.device.hand) = (0.05, 2e-3, 0.01);
    line.lives(2.0);
    assert!((line.device.plant.angle() - 0.2).abs() < 2.0 * TAU / COUNTS);
    assert_eq!(line.hand.notes("no watchdog, as was allowed"), 2);
    // A home-made board that has commands alone.
    let mut line = plugged(Names::Bare, Settings { unwatched: true, ..Settings::default() });
    line.device.state = 8;
    (line.hand.stiffness, line.hand.damping, line.device.hand) = (0.05, 2e-3, 0.01);
    line.lives(2.0);
    assert!((line.device.plant.angle() - 0.2).abs() < 2.0 * TAU / COUNTS, "{:?}", line.hand.news);
    for words in
        ["does not say what it is", "errors cannot be read", "torque has no limit", "speed has no limit"]
    {
        assert_eq!(line.hand.notes(words), 1, "{words}: {:?}", line.hand.news);
    }
}

#[test]
fn errors_are_named() {
    for (names, bits, said) in
        [(Names::Old, 0x100, "encoder failed"), (Names::New, 1 << 9, "supply voltage too low")]
    {
        let mut line = plugged(names, Settings::default());
        line.device.error = bits;
        let why = line.loses(1.0);
        assert!(why.is_final() && why.to_string().contains(said), "{why}");
        assert!(!line.text().contains("requested_state"));
        let mut line = running(names);
        line.hand.forced = Some(0.02);
        line.device.mischief.fails = Some((line.now + 0.1, bits));
        let why = line.loses(1.0);
        assert!(why.is_final() && why.to_string().contains(said), "{why}");
        assert!(is_idle(&line));
    }
}

#[test]
fn a_board_that_starts_anew_is_taken_up_again() {
    let mut line = running(Names::Old);
    line.device.mischief.reset = Some(line.now + 0.1);
    let why = line.loses(1.0);
    assert!(matches!(why, Lost::Axis { state: Some(1), errors: 0, .. }) && !why.is_final(), "{why:?}");
    assert!(is_idle(&line));
    line.device.hand = 0.01;
    line.begin();
    line.lives(1.5);
    assert!((line.device.plant.angle() - 0.2).abs() < 2.0 * TAU / COUNTS, "{:?}", line.hand.news);
}

#[test]
fn torque_keeps_to_its_limit_and_is_a_number() {
    let mut line = running(Names::Old);
    for (wanted, made) in [(1.0, 0.05), (-1e300, -0.05), (f64::INFINITY, 0.0), (f64::NAN, 0.0), (0.01, 0.01)]
    {
        line.hand.forced = Some(wanted);
        line.lives(0.05);
        assert_eq!(line.device.torque(), made, "{wanted}");
        line.hand.forced = Some(0.0);
        line.lives(0.05);
    }
    let counts = line.session.counts();
    assert!(counts.clipped > 80 && counts.not_finite > 80, "{counts:?}");
    assert!(line.device.made.iter().all(|(_, torque)| torque.abs() <= 0.05));
}

#[test]
fn limits_are_lowered_and_never_raised() {
    let mut line = plugged(Names::New, Settings::default());
    line.device.properties.insert("axis0.config.torque_soft_max".into(), 0.01);
    line.device.properties.insert("axis0.controller.config.vel_limit".into(), 2.0);
    line.lives(0.5);
    assert!(line.session.is_ready());
    let get = |name: &str| line.device.properties[&format!("axis0.{name}")];
    assert_eq!((get("config.torque_soft_max"), get("config.torque_soft_min")), (0.01, -0.05));
    assert_eq!((get("controller.config.vel_limit"), line.hand.notes("stays so")), (2.0, 2));
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let good = Settings::default();
    let bad = [
        (Settings { axis: 2, ..good }, "axis"),
        (Settings { most_torque: f64::NAN, ..good }, "most torque"),
        (Settings { watchdog: 0.0, ..good }, "watchdog"),
        (Settings { patience: 0.03, ..good }, "patience"),
        (Settings { rate: 20.0, ..good }, "rate"),
    ];
    for (settings, field) in bad {
        assert_eq!(ODrive::new(settings).unwrap_err().field, field);
    }
}

#[test]
fn another_axis_is_another() {
    let mut line = plugged(Names::Old, Settings { axis: 1, unwatched: true, ..Settings::default() });
    let end = line.run(3.0);
    assert!(matches!(end, Some(Turn::Lost(_))), "{end:?}: it has one motor alone");
    let mut hand = Hand::default();
    let mut out = Vec::new();
    assert!(matches!(line.session.turn(9.0, &mut hand, &mut out), Turn::Lost(_)));
    line.device.pass(9.0);
    assert_eq!(line.device.torque(), 0.0);
}
