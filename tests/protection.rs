//! What an actuator does not bear does not leave the device; what it bears leaves as it is.

mod common;

use common::{channel, patch, run};
use pacinian::actuator::drive::Drive;
use pacinian::actuator::thermal::Thermal;
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::FIELDS;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;

const PATCH: &str = "[voice.v]\noutput = \"out\"\n[voice.v.nodes]\nout = { type = \"sine\", frequency = \"event.frequency\" }\n";

const COIL: &str = "model = \"voice-coil\"\nresistance = 7\nforce_factor = 1.2\nmoving_mass = 1.5e-3\nresonance = 230\nq = 3.6\n";

fn rig(actuator: &str) -> Rig {
    let text = format!(
        "format = \"pacinian-rig/1\"\ntitle = \"t\"\n[device]\nchannels = 1\nfull_scale_volts = 2\n[amplifier.a]\ngain = 5\n\
         [actuator.x]\n{actuator}\n[[tactor]]\nname = \"skin\"\nchannel = 1\nactuator = \"x\"\namplifier = \"a\"\n"
    );
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn compiled(actuator: &str) -> Plan {
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    scene(&patch(PATCH), &rig(actuator), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// Volts at the actuator, of a tone.
fn tone(plan: &Plan, hertz: f64, level: f64, seconds: f64, calls: &[usize]) -> (Engine, Vec<f64>) {
    let mut engine = Engine::new(plan).unwrap();
    let mut own = [0.0; FIELDS];
    own[0] = hertz;
    let play = Play { instrument: 0, place: Spot::Row(0), level, felt: None, duration: seconds, own, id: 1 };
    assert!(engine.schedule(Instant::default(), Source::Program, Event::Play(play)));
    let frames = run(&mut engine, (seconds * 48_000.0) as usize, calls);
    let volts = channel(&frames, 1, 0).iter().map(|x| 10.0 * x).collect();
    (engine, volts)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, value| most.max(value.abs()))
}

#[test]
fn what_is_borne_leaves_to_the_bit() {
    let free = compiled("model = \"voice-coil\"");
    assert!(free.protections.is_empty());
    let known = compiled(&format!("{COIL}max_volts = 9.5\nmax_rms_amperes = 1.3\nstroke = 5e-3\n"));
    assert_eq!(known.protections.len(), 1);
    let (engine, volts) = tone(&known, 180.0, 0.9, 1.0, &[480]);
    assert_eq!(volts, tone(&free, 180.0, 0.9, 1.0, &[480]).1);
    assert_eq!(engine.stage().protections().changed(), 0);
    assert!(engine.stage().protections().counts(0).unwrap().farthest > 1e-4);
}

#[test]
fn peak_and_stroke_hold_whatever_is_played() {
    let peak = compiled("model = \"voice-coil\"\nrated_volts = 4");
    let (engine, volts) = tone(&peak, 60.0, 1.0, 0.5, &[480]);
    assert!((largest(&volts) - 4.0).abs() < 1e-5, "{}", largest(&volts));
    let counts = engine.stage().protections().counts(0).unwrap();
    assert!(counts.peak.samples > 10_000 && counts.changed == counts.peak.samples);
    assert!(
        (counts.peak.most
            - (largest(&tone(&compiled("model = \"generic\""), 60.0, 1.0, 0.5, &[480]).1) - 4.0))
            .abs()
            < 1e-4
    );

    // At its resonance it would go several times as far as it may; on the model of the actuator itself it does not.
    let stroke = 0.4e-3;
    let plan = compiled(&format!("{COIL}stroke = {stroke}\n"));
    let moved = |plan: &Plan| {
        let (_, volts) = tone(plan, 230.0, 1.0, 0.5, &[480]);
        let plant = rig(COIL).actuators[0].coil().unwrap();
        let mut model =
            pacinian::actuator::coil::model::Model::new(&plant, 48_000.0, Drive::Voltage).unwrap();
        volts.iter().fold(0.0_f64, |most, volts| most.max(model.step(*volts).displacement.abs()))
    };
    let (free, held) = (moved(&compiled("model = \"voice-coil\"")), moved(&plan));
    assert!(free > 1.5 * stroke, "{free}");
    assert!(held <= stroke * (1.0 + 1e-6) && held > 0.9 * stroke, "{held}");
}

/// A full-scale tone for a minute on a coil that is given no time to cool: by the two-node model itself, which knows nothing of who holds
/// back, the winding stays within 2 % of what it bears, and is brought to its limit.
#[test]
fn the_winding_stays_as_cool_as_it_must() {
    let heat = "max_heating = 60\nwinding_to_housing = 20\nhousing_to_air = 40\nwinding_time = 4\nhousing_time = 200\n";
    let plan = compiled(&format!("{COIL}{heat}"));
    let actuator = rig(&format!("{COIL}{heat}")).actuators[0].clone();
    let warmest = |plan: &Plan| {
        let (_, volts) = tone(plan, 40.0, 1.0, 60.0, &[4800]);
        let mut thermal = Thermal::new(&actuator.cooling().unwrap()).unwrap();
        let plant = actuator.coil().unwrap();
        let mut model =
            pacinian::actuator::coil::model::Model::new(&plant, 48_000.0, Drive::Voltage).unwrap();
        let mut most = 0.0_f64;
        for volts in volts {
            let current = model.step(volts).current;
            thermal.step(current * current, 1.0 / 48_000.0);
            most = most.max(thermal.winding());
        }
        most
    };
    let (free, held) = (warmest(&compiled("model = \"voice-coil\"")), warmest(&plan));
    assert!(free > 150.0, "{free}");
    assert!((40.0..1.03 * 60.0).contains(&held), "{held}");
}

#[test]
fn any_cut_gives_the_same_bits() {
    let heat = "max_heating = 30\nwinding_to_housing = 20\nhousing_to_air = 40\nwinding_time = 0.4\nhousing_time = 20\n";
    let plan =
        compiled(&format!("{COIL}{heat}stroke = 0.6e-3\nmax_volts = 8\nmax_slew = 2e4\nmax_rms_volts = 4\n"));
    let bits = |calls: &[usize]| -> Vec<u64> {
        tone(&plan, 93.0, 1.0, 1.0, calls).1.iter().map(|x| x.to_bits()).collect()
    };
    let whole = bits(&[48_000]);
    for calls in [&[1][..], &[7], &[480], &[3, 1000, 1, 17, 250, 64]] {
        assert!(bits(calls) == whole, "{calls:?}");
    }
}

/// A motor with an eccentric mass on an output for vibration only gets hot of what alternates: it gets what it bears of it.
#[test]
fn a_motor_that_vibrates_gets_what_it_can_bear() {
    let plan = compiled("part = \"coin-10mm\"");
    let (engine, volts) = tone(&plan, 200.0, 1.0, 20.0, &[4800]);
    let late: Vec<f64> = volts[volts.len() - 48_000..].to_vec();
    let rms = (late.iter().map(|v| v * v).sum::<f64>() / late.len() as f64).sqrt();
    assert!(rms < 1.55 && rms > 1.2, "{rms}");
    assert!(engine.stage().protections().counts(0).unwrap().alternating.samples > 100_000);
}
