//! Voices that are bent and pressed while they sound.
#![cfg(feature = "report")]

mod common;

use common::{channel, compiled, play, run};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Move, Play, Source};
use pacinian::graph::plan::{Plan, Precision};
use pacinian::node::motion::Motion;
use pacinian::report::measure::{OVER, designed};
use pacinian::report::{Comparison, Played, Reference, compare};
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;

/// A tone that follows the wheel, as loud as it is pressed, through a filter that follows the timbre.
const ALL: &str = r#"
[voice.v]
voices = 16
output = "o"
[voice.v.nodes]
t = { type = "sine", frequency = "event.frequency * touch.bend", amplitude = "0.2 + 0.8 * touch.pressure" }
f = { type = "lowpass", input = "t", cutoff = "80 + 400 * touch.timbre" }
e = { type = "envelope", attack = 0.01, release = 0.05 }
o = { type = "multiply", inputs = ["f", "e"] }
"#;

/// A tone that follows the wheel, and nothing else.
const BEND: &str = r#"
[voice.v]
voices = 16
output = "o"
[voice.v.nodes]
t = { type = "sine", frequency = "event.frequency * touch.bend" }
e = { type = "envelope", attack = 0.02, release = 0.05 }
o = { type = "multiply", inputs = ["t", "e"] }
"#;

type Moves = Vec<(f64, Move)>;

fn to(at: f64, id: u64, motion: Motion, value: f64) -> (f64, Move) {
    (at, Move { id, motion, value })
}

fn schedule(engine: &mut Engine, rate: f64, events: &[(f64, Play)], moves: &[(f64, Move)]) {
    for (at, play) in events {
        assert!(engine.schedule(Instant::of_samples(at * rate), Source::Program, Event::Play(*play)));
    }
    for (at, moved) in moves {
        assert!(engine.schedule(Instant::of_samples(at * rate), Source::Program, Event::Touch(*moved)));
    }
}

fn rendered(plan: &Plan, events: &[(f64, Play)], moves: &[(f64, Move)], seconds: f64) -> (Engine, Vec<f32>) {
    let mut engine = Engine::new(plan).unwrap();
    schedule(&mut engine, plan.engine_rate(), events, moves);
    let frames = run(&mut engine, (seconds * plan.engine_rate()).ceil() as usize * plan.ratio, &[480]);
    (engine, frames)
}

fn against(engine: &Engine, plan: &Plan, frames: &[f32], ideal: &Reference) -> Comparison {
    let delay = engine.delay();
    assert_eq!((engine.counters().stolen, engine.stage().counts().limited), (0, 0));
    let late = delay.lead + delay.up_sampling + delay.band_limit_phase;
    compare(frames, ideal, plan.ratio, late, &|channel, hertz| designed(engine, channel, hertz))
}

/// Where a way of straight lines stands, and its integral from 0: the definition, told anew.
fn way(moves: &[(f64, f64)], smoothing: f64, t: f64) -> (f64, f64) {
    let (mut corners, mut value) = (vec![(0.0, 0.0)], 0.0);
    for (i, (at, goal)) in moves.iter().enumerate() {
        let end = moves.get(i + 1).map_or(f64::INFINITY, |next| next.0).min(at + smoothing);
        corners.push((*at, value));
        value += (goal - value) * (end - at) / smoothing;
        corners.push((end, value));
    }
    let (mut integral, mut before) = (0.0, (0.0, 0.0));
    for corner in corners.into_iter().chain([(f64::INFINITY, value)]) {
        if corner.0 >= t {
            let slope =
                if corner.0.is_finite() { (corner.1 - before.1) / (corner.0 - before.0) } else { 0.0 };
            let now = before.1 + slope * (t - before.0);
            return (now, integral + 0.5 * (before.1 + now) * (t - before.0));
        }
        integral += 0.5 * (before.1 + corner.1) * (corner.0 - before.0);
        before = corner;
    }
    unreachable!("the last corner lies beyond every time")
}

/// The phase of a bent sine is the integral of its frequency, from its definition, and nothing of the program takes part in it.
#[test]
fn a_bent_sine_is_the_integral_of_its_frequency() {
    // Up in small steps, as a wheel sends them, down at once, and up again while it is still on its way.
    let mut wheel: Vec<(f64, f64)> =
        (0..40).map(|i| (0.1 + 0.0047 * f64::from(i), Motion::detune(0.05 * f64::from(i)))).collect();
    wheel.extend([(0.4001, -0.25), (0.4043, 0.5), (0.7, 0.0)]);
    let (onset, hertz, held) = (0.0123456, 110.0, 0.9);
    for (precision, most) in [(Precision::Single, -90.0), (Precision::Double, -95.0)] {
        let mut plan = compiled(BEND, 1, 48_000.0).plan;
        plan.precision = precision;
        let moves: Moves = wheel.iter().map(|(t, d)| to(onset + t, 5, Motion::Detune, *d)).collect();
        let (engine, frames) =
            rendered(&plan, &[(onset, Play { level: 0.5, ..play(0, 0, hertz, held, 5) })], &moves, 1.3);
        let rate = plan.engine_rate();
        let samples = (1.3 * rate) as usize;
        let value = |n: usize| {
            let t = n as f64 / rate - onset;
            if t <= 0.0 {
                return 0.0;
            }
            let edge = (t / 0.02).min(1.0) * (1.0 - ((t - held) / 0.05).clamp(0.0, 1.0));
            let turns = hertz * (t + way(&wheel, 0.01, t).1);
            0.5 * edge * (std::f64::consts::TAU * turns).sin()
        };
        let ideal = Reference { rate, channels: vec![(0..samples).map(value).collect()] };
        let found = against(&engine, &plan, &frames, &ideal);
        assert!(found.error_db < most, "{precision:?}: {found:?}");
        // One that is not bent is something else altogether.
        let (engine, frames) =
            rendered(&plan, &[(onset, Play { level: 0.5, ..play(0, 0, hertz, held, 5) })], &[], 1.3);
        assert!(against(&engine, &plan, &frames, &ideal).error_db > -10.0);
    }
}

/// A dozen voices on four channels, each moved in all three ways from its onset on, at instants between samples.
fn dozen() -> (Vec<(f64, Play)>, Moves) {
    let events: Vec<(f64, Play)> = (0..12_u32)
        .map(|i| {
            let one = play(0, i % 4, 60.0 + 17.3 * f64::from(i), 0.25, u64::from(i));
            (0.01 + 0.0431 * f64::from(i), Play { level: 0.2, ..one })
        })
        .collect();
    let mut moves = Moves::new();
    for (at, play) in &events {
        let i = play.id as f64;
        moves.push(to(*at, play.id, Motion::Pressure, 0.08 * i));
        moves.push(to(*at, play.id, Motion::Detune, 0.02 * i));
        for n in 0..25 {
            let (at, n) = (at + 0.00971 * (f64::from(n) + 0.07 * i), f64::from(n));
            moves.push(to(at, play.id, Motion::Detune, 0.1 * (0.7 * n + i).sin()));
            moves.push(to(at + 0.0004, play.id, Motion::Pressure, 0.5 + 0.5 * (0.5 * n + i).sin()));
            moves.push(to(at + 0.0009, play.id, Motion::Timbre, 0.5 + 0.4 * (0.3 * n - i).sin()));
        }
    }
    moves.sort_by(|a, b| a.0.total_cmp(&b.0));
    (events, moves)
}

#[test]
fn the_engine_moves_voices_as_their_definitions_say() {
    let (events, moves) = dozen();
    for rate in [48_000.0, 44_100.0] {
        let plan = compiled(ALL, 4, rate).plan;
        let (engine, frames) = rendered(&plan, &events, &moves, 1.3);
        let seconds = frames.len() as f64 / 4.0 / rate;
        let of = |moves: &[(f64, Move)]| {
            let played = Played { events: &events, moves, input: &[], released: f64::INFINITY };
            let watch = &mut |_| Ok::<(), std::convert::Infallible>(());
            let Ok(all) = pacinian::report::reference_watched(&plan, &played, seconds, OVER, watch);
            all
        };
        let found = against(&engine, &plan, &frames, &of(&moves));
        println!("{rate} Hz: {found:?}");
        assert!(found.error_db < -80.0 && found.above_db < -60.0, "{rate}: {found:?}");
        assert!(against(&engine, &plan, &frames, &of(&[])).error_db > -20.0, "moves must matter");
    }
}

#[test]
fn no_lane_hears_what_another_is_told() {
    let (events, moves) = dozen();
    let plan = compiled(ALL, 12, 48_000.0).plan;
    let events: Vec<(f64, Play)> =
        events.iter().map(|(at, of)| (*at, Play { place: Spot::Row(of.id as u32), ..*of })).collect();
    let (_, all) = rendered(&plan, &events, &moves, 1.0);
    for one in &events {
        let own: Moves = moves.iter().filter(|(_, of)| of.id == one.1.id).copied().collect();
        let (_, alone) = rendered(&plan, &[*one], &own, 1.0);
        let c = one.1.id as usize;
        let (all, alone) = (channel(&all, 12, c), channel(&alone, 12, c));
        assert!(all.iter().any(|x| *x != 0.0));
        assert!(all.iter().zip(&alone).all(|(a, b)| a.to_bits() == b.to_bits()), "voice {c}");
    }
}

#[test]
fn cuts_and_instruction_sets_change_no_bit() {
    let (events, moves) = dozen();
    for precision in [Precision::Single, Precision::Double] {
        let mut plan = compiled(ALL, 4, 48_000.0).plan;
        plan.precision = precision;
        let bits = |isa, calls: &[usize]| -> Vec<u32> {
            let mut engine = Engine::with_isa(&plan, isa).unwrap();
            schedule(&mut engine, plan.engine_rate(), &events, &moves);
            run(&mut engine, 48_000, calls).iter().map(|x| x.to_bits()).collect()
        };
        let whole = bits(pacinian::dsp::isa::Isa::detect(), &[48_000]);
        for calls in [&[1][..], &[7], &[64], &[3, 1000, 1, 17, 250, 64]] {
            assert!(bits(pacinian::dsp::isa::Isa::detect(), calls) == whole, "{precision:?} in {calls:?}");
        }
        assert!(bits(pacinian::dsp::isa::Isa::Baseline, &[480]) == whole, "{precision:?}");
    }
}

/// What a voice is told at its onset it has from its first sample on; what it is told later it is on its way to.
#[test]
fn a_voice_begins_where_it_is_told_to_be_at_its_onset() {
    let text = ALL.replace("\"event.frequency * touch.bend\"", "\"event.frequency\"");
    let plan = compiled(&text, 1, 48_000.0).plan;
    let events = [(0.01003, Play { level: 0.5, ..play(0, 0, 110.0, 0.1, 3) })];
    let pressed = |at: f64| rendered(&plan, &events, &[to(at, 3, Motion::Pressure, 0.75)], 0.3).1;
    // 0.2 + 0.8 × 0.75, as a number.
    let loud = text.replace("0.2 + 0.8 * touch.pressure", "0.8");
    let loud = rendered(&compiled(&loud, 1, 48_000.0).plan, &events, &[], 0.3).1;
    let differs = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(differs(&pressed(0.01003), &loud) < 1e-6, "{}", differs(&pressed(0.01003), &loud));
    assert!(differs(&pressed(0.01103), &loud) > 1e-3);
    // Nobody is there yet.
    assert!(differs(&pressed(0.01002), &rendered(&plan, &events, &[], 0.3).1) == 0.0);
}

#[test]
fn a_voice_that_was_released_is_still_in_the_hand() {
    let plan = compiled(&ALL.replace("release = 0.05", "release = 0.5"), 1, 48_000.0).plan;
    let events = [(0.01, play(0, 0, 110.0, 0.1, 3))];
    let (_, let_go) = rendered(&plan, &events, &[], 0.7);
    let (_, pressed) = rendered(&plan, &events, &[to(0.2, 3, Motion::Pressure, 1.0)], 0.7);
    let loudest = |frames: &[f32], from: f64, until: f64| {
        frames[(from * 48_000.0) as usize..(until * 48_000.0) as usize]
            .iter()
            .fold(0.0_f32, |a, x| a.max(x.abs()))
    };
    assert_eq!(loudest(&let_go, 0.0, 0.2), loudest(&pressed, 0.0, 0.2));
    let ratio = loudest(&pressed, 0.25, 0.3) / loudest(&let_go, 0.25, 0.3);
    assert!((ratio - 5.0).abs() < 0.05, "{ratio}");
}

/// A voice that had to make room for another in the middle of a bend takes its bend with it.
#[test]
fn a_stolen_voice_leaves_nothing_behind() {
    let one = BEND.replace("voices = 16", "voices = 1");
    let plan = compiled(&one, 2, 48_000.0).plan;
    let first = (0.01, play(0, 0, 110.0, 1.0, 1));
    let second = (0.1003, play(0, 1, 90.0, 0.3, 2));
    let bends = |until: f64| -> Moves {
        (0..40)
            .map(|i| 0.05 + 0.005 * f64::from(i))
            .filter(|at| *at < until)
            .map(|at| to(at, 1, Motion::Detune, 3.0 * at))
            .collect()
    };
    let (engine, all) = rendered(&plan, &[first, second], &bends(1.0), 0.6);
    assert_eq!(engine.counters().stolen, 1);
    let (_, before) = rendered(&plan, &[first, second], &bends(0.1003), 0.6);
    assert!(all.iter().zip(&before).all(|(a, b)| a.to_bits() == b.to_bits()), "what fades is not in a hand");
    let (_, alone) = rendered(&plan, &[second], &[], 0.6);
    let (with, alone) = (channel(&all, 2, 1), channel(&alone, 2, 1));
    assert!(with.iter().any(|x| *x != 0.0));
    assert!(with.iter().zip(&alone).all(|(a, b)| a.to_bits() == b.to_bits()), "the next begins at rest");
}

#[test]
fn hostile_moves_do_no_harm() {
    let plan = compiled(ALL, 4, 48_000.0).plan;
    let (events, _) = dozen();
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, -0.0, 1e-310, 5.0];
    let mut moves = Moves::new();
    for (i, (at, play)) in events.iter().enumerate() {
        for n in 0..200_u32 {
            // Many at one instant, many ids that nobody has, before and after the voice.
            let at = at - 0.02 + 0.002 * f64::from(n / 4);
            let id = if n % 7 == 0 { u64::MAX - u64::from(n) } else { play.id };
            moves.push(to(at, id, Motion::ALL[(n as usize + i) % 3], odd[(n as usize * 3 + i) % odd.len()]));
        }
    }
    let (engine, frames) = rendered(&plan, &events, &moves, 1.5);
    assert!(frames.iter().all(|x| x.is_finite() && x.abs() <= 1.0));
    assert!(engine.is_silent(), "all have ended");
    assert_eq!(engine.counters().dropped, 0);
}

/// A voice that reads nothing of it has nothing for it, and is the same bit by bit, whatever it is told.
#[test]
fn who_does_not_listen_pays_nothing() {
    let text = ALL
        .replace("event.frequency * touch.bend", "event.frequency")
        .replace("0.2 + 0.8 * touch.pressure", "0.5")
        .replace("80 + 400 * touch.timbre", "200");
    let plan = compiled(&text, 4, 48_000.0).plan;
    assert_eq!(plan.instruments[0].hears(), [false; 3]);
    assert!(plan.instruments[0].program.ops.iter().all(|op| !op.node.name.starts_with("touch")));
    let (events, moves) = dozen();
    let (told, untold) = (rendered(&plan, &events, &moves, 1.0).1, rendered(&plan, &events, &[], 1.0).1);
    assert!(told.iter().zip(&untold).all(|(a, b)| a.to_bits() == b.to_bits()));
    assert_eq!(compiled(ALL, 1, 48_000.0).plan.instruments[0].hears(), [true; 3]);
    assert_eq!(compiled(BEND, 1, 48_000.0).plan.instruments[0].hears(), [true, false, false]);
}

/// While nobody moves, a tone that could be bent keeps the frequency that it is told, in full precision.
#[test]
fn a_wheel_at_rest_costs_no_precision() {
    let plan = compiled(BEND, 1, 48_000.0).plan;
    let ops = &plan.instruments[0].program;
    let sine = ops.ops.iter().find(|op| op.node.kind.spec().name == "sine").unwrap();
    assert!(matches!(ops.steady[sine.inputs[0].base as usize], pacinian::graph::Base::Start(_)));
    let factors =
        compiled(&BEND.replace("event.frequency * touch.bend", "2 * touch.bend * event.frequency"), 1, 48e3);
    let ops = &factors.plan.instruments[0].program;
    let sine = ops.ops.iter().find(|op| op.node.kind.spec().name == "sine").unwrap();
    assert!(matches!(ops.steady[sine.inputs[0].base as usize], pacinian::graph::Base::Start(_)));
    // And a plain tone gives the same.
    let events = [(0.01, Play { level: 0.5, ..play(0, 0, 123.456, 2.0, 1) })];
    let (engine, frames) = rendered(&plan, &events, &[], 2.3);
    let plain = compiled(&BEND.replace("event.frequency * touch.bend", "event.frequency"), 1, 48_000.0).plan;
    let ideal = pacinian::report::reference(&plain, &events, 2.3, OVER);
    let found = against(&engine, &plan, &frames, &ideal);
    assert!(found.error_db < -95.0, "{found:?}");
}
