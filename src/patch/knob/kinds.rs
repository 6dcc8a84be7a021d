//! The types of effects of a knob, and the keys of each.

use crate::text::field::{Field, Form, Table};

/// A type of effect.
#[derive(Debug)]
pub struct Type {
    /// The word for it.
    pub word: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// Keys that it must have.
    pub needs: &'static [&'static str],
    /// Keys that it may have.
    pub may: &'static [&'static str],
}

const fn of(
    word: &'static str,
    needs: &'static [&'static str],
    may: &'static [&'static str],
    doc: &'static str,
) -> Type {
    Type { word, doc, needs, may }
}

/// Types of effects.
pub static TYPES: [Type; 16] = [
    of("spring", &["stiffness"], &["centre"], "-K (angle - centre)"),
    of("damper", &["damping"], &[], "-B times the estimated speed"),
    of(
        "wall",
        &["angle", "stiffness"],
        &["damping", "side"],
        "a wall, which pushes and never pulls; a `knob.wall` as it is hit",
    ),
    of(
        "end-stops",
        &["low", "high", "stiffness"],
        &["damping"],
        "two walls with a range between them; a `knob.wall` as either is hit",
    ),
    of(
        "detents",
        &["count", "torque"],
        &["centre", "shape", "table", "hysteresis"],
        "so many notches a turn, the strongest pull of each `torque`; a `knob.detent` as one is passed",
    ),
    of(
        "snap",
        &["width", "stiffness", "torque"],
        &["point", "centre"],
        "a spring to the nearest of places `width` apart, at most `torque`, which changes over with hysteresis",
    ),
    of(
        "magnet",
        &["centre", "stiffness", "reach"],
        &[],
        "a pull to an angle that ends at its reach, smooth everywhere",
    ),
    of(
        "friction",
        &["torque"],
        &["stretch", "law"],
        "dry friction of displacement alone: it needs no speed and does not drift",
    ),
    of("inertia", &["inertia", "stiffness"], &["damping"], "a flywheel behind a spring and a damper"),
    of("constant", &["torque"], &[], "a torque that depends on nothing; positive turns to larger angles"),
    of(
        "spin",
        &["speed", "damping", "torque"],
        &[],
        "a pull to a speed, at most `torque`: it turns by itself",
    ),
    of("ripple", &["torque", "wavelength"], &[], "a sine over the angle"),
    of("texture", &["torque", "signal"], &[], "a signal of the patch times a torque"),
    of("table", &["points"], &[], "torque over angle, straight lines between points"),
    of(
        "contact",
        &["angle", "factor", "torque"],
        &["side"],
        "a round body in the way (Hertz): factor times depth to the power of 3/2, at most `torque`",
    ),
    of(
        "transient",
        &["strength", "frequency", "decay"],
        &["least", "torque"],
        "a ringing as a wall is hit, as strong as that was fast",
    ),
];

/// Keys that every effect may have.
pub(super) const COMMON: [&str; 3] = ["type", "gain", "shift"];

/// The words for the types.
const WORDS: [&str; 16] = {
    let mut words = [""; 16];
    let mut n = 0;
    while n < 16 {
        words[n] = TYPES[n].word;
        n += 1;
    }
    words
};

/// Its keys.
pub static TABLE: Table = Table {
    name: "knob",
    doc: "What a force-feedback knob feels like. The rig says what the knob is; where it has none, one is simulated.",
    fields: &[
        Field::new("effects", Form::Named(&EFFECT), "", "Effects, by name; their torques add up.").required()
    ],
    others: None,
};

/// The keys of an effect.
pub static EFFECT: Table = Table {
    name: "effect",
    doc: "An effect: a torque of the knob that depends on its angle, its speed, or a signal.",
    fields: &[
        Field::new("type", Form::Word(&WORDS), "", "What it does.").required(),
        Field::new("torque", Form::any_number(-1e3, 1e3), "N m", "Its torque, or the most of it."),
        Field::new(
            "stiffness",
            Form::any_number(0.0, 1e6),
            "N m/rad",
            "How stiff it is. More than the device bears is held to that.",
        ),
        Field::new(
            "damping",
            Form::any_number(0.0, 1e3),
            "N m s/rad",
            "How viscous it is; 0 of walls where nothing is said.",
        ),
        Field::new(
            "centre",
            Form::number(0.0, -1e6, 1e6),
            "rad",
            "Where it is at rest, or one of its places is.",
        ),
        Field::new("angle", Form::any_number(-1e6, 1e6), "rad", "Where it begins."),
        Field::new(
            "side",
            Form::Word(&["above", "below"]),
            "",
            "Of a wall or a contact: it stands in the way of larger angles, or of smaller ones.",
        ),
        Field::new("low", Form::any_number(-1e6, 1e6), "rad", "The smallest free angle."),
        Field::new("high", Form::any_number(-1e6, 1e6), "rad", "The largest free angle."),
        Field::new("count", Form::any_number(1e-3, 1e5), "a turn", "How many detents."),
        Field::new("shape", Form::Word(&["sine", "triangle"]), "", "How torque runs from detent to detent."),
        Field::new(
            "table",
            Form::Defined("numbers"),
            "",
            "In place of a shape: torque over `torque` at equal steps from crest to crest, 2 or more values within -1 and 1.",
        ),
        Field::new(
            "hysteresis",
            Form::number(0.05, 0.0, 0.4),
            "pitches",
            "By how much a crest must be passed until the detent counts as passed.",
        ),
        Field::new("width", Form::any_number(1e-6, 1e6), "rad", "From place to place."),
        Field::new(
            "point",
            Form::number(0.6, 0.5, 1.0),
            "widths",
            "How far from its place the knob changes over to the next: 0.5 is no hysteresis.",
        ),
        Field::new("reach", Form::any_number(1e-9, 1e6), "rad", "How far from its centre it pulls."),
        Field::new(
            "stretch",
            Form::number(0.01, 1e-9, 1e3),
            "rad",
            "How far the knob gives before it slides: several counts of the encoder.",
        ),
        Field::new(
            "law",
            Form::Word(&["adhesion", "dahl"]),
            "",
            "Whether friction gives like a spring until it slides, or more and more.",
        ),
        Field::new("inertia", Form::any_number(1e-12, 1e3), "kg m2", "Of the flywheel."),
        Field::new("speed", Form::any_number(-1e4, 1e4), "rad/s", "The speed that it pulls to."),
        Field::new("wavelength", Form::any_number(1e-6, 1e6), "rad", "From crest to crest."),
        Field::new(
            "signal",
            Form::Defined("signal"),
            "",
            "A number or an expression of shared nodes, controls and `knob.speed`; \"voices\": what is played at the knob's output.",
        ),
        Field::new(
            "points",
            Form::Defined("curve"),
            "rad, N m",
            "Pairs of angle and torque, angles rising; beyond the ends, the torque of the end.",
        ),
        Field::new("factor", Form::any_number(1e-9, 1e9), "N m/rad^1.5", "Of a contact."),
        Field::new(
            "strength",
            Form::any_number(0.0, 1e3),
            "N m s/rad",
            "Amplitude of a ringing for a hit at 1 rad/s.",
        ),
        Field::new("frequency", Form::any_number(20.0, 300.0), "Hz", "Of a ringing."),
        Field::new("decay", Form::any_number(1e-3, 10.0), "s", "In which a ringing falls to 1/e."),
        Field::new("least", Form::number(0.05, 0.0, 1e4), "rad/s", "Hits slower than this pass unheard."),
        Field::new(
            "gain",
            Form::Defined("signal"),
            "",
            "Factor of its torque: a number, or an expression of shared nodes, controls and `knob.speed`; 1 where nothing is said.",
        ),
        Field::new(
            "shift",
            Form::Defined("signal"),
            "rad",
            "By how much it is turned: a number or such an expression; 0 where nothing is said.",
        ),
    ],
    others: None,
};
