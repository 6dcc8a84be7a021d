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
             motor's own model, with its inductance. Where it is known where the mass hangs (after `drive-home`, and from there on, \
             wherever clicks, spins and brakes turn it, until the motor's figures, if they are 5 % off, may have led its model 30 degrees astray: after two quarter turns one way, \
             eight to and fro), gravity is part of it: the model ends each drive while the click is under way, and less \
             than 0.1 % of its peak speed is left of the first click from home, as far as the mass hangs where home is said to be. Near the top a small error grows by itself, \
             most in weak clicks: where it matters, go home again before each. Where it is not, the times are those of a motor that lies flat: of a coin motor that stands upright, \
             gravity then leaves 1 to 16 %, by where the mass hangs and how weak the click is. The event's level is the share of the strongest acceleration that the motor \
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
