//! The mass of a motor is brought to where gravity catches it.

use super::order;
use super::spec::{Family, NodeSpec};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-home",
    family: Family::Motor,
    summary: "The mass of a motor is brought to where gravity catches it.",
    detail: "Which way a click kicks depends on where the mass hangs, and every click leaves it elsewhere. This spins it, and then lets it \
             creep with too little to lift it over the top: it is caught at the same place, wherever it was before, and friction \
             keeps it there, so that clicks kick the same way. From there on it is known where the mass hangs, and clicks are solved with gravity \
             (see `drive-click`). It takes some tenths of a second and is felt a little, so it belongs before a row of clicks; a weak click \
             back, with the `turns` of the click forward but negative, then keeps it near for a few; `park` in the rig goes home again by itself, after every rest. The motor must have a `tilt` in the rig, or \
             gravity is not known, and a steady voltage: the pulses of a bridge and the carrier of a rectifier shake the mass loose. How \
             long it takes, where the mass hangs then and how certainly, says `pacinian check`, also where a figure of the motor is 5 % off: where friction is \
             several times the weight of the mass, as in most small motors, that may be anywhere, so `pacinian identify` the motor before counting on it. \
             Beside a motor that can be brought home, the order is nothing for one that cannot, and is counted: `pacinian check` warns of it where the patch's own \
             events, patterns and triggers send it there; what comes by MIDI, OSC or from a library it cannot know beforehand, and says of the \
             motor alone that it is not to be brought home. Level and release change nothing. It is an \
             order to the rumble motors at the voice's place (outputs of kind drive), worked out \
             for each of them; elsewhere, and as a signal, it is silence. The newest order of a motor holds, and what was under way \
             is braked first.",
    params: &[],
    example: r#"go = { type = "drive-home" }"#,
};

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, false>;

/// The definition.
pub type Exact = order::Exact<false>;
