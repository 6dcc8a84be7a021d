//! `pacinian identify`: actuators that are simulated with the project's own models, recorded with noise, identified by the program, and
//! compared with what they were made of; and everything that is no good.
#![cfg(feature = "cli")]

mod coils;
mod currents;
mod mistakes;
mod motors;
#[path = "../program/mod.rs"]
mod program;

use pacinian::actuator::identify::stimulus::steps;
use pacinian::actuator::motor::{Drive, GRAVITY, Motor, Parameters, Plan, Wish};
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use pacinian::rig::{Actuator, part};
use program::{Scratch, read_wav};
use serde_json::Value;

const RIG: &str = "format = \"pacinian-rig/1\"   # mine\ntitle = \"T\"\n[device]\nchannels = 2\nfull_scale_volts = 5\ncoupling = \"dc\"\n\
    [amplifier.bridge]\ngain = 2\nmax_volts = 12\ncoupling = \"dc\"\n\n# What hangs on it.\n";
const WRIST: &str = "\n[[output]]\nkind = \"drive\"\nname = \"wrist\"\nchannel = 2\nactuator = \"coin\"\namplifier = \"bridge\"\n";
const TACTOR: &str =
    "\n[[tactor]]\nname = \"tip\"\nchannel = 1\nactuator = \"shaker\"\namplifier = \"bridge\"\n";
/// Volts for a sample of 1.0.
const SCALE: f64 = 10.0;

/// Normal deviates: a congruential generator (Knuth's multiplier), Box and Muller.
struct Noise(u64);

impl Noise {
    fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// So many decibels below the mean square of a signal.
    fn on(&mut self, x: &[f64], decibels: f64) -> Vec<f64> {
        let square = x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        let deviation = square.sqrt() * 10f64.powf(-decibels / 20.0);
        let mut normal = || (-2.0 * self.even().ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos();
        x.iter().map(|x| x + deviation * normal()).collect()
    }
}

/// What a file of one driven channel says, in volts.
fn driven(scratch: &Scratch, name: &str, channel: usize) -> (f64, Vec<f64>) {
    let (spec, samples) = read_wav(&scratch.0.join(name));
    let frames = samples.chunks(usize::from(spec.channels));
    (f64::from(spec.sample_rate), frames.map(|frame| SCALE * f64::from(frame[channel - 1])).collect())
}

/// Acceleration and current of a motor under volts.
fn turn(p: &Parameters, rate: f64, volts: &[f64]) -> [Vec<f64>; 2] {
    let plan = Plan::choose(p, rate, &Wish { error: 0.0, posture: true, casing: true });
    let mut motor = Motor::<false>::new(p, &plan, rate).unwrap();
    motor.place(0.4, 0.0);
    let mut all = [vec![], vec![]];
    for volts in volts {
        let now = motor.reading();
        all[0].push(now.acceleration[0]);
        all[1].push(now.current);
        motor.drive(Drive::Voltage(*volts));
        motor.step();
    }
    all
}

/// Some samples later, and some more behind.
fn late(x: &[f64], before: usize, behind: usize) -> Vec<f64> {
    [vec![0.0; before], x.to_vec(), vec![0.0; behind]].concat()
}

fn record(scratch: &Scratch, name: &str, rate: f64, encoding: Encoding, channels: &[(&[f64], f64)]) {
    let spec = WavSpec::new(channels.len(), rate as u32, encoding);
    let mut wav = WavWriter::create(scratch.0.join(name), spec).unwrap();
    let planar: Vec<Vec<f32>> =
        channels.iter().map(|(x, scale)| x.iter().map(|x| (x / scale) as f32).collect()).collect();
    wav.write_planar(&planar).unwrap();
    assert_eq!(wav.finish().unwrap().clipped, 0);
}

/// What is told under a name: within 3 % of the truth, and the interval holds it.
#[track_caller]
fn near(said: &Value, name: &str, truth: f64) {
    let told = said["told"].as_array().unwrap();
    let figure = told
        .iter()
        .find(|f| f["name"] == name)
        .unwrap_or_else(|| panic!("{name} is not told: {:#}", said["untold"]));
    let value = figure["value"].as_f64().unwrap();
    assert!((value / truth - 1.0).abs() < 0.03, "{name} = {value}, but it is {truth}");
    let [least, most] = [0, 1].map(|n| figure["interval"][n].as_f64().unwrap());
    assert!((least..=most).contains(&truth), "{name}: {least} to {most}, but it is {truth}");
}

fn why_not<'a>(said: &'a Value, name: &str) -> &'a str {
    let all = said["untold"].as_array().unwrap();
    all.iter()
        .find(|one| one["name"] == name)
        .and_then(|one| one["why"].as_str())
        .unwrap_or_else(|| panic!("{name}: {said:#}"))
}

fn of_part(name: &str) -> Actuator {
    Actuator::of_part(part::find(name).unwrap())
}

fn coin() -> Parameters {
    Parameters { gravity: GRAVITY, ..of_part("coin-10mm").rumble_motor().unwrap() }
}

/// A coin that is driven by steps, drive and acceleration and current in one recording, the two of them later by some samples: its parameters.
fn coin_take(scratch: &Scratch, name: &str, later: usize) -> Parameters {
    let (p, rate) = (coin(), 8000.0);
    let volts = steps(3.0, p.mechanical_time(), rate).unwrap();
    let [x, i] = turn(&p, rate, &volts);
    let (volts, x, i) = (late(&volts, 0, later), late(&x, later, 0), late(&i, later, 0));
    let (x, i) = (Noise(21).on(&x, 40.0), Noise(22).on(&i, 40.0));
    record(scratch, name, rate, Encoding::F32, &[(&volts, SCALE), (&x, 40.0), (&i, 1.0)]);
    p
}

/// What the motion of a motor tells.
fn groups(p: &Parameters) -> [(&'static str, f64); 4] {
    [
        ("time_constant", p.mechanical_time()),
        ("speed_per_volt", p.gain / (p.resistance * p.damping())),
        ("running_volts", p.coulomb * p.resistance / p.gain),
        ("eccentric_per_mass", p.eccentric / p.casing.mass().unwrap()),
    ]
}
