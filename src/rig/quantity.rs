//! The figures of an actuator, and of which models they are.

use super::actuator::Model;
use crate::text::field::{Field, Form};

/// How many there are.
pub const COUNT: usize = FIGURES.len();

/// Their keys, in the order in which one fills them in.
pub const FIELDS: [Field; COUNT] = {
    let mut fields = [const { Field::new("", Form::Text, "", "") }; COUNT];
    let mut n = 0;
    while n < COUNT {
        let Figure { key, least, most, unit, doc, .. } = FIGURES[n];
        fields[n] = Field::new(key, Form::any_number(least, most), unit, doc);
        n += 1;
    }
    fields
};

/// By key: the models that have it; none for all of them.
pub const MODELS: [&[Model]; COUNT] = {
    let mut models: [&[Model]; COUNT] = [&[]; COUNT];
    let mut n = 0;
    while n < COUNT {
        models[n] = FIGURES[n].of;
        n += 1;
    }
    models
};

/// Its description.
pub fn field(key: &str) -> Option<&'static Field> {
    static TABLE: [Field; COUNT] = FIELDS;
    TABLE.iter().find(|field| field.key == key)
}

struct Figure {
    key: &'static str,
    least: f64,
    most: f64,
    unit: &'static str,
    of: &'static [Model],
    doc: &'static str,
}

const fn figure(
    key: &'static str,
    [least, most]: [f64; 2],
    unit: &'static str,
    of: &'static [Model],
    doc: &'static str,
) -> Figure {
    Figure { key, least, most, unit, of, doc }
}

const ANY: &[Model] = &[];
const MOTOR: &[Model] = &[Model::RumbleMotor];
const COILS: &[Model] = &[Model::VoiceCoil, Model::InertialMotor, Model::Lra];
const WOUND: &[Model] = &[Model::VoiceCoil, Model::InertialMotor, Model::RumbleMotor, Model::Lra];
const TACTOR: &[Model] = &[Model::VoiceCoil];
const EXCITER: &[Model] = &[Model::InertialMotor];
const SHEET: &[Model] = &[Model::Lra];
const SPRUNG: &[Model] = &[Model::VoiceCoil, Model::InertialMotor];
const SHAKEN: &[Model] = &[Model::InertialMotor, Model::Lra];
const PIEZO: &[Model] = &[Model::Piezo];

const FIGURES: [Figure; 46] = [
    figure("resonance", [1.0, 10_000.0], "Hz", ANY, "Its resonance."),
    figure("q", [0.05, 1000.0], "", ANY, "Quality of the resonance."),
    figure("rated_volts", [1e-3, 1e4], "V", ANY, "What it is made for (peak)."),
    figure(
        "max_volts",
        [1e-3, 1e4],
        "V",
        ANY,
        "The most it bears (peak), if that is more than what it is made for.",
    ),
    figure(
        "max_amperes",
        [1e-6, 1e3],
        "A",
        ANY,
        "The most current it bears (peak); of a motor at a voltage that at a standstill, as data sheets have it: braked, it takes up to twice as much.",
    ),
    figure(
        "max_rms_volts",
        [1e-3, 1e4],
        "V",
        ANY,
        "What it bears for as long as one likes (root mean square).",
    ),
    figure(
        "max_rms_amperes",
        [1e-6, 1e3],
        "A",
        ANY,
        "The current it bears for as long as one likes (root mean square).",
    ),
    figure("max_slew", [1e-3, 1e12], "V/s", ANY, "The fastest change of voltage it bears."),
    figure(
        "max_heating",
        [1.0, 1000.0],
        "K",
        WOUND,
        "By how much its winding may be warmer than the air; with the four figures below it limits what it gets for long.",
    ),
    figure("winding_to_housing", [1e-3, 1e5], "K/W", WOUND, "Thermal resistance from winding to housing."),
    figure("housing_to_air", [1e-3, 1e5], "K/W", WOUND, "Thermal resistance from housing to air."),
    figure(
        "winding_time",
        [1e-3, 1e6],
        "s",
        WOUND,
        "In which the winding follows the housing: its heat capacity times `winding_to_housing`.",
    ),
    figure(
        "housing_time",
        [1e-3, 1e7],
        "s",
        WOUND,
        "In which the housing follows the air: its heat capacity times `housing_to_air`.",
    ),
    figure("resistance", [1e-3, 1e9], "ohm", WOUND, "Resistance of the winding."),
    figure("inductance", [0.0, 1e3], "H", WOUND, "Inductance of the winding; 0: none to speak of."),
    figure(
        "torque_constant",
        [1e-9, 1e3],
        "N m/A",
        MOTOR,
        "Torque for each ampere, which is volts for each rad/s.",
    ),
    figure(
        "inertia",
        [1e-18, 1e3],
        "kg m2",
        MOTOR,
        "Of all that spins, about the shaft; the eccentric mass is part of it.",
    ),
    figure("viscous_friction", [0.0, 1e3], "N m s/rad", MOTOR, "Friction that grows with speed."),
    figure("coulomb_friction", [0.0, 1e3], "N m", MOTOR, "Friction while it turns, whatever its speed."),
    figure(
        "static_friction",
        [0.0, 1e3],
        "N m",
        MOTOR,
        "Friction that holds it at rest; that of running where nothing is said.",
    ),
    figure(
        "eccentric_moment",
        [0.0, 1e3],
        "kg m",
        MOTOR,
        "Eccentric mass times the distance of its centre from the shaft.",
    ),
    figure(
        "mass",
        [1e-9, 1e6],
        "kg",
        MOTOR,
        "All that moves with the motor, eccentric mass included; a motor in a firm hand does not move.",
    ),
    figure(
        "mount_stiffness",
        [0.0, 1e12],
        "N/m",
        MOTOR,
        "Of the springs that hold what moves; none where nothing is said.",
    ),
    figure("mount_damping", [0.0, 1e9], "N s/m", MOTOR, "Of what holds what moves."),
    figure(
        "time_constant",
        [1e-6, 1e3],
        "s",
        MOTOR,
        "In which its speed follows the voltage; for a motor of which no more is known.",
    ),
    figure(
        "speed_per_volt",
        [1e-6, 1e9],
        "rad/s/V",
        MOTOR,
        "By which its speed grows with the voltage; likewise.",
    ),
    figure(
        "running_volts",
        [0.0, 1e4],
        "V",
        MOTOR,
        "What friction takes of the voltage while it runs; likewise.",
    ),
    figure("start_volts", [0.0, 1e4], "V", MOTOR, "What starts it from rest, gravity aside; likewise."),
    figure("eccentric_per_mass", [0.0, 1e3], "m", MOTOR, "Eccentric moment over all that moves; likewise."),
    figure("force_factor", [1e-6, 1e6], "N/A", SPRUNG, "Force for each ampere, which is volts for each m/s."),
    figure("moving_mass", [1e-9, 1e3], "kg", TACTOR, "What the coil moves: coil or magnet, and contactor."),
    figure("slug_mass", [1e-9, 1e3], "kg", SHAKEN, "What is shaken inside."),
    figure(
        "casing_mass",
        [1e-9, 1e6],
        "kg",
        EXCITER,
        "Everything else that moves as one: the casing and what it is mounted on.",
    ),
    figure(
        "stiffness",
        [0.0, 1e12],
        "N/m",
        SPRUNG,
        "Of the suspension; from `resonance` where nothing is said.",
    ),
    figure("damping", [0.0, 1e9], "N s/m", SPRUNG, "Of the suspension; from `q` where nothing is said."),
    figure("stroke", [1e-9, 1.0], "m", COILS, "The farthest it moves from rest."),
    figure(
        "sensitivity",
        [1e-9, 1e9],
        "m/s2/V",
        COILS,
        "Acceleration (peak) for each volt (peak) at the resonance.",
    ),
    figure(
        "rated_acceleration",
        [1e-6, 1e6],
        "m/s2",
        SHEET,
        "What the rated voltage makes at the resonance (peak).",
    ),
    figure("test_mass", [0.0, 1e6], "kg", SHEET, "What it was mounted on when that was measured."),
    figure("device_mass", [1e-9, 1e3], "kg", SHEET, "All of it, with its slug."),
    figure("skin_mass", [0.0, 1.0], "kg", TACTOR, "Skin that moves with the contactor."),
    figure("skin_stiffness", [0.0, 1e9], "N/m", TACTOR, "Of the skin; none where nothing is said."),
    figure("skin_damping", [0.0, 1e6], "N s/m", TACTOR, "Of the skin."),
    figure(
        "capacitance",
        [1e-15, 1.0],
        "F",
        PIEZO,
        "Of the element: with `max_amperes`, its own or the amplifier's, it says how fast its voltage may change.",
    ),
    figure(
        "min_volts",
        [-1e4, 0.0],
        "V",
        PIEZO,
        "The lowest voltage it bears; as far below 0 as above where nothing is said.",
    ),
    figure("loss", [0.0, 10.0], "", PIEZO, "Tangent of its loss angle."),
];
