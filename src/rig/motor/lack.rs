//! What a rig does not say of a motor, or says amiss.

use std::fmt;

use crate::actuator::fault::Fault;
use crate::rig::Actuator;
use crate::text::Problem;

/// What is missing for a motor, or contradicts itself.
#[derive(Debug, Clone, PartialEq)]
pub enum Lack {
    /// A figure that nothing says.
    Figure(&'static str),
    /// A figure that cannot be.
    Fault(Fault),
}

impl fmt::Display for Lack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Figure(key) => write!(f, "`{key}` is not known"),
            Self::Fault(fault) => {
                f.write_str(&fault.to_string().replacen(fault.field, key_of(fault.field), 1))
            }
        }
    }
}

impl std::error::Error for Lack {}

impl Lack {
    pub(in crate::rig) fn of(self, actuator: &Actuator) -> Problem {
        let name = &actuator.name;
        match self {
            Self::Figure(key) => {
                let what = format!("actuator `{name}` lacks `{key}`: how it moves is not known");
                let help = match actuator.part {
                    None => "give it, or name a part that ships: part = \"...\"; `pacinian parts` lists them",
                    Some(_) => "its part does not say it; give it here",
                };
                Problem::error(&actuator.span, what).help(help.to_string())
            }
            Self::Fault(fault) => {
                let what = format!("actuator `{name}` cannot be: {}", Self::Fault(fault));
                Problem::error(&actuator.span, what)
            }
        }
    }
}

/// The rig's key for a field of the model.
fn key_of(field: &'static str) -> &'static str {
    match field {
        "gain" => "torque_constant",
        "viscous" => "viscous_friction",
        "coulomb" => "coulomb_friction",
        "stiction" => "static_friction",
        "eccentric" => "eccentric_moment",
        "casing mass" => "mass",
        "casing stiffness across" | "casing stiffness upright" => "mount_stiffness",
        "casing damping across" | "casing damping upright" => "mount_damping",
        other => other,
    }
}
