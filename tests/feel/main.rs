//! What is felt: against the models themselves, closed forms, and through the program.

mod carried;
mod chain;
mod coils;
mod hostile;
mod motors;
#[cfg(feature = "cli")]
#[path = "../program/mod.rs"]
mod program;
#[cfg(feature = "cli")]
mod rendered;

use std::f64::consts::TAU;

use pacinian::actuator::motor::Parameters;
use pacinian::feel::{Feel, Figures, Wish};
use pacinian::rig::{Actuator, Rig, part};

const RATE: f64 = 48_000.0;
const COIN: &str = "[actuator.a]\npart = \"coin-10mm\"\n";
const TACTOR: &str = "[actuator.a]\nmodel = \"voice-coil\"\nresistance = 7\ninductance = 2.5e-4\nforce_factor = 1.2\n\
    moving_mass = 1.5e-3\nstiffness = 3132.7\ndamping = 0.6\nskin_mass = 1e-4\nskin_stiffness = 1200\nskin_damping = 1.5\n";
const SHAKER: &str = "[actuator.a]\nmodel = \"inertial-motor\"\nresistance = 6\ninductance = 2e-4\nforce_factor = 1.5\n\
    slug_mass = 5.5e-3\ncasing_mass = 0.1\nstiffness = 741\ndamping = 0.983\n";
const LRA: &str = "[actuator.a]\npart = \"vybronics-vg0832013d\"\n";

/// A rig of one raw output whose device has 2 V at a sample of 1, in front of this actuator; with more keys of device, amplifier and output.
fn rig(actuator: &str, [device, amplifier, output]: [&str; 3]) -> Rig {
    let (described, named) = match amplifier {
        "" => (String::new(), ""),
        keys => (format!("[amplifier.amp]\n{keys}\n"), "amplifier = \"amp\"\n"),
    };
    let kind = if output.contains("kind") { "" } else { "kind = \"raw\"\n" };
    let text = format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 2.0\n{device}\n{described}{actuator}\n\
         [[output]]\nname = \"o\"\nchannel = 1\nactuator = \"a\"\n{kind}{named}{output}\n"
    );
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}\n{text}")).value
}

const DC: [&str; 3] = ["coupling = \"dc\"", "gain = 1.5\nmax_volts = 12\ncoupling = \"dc\"", ""];

fn feel(rig: &Rig, rate: f64) -> Feel {
    let feel = Feel::new(rig, rig.device.channels as usize, rate, &Wish::default()).unwrap();
    assert!(feel.unfelt().is_empty(), "{:?}", feel.unfelt());
    feel
}

/// What a rig of one output makes felt, by its traces, and the figures of that.
fn felt(rig: &Rig, rate: f64, samples: &[f32]) -> (Vec<Vec<f32>>, Figures) {
    let (mut feel, mut frames) = (feel(rig, rate), Vec::new());
    feel.process(samples, &mut frames);
    let traces = feel.traces().len();
    assert_eq!(frames.len(), traces * samples.len());
    let trace = |n: usize| frames.iter().skip(n).step_by(traces).copied().collect();
    ((0..traces).map(trace).collect(), feel.felt()[0].figures())
}

/// Something that does everything: bursts, steps, silence, both signs; from −1 to 1.
fn lively(count: usize) -> Vec<f32> {
    let at = |n: usize| {
        let t = n as f64 / RATE;
        let swell = (TAU * 1.7 * t).sin();
        let part = match (t * 8.0) as usize % 4 {
            0 => 0.9,
            1 => (TAU * 190.0 * t).sin(),
            2 => 0.0,
            _ => (TAU * 31.0 * t).sin().signum() * 0.8,
        };
        (swell * part) as f32
    };
    (0..count).map(at).collect()
}

fn coin() -> Parameters {
    Actuator::of_part(part::find("coin-10mm").unwrap()).rumble_motor().unwrap()
}

fn largest(values: &[f32]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(f64::from(value.abs())))
}

#[track_caller]
fn close(is: f64, due: f64, within: f64, what: &str) {
    assert!((is - due).abs() <= within * due.abs(), "{what}: {is} for {due}");
}
