//! Motors behind a carrier and diodes: what is felt is what they do under the smooth carrier of a real converter.

use std::f64::consts::TAU;

use super::{COIN, RATE, rig};
use pacinian::actuator::link::carrier::Rectifier;
use pacinian::actuator::link::diodes::Diodes;
use pacinian::actuator::motor::{Level, Motor, Parameters, Plan};
use pacinian::feel::{Feel, Wish};
use pacinian::rig::Rig;

/// A gamepad's motor, which keeps its current for 0.4 ms.
const PAD: &str = "[actuator.a]\nmodel = \"rumble-motor\"\nrated_volts = 6.0\nresistance = 10.42\ninductance = 4.2e-3\n\
    torque_constant = 0.011\ninertia = 1.15e-7\nviscous_friction = 1e-6\ncoulomb_friction = 6e-4\nstatic_friction = 8e-4\n\
    eccentric_moment = 1.38e-5\nmass = 0.25\n";

/// Steps of the twin in a frame, where nothing speaks for more.
const FINE: u32 = 256;

/// A tone that swells for 5 ms and stays: its amplitude at a time in frames, as a share of its largest.
fn swell(frames: f64) -> f64 {
    // sin⁴: so smooth that all of it is below half the rate.
    let share = (frames / (0.005 * RATE)).clamp(0.0, 1.0);
    (0.5 - 0.5 * (0.5 * TAU * share).cos()).powi(2)
}

fn behind(actuator: &str, hertz: f64, rectifier: &str, device: &str) -> Rig {
    let amplifier = format!(
        "drive = \"carrier\"\ngain = 4.0\ncarrier = {hertz:?}\nrectifier = \"{rectifier}\"\ndiode_drop = 0.7\ncoupling = \"dc\""
    );
    rig(actuator, [device, &amplifier, ""])
}

/// The motor under that tone itself, at every instant: casing acceleration of each frame.
fn twin(
    p: &Parameters,
    full_wave: bool,
    share: f64,
    volts: f64,
    frames: u32,
    fine: u32,
) -> (Vec<[f64; 2]>, f64) {
    let rate = RATE * f64::from(fine);
    let plan = Plan { gravity: false, ..Plan::whole(Level::Default) };
    let mut motor = Motor::<false>::new(p, &plan, rate).unwrap();
    let diodes = Diodes::new(Rectifier { full_wave, drop: 0.7 }, rate);
    let (mut last, mut felt, mut fastest) = ([0.0; 2], Vec::new(), 0.0_f64);
    for frame in 0..frames {
        for part in 0..fine {
            // A sample is in the middle of its frame.
            let at = f64::from(frame) - 0.5 + (f64::from(part) + 0.5) / f64::from(fine);
            diodes.step(&mut motor, volts * swell(at) * (TAU * share * at).cos(), |_, _, _| {});
        }
        let now = motor.casing_velocity();
        felt.push([0, 1].map(|axis| (now[axis] - last[axis]) * RATE));
        last = now;
        fastest = fastest.max(motor.speed());
    }
    (felt, fastest)
}

/// Magnitudes of the means over a millisecond.
fn heard(felt: &[[f64; 2]]) -> Vec<f64> {
    let mean = |frames: &[[f64; 2]]| {
        let sum = frames.iter().fold([0.0; 2], |sum, felt| [sum[0] + felt[0], sum[1] + felt[1]]);
        (sum[0] / frames.len() as f64).hypot(sum[1] / frames.len() as f64)
    };
    felt.chunks_exact(48).map(mean).collect()
}

/// Samples of that tone, of so many volts before the diodes.
fn tone(share: f64, volts: f64, frames: u32) -> Vec<f32> {
    let at = |n: f64| volts * swell(n) * (TAU * share * n).cos();
    (0..frames).map(|n| (at(f64::from(n)) / 8.0) as f32).collect()
}

/// All that samples make felt.
fn whole(feel: &mut Feel, samples: &[f32]) -> Vec<[f64; 2]> {
    let (mut felt, mut rest) = (Vec::new(), Vec::new());
    feel.process(samples, &mut felt);
    feel.finish(&mut rest);
    felt.extend_from_slice(&rest);
    felt.as_chunks::<2>().0.iter().map(|felt| felt.map(f64::from)).collect()
}

/// Means over a millisecond are what they are under the smooth carrier, within the wish: at 12 samples a turn, at four and three, at little more than two, and where
/// turns and samples have no ratio; through a bridge of diodes and through one; with and without a coil that keeps its current.
#[test]
fn it_is_felt_as_under_the_carrier_itself() {
    let frames = 4800;
    for (actuator, volts) in [(COIN, 3.0), (COIN, 5.0), (PAD, 7.9)] {
        for (hertz, rectifier) in [
            (4000.0, "full-wave"),
            (3700.0, "half-wave"),
            (12_000.0, "full-wave"),
            (12_000.0, "half-wave"),
            (16_000.0, "full-wave"),
            (16_000.0, "half-wave"),
            (21_500.0, "full-wave"),
        ] {
            // Through one diode its coil lets too little in to turn by.
            if actuator == PAD && rectifier == "half-wave" {
                continue;
            }
            let rig = behind(actuator, hertz, rectifier, "");
            let p = rig.actuators[0].rumble_motor().unwrap();
            let share = hertz / RATE;
            let samples = tone(share, volts, frames + 100);
            let (due, fastest) = twin(&p, rectifier == "full-wave", share, volts, frames, FINE);
            let (due, rated) = (heard(&due), p.rated_acceleration().unwrap());
            for error in [2e-2, 1e-3] {
                let mut feel = Feel::new(&rig, 1, RATE, &Wish { error }).unwrap();
                let felt = whole(&mut feel, &samples);
                assert_eq!(felt.len(), samples.len());
                let heard = heard(&felt);
                let off = heard.iter().zip(&due).fold(0.0, |most: f64, (is, due)| most.max((is - due).abs()));
                let off = off / rated;
                let of = &feel.felt()[0];
                let told = format!("{hertz} {rectifier} {error}: {off}, {} steps of {actuator}", of.steps());
                assert!(of.reaches().is_none() && fastest > 0.015 * p.rated_speed(), "{told} {fastest}");
                assert!(off < error, "{told}");
            }
        }
    }
}

/// Where the wish cannot be granted that is said, and what is reached is.
#[test]
fn what_cannot_be_reached_is_said() {
    let (hertz, volts, frames, error) = (20_000.0, 5.0, 720, 1e-7);
    let rig = behind(COIN, hertz, "full-wave", "");
    let p = rig.actuators[0].rumble_motor().unwrap();
    let share = hertz / RATE;
    let samples = tone(share, volts, frames + 100);
    let mut feel = Feel::new(&rig, 1, RATE, &Wish { error }).unwrap();
    let felt = whole(&mut feel, &samples);
    let (due, _) = twin(&p, true, share, volts, frames, 2048);
    let (is, due) = (heard(&felt), heard(&due));
    let off = is.iter().zip(&due).fold(0.0, |most: f64, (is, due)| most.max((is - due).abs()));
    let off = off / p.rated_acceleration().unwrap();
    let reaches = feel.felt()[0].reaches().unwrap();
    assert!(reaches > error && reaches < 1e-4 && off < reaches, "{off} {reaches}");
    assert!(due.last() > Some(&0.1));
}

/// Beside a motor behind diodes, what is felt elsewhere is what it is alone, in the same frames; and so is what is felt behind them. It does not
/// matter how a run is cut, and what waits comes out at the end, be it all.
#[test]
fn nothing_is_shifted() {
    let amplifiers = "[amplifier.plain]\ngain = 2.0\ncoupling = \"dc\"\n[amplifier.amp]\ndrive = \"carrier\"\ngain = 4.0\n\
        diode_drop = 0.7\ncoupling = \"dc\"\n";
    let output = |name: &str, channel: u32, amplifier: &str| {
        format!(
            "[[output]]\nkind = \"raw\"\nname = \"{name}\"\nchannel = {channel}\nactuator = \"a\"\namplifier = \"{amplifier}\"\n"
        )
    };
    let parsed = |outputs: &str| {
        let text = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 2.0\ncoupling = \"dc\"\n{amplifiers}{COIN}{outputs}"
        );
        Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    };
    let frames: Vec<f32> = (0..9000)
        .flat_map(|n| {
            let at = f64::from(n);
            let tone = 0.6 * (TAU * 3700.0 / RATE * at).cos();
            if n < 500 { [0.0; 2] } else { [0.5 * swell(at - 3000.0) as f32, tone as f32] }
        })
        .collect();
    let run = |rig: &Rig, lengths: &[usize]| {
        let mut feel = Feel::new(rig, 2, RATE, &Wish { error: 1e-2 }).unwrap();
        let (mut all, mut some, mut rest) = (Vec::new(), Vec::new(), &frames[..]);
        for length in lengths.iter().cycle() {
            let (now, later) = rest.split_at(rest.len().min(*length));
            feel.process(now, &mut some);
            all.extend_from_slice(&some);
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        assert_eq!(all.len() / feel.traces().len() + feel.late(), frames.len() / 2);
        feel.finish(&mut some);
        all.extend_from_slice(&some);
        feel.finish(&mut some);
        assert_eq!((all.len() / feel.traces().len(), some.len()), (frames.len() / 2, 0));
        (all, feel.felt().iter().map(|felt| felt.figures()).collect::<Vec<_>>())
    };
    let [plain, carried] = [output("p", 1, "plain"), output("c", 2, "amp")];
    let (both, figures) = run(&parsed(&(plain.clone() + &carried)), &[18_000]);
    let (alone, of_alone) = run(&parsed(&plain), &[18_000]);
    let (behind, of_behind) = run(&parsed(&carried), &[18_000]);
    for (n, both) in both.as_chunks::<4>().0.iter().enumerate() {
        assert_eq!([both[0], both[1]], [alone[2 * n], alone[2 * n + 1]], "{n}");
        assert_eq!([both[2], both[3]], [behind[2 * n], behind[2 * n + 1]], "{n}");
    }
    assert_eq!(figures, [of_alone, of_behind].concat());
    assert!(figures.iter().all(|figures| figures.peak > 1.0 && figures.peak_at < 9000.0 / RATE));
    for lengths in [&[1_usize][..], &[2, 5], &[3], &[192, 7, 1000, 0], &[95, 97, 4096]] {
        assert!(
            run(&parsed(&(plain.clone() + &carried)), lengths) == (both.clone(), figures.clone()),
            "{lengths:?}"
        );
    }
    // Fewer frames than must follow one.
    let mut feel = Feel::new(&parsed(&carried), 2, RATE, &Wish::default()).unwrap();
    let mut felt = Vec::new();
    feel.process(&[0.9; 20], &mut felt);
    assert_eq!((felt.len(), feel.late()), (0, 48));
    feel.finish(&mut felt);
    assert_eq!(felt.len(), 20);
}
