//! Clicks after the way home: from where the mass is known to hang they stop it, though gravity pulls at it.

use super::{RATE, run};
use crate::common::{channel, patch};
use pacinian::actuator::motor::{Drive, Level, Motor, Plan};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::FIELDS;
use pacinian::node::asset::NoAssets;
use pacinian::rig::{OutputKind, Rig};
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;
use std::f64::consts::{LN_2, PI, TAU};

/// Three upright motors, two of them coins, the third with and without a coil that counts.
fn rig(henries: f64) -> Rig {
    let mut text = String::from(
        "format = \"pacinian-rig/1\"\ntitle = \"Upright\"\n[device]\nchannels = 3\nfull_scale_volts = 5.0\ncoupling = \"dc\"\n\
         [amplifier.bridge]\ngain = 3.0\nmax_volts = 12.0\ncoupling = \"dc\"\n[actuator.coin]\npart = \"coin-10mm\"\n\
         [actuator.other]\npart = \"precision-microdrives-304-002\"\n[actuator.pad]\nmodel = \"rumble-motor\"\nrated_volts = 12.5\n\
         resistance = 10.42\ntorque_constant = 0.011\ninertia = 1.15e-7\nviscous_friction = 1e-6\ncoulomb_friction = 2e-4\n\
         static_friction = 4e-4\neccentric_moment = 1.38e-5\nmass = 0.25\n",
    );
    text += &format!("inductance = {henries}\n");
    for (n, name) in ["coin", "other", "pad"].iter().enumerate() {
        text += &format!(
            "[[output]]\nkind = \"drive\"\nname = \"{name}\"\nchannel = {}\nactuator = \"{name}\"\namplifier = \"bridge\"\n\
             shaping = \"overdrive\"\ntilt = 0.0\n",
            n + 1
        );
    }
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

const VOICES: &str = "[voice.home]\noutput = \"go\"\n[voice.home.nodes]\ngo = { type = \"drive-home\" }\n\
    [voice.click]\noutput = \"go\"\n[voice.click.nodes]\ngo = { type = \"drive-click\", turns = 0.25 }\n\
    [voice.thump]\noutput = \"go\"\n[voice.thump.nodes]\ngo = { type = \"drive-click\", turns = 1.0 }\n";
const HOME: u32 = 0;
const CLICK: u32 = 1;
const THUMP: u32 = 2;

/// What is played live: when (s), which voice, how strongly; on every motor.
fn sent(plan: &plan::Plan, played: &[(f64, u32, f64)], seconds: f64, calls: &[usize]) -> Vec<Vec<f64>> {
    let frames = run(&mut engine(plan, played), (seconds * RATE) as usize, calls);
    volts(plan, &frames)
}

/// The same until nothing sounds, nothing waits and every motor is where it stays: in fewer seconds than these.
fn rendered(plan: &plan::Plan, played: &[(f64, u32, f64)], most: f64) -> Vec<Vec<f64>> {
    let (mut engine, mut frames) = (engine(plan, played), Vec::new());
    while !engine.is_silent() {
        frames.extend(run(&mut engine, 480, &[480]));
        assert!(frames.len() < 3 * (most * RATE) as usize, "it is never over");
    }
    volts(plan, &frames)
}

/// In which that is to be played.
fn engine(plan: &plan::Plan, played: &[(f64, u32, f64)]) -> Engine {
    let mut engine = Engine::new(plan).unwrap();
    for (at, instrument, level) in played {
        for place in 0..3 {
            let play = Play {
                instrument: *instrument,
                place: Spot::Row(place),
                level: *level,
                felt: None,
                duration: 0.01,
                own: [0.0; FIELDS],
                id: 0,
            };
            let at = Instant::of_samples(at * plan.engine_rate());
            assert!(engine.schedule(at, Source::Program, Event::Play(play)));
        }
    }
    engine
}

/// What reaches every motor.
fn volts(plan: &plan::Plan, frames: &[f32]) -> Vec<Vec<f64>> {
    let volts = |drive: &plan::Drive| {
        let samples = channel(frames, 3, drive.channel as usize);
        samples.iter().map(|sample| sample * drive.per_sample).collect()
    };
    plan.drives.iter().map(volts).collect()
}

/// The share of its peak speed with which a motor turns when what drives it backward is over and its coil is empty; of what begins at a time (s).
fn left(motor: &mut Motor, volts: &[f64], from: f64, to: f64, done: &mut usize) -> f64 {
    let (mut peak, mut drives, mut end, mut is) = (0.0_f64, [0.0_f64; 2], None, 0.0);
    let coil = (motor.parameters().electrical_time() * LN_2 * RATE).ceil() as usize;
    while *done < (to * RATE) as usize {
        let given = volts[*done];
        motor.drive(Drive::Voltage(given));
        motor.step();
        *done += 1;
        if *done <= (from * RATE) as usize {
            continue;
        }
        peak = peak.max(motor.speed().abs());
        let [forward, backward] = &mut drives;
        // What is left of a click before is braked by less; and the first frame may be less, as a click begins anywhere.
        if given.abs() > 0.3 && *backward == 0.0 {
            if given * *forward >= 0.0 {
                *forward = if given.abs() > forward.abs() { given } else { *forward };
            } else if given.abs() > 0.999 * forward.abs() {
                *backward = given;
            }
        } else if *backward != 0.0 && end.is_none() && given / *backward < 0.999 {
            end = Some(*done + coil);
        }
        if end == Some(*done) {
            is = motor.speed().abs();
        }
    }
    assert!(end.is_some() && peak > 0.0, "there is a click in {from} s to {to} s");
    is / peak
}

/// What must hold of a click from a known place: less than 0.5 % of its peak speed is left when its drive ends. Home first, then a quarter turn
/// and back, a weak one and back, and a whole one.
#[test]
fn clicks_after_the_way_home_stop_the_rotor() {
    for henries in [0.0, 4.2e-3] {
        let options = Options { rate: Some(RATE), live: true, ..Options::default() };
        let plan =
            scene(&patch(VOICES), &rig(henries), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan;
        assert_eq!(plan.homes.len(), 3);
        let begin = 0.02 + plan.homes.iter().map(|(_, home)| home.seconds()).fold(0.0, f64::max) + 0.2;
        let clicks = [(CLICK, 1.0), (CLICK, -0.8), (CLICK, 0.6), (CLICK, -1.0), (THUMP, 1.0)];
        let mut played = vec![(0.01, HOME, 1.0)];
        played
            .extend((0..).zip(clicks).map(|(n, (which, level))| (begin + 0.3 * f64::from(n), which, level)));
        let seconds = begin + 0.3 * 5.0;
        let all = sent(&plan, &played, seconds, &[480]);
        assert_eq!(all, sent(&plan, &played, seconds, &[64, 1, 333]), "however it is cut");
        // The same clicks, as if the motors lay flat.
        let blind = sent(&plan, &played[1..], seconds, &[480]);
        for (n, drive) in plan.drives.iter().enumerate() {
            let parameters = &drive.setup.parameters;
            let (_, home) = plan.homes.iter().find(|(of, _)| *of == n).unwrap();
            let (mut worst, mut flat) = ([0.0_f64; 5], [0.0_f64; 5]);
            for first in (0..6).map(|n| TAU * (f64::from(n) + 0.21) / 6.0) {
                let mut motor = Motor::<false>::new(parameters, &Plan::whole(Level::Fine), RATE).unwrap();
                motor.place(first, 0.0);
                let mut done = (begin * RATE) as usize;
                for volts in &all[n][..done] {
                    motor.drive(Drive::Voltage(*volts));
                    motor.step();
                }
                let off = (motor.reading().angle - home.angle).sin().abs();
                assert!(off <= home.spread.sin() + 0.01, "{first}: {off} {home:?}");
                // What is asked is of a known angle; what home is off by is its own.
                motor.place(home.angle, 0.0);
                let mut other = motor.clone();
                let mut behind = done;
                for n_th in 0..5 {
                    let (from, to) = (begin + 0.3 * n_th as f64, begin + 0.3 * (n_th + 1) as f64);
                    worst[n_th] = worst[n_th].max(left(&mut motor, &all[n], from, to, &mut done));
                    flat[n_th] = flat[n_th].max(left(&mut other, &blind[n], from, to, &mut behind));
                }
            }
            println!(
                "channel {n}, {henries} H: {:.3?} % left, {:.2?} % as if flat, home {:.1} degrees within {:.1}",
                worst.map(|x| 100.0 * x),
                flat.map(|x| 100.0 * x),
                home.angle.to_degrees(),
                home.spread.to_degrees()
            );
            assert!(worst.iter().all(|left| *left < 0.005), "{n} {henries}: {worst:?} {flat:?}");
            assert!(flat[0] > 0.005, "{n}: gravity counts: {flat:?}");
        }
    }
}

/// Through the whole engine too: with `park` in the rig every click of a row begins where the mass was brought, wherever it hung at first and whatever the
/// clicks before it left; without it they begin elsewhere. A render is over once the last of them is home again.
#[test]
fn every_parked_click_begins_at_home() {
    let planned = |park: bool| {
        let mut rig = rig(4.2e-3);
        for output in &mut rig.outputs {
            if let OutputKind::Drive(turning) = &mut output.kind {
                turning.park = park.then_some(0.1);
            }
        }
        let options = Options { rate: Some(RATE), live: true, ..Options::default() };
        scene(&patch(VOICES), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    };
    let plans = [planned(true), planned(false)];
    let way = plans[0].homes.iter().map(|(_, home)| home.seconds()).fold(0.0, f64::max);
    // Long enough to come to rest, to rest, to go home and to rest there.
    let pause = 0.6 + 0.1 + way + 0.3;
    let levels = [1.0, 0.5, 1.0, 0.3, -0.8, 1.0];
    let begins = |n: usize| 0.02 + way + 0.6 + pause * n as f64;
    let mut played = vec![(0.01, HOME, 1.0)];
    played.extend(levels.iter().enumerate().map(|(n, level)| (begins(n), CLICK, *level)));
    let [parked, left] = plans.each_ref().map(|plan| sent(plan, &played, begins(levels.len()), &[480, 64]));
    for (n, drive) in plans[0].drives.iter().enumerate() {
        let (_, home) = plans[0].homes.iter().find(|(of, _)| *of == n).unwrap();
        let late = crate::late(&plans[0], drive.channel as usize);
        let farthest = |volts: &[f64], first: f64| {
            let mut motor =
                Motor::<false>::new(&drive.setup.parameters, &Plan::whole(Level::Fine), RATE).unwrap();
            motor.place(first, 0.0);
            let mut most = 0.0_f64;
            let mut frame = 0;
            for click in 0..levels.len() {
                let until = ((begins(click) + late) * RATE) as usize;
                for volts in &volts[frame..until] {
                    motor.drive(Drive::Voltage(*volts));
                    motor.step();
                }
                frame = until;
                assert!(motor.is_stuck() && volts[until + 1] != 0.0, "{n}: click {click} begins at rest");
                most = most.max(((motor.turned() - home.angle + PI).rem_euclid(TAU) - PI).abs());
            }
            most
        };
        for first in [-2.8, -1.2, 0.3, 2.1] {
            let off = farthest(&parked[n], first);
            assert!(off < home.spread + 0.02, "motor {n} from {first}: {off} {home:?}");
        }
        assert!(farthest(&left[n], 0.3) > 1.0, "motor {n}: left where clicks end");
    }
    // After one click that is the last: all that is rendered until nothing is to come.
    let last = [(0.01, HOME, 1.0), (begins(0), CLICK, 1.0)];
    let [parked, left] = plans.each_ref().map(|plan| rendered(plan, &last, begins(3)));
    for (n, drive) in plans[0].drives.iter().enumerate() {
        let (_, home) = plans[0].homes.iter().find(|(of, _)| *of == n).unwrap();
        let off = |volts: &[f64]| {
            let mut motor =
                Motor::<false>::new(&drive.setup.parameters, &Plan::whole(Level::Fine), RATE).unwrap();
            motor.place(0.3, 0.0);
            for volts in volts {
                motor.drive(Drive::Voltage(*volts));
                motor.step();
            }
            ((motor.turned() - home.angle + PI).rem_euclid(TAU) - PI).abs()
        };
        assert!(
            off(&parked[n]) < home.spread + 0.02,
            "motor {n}: over before it is home: {}",
            off(&parked[n])
        );
        assert!(off(&left[n]) > 0.3, "motor {n}: {}", off(&left[n]));
    }
    assert!(parked[0].len() > left[0].len() + (0.1 * RATE) as usize);
}
