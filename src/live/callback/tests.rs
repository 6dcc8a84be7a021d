use std::sync::Arc;

use ringbuf::traits::{Consumer, Observer, Producer};

use super::{Callback, Cue, Deed, FOR_PROGRAM, PATTERNS, Rings, SOURCES, UNDER_WAY};
use crate::engine::event::{Event, Play, Source};
use crate::engine::exchange::exchange;
use crate::engine::turnover::{Turn, Turned};
use crate::graph::scene::{Options, scene};
use crate::graph::start::FIELDS;
use crate::live::board::Board;
use crate::live::gate::{Gate, Order};
use crate::node::asset::NoAssets;
use crate::patch::Patch;
use crate::rig::Rig;
use crate::schedule::Instant;
use crate::space::spot::Spot;

const STOPS: usize = 0;
const PROGRAM: usize = 2;

/// A callback that takes up to 64 frames, which are 11 engine samples, and the other ends of its rings.
fn callback() -> (Callback, Rings) {
    let text = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"s\"\n\
        [voice.v.nodes]\ns = { type = \"sine\", frequency = 100 }\n";
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let scene = scene(&patch, &Rig::default_for(1), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    let (_director, stagehand) = exchange(&scene.plan).unwrap();
    Callback::new(stagehand, Gate::new(48_000.0, 1.0), Arc::new(Board::new(1)))
}

fn at(sample: u64) -> Instant {
    Instant { sample, fraction: 0 }
}

fn send(rings: &mut Rings, source: usize, sample: u64, event: Event) {
    let cue = Cue { plan: 0, at: at(sample), event, cause: 0 };
    rings.cues[source].try_push(cue).unwrap_or_else(|_| panic!("no room"));
}

/// A marker of a pattern of that id.
fn marker(id: u64) -> Event {
    Event::Marker(0, id << 8)
}

/// What a callback gave to the engine.
fn given(callback: &mut Callback, rings: &mut Rings) -> Vec<(Instant, Source, Event)> {
    callback.process(&[], &mut [0.0; 64]);
    let deeds = rings.reports.pop_iter().map(|report| report.deed);
    let event = |deed| match deed {
        Deed::Event { due, source, event, .. } => Some((due, source, event)),
        _ => None,
    };
    deeds.filter_map(event).collect()
}

/// Fills the engine with markers of a pattern that are due at `sample`, as far as patterns may, and its ring.
fn flood(callback: &mut Callback, rings: &mut Rings, id: u64, sample: u64) {
    while callback.stagehand.engine().room() > FOR_PROGRAM {
        send(rings, PATTERNS, sample, marker(id));
        if rings.cues[PATTERNS].is_full() {
            given(callback, rings);
        }
    }
    while !rings.cues[PATTERNS].is_full() {
        send(rings, PATTERNS, sample, marker(id));
    }
}

#[test]
fn patterns_leave_room_for_what_lets_go() {
    assert_eq!((SOURCES[STOPS], SOURCES[PROGRAM]), (Source::Stop, Source::Program));
    let (mut callback, mut rings) = callback();
    flood(&mut callback, &mut rings, 1, 1_000_000);
    given(&mut callback, &mut rings);
    assert_eq!(callback.stagehand.engine().room(), FOR_PROGRAM);
    send(&mut rings, PROGRAM, 0, Event::Release(7));
    let taken = given(&mut callback, &mut rings);
    assert_eq!(taken, [(at(0), Source::Program, Event::Release(7))]);
}

#[test]
fn what_is_called_off_on_its_way_does_not_begin() {
    let (mut callback, mut rings) = callback();
    flood(&mut callback, &mut rings, 3, 1_000_000);
    given(&mut callback, &mut rings);
    while rings.cues[PATTERNS].vacant_len() < UNDER_WAY {
        callback.cues[PATTERNS].try_pop().unwrap();
    }
    for (sample, id) in [(400_000, 1), (600_000, 2), (600_000, 1), (500_000, 1), (499_999, 1)] {
        send(&mut rings, PATTERNS, sample, marker(id));
    }
    send(&mut rings, STOPS, 500_000, Event::Cancel(1 << 8, 8));
    let taken = given(&mut callback, &mut rings);
    assert_eq!(taken, [(at(500_000), Source::Stop, Event::Cancel(1 << 8, 8))], "no pattern has room");
    // What is sent later is no affair of that call.
    send(&mut rings, PATTERNS, 700_000, marker(1));
    // Now there is room.
    send(&mut rings, PROGRAM, 0, Event::Cancel(3 << 8, 8));
    let taken = (0..4).flat_map(|_| given(&mut callback, &mut rings)).collect::<Vec<_>>();
    let begins = taken.iter().filter(|(_, source, _)| *source == Source::Pattern);
    let begins: Vec<_> = begins.map(|(due, _, event)| (due.sample, *event)).collect();
    assert_eq!(
        begins,
        [(400_000, marker(1)), (600_000, marker(2)), (499_999, marker(1)), (700_000, marker(1))]
    );
}

/// Nobody fetches what is told: of what lets sound begin and what shuts it, that is told which decides whether anything leaves.
#[test]
fn what_the_gate_is_told_is_reported_behind_any_number_of_events() {
    let (mut callback, mut rings) = callback();
    let mut sent = 0_u64;
    while sent < 2 * super::REPORTS as u64 {
        for _ in 0..1000 {
            send(&mut rings, PROGRAM, 0, Event::Control(0, 0.5));
            sent += 1;
        }
        callback.process(&[], &mut [0.0; 64]);
    }
    for order in [Order::Latch, Order::Release, Order::Close] {
        callback.order(order);
    }
    let deeds: Vec<_> = rings.reports.pop_iter().map(|report| report.deed).collect();
    // That of the voice which always sounds.
    let (turns, deeds): (Vec<_>, Vec<_>) = deeds.into_iter().partition(|deed| matches!(deed, Deed::Turn(_)));
    assert_eq!(turns.len(), 1);
    let orders = deeds.iter().filter(|deed| matches!(deed, Deed::Order(..))).count() as u64;
    assert_eq!(deeds.last(), Some(&Deed::Order(Order::Close, 0)));
    assert_eq!((orders, deeds.len() as u64 - orders + callback.board.untold.get()), (3, sent));
}

/// Nobody fetches what is told: voices that make room, of which a replay knows by itself, leave half of the room to what it needs.
#[test]
fn a_flood_of_voices_that_make_room_leaves_room_for_what_is_played() {
    let (mut callback, mut rings) = callback();
    let play = Play {
        instrument: 0,
        place: Spot::Row(0),
        level: 0.1,
        felt: None,
        duration: 1.0,
        own: [0.0; FIELDS],
        id: 7,
    };
    let mut sent = 0;
    while sent < 2 * super::REPORTS {
        for _ in 0..1000 {
            send(&mut rings, PROGRAM, 0, Event::Play(play));
        }
        callback.process(&[], &mut [0.0; 64]);
        sent += 1000;
    }
    let deeds: Vec<_> = rings.reports.pop_iter().map(|report| report.deed).collect();
    let last =
        deeds.iter().rposition(|deed| matches!(deed, Deed::Turn(Turn { what: Turned::Stolen(7, 7), .. })));
    assert!(last.is_some_and(|last| last < super::REPORTS / 2), "{last:?} of {}", deeds.len());
    let played = deeds.iter().filter(|deed| matches!(deed, Deed::Event { .. })).count();
    assert!(played > super::REPORTS / 2, "{played}");
    assert_eq!(
        played as u64 + callback.board.untold.get(),
        sent as u64,
        "and no voice that made room is missed"
    );
}
