//! Raw outputs carry what is played on them as it is: past limiter and band limit, at the device's rate.

mod common;

use common::{channel, moments, patch, play, rendered, run, schedule};
use pacinian::engine::Engine;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;

const PATCH: &str = r#"
[voice.tone]
output = "out"
[voice.tone.nodes]
sine = { type = "sine", frequency = "event.frequency" }
swell = { type = "envelope", attack = 0.02, decay = 0.0, sustain = 1.0, release = 0.02 }
out = { type = "multiply", inputs = ["sine", "swell"] }
"#;

const RIG: &str = r#"
format = "pacinian-rig/1"
[device]
channels = 10
[[tactor]]
name = "skin"
channel = 1
[[output]]
kind = "raw"
name = "meter"
channel = 2
[[output]]
kind = "raw"
name = "far"
channel = 10
gain = 0.5
polarity = -1
"#;

fn plan(rate: f64) -> Plan {
    let rig = Rig::parse("rig.toml", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(rate), live: true, ..Options::default() };
    scene(&patch(PATCH), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// Places are numbered as the outputs of the rig.
const SKIN: u32 = 0;
const METER: u32 = 1;
const FAR: u32 = 2;

#[test]
fn raw_is_neither_cut_at_1_khz_nor_limited_nor_delayed_by_it() {
    for rate in [48_000.0, 44_100.0] {
        let plan = plan(rate);
        let events = [SKIN, METER, FAR].map(|place| (0.0, play(0, place, 2_000.0, 1.0, u64::from(place))));
        let (engine, frames) = rendered(&plan, &events, 0.0);
        let (from, to) = ((0.25 * rate) as usize, (0.75 * rate) as usize);
        let strength = |c: usize| {
            let (re, im) = moments(&channel(&frames, 10, c)[from..to], 2_000.0, rate)[0];
            2.0 * re.hypot(im) / (to - from) as f64
        };
        let designed = engine.stage().response(1, 2_000.0).abs();
        assert!(designed > 0.7, "{designed}");
        assert!(strength(0) < 1e-3, "on the skin: {}", strength(0));
        assert!((strength(1) - designed).abs() < 1e-3, "{} for {designed}", strength(1));
        assert!((strength(9) - 0.5 * designed).abs() < 1e-3);

        // In time, it is late by the voices' lead and the up-sampling alone.
        let events = [METER, FAR].map(|place| (0.0, play(0, place, 200.0, 1.0, u64::from(place))));
        let (engine, frames) = rendered(&plan, &events, 0.0);
        let late = engine.delay().lead + engine.delay().up_sampling;
        for n in (from..to).step_by(11) {
            let exact = (std::f64::consts::TAU * 200.0 * (n as f64 / rate - late)).sin();
            assert!((f64::from(frames[10 * n + 1]) - exact).abs() < 0.005, "frame {n}");
            assert!((f64::from(frames[10 * n + 9]) + 0.5 * exact).abs() < 0.005, "frame {n}");
        }
        assert!(engine.stage().counts().limited == 0 && engine.is_silent());
        assert!(frames[frames.len() - 100..].iter().all(|x| *x == 0.0), "silence becomes exact zero");
    }
}

#[test]
fn beyond_full_scale_it_is_cut_and_counted() {
    let plan = plan(48_000.0);
    let mut loud = play(0, METER, 200.0, 0.2, 1);
    loud.level = 3.0;
    let (engine, frames) = rendered(&plan, &[(0.0, loud)], 0.0);
    let most = frames.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    let cut = frames.iter().filter(|x| x.abs() == 1.0).count() as u64;
    assert_eq!((most, engine.stage().counts().limited), (1.0, 0));
    assert!(cut > 1000 && engine.stage().counts().clamped.abs_diff(cut) < 10);
}

#[test]
fn it_does_not_matter_how_time_is_cut() {
    let plan = plan(44_100.0);
    let heard = |calls: &[usize]| {
        let mut engine = Engine::new(&plan).unwrap();
        let events = [SKIN, METER, FAR].map(|p| (3.3 + f64::from(p), play(0, p, 310.0, 0.1, u64::from(p))));
        schedule(&mut engine, &events);
        run(&mut engine, 10_000, calls)
    };
    let whole = heard(&[10_000]);
    assert!(whole.iter().skip(9).step_by(10).any(|x| *x != 0.0));
    for calls in [&[1][..], &[5], &[64, 3, 480]] {
        assert!(heard(calls) == whole, "{calls:?}");
    }
}

#[cfg(feature = "report")]
#[test]
fn the_reference_knows_of_it() {
    use pacinian::engine::event::Play;
    use pacinian::report::measure;
    // Low enough for the limiter, which the reference does not model.
    let quiet = |place, hertz, id| Play { level: 0.5, ..play(0, place, hertz, 0.2, id) };
    let events = [(0.01, quiet(METER, 210.0, 1)), (0.02, quiet(SKIN, 300.0, 2))];
    let found = measure(&plan(48_000.0), &events, 0.4).unwrap().comparison;
    assert!(found.error_db < -80.0, "{found:?}");
}
