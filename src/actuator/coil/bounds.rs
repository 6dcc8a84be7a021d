//! What limits the motion of a coil actuator.

use super::parameters::{Skin, Spring, VoiceCoil};
use super::plant::{Kind, Plant};
use crate::actuator::fault::{Fault, Limit, not_negative, positive};

/// What limits the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// Where the motion ends, on both sides.
    pub end_stop: Option<EndStop>,
    /// Force with which a tactor is pressed on the skin, newtons; `None`: it sticks to it.
    pub preload: Option<f64>,
}

/// Where the motion ends, on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndStop {
    /// Metres from rest, above 0.
    pub stroke: f64,
    /// What it hits there; its stiffness above 0.
    pub spring: Spring,
}

impl Bounds {
    /// None at all.
    pub(super) fn is_none(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn check(&self, plant: &Plant) -> Result<(), Fault> {
        if let Some(stop) = &self.end_stop {
            positive("stroke", stop.stroke)?;
            positive("stop.stiffness", stop.spring.stiffness)?;
            not_negative("stop.damping", stop.spring.damping)?;
        }
        let Some(preload) = self.preload else { return Ok(()) };
        not_negative("preload", preload)?;
        let why = match &plant.kind {
            Kind::Tactor(VoiceCoil { skin: Skin::One(tissue), .. }) if tissue.spring.stiffness > 0.0 => {
                return Ok(());
            }
            Kind::Tactor(VoiceCoil { skin: Skin::Two(..), .. }) => "a skin of two branches is never lost",
            Kind::Tactor(_) => "there is no skin with a stiffness",
            Kind::Inertial(_) => "an inertial motor does not press on the skin",
        };
        Err(Fault { because: Some(why), field: "preload", value: preload, limit: Limit::Absent })
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Model;
    use super::super::parameters::tests::{inertial, layered, tactor};
    use super::super::parameters::{Skin, Spring, Tissue, VoiceCoil};
    use super::super::plant::Plant;
    use super::{Bounds, EndStop};
    use crate::actuator::drive::Drive;

    fn stop(stroke: f64, stiffness: f64, damping: f64) -> Bounds {
        Bounds { end_stop: Some(EndStop { stroke, spring: Spring { stiffness, damping } }), preload: None }
    }

    #[test]
    fn bounds_that_cannot_be_are_refused() {
        let skin = Plant::voice_coil(&tactor()).unwrap();
        let fault = |plant: &Plant, bounds| {
            Model::bounded(plant, 48e3, Drive::Voltage, &bounds).unwrap_err().to_string()
        };
        assert!(fault(&skin, stop(0.0, 1.0, 0.0)).starts_with("`stroke` is 0"));
        assert!(fault(&skin, stop(1.0, 0.0, 0.0)).starts_with("`stop.stiffness` is 0"));
        assert!(fault(&skin, stop(1.0, 1.0, -1.0)).starts_with("`stop.damping` is -1"));
        let pressed = |preload| Bounds { preload: Some(preload), end_stop: None };
        assert!(fault(&skin, pressed(-1.0)).starts_with("`preload` is -1"));
        let free = Plant::voice_coil(&VoiceCoil { skin: Skin::One(Tissue::default()), ..tactor() }).unwrap();
        assert!(fault(&free, pressed(1.0)).contains("no skin"));
        assert!(fault(&Plant::voice_coil(&layered()).unwrap(), pressed(1.0)).contains("never lost"));
        assert!(fault(&Plant::inertial(&inertial()).unwrap(), pressed(1.0)).contains("inertial"));
    }
}
