//! A motor that is switched on and off.

use super::order;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-on",
    family: Family::Motor,
    summary: "A motor that is switched on and off.",
    detail: "A steady voltage (or current, if that is what the amplifier imposes) while the event lasts, then a short circuit (or \
             open terminals). The event's level times `level` is the share of the most that there may be. It is what there is \
             without shaping: the motor takes its time to get there, and to stop. Behind a rectifier nothing goes backward, and it rolls out. It is an order to the rumble motors at the \
             voice's place (outputs of kind drive), worked out for each of them; elsewhere, and as a signal, it is silence. The \
             newest order of a motor holds, and what was under way is braked first.",
    params: &[
        Param {
            name: "level",
            kind: Kind::Constant(Numeric::or(1.0, -1.0, 1.0)),
            unit: "",
            doc: "The share of the most that there may be; backward where it is negative.",
        },
    ],
    example: r#"run = { type = "drive-on", level = 0.8 }"#,
};

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, true>;

/// The definition.
pub type Exact = order::Exact<true>;
