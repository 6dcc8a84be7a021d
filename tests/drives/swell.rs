//! Shapings as orders of a patch.

use pacinian::actuator::driver::setup::Shaping;
use pacinian::engine::event::Event;
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;

use super::common::scenes::MOTORS;
use super::{COIN, PAD, RATE, common, late, play, sent, speeds};

/// An envelope of a quarter of a second, a spin that switches, and a drive after which the motor rolls.
const SHAPED: &str = r#"
[voice.swell]
output = "swell"
[voice.swell.nodes]
swell = { type = "drive-swell", points = [{ at = 0.1, value = 0.5 }, { at = 0.15, value = 0.5 }, { at = 0.25, value = 0 }] }
[voice.plain]
output = "swell"
[voice.plain.nodes]
swell = { type = "drive-swell", shaping = "plain", points = [{ at = 0.1, value = 0.5 }, { at = 0.15, value = 0.5 }, { at = 0.25, value = 0 }] }
[voice.chatter]
output = "spin"
[voice.chatter.nodes]
spin = { type = "drive-spin", shaping = "switching", level = 0.5 }
[voice.roll]
output = "on"
[voice.roll.nodes]
on = { type = "drive-on", level = 0.8, after = "open" }
"#;

const SWELL: u32 = 0;
const PLAIN: u32 = 1;
const CHATTER: u32 = 2;
const ROLL: u32 = 3;

fn compiled(text: &str) -> plan::Plan {
    let rig = Rig::parse("rig.toml", MOTORS.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&common::patch(text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

fn wish(t: f64) -> f64 {
    let up = (t / 0.1).clamp(0.0, 1.0);
    0.5 * up.min(((0.25 - t) / 0.1).clamp(0.0, 1.0))
}

/// On each motor, whatever its levels are shaped by.
#[test]
fn an_envelope_is_one_event() {
    let plan = compiled(SHAPED);
    assert_eq!(
        plan.drives.iter().map(|d| d.setup.shaping).collect::<Vec<_>>(),
        [Shaping::Inverse, Shaping::Overdrive]
    );
    for place in [COIN, PAD] {
        let n = (place - COIN) as usize;
        let setup = &plan.drives[n].setup;
        let off = |instrument: u32, level: f64| {
            let event = Event::Play(play(instrument, place, level, 0.01));
            let volts = &sent(&plan, &[(0.1, event)], 0.6, &[480])[n];
            let turned = speeds(&setup.parameters, volts);
            let begin = 0.1 + late(&plan, plan.drives[n].channel as usize);
            let square = |(n, speed): (usize, &f64)| {
                let is = (speed / setup.full_speed()).powi(2);
                (is - level * wish((n as f64 + 1.0) / RATE - begin)).powi(2)
            };
            let mean = turned.iter().enumerate().map(square).sum::<f64>() / (0.25 * RATE);
            (mean.sqrt() / (0.5 * level), *turned.last().unwrap())
        };
        for level in [1.0, 0.6] {
            let ((inverse, last), (plain, _)) = (off(SWELL, level), off(PLAIN, level));
            assert!(
                inverse < 0.02 && plain > 2.0 * inverse && last == 0.0,
                "{place} {level}: {inverse} {plain} {last}"
            );
        }
    }
}

#[test]
fn a_spin_may_switch_and_a_drive_may_let_go() {
    let plan = compiled(SHAPED);
    let (n, setup) = (1, &plan.drives[1].setup);
    let begin = 0.1 + late(&plan, plan.drives[n].channel as usize);
    let frame = |seconds: f64| ((begin + seconds) * RATE) as usize;
    let volts = &sent(&plan, &[(0.1, Event::Play(play(CHATTER, PAD, 1.0, 0.2)))], 0.6, &[480])[n];
    assert!(volts[frame(0.01)..frame(0.19)].iter().all(|v| (v.abs() / setup.limit - 1.0).abs() < 1e-6));
    let turned = speeds(&setup.parameters, volts);
    let kept = turned[frame(0.18)] / setup.full_speed();
    assert!((kept * kept - 0.5).abs() < 0.05 && turned.last() == Some(&0.0), "{kept}");
    // Without a brake it rolls for ten times as long as a short circuit lets it.
    let volts = &sent(&plan, &[(0.1, Event::Play(play(ROLL, PAD, 1.0, 0.1)))], 1.0, &[480])[n];
    let turned = speeds(&setup.parameters, volts);
    let p = &setup.parameters;
    let (dry, rate) = (p.coulomb / p.viscous, p.viscous / p.effective_inertia());
    let from = turned[frame(0.105)];
    let wanted = (from + dry) * (-rate * 0.03).exp() - dry;
    assert!((turned[frame(0.135)] - wanted).abs() < 0.01 * from, "{} {wanted}", turned[frame(0.135)]);
    assert_eq!(volts.last(), Some(&0.0));
}

/// Another patch has other envelopes: what was under way is braked. The same patch again goes on.
#[test]
fn another_patch_ends_it() {
    let plan = compiled(SHAPED);
    let other = compiled(&SHAPED.replace("at = 0.1,", "at = 0.12,"));
    let n = 0;
    let turned = |next: &plan::Plan| {
        let (mut director, mut stagehand) = exchange(&plan).unwrap();
        let event = Event::Play(play(SWELL, COIN, 1.0, 0.01));
        let at = pacinian::schedule::Instant::of_samples(0.1 * plan.engine_rate());
        assert!(stagehand.engine().schedule(at, pacinian::engine::event::Source::Program, event));
        let begin = 0.1 + late(&plan, plan.drives[n].channel as usize);
        let mut frames = vec![0.0; 3 * ((begin + 0.12) * RATE) as usize];
        stagehand.process(&[], &mut frames);
        assert!(director.send(next).unwrap());
        let mut rest = vec![0.0; 3 * (0.3 * RATE) as usize];
        stagehand.process(&[], &mut rest);
        frames.extend(rest);
        let drive = &plan.drives[n];
        let volts: Vec<f64> = frames
            .chunks(3)
            .map(|frame| f64::from(frame[drive.channel as usize]) * drive.per_sample)
            .collect();
        speeds(&drive.setup.parameters, &volts)[((begin + 0.15) * RATE) as usize] / drive.setup.full_speed()
    };
    let (ended, goes_on) = (turned(&other), turned(&plan));
    assert!(ended.abs() < 0.02 && (goes_on * goes_on - 0.5).abs() < 0.02, "{ended} {goes_on}");
}
