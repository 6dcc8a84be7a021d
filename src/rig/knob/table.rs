//! The keys of `[knob]`.

use super::controller::CONTROLLER;
use super::sensor::SENSOR;
use crate::text::field::{Field, Form, Table};

/// What a rig says of a knob.
pub static TABLE: Table = Table {
    name: "knob",
    doc: "A force-feedback knob: its motor, what hangs on it, how it is read and driven, and what it must keep to.",
    fields: &FIELDS,
    others: None,
};

/// Its keys. Those that are numbers may be figures of a shipped motor.
pub static FIELDS: [Field; 45] = [
    Field::new(
        "motor",
        Form::Text,
        "",
        "A motor that ships with pacinian, whose figures hold where nothing else is said: pittman-8693, maxon-re25.",
    ),
    Field::new(
        "inertia",
        Form::any_number(1e-12, 1e3),
        "kg m2",
        "Of all that turns with the motor's shaft, without what `knob_inertia` says; needed without a `motor`.",
    ),
    Field::new(
        "knob_inertia",
        Form::any_number(1e-12, 1e3),
        "kg m2",
        "Of the knob on it. Where `resonance` is known too, the two are joined by a shaft that twists.",
    ),
    Field::new(
        "viscous",
        Form::any_number(0.0, 1e3),
        "N m s/rad",
        "Viscous friction of the bearings; 0 where nothing is said.",
    ),
    Field::new(
        "viscous_shorted",
        Form::any_number(0.0, 1e3),
        "N m s/rad",
        "What is added to that while the terminals are shorted, as data sheets have it. A motor that a current drives has none of it: it counts with drive = \"voltage\" alone.",
    ),
    Field::new(
        "friction",
        Form::any_number(0.0, 1e3),
        "N m",
        "Dry friction while it turns. Alone it hides the encoder's counts; where it is not known, nothing is said of the dynamic range.",
    ),
    Field::new(
        "stiction",
        Form::any_number(0.0, 1e3),
        "N m",
        "Dry friction at rest; that of turning where nothing is said.",
    ),
    Field::new(
        "peak_torque",
        Form::any_number(1e-9, 1e3),
        "N m",
        "The most torque, for a short time; needed without a `motor`.",
    ),
    Field::new(
        "continuous_torque",
        Form::any_number(1e-9, 1e3),
        "N m",
        "What it bears for good; a fifth of the peak where nothing is said.",
    ),
    Field::new(
        "torque_constant",
        Form::any_number(1e-9, 1e3),
        "N m/A",
        "Torque for an ampere, which is also volts for a rad/s.",
    ),
    Field::new("resistance", Form::any_number(1e-6, 1e6), "ohm", "Of the winding."),
    Field::new("inductance", Form::any_number(1e-9, 1e3), "H", "Of the winding."),
    Field::new("supply", Form::any_number(1e-3, 1e6), "V", "Of the amplifier."),
    Field::new(
        "drive",
        Form::Word(&["ideal", "current", "voltage"]),
        "",
        "What the amplifier imposes: the torque itself, a current by a loop of `current_bandwidth`, or a voltage.",
    ),
    Field::new("current_bandwidth", Form::number(1000.0, 1.0, 1e6), "Hz", "Of a current loop."),
    Field::new(
        "winding_time",
        Form::number(12.0, 1e-2, 1e5),
        "s",
        "In which the winding warms: how long the peak torque lasts.",
    ),
    Field::new("housing_time", Form::any_number(1e-2, 1e6), "s", "In which the housing warms."),
    Field::new(
        "resonance",
        Form::any_number(1.0, 1e5),
        "Hz",
        "Of the motor against its shaft with the knob clamped.",
    ),
    Field::new("shaft_damping", Form::number(0.0, 0.0, 1e3), "N m s/rad", "Of the shaft as it twists."),
    Field::new(
        "counts",
        Form::any_count(1, 400_000_000),
        "a turn",
        "Counts of the encoder, four for each of its lines; the angle is known exactly where neither is said.",
    ),
    Field::new(
        "lines",
        Form::any_count(1, 100_000_000),
        "a turn",
        "Lines of the encoder, in place of counts.",
    ),
    Field::new(
        "cogging",
        Form::Defined("harmonics"),
        "",
        "Torque that the motor makes by itself over the angle: a list of { periods, amplitude, phase }, in N m and rad.",
    ),
    Field::new(
        "ripple",
        Form::Defined("harmonics"),
        "",
        "By what share its torque constant is larger than on the mean, over the angle, likewise.",
    ),
    Field::new("compensate", Form::Flag(false), "", "Whether known cogging and ripple are made up for."),
    Field::new("low", Form::any_number(-1e6, 1e6), "rad", "Where a mechanical stop ends it."),
    Field::new("high", Form::any_number(-1e6, 1e6), "rad", "Where the other does."),
    Field::new("stop_stiffness", Form::number(10.0, 1e-6, 1e9), "N m/rad", "Of those stops."),
    Field::new("stop_damping", Form::number(0.0, 0.0, 1e6), "N m s/rad", "Of those stops."),
    Field::new(
        "rate",
        Form::number(8000.0, 1000.0, 192_000.0),
        "Hz",
        "Of the servo: of what fits the engine, the nearest is taken.",
    ),
    Field::new(
        "delay",
        Form::any_number(0.0, 0.5),
        "s",
        "From the angle to its torque, measured, beside the tick for which torque is held: with a `sensor` what card and system take, as `pacinian latency` says. Where nothing is said, none; with a `sensor` four blocks and 4 ms, with a `controller` two blocks, two exchanges and 2 ms.",
    ),
    Field::new(
        "velocity",
        Form::Word(&["adaptive", "kalman", "filtered", "difference"]),
        "",
        "How speed is estimated: by the longest line that explains the readings, by a filter for a bounded acceleration, a low-pass, or the last step alone.",
    ),
    Field::new(
        "velocity_window",
        Form::number(0.01, 1e-5, 1.0),
        "s",
        "Of the adaptive estimate: the longest line.",
    ),
    Field::new("velocity_corner", Form::number(100.0, 0.1, 1e5), "Hz", "Of the filtered one."),
    Field::new(
        "acceleration",
        Form::number(1000.0, 1e-3, 1e9),
        "rad/s2",
        "Of the Kalman one: root-mean-square.",
    ),
    Field::new(
        "margin",
        Form::number(0.5, 1e-3, 1.0),
        "",
        "The share of what makes it swing that the governor grants.",
    ),
    Field::new(
        "passivity",
        Form::number(0.0, 0.0, 1.0),
        "",
        "Brakes by what came out in excess of what went in, up to this share of the speed a tick; 0 watches and does not brake. What a delay of up to a tick creates is made good, of more a part.",
    ),
    Field::new("slew", Form::number(1000.0, 1e-6, 1e9), "N m/s", "The fastest change of torque."),
    Field::new(
        "reconstruction",
        Form::any_number(1.0, 1e5),
        "Hz",
        "Corner of a low-pass on the torque; none where nothing is said.",
    ),
    Field::new(
        "soft_start",
        Form::number(0.3, 0.0, 10.0),
        "s",
        "In which torque rises once it is asked for.",
    ),
    Field::new(
        "over_speed",
        Form::number(60.0, 0.1, 1e5),
        "rad/s",
        "The speed at which torque goes off for good: faster than a hand turns.",
    ),
    Field::new(
        "stale",
        Form::number(0.005, 0.0, 10.0),
        "s",
        "How long a reading may be missing before torque falls.",
    ),
    Field::new("release", Form::number(0.05, 0.0, 10.0), "s", "In which it falls then."),
    Field::new(
        "sensor",
        Form::One(&SENSOR),
        "",
        "By which inputs of a sound card the angle of a knob that is there comes in; where nothing is said, it is simulated.",
    ),
    Field::new(
        "controller",
        Form::One(&CONTROLLER),
        "",
        "The serial line of a knob that is there, in place of `sensor` and `output`: { type = \"odrive\", port = \"/dev/ttyACM0\" }.",
    ),
    Field::new(
        "output",
        Form::Defined("torque output"),
        "",
        "The output of kind torque that it leaves by: { name = \"knob\", newton_metres = 0.15 }, the torque of a sample of 1.0. Where nothing is said, the only one, and the peak.",
    ),
];

/// The keys of a harmonic.
pub static HARMONIC: Table = Table {
    name: "harmonic",
    doc: "A sine over the angle of a turn.",
    fields: &[
        Field::new("periods", Form::any_count(1, 10_000), "a turn", "How many periods a turn has.")
            .required(),
        Field::new("amplitude", Form::any_number(-1e3, 1e3), "N m", "Its amplitude; of ripple a share.")
            .required(),
        Field::new("phase", Form::number(0.0, -1e3, 1e3), "rad", "amplitude sin(periods angle + phase)."),
    ],
    others: None,
};

/// The keys of `output`.
pub static OUTPUT: Table = Table {
    name: "torque output",
    doc: "Where torque leaves.",
    fields: &[
        Field::new("name", Form::Text, "", "An [[output]] with kind = \"torque\".").required(),
        Field::new("newton_metres", Form::any_number(1e-9, 1e3), "N m", "The torque of a sample of 1.0.")
            .required(),
    ],
    others: None,
};
