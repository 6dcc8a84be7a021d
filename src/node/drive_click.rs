//! A click or a thump of a motor: thrown forward and stopped.

use super::order;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "drive-click",
    family: Family::Motor,
    summary: "A click or a thump of a motor: thrown forward and stopped.",
    detail: "The mass is turned so far and stands again: the full drive forward, then backward for as long as it takes to stop \
             the rotor, which is less than forward, then a last moment forward that empties the coil. The times are solved on the \
             motor's own model, with its inductance and as if it lay flat: of a coin motor that stands upright, gravity leaves 1 to 7 % of \
             the click's peak speed when the drive ends, by where the mass hangs. The event's level is the share of the strongest acceleration that the motor \
             can make in such a click; a weaker one than what turns it at all is played as strong as that. A quarter of a \
             turn is a click, a whole turn or more a thump. Behind a rectifier (drive = \"carrier\" in the rig) nothing brakes, and a click \
             is a push forward, so short that the mass rolls to where it is to stand. The release changes nothing. It is an order to the rumble motors at the \
             voice's place (outputs of kind drive), worked out for each of them; elsewhere, and as a signal, it is silence. The \
             newest order of a motor holds, and what was under way is braked first.",
    params: &[
        Param {
            name: "turns",
            kind: Kind::Constant(Numeric::or(0.25, -100.0, 100.0)),
            unit: "",
            doc: "How far the mass turns; negative backward.",
        },
    ],
    example: r#"tap = { type = "drive-click", turns = 0.25 }"#,
};

/// Eight lanes of silence.
pub type Lanes<R> = order::Lanes<R, false>;

/// The definition.
pub type Exact = order::Exact<false>;
