//! A motor that is switched on and off.

use super::order;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::actuator::driver::order::{After, By};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-on",
    family: Family::Motor,
    summary: "A motor that is switched on and off.",
    detail: "A steady voltage (or current, if that is what the amplifier imposes) while the event lasts, then a short circuit (or \
             open terminals). With `by` it is the one or the other whatever the amplifier imposes, and with `after` a short circuit or open \
             terminals follow, worked out from the speed that the motor's model has: a voltage amplifier lets a motor roll by giving what it makes itself, \
             and a current amplifier brakes it with what would flow through a short circuit. The event's level times `level` is the share of the most that there may be. It is what there is \
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
        Param {
            name: "by",
            kind: Kind::Choice(&["amplifier", "voltage", "current"], 0),
            unit: "",
            doc: "What is steady: what the amplifier imposes, a voltage (the faster it turns the less flows), or a current (as much torque at every speed, as long as there are volts for it).",
        },
        Param {
            name: "after",
            kind: Kind::Choice(&["nothing", "short", "open"], 0),
            unit: "",
            doc: "What follows: nothing is sent (a short circuit of a voltage, open terminals of a current), a short circuit, which brakes, or open terminals, where friction alone stops it.",
        },
    ],
    example: r#"run = { type = "drive-on", level = 0.8 }"#,
};

/// What a choice of `by` means.
pub fn by(choice: usize) -> By {
    By::ALL.get(choice).copied().unwrap_or_default()
}

/// What a choice of `after` means.
pub fn after(choice: usize) -> After {
    After::ALL.get(choice).copied().unwrap_or_default()
}

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, true>;

/// The definition.
pub type Exact = order::Exact<true>;
