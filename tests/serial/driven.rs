//! The driver, the port and the thread, through a pseudo-terminal. Limits of time are far beyond what a busy machine needs.

use std::sync::{Arc, Mutex};

use pacinian::io::knob::driver::{Running, run};
use pacinian::io::knob::line::{Line, Trouble};
use pacinian::io::knob::lost::Lost;
use pacinian::io::knob::odrive::{ODrive, Settings};
use pacinian::io::knob::port::{Port, SMART_KNOB_BAUD};
use pacinian::io::knob::servo::{News, Reading, Servo};
use pacinian::io::knob::smartknob::config::Config;
use pacinian::io::knob::smartknob::{self, Feel, SmartKnob};

use crate::hand::Hand;
use crate::odrive::{FakeODrive, Names};
use crate::smartknob::FakeSmartKnob;
use crate::terminal::{Terminal, wait};

/// A hand that can be looked at meanwhile.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Hand>>);

impl Servo for Shared {
    fn tick(&mut self, reading: &Reading) -> f64 {
        // Taken out, so that a panic does not poison it.
        let mut hand = self.0.lock().unwrap().clone();
        let torque = hand.tick(reading);
        self.0.lock().unwrap().clone_from(&hand);
        torque
    }

    fn lost(&mut self, why: &Lost) {
        self.0.lock().unwrap().lost(why);
    }

    fn news(&mut self, news: &News) {
        self.0.lock().unwrap().news(news);
    }
}

impl Shared {
    fn with<T>(&self, f: impl FnOnce(&mut Hand) -> T) -> T {
        f(&mut self.0.lock().unwrap())
    }
}

/// As patient as a machine that does many other things needs it.
fn settings() -> Settings {
    Settings { watchdog: 1.0, patience: 0.4, rate: 500.0, ..Settings::default() }
}

fn odrive(terminal: &Terminal<FakeODrive>, hand: &Shared) -> Running {
    let port = Port::open(terminal.name(), 115_200).unwrap().say_ready();
    run(port, ODrive::new(settings()).unwrap(), hand.clone()).unwrap()
}

#[test]
fn an_odrive_is_driven_and_left_idle() {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    let hand = Shared::default();
    hand.with(|hand| (hand.stiffness, hand.damping) = (0.05, 1e-3));
    terminal.device().hand = 0.01;
    let running = odrive(&terminal, &hand);
    wait("the spring", || {
        let device = terminal.device();
        (device.plant.angle() - 0.2).abs() < 5e-3 && device.plant.speed().abs() < 0.05
    });
    wait("many readings", || hand.with(|hand| hand.ticks > 200));
    let standing = running.standing();
    assert!(standing.ready && standing.lost.is_none() && !standing.ended, "{standing:?}");
    assert!(standing.round_trip.mean > 0.0 && standing.round_trip.worst < 1.0, "{standing:?}");
    let end = running.stop();
    assert!(end.ended && !end.ready && end.counts.lost == 0, "{end:?}");
    wait("the last bytes", || terminal.device().state == 1);
    let device = terminal.device();
    assert_eq!(
        (device.torque(), device.error, device.properties["axis0.config.enable_watchdog"]),
        (0.0, 0, 0.0)
    );
}

#[test]
fn the_watchdog_stops_the_motor_of_a_thread_that_ended() {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    let hand = Shared::default();
    hand.with(|hand| (hand.forced, hand.panics_at) = (Some(0.01), Some(100)));
    let running = odrive(&terminal, &hand);
    wait("torque", || terminal.device().torque() == 0.01 || terminal.device().error != 0);
    wait("its watchdog", || terminal.device().error == 0x800);
    assert_eq!(terminal.device().torque(), 0.0);
    drop(running);
}

#[test]
fn a_device_that_is_pulled_out_comes_back_as_itself() {
    let mut terminal = Terminal::new(FakeODrive::new(Names::Old));
    let hand = Shared::default();
    hand.with(|hand| (hand.stiffness, hand.damping) = (0.05, 1e-3));
    let running = odrive(&terminal, &hand);
    wait("readings", || hand.with(|hand| hand.ticks > 50));
    terminal.pull();
    wait("the loss", || hand.with(|hand| !hand.lost.is_empty()));
    assert!(matches!(hand.with(|hand| hand.lost[0].clone()), Lost::Vanished(_)));
    wait("it to be told", || matches!(running.standing().lost, Some(Lost::Vanished(_))));
    let ticks = hand.with(|hand| hand.ticks);
    // The hand is asked for nothing while it is away, and a board that had no current has no error.
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(hand.with(|hand| hand.ticks), ticks);
    *terminal.device() = FakeODrive::new(Names::Old);
    terminal.device().pass_to(terminal.now());
    terminal.plug();
    wait("its return", || hand.with(|hand| hand.ticks > ticks + 50));
    let standing = running.standing();
    assert!(standing.ready && standing.opened_again == 1 && standing.counts.lost >= 1, "{standing:?}");
    running.stop();
}

#[test]
fn what_is_no_knob_ends_the_thread() {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    terminal.device().mischief.echo = true;
    let hand = Shared::default();
    let running = odrive(&terminal, &hand);
    wait("the end", || running.standing().ended);
    assert!(matches!(running.standing().lost, Some(Lost::Echo(_))));
    assert_eq!(hand.with(|hand| (hand.ticks, hand.lost.len())), (0, 1));
    assert_eq!(terminal.device().state, 1);
}

#[test]
fn a_flood_is_borne_and_told() {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    let hand = Shared::default();
    let running = odrive(&terminal, &hand);
    wait("readings", || hand.with(|hand| hand.ticks > 50));
    terminal.device().mischief.flood = 1e5;
    wait("the loss", || hand.with(|hand| hand.lost.iter().any(|why| matches!(why, Lost::Flood(_)))));
    terminal.device().mischief.flood = 0.0;
    let ticks = hand.with(|hand| hand.ticks);
    wait("its return", || hand.with(|hand| hand.ticks > ticks + 50));
    running.stop();
}

#[test]
fn a_port_is_for_one_alone_and_has_no_wires_here() {
    let mut terminal = Terminal::new(FakeODrive::new(Names::Old));
    let mut port = Port::open(terminal.name(), SMART_KNOB_BAUD).unwrap().say_ready();
    let busy = Port::open(terminal.name(), 115_200).err().unwrap();
    assert_eq!(busy.kind, Trouble::Busy, "{busy}");
    terminal.pull();
    let mut bytes = [0; 8];
    let gone = (0..100).find_map(|_| port.read(&mut bytes, std::time::Duration::from_millis(50)).err());
    assert!(gone.is_some());
    assert!(port.write(b"x").is_err(), "it is closed");
    assert_eq!(port.open_again().unwrap_err().kind, Trouble::Missing);
    terminal.plug();
    port.open_again().unwrap();
    port.write(b"x").unwrap();
}

#[test]
fn a_smartknob_is_told_what_to_be() {
    for fork in [false, true] {
        let terminal = Terminal::new(FakeSmartKnob::new(fork));
        let hand = Shared::default();
        let settings = smartknob::Settings { seed: 9, parting: None };
        let (session, remote) = SmartKnob::new(settings).unwrap();
        let port = Port::open(terminal.name(), SMART_KNOB_BAUD).unwrap();
        let running = run(port, session, hand.clone()).unwrap();
        wait("readings", || hand.with(|hand| hand.ticks > 20));
        let config = Config { text: "CS S".into(), ..Config::default() };
        remote.set(Feel { config, origin: 0.0, stay: false }).unwrap();
        wait("it to be so", || hand.with(|hand| hand.news.contains(&News::InForce("CS S".into()))));
        terminal.device().press = 3;
        wait("a press", || hand.with(|hand| hand.news.contains(&News::Press(3))));
        terminal.device().hand = 0.004;
        wait("it to turn", || hand.with(|hand| hand.last.unwrap().angle > 0.5));
        let end = running.stop();
        assert!(end.ended && end.counts.lost == 0, "{end:?}");
        assert!(!terminal.device().calibrated && terminal.device().commands.is_empty());
    }
}
