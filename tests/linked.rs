//! A session whose knob a slow thread sends worlds to.
#![cfg(feature = "live")]

mod common;

use std::time::{Duration, Instant};

use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::session::{Beginning, Session};
use pacinian::knob::local_model::link::Seen;
use pacinian::knob::local_model::model::{Contact, LocalModel};
use pacinian::knob::local_model::pending::Message;
use pacinian::knob::safety::chain::Trip;
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;
use pacinian::live::torque::Torque;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;

const FREE: &str = "[knob.effects]\nf = { type = \"constant\", torque = 0 }\n";
const SOUND: &str =
    "[voice.v]\nstart = \"always\"\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 100 }\n";

fn reload(text: &str) -> Reload {
    // The rate of the virtual card.
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Reload::of(common::patch(text), Rig::default_for(1), &options, &NoAssets).unwrap()
}

fn session(text: &str, link_knob: bool) -> Session {
    let beginning = Beginning { link_knob, ..Beginning::of(reload(text), Chosen::Virtual(None)) };
    Session::start(beginning).unwrap_or_else(|error| panic!("{error}"))
}

/// A wall that comes thirty times a second, also behind a patch that takes over: the hand holds with 0.3 N m/rad at 1 rad, the wall with 0.2 beyond 0.5, and
/// they meet at 0.8, but for friction.
#[test]
fn a_wall_of_a_slow_thread_is_felt_and_goes_on_behind_a_new_patch() {
    let mut session = session(FREE, true);
    let mut slow = session.linked_knob().unwrap();
    assert!(session.linked_knob().is_none(), "there is one");
    let mut until = |what: &str, angle: f64, stiffness: f64| {
        let begin = Instant::now();
        loop {
            let look = slow.look();
            let rests = look.velocity.abs() < 0.01 && (look.angle - angle).abs() < 0.01;
            if rests && (look.torque + stiffness * (angle - 0.5)).abs() < 0.003 {
                return;
            }
            assert!(begin.elapsed() < Duration::from_secs(20), "{what}: {look:?}");
            let contact = Contact { angle: 0.5, below: false, stiffness };
            let range = (look.angle - 1.0, look.angle + 1.0);
            let model = LocalModel { stamp: look.tick, contact: Some(contact), range, ..LocalModel::FREE };
            slow.send(Message::new(model, 0.0));
            std::thread::sleep(Duration::from_millis(33));
        }
    };
    session.handle().send(Signal::Set("hand".into(), 1.0)).unwrap();
    until("the wall", 0.8, 0.2);
    session.handle().send(Signal::Reload(Box::new(reload(&format!("{FREE}{SOUND}"))))).unwrap();
    // Twice as stiff, less deep.
    until("another wall, behind another patch", (0.3 + 0.4 * 0.5) / 0.7, 0.4);
}

/// A simulated knob that is turned faster than its motor may turn loses its torque as a real one does, is told to have, and gets it back when asked.
#[test]
fn a_simulated_knob_that_was_too_fast_gets_its_torque_back_when_asked() {
    let mut session = session("[knob.effects]\ns = { type = \"spring\", stiffness = 0.003 }\n", true);
    let mut slow = session.linked_knob().unwrap();
    let mut until = |what: &str, holds: &dyn Fn(&Seen, Torque) -> bool| {
        let begin = Instant::now();
        while !holds(&slow.look(), session.board().torque()) {
            assert!(begin.elapsed() < Duration::from_secs(20), "{what}: {:?}", session.board().torque());
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let send = |signal: Signal| session.handle().send(signal).unwrap();
    send(Signal::Set("hand".into(), 3.0));
    let rests = |seen: &Seen| seen.velocity.abs() < 0.1 && seen.angle > 2.7;
    until("the spring", &|seen, torque| rests(seen) && seen.torque < -0.005 && torque == Torque::Simulated);
    // 90 rad/s.
    send(Signal::Set("hand".into(), -6.0));
    until("the fall", &|seen, torque| torque == Torque::Fallen(Trip::OverSpeed) && seen.torque == 0.0);
    until("rest", &|seen, _| seen.velocity.abs() < 0.1 && seen.angle < -5.5);
    send(Signal::Torque(true));
    until("the spring again", &|seen, torque| seen.torque > 0.01 && torque == Torque::Simulated);
    send(Signal::Torque(false));
    until("nothing", &|seen, torque| seen.torque == 0.0 && torque == Torque::Off);
}

#[test]
fn there_is_an_end_where_it_was_asked_for_and_a_knob_is_there() {
    for (text, asked, there) in [(FREE, false, false), (SOUND, true, false), (FREE, true, true)] {
        assert_eq!(session(text, asked).linked_knob().is_some(), there, "{text} {asked}");
    }
}
