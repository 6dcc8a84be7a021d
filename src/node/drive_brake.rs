//! A motor is brought to rest.

use super::order;
use super::spec::{Family, NodeSpec};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-brake",
    family: Family::Motor,
    summary: "A motor is brought to rest.",
    detail: "As fast as the drive allows, whatever it was ordered (behind a rectifier, where nothing brakes, it rolls out); what levels say \
             then goes on. It is an order to the rumble \
             motors at the voice's place (outputs of kind drive), worked out for each of them; elsewhere, and as a signal, it is \
             silence. The newest order of a motor holds, and what was under way is braked first.",
    params: &[],
    example: r#"stop = { type = "drive-brake" }"#,
};

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, false>;

/// The definition.
pub type Exact = order::Exact<false>;
