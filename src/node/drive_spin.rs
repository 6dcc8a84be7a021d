//! A buzz of a motor: overdriven to its speed, braked at the end.

use super::order;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::actuator::driver::setup::Shaping;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-spin",
    family: Family::Motor,
    summary: "A buzz of a motor: overdriven to its speed, braked at the end.",
    detail: "The full drive until the motor is as fast as it is to be, then what holds it; from the end of the event the full \
             drive backward until it stands (behind a rectifier, where nothing brakes, it rolls out). The event's level times `level` is \
             the share of the rated vibration. With `shaping` it is brought about in another way: \"switching\" gives the full drive one way or \
             the other at every sample, whichever brings the motor nearer, and so holds its speed against all that its model knows of; \"plain\" gives \
             what holds the speed, and nothing behind it. It is an order \
             to the rumble motors at the voice's place (outputs of kind drive), worked out for each of them; elsewhere, and as a \
             signal, it is silence. The newest order of a motor holds, and what was under way is braked first.",
    params: &[
        Param {
            name: "level",
            kind: Kind::Constant(Numeric::or(1.0, -1.0, 1.0)),
            unit: "",
            doc: "The share of the rated vibration; backward where it is negative.",
        },
        Param {
            name: "shaping",
            kind: Kind::Choice(&["overdrive", "switching", "plain"], 0),
            unit: "",
            doc: "How the speed is brought about.",
        },
    ],
    example: r#"buzz = { type = "drive-spin" }"#,
};

/// What a choice of `shaping` means.
pub fn shaping(choice: usize) -> Shaping {
    [Shaping::Overdrive, Shaping::Switching, Shaping::Plain].get(choice).copied().unwrap_or(Shaping::Overdrive)
}

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, true>;

/// The definition.
pub type Exact = order::Exact<true>;
