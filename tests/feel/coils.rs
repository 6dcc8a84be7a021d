//! Coil actuators: against their frequency response and the model itself.

use std::f64::consts::{PI, TAU};

use super::{COIN, DC, LRA, RATE, SHAKER, TACTOR, close, feel, felt, largest, lively, rig};
use pacinian::actuator::coil::energy::Ledger;
use pacinian::actuator::coil::model::Model;
use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::thermal::Thermal;
use pacinian::dsp::complex::Complex;
use pacinian::feel::Left;
use pacinian::rig::Rig;

/// A sine that settled, by its response: a held drive has images at f + k rate, each of which the mean takes sin²x/x² of.
#[test]
fn a_tone_is_felt_as_the_response_has_it() {
    let current = "gain = 0.2\ndrive = \"current\"\ncoupling = \"dc\"";
    for (name, actuator, amplifier, casing) in [
        ("tactor", TACTOR, DC[1], false),
        ("tactor by current", TACTOR, current, false),
        ("shaker", SHAKER, DC[1], true),
        ("lra", LRA, DC[1], true),
    ] {
        let rig = rig(actuator, [DC[0], amplifier, ""]);
        let plant = rig.actuators[0].coil().unwrap();
        for (hertz, rate) in [(60.0, 48_000.0), (250.0, 48_000.0), (400.0, 8000.0)] {
            let (settled, periods): (f64, f64) = (3.0, 30.0);
            let count = (rate * (settled + periods / hertz)).round() as usize;
            let omega = TAU * hertz / rate;
            let samples: Vec<f32> = (0..count).map(|n| (omega * n as f64).cos() as f32).collect();
            let (traces, _) = felt(&rig, rate, &samples);
            assert_eq!(traces.len(), 1, "{name}");
            let mut sum = Complex::default();
            let begin = (rate * settled) as usize;
            for (n, value) in traces[0].iter().enumerate().skip(begin) {
                let turn = omega * n as f64;
                sum = sum + Complex::new(turn.cos(), -turn.sin()) * f64::from(*value);
            }
            let is = sum * (2.0 / (count - begin) as f64);
            let mut due = Complex::default();
            for image in -30_000..=30_000_i32 {
                let at = hertz + f64::from(image) * rate;
                let x = PI * at / rate;
                let response =
                    if amplifier == current { plant.per_ampere(at.abs()) } else { plant.per_volt(at.abs()) };
                let response = if casing { response.casing } else { response.acceleration };
                let response = if at < 0.0 { Complex::new(response.re, -response.im) } else { response };
                due = due + response * (x.sin() / x).powi(2);
            }
            let due = due * if amplifier == current { 0.4 } else { 3.0 };
            assert!((is - due).abs() < 1e-6 * due.abs(), "{name} {hertz} {rate}: {is:?} {due:?}");
            // So it is what the actuator does, but for what `loses` says, and below a resonance what it says of that.
            let (drive, unit) =
                if amplifier == current { (Imposes::Current, 0.4) } else { (Imposes::Voltage, 3.0) };
            let own = if amplifier == current { plant.per_ampere(hertz) } else { plant.per_volt(hertz) };
            let own = if casing { own.casing } else { own.acceleration }.abs() * unit;
            let feel = feel(&rig, rate);
            let loses = feel.loses(hertz.max(plant.resonance(drive).unwrap().hertz));
            assert!((is.abs() / own - 1.0).abs() < 1.1 * loses + 1e-6, "{name} {hertz} {rate}: {loses}");
        }
    }
}

/// Coils: by the model itself, to the bit; its ledger and thermal model.
#[test]
fn a_coil_is_felt_as_its_model_moves() {
    let warm = "winding_to_housing = 40\nhousing_to_air = 60\nwinding_time = 0.2\nhousing_time = 6\nmax_heating = 200\nstroke = 1e-3\n";
    let samples = lively(48_000);
    for (actuator, casing) in [(TACTOR, false), (SHAKER, true)] {
        let rig = rig(&format!("{actuator}{warm}"), DC);
        let plant = rig.actuators[0].coil().unwrap();
        let (traces, figures) = felt(&rig, RATE, &samples);
        let mut model = Model::new(&plant, RATE, Imposes::Voltage).unwrap();
        let mut ledger = Ledger::new(&model);
        let (mut velocity, mut farthest, mut amperes) = (0.0, 0.0_f64, Vec::new());
        // No model runs before something is played.
        assert!(samples[0] == 0.0 && samples[1] != 0.0);
        for (n, sample) in samples.iter().enumerate().skip(1) {
            let o = ledger.step(&mut model, f64::from(*sample) * 2.0 * 1.5);
            let now = if casing { o.casing_velocity } else { o.velocity };
            assert_eq!(traces[0][n], ((now - velocity) * RATE) as f32, "{n}");
            velocity = now;
            farthest = farthest.max(o.displacement.abs());
            amperes.push(o.current);
        }
        close(figures.energy.unwrap(), ledger.supplied, 1e-9, "energy");
        assert_eq!((figures.farthest, figures.of_stroke), (Some(farthest), Some(farthest / 1e-3)));
        let mut thermal = Thermal::new(&rig.actuators[0].cooling().unwrap()).unwrap();
        let warmest = amperes.chunks(480).fold(0.0_f64, |warmest, tick| {
            thermal
                .step(tick.iter().map(|i| i * i).sum::<f64>() / tick.len() as f64, tick.len() as f64 / RATE);
            warmest.max(thermal.winding())
        });
        // Currents at the ends of frames for means over them.
        close(figures.warmest.unwrap(), warmest, 1e-3, "warmest");
        assert!(warmest > 1.0);
    }
}

/// Where momentum is kept, slug and casing go against each other: the casing's velocity is read rightly.
#[test]
fn a_free_casing_keeps_the_momentum() {
    let plant = rig(SHAKER, DC).actuators[0].coil().unwrap();
    let mut model = Model::new(&plant, RATE, Imposes::Voltage).unwrap();
    let mut moved = 0.0;
    for sample in lively(4800) {
        let o = model.step(f64::from(sample));
        // The slug's own velocity is the casing's and its own within.
        assert!((5.5e-3 * (o.velocity + o.casing_velocity) + 0.1 * o.casing_velocity).abs() < 1e-15);
        moved = f64::max(moved, o.casing_velocity.abs());
    }
    assert!(moved > 1e-4);
}

/// An inductance that is not worth its while is left out, and does no more than was said.
#[test]
fn an_inductance_that_is_not_felt_is_left_out() {
    let small = TACTOR.replace("2.5e-4", "8e-7");
    // For the skin nothing beyond 1 kHz; as it comes, up to half the rate.
    let on = |actuator: &str, kind: &str| rig(actuator, [DC[0], DC[1], kind]);
    let left = |rig: &Rig| feel(rig, RATE).felt()[0].left_out().to_vec();
    let skin = on(&small, "kind = \"vibration\"\ndc = true");
    let share = TAU * 1000.0 * 8e-7 / 7.0;
    let [Left::Small(told)] = left(&skin)[..] else { panic!("{:?}", left(&skin)) };
    close(told, share, 1e-12, "share");
    assert!(left(&on(&small, "")).is_empty() && left(&on(TACTOR, "kind = \"vibration\"")).is_empty());
    let current = rig(TACTOR, [DC[0], "gain = 0.2\ndrive = \"current\"\ncoupling = \"dc\"", ""]);
    assert_eq!(left(&current), [Left::Imposed]);
    let samples: Vec<f32> = (0..9600).map(|n| (TAU * 700.0 / RATE * f64::from(n)).sin() as f32).collect();
    let ((with, _), (without, _)) = (felt(&on(&small, ""), RATE, &samples), felt(&skin, RATE, &samples));
    let apart = with[0].iter().zip(&without[0]).skip(4800).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(f64::from(apart) < share * largest(&with[0]) && apart > 0.0, "{apart} of {}", largest(&with[0]));
    let motors = rig(COIN, DC);
    let told: Vec<String> = left(&motors).iter().map(ToString::to_string).collect();
    assert_eq!(told, ["gravity: nobody said how the device is held"]);
}
