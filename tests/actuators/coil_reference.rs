//! The coil actuators against reference data of high precision.

use pacinian::actuator::coil::model::{Model, State};
use pacinian::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::coil::readout::Outputs;
use pacinian::actuator::coil::response::Response;
use pacinian::actuator::drive::Drive;
use pacinian::dsp::complex::Complex;
use serde_json::Value;
use std::f64::consts::TAU;

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/voicecoil_frf.json")).expect("reference data")
}

fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).expect("a number")
}

fn field(data: &Value, name: &str) -> f64 {
    number(&data["params"][name])
}

fn coil(data: &Value) -> Coil {
    Coil { resistance: field(data, "R"), inductance: field(data, "L"), force_factor: field(data, "Bl") }
}

fn suspension(data: &Value) -> Spring {
    Spring { stiffness: field(data, "k"), damping: field(data, "c") }
}

fn tactor(data: &Value) -> Plant {
    let skin = Tissue {
        mass: field(data, "ms"),
        spring: Spring { stiffness: field(data, "ks"), damping: field(data, "cs") },
    };
    Plant::voice_coil(&VoiceCoil {
        coil: coil(data),
        mass: field(data, "m"),
        suspension: suspension(data),
        skin: Skin::One(skin),
    })
    .expect("sound")
}

fn inertial(data: &Value) -> Plant {
    Plant::inertial(&Inertial {
        coil: coil(data),
        slug_mass: field(data, "m"),
        casing_mass: field(data, "M"),
        suspension: suspension(data),
        hand: Tissue::default(),
    })
    .expect("sound")
}

/// Largest distance from the points of a table, as a share of each.
fn worst(table: &Value, response: impl Fn(f64) -> Complex) -> f64 {
    let rows = table.as_array().expect("rows");
    assert_eq!(rows.len(), 21);
    let distance = |row: &Value| {
        let (magnitude, degrees) = (number(&row[1]), number(&row[2]));
        let expected = Complex::turned(degrees.to_radians()) * magnitude;
        (response(number(&row[0])) - expected).abs() / magnitude
    };
    rows.iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn the_frequency_responses_are_those_of_the_reference() {
    let data = reference();
    let (skin, motor) = (tactor(&data["tactor"]), inertial(&data["inertial"]));
    let of = |plant: Plant, volts: bool, what: fn(Response) -> Complex| {
        move |hertz| what(if volts { plant.per_volt(hertz) } else { plant.per_ampere(hertz) })
    };
    for (table, response) in [
        (&data["tactor"]["x_per_V"], of(skin, true, |r| r.displacement)),
        (&data["tactor"]["x_per_A"], of(skin, false, |r| r.displacement)),
        (&data["inertial"]["acc_per_V"], of(motor, true, |r| r.casing)),
        (&data["inertial"]["acc_per_A"], of(motor, false, |r| r.casing)),
    ] {
        let worst = worst(table, response);
        assert!(worst < 1e-12, "{worst:e}");
    }
}

/// A response that a table has at a frequency, under a hold, as sampled at the end of each step, the drive not yet changed: the sum over all images n of H(ω + n ω_s) times the hold's
/// (1 − e^(−jωT)) / (j (ω + n ω_s) T). What of it follows the drive at once, `at_once`, is the drive before instead. The images lie beyond the table, so those are the plant's, which was held against it above; in pairs they fall
/// as n⁻² at least, and what is left after N is the last times N² / (N + ½).
fn held(hertz: f64, told: Complex, at_once: f64, rate: f64, beyond: &impl Fn(f64) -> Complex) -> Complex {
    let at_once = Complex::new(at_once, 0.0);
    let hold = Complex::new(1.0, 0.0) - Complex::turned(-TAU * hertz / rate);
    let held = |h: Complex, at: f64| (h - at_once) * hold / (Complex::oscillation(at) * (1.0 / rate));
    let image = |n: f64| {
        let (above, below) = (hertz + n * rate, n * rate - hertz);
        let mirrored = beyond(below);
        held(beyond(above), above) + held(Complex::new(mirrored.re, -mirrored.im), -below)
    };
    let last = 1000;
    let rest = image(f64::from(last)) * (f64::from(last).powi(2) / (f64::from(last) + 0.5));
    let before = Complex::turned(-TAU * hertz / rate) * at_once;
    (1..=last).fold(before + held(told, hertz) + rest, |sum, n| sum + image(f64::from(n)))
}

/// What comes out at a frequency of whole periods in two seconds, once everything else has died away.
fn measured(model: &mut Model, hertz: f64, rate: f64, of: fn(&Outputs) -> f64) -> Complex {
    let (turn, count) = (TAU * hertz / rate, 2 * rate as usize);
    let mut sum = Complex::default();
    for n in 0..2 * count {
        let phase = turn * (n % count) as f64;
        let y = of(&model.outputs());
        if n >= count {
            sum = sum + Complex::turned(-phase) * y * (2.0 / count as f64);
        }
        model.advance(phase.cos());
    }
    sum
}

/// The model over time at 48 kHz, against the response corrected for the hold, at every frequency of the reference.
#[test]
fn the_model_over_time_is_the_response_of_the_reference_under_a_hold() {
    let data = reference();
    let rate = 48_000.0;
    let (skin, motor) = (tactor(&data["tactor"]), inertial(&data["inertial"]));
    type Beyond<'a> = Box<dyn Fn(f64) -> Complex + 'a>;
    type Case<'a> = (&'a Plant, Drive, &'a Value, fn(&Outputs) -> f64, f64, Beyond<'a>);
    let cases: [Case; 4] = [
        (
            &skin,
            Drive::Voltage,
            &data["tactor"]["x_per_V"],
            |o| o.displacement,
            0.0,
            Box::new(|f| skin.per_volt(f).displacement),
        ),
        (
            &skin,
            Drive::Current,
            &data["tactor"]["x_per_A"],
            |o| o.displacement,
            0.0,
            Box::new(|f| skin.per_ampere(f).displacement),
        ),
        (
            &motor,
            Drive::Voltage,
            &data["inertial"]["acc_per_V"],
            |o| o.casing,
            0.0,
            Box::new(|f| motor.per_volt(f).casing),
        ),
        // A current pushes slug and casing apart at once: the casing by Bl/M.
        (
            &motor,
            Drive::Current,
            &data["inertial"]["acc_per_A"],
            |o| o.casing,
            -field(&data["inertial"], "Bl") / field(&data["inertial"], "M"),
            Box::new(|f| motor.per_ampere(f).casing),
        ),
    ];
    for (n, (plant, drive, table, of, at_once, beyond)) in cases.into_iter().enumerate() {
        let rows = table.as_array().expect("rows");
        assert_eq!(rows.len(), 21);
        for row in rows {
            let hertz = number(&row[0]);
            let told = Complex::turned(number(&row[2]).to_radians()) * number(&row[1]);
            let expected = held(hertz, told, at_once, rate, &beyond);
            let is = measured(&mut Model::new(plant, rate, drive).expect("sound"), hertz, rate, of);
            let apart = (is - expected).abs() / expected.abs();
            assert!(apart < 1e-6, "{n}, {hertz} Hz: {apart:e}");
        }
    }
}

/// Largest distance of the model's own matrix from the reference's, whose rows and columns are current, displacement, velocity and
/// input; as a share of each entry.
fn matrix_distance(plant: &Plant, rows: &Value) -> f64 {
    let states = [
        State { current: 1.0, ..State::default() },
        State { displacement: 1.0, ..State::default() },
        State { velocity: 1.0, ..State::default() },
        State::default(),
    ];
    let mut worst: f64 = 0.0;
    for (column, state) in states.iter().enumerate() {
        let mut model = Model::new(plant, 48_000.0, Drive::Voltage).expect("sound");
        model.set_state(state);
        model.advance(if column == 3 { 1.0 } else { 0.0 });
        let after = model.state();
        for (row, is) in [after.current, after.displacement, after.velocity].iter().enumerate() {
            let expected = number(&rows[row][column]);
            worst = worst.max((is / expected - 1.0).abs());
        }
    }
    worst
}

#[test]
fn the_matrices_are_those_of_the_reference() {
    let data = reference();
    for (plant, rows) in [
        (tactor(&data["tactor"]), &data["tactor"]["zoh_48k_[i,x,v|V]"]),
        (inertial(&data["inertial"]), &data["inertial"]["zoh_48k_[i,z,zdot|V]"]),
    ] {
        let worst = matrix_distance(&plant, rows);
        assert!(worst < 1e-13, "{worst:e}");
    }
}
