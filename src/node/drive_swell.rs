//! An envelope of a motor, known as a whole.

use super::order;
use super::spec::{Family, Kind, NodeSpec, Param};
use crate::actuator::driver::setup::Shaping;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-swell",
    family: Family::Motor,
    summary: "An envelope of a motor, known as a whole.",
    detail: "The casing shakes as strongly as the points say, in shares of the rated vibration times the event's level: from 0 at the onset through \
             each of them, along its shape (as of `breakpoints`), then 0. By inverse dynamics: as all of it is known when the patch is \
             loaded, what would rise faster than the motor can is reached later and what would fall faster than it can be braked is left \
             earlier, so that it is braked in time and needs no look-ahead; `pacinian check` says how much of it is out of a motor's reach. `shaping` makes \
             it otherwise, as that of an output does levels: \"overdrive\", \"switching\" or \"plain\". The release changes nothing. It is an order \
             to the rumble motors at the voice's place (outputs of kind drive), worked out for each of them; elsewhere, and as a \
             signal, it is silence. The newest order of a motor holds, and what was under way is taken over at its speed, braked or \
             sped up as fast as may be; an envelope ends where another patch takes over that has other ones.",
    params: &[
        Param {
            name: "points",
            kind: Kind::Points,
            unit: "",
            doc: "Points in order, the last of them from 0.1 ms to 10 s after the onset: `at` in seconds, `value` the share of the rated vibration (negative: backward), and `shape` of the way there: linear, slow, fast, exponential or from −20 to 20.",
        },
        Param {
            name: "shaping",
            kind: Kind::Choice(&["inverse", "overdrive", "switching", "plain"], 0),
            unit: "",
            doc: "How the speeds are brought about.",
        },
    ],
    example: r#"rise = { type = "drive-swell", points = [{ at = 0.1, value = 0.8 }, { at = 0.25, value = 0 }] }"#,
};

/// What a choice of `shaping` means.
pub fn shaping(choice: usize) -> Shaping {
    let all = [Shaping::Inverse, Shaping::Overdrive, Shaping::Switching, Shaping::Plain];
    all.get(choice).copied().unwrap_or_default()
}

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, false>;

/// The definition.
pub type Exact = order::Exact<false>;
