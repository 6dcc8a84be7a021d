//! What a coil, what it moves and what it pushes against are made of.

use crate::actuator::fault::{Fault, Limit, not_negative, positive};

/// A coil in a magnetic field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coil {
    /// Ohms, above 0.
    pub resistance: f64,
    /// Henries; 0: the current follows the voltage at once.
    pub inductance: f64,
    /// Newtons an ampere, which is volts a metre a second; above 0.
    pub force_factor: f64,
}

/// A spring and the damping beside it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring {
    /// Newtons a metre.
    pub stiffness: f64,
    /// Newtons a metre a second.
    pub damping: f64,
}

/// A mass on a spring that stands on firm ground: skin, or a hand. Without a mass, stiffness and damping it is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tissue {
    /// Kilograms.
    pub mass: f64,
    /// To the ground.
    pub spring: Spring,
}

/// A second branch of skin, which stores motion of its own: a mass between the contactor and the bone.
///
/// Two branches that are firmly joined to the contactor would add up to one. This one is joined to it by a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Kilograms, above 0.
    pub mass: f64,
    /// To the contactor.
    pub coupling: Spring,
    /// To the bone; none: the layer hangs on the contactor alone.
    pub anchor: Spring,
}

/// What a contactor pushes against.
///
/// Skin is known by its order of magnitude: it differs between places, people and forces, and a fingertip is not one mass on
/// a spring over all of 50 to 500 Hz. Measured skin goes into the frequency response, see [`Plant::against`](super::plant::Plant).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Skin {
    /// Nothing.
    #[default]
    None,
    /// A mass on a spring.
    One(Tissue),
    /// A mass on a spring, and a layer in parallel.
    Two(Tissue, Layer),
}

/// A tactor: a coil moves a contactor, in a housing that is held, against the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoiceCoil {
    /// Its coil.
    pub coil: Coil,
    /// What moves, kilograms, above 0.
    pub mass: f64,
    /// What holds it in the housing.
    pub suspension: Spring,
    /// What it pushes against.
    pub skin: Skin,
}

/// An inertial motor: a coil shakes a slug inside a casing that is free, or held by a hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// Its coil.
    pub coil: Coil,
    /// What is shaken, kilograms, above 0.
    pub slug_mass: f64,
    /// Everything else that moves as one: the casing and what is firmly mounted on it, kilograms, above 0.
    pub casing_mass: f64,
    /// What holds the slug in the casing.
    pub suspension: Spring,
    /// What holds the casing.
    pub hand: Tissue,
}

impl Inertial {
    /// The casing, kilograms, of a device that weighs so much with its slug.
    ///
    /// # Errors
    /// A device no heavier than its slug.
    pub fn casing_of(device_mass: f64, slug_mass: f64) -> Result<f64, Fault> {
        positive("slug_mass", slug_mass)?;
        let fault =
            Fault::because("device_mass", device_mass, Limit::Above(slug_mass), "the slug is part of it");
        if device_mass.is_finite() && device_mass > slug_mass {
            Ok(device_mass - slug_mass)
        } else {
            Err(fault)
        }
    }
}

impl Coil {
    pub(super) fn check(&self) -> Result<(), Fault> {
        positive("resistance", self.resistance)?;
        not_negative("inductance", self.inductance)?;
        positive("force_factor", self.force_factor)
    }
}

impl Spring {
    fn check(&self, fields: [&'static str; 2]) -> Result<(), Fault> {
        not_negative(fields[0], self.stiffness)?;
        not_negative(fields[1], self.damping)
    }
}

impl Tissue {
    fn check(&self, fields: [&'static str; 3]) -> Result<(), Fault> {
        not_negative(fields[0], self.mass)?;
        self.spring.check([fields[1], fields[2]])
    }

    /// Whether it is nothing but mass.
    pub(super) fn is_free(&self) -> bool {
        self.spring == Spring::default()
    }
}

impl VoiceCoil {
    pub(super) fn check(&self) -> Result<(), Fault> {
        self.coil.check()?;
        positive("mass", self.mass)?;
        self.suspension.check(["stiffness", "damping"])?;
        match &self.skin {
            Skin::None => Ok(()),
            Skin::One(tissue) => tissue.check(["skin.mass", "skin.stiffness", "skin.damping"]),
            Skin::Two(tissue, layer) => {
                tissue.check(["skin.mass", "skin.stiffness", "skin.damping"])?;
                positive("layer.mass", layer.mass)?;
                layer.coupling.check(["layer.stiffness", "layer.damping"])?;
                layer.anchor.check(["layer.anchor_stiffness", "layer.anchor_damping"])
            }
        }
    }
}

impl Inertial {
    pub(super) fn check(&self) -> Result<(), Fault> {
        self.coil.check()?;
        positive("slug_mass", self.slug_mass)?;
        positive("casing_mass", self.casing_mass)?;
        self.suspension.check(["stiffness", "damping"])?;
        self.hand.check(["hand.mass", "hand.stiffness", "hand.damping"])
    }
}

#[cfg(test)]
pub(in crate::actuator) mod tests {
    use super::{Coil, Inertial, Layer, Skin, Spring, Tissue, VoiceCoil};
    use crate::actuator::coil::plant::Plant;

    /// The tactor of the reference data.
    pub fn tactor() -> VoiceCoil {
        VoiceCoil {
            coil: Coil { resistance: 7.0, inductance: 2.5e-4, force_factor: 1.2 },
            mass: 1.5e-3,
            suspension: Spring { stiffness: 3132.7, damping: 0.6 },
            skin: Skin::One(Tissue { mass: 1e-4, spring: Spring { stiffness: 1200.0, damping: 1.5 } }),
        }
    }

    /// The same with a layer below the skin.
    pub fn layered() -> VoiceCoil {
        let layer = Layer {
            mass: 4e-4,
            coupling: Spring { stiffness: 700.0, damping: 0.4 },
            anchor: Spring { stiffness: 300.0, damping: 0.9 },
        };
        let Skin::One(tissue) = tactor().skin else { unreachable!() };
        VoiceCoil { skin: Skin::Two(tissue, layer), ..tactor() }
    }

    /// The inertial motor of the reference data.
    pub fn inertial() -> Inertial {
        Inertial {
            coil: Coil { resistance: 6.0, inductance: 2e-4, force_factor: 1.5 },
            slug_mass: 5.5e-3,
            casing_mass: 0.10,
            suspension: Spring { stiffness: 741.0, damping: 0.983 },
            hand: Tissue::default(),
        }
    }

    /// The same in a hand.
    pub fn held() -> Inertial {
        let hand = Tissue { mass: 0.05, spring: Spring { stiffness: 900.0, damping: 4.0 } };
        Inertial { hand, ..inertial() }
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        let tactor_fault = |change: fn(&mut VoiceCoil)| {
            let mut v = layered();
            change(&mut v);
            Plant::voice_coil(&v).unwrap_err().field
        };
        assert_eq!(tactor_fault(|v| v.coil.resistance = 0.0), "resistance");
        assert_eq!(tactor_fault(|v| v.coil.inductance = -1e-9), "inductance");
        assert_eq!(tactor_fault(|v| v.coil.force_factor = f64::NAN), "force_factor");
        assert_eq!(tactor_fault(|v| v.mass = 0.0), "mass");
        assert_eq!(tactor_fault(|v| v.suspension.stiffness = -1.0), "stiffness");
        assert_eq!(tactor_fault(|v| v.suspension.damping = f64::INFINITY), "damping");
        assert_eq!(
            tactor_fault(|v| if let Skin::Two(tissue, _) = &mut v.skin {
                tissue.mass = -1.0;
            }),
            "skin.mass"
        );
        assert_eq!(
            tactor_fault(|v| if let Skin::Two(_, layer) = &mut v.skin {
                layer.mass = 0.0;
            }),
            "layer.mass"
        );
        let inertial_fault = |change: fn(&mut Inertial)| {
            let mut m = inertial();
            change(&mut m);
            Plant::inertial(&m).unwrap_err().field
        };
        assert_eq!(inertial_fault(|m| m.slug_mass = -1.0), "slug_mass");
        assert_eq!(inertial_fault(|m| m.casing_mass = 0.0), "casing_mass");
        assert_eq!(inertial_fault(|m| m.hand.spring.damping = -0.1), "hand.damping");
    }

    #[test]
    fn a_device_is_heavier_than_its_slug() {
        assert_eq!(Inertial::casing_of(8e-3, 2e-3), Ok(6e-3));
        for (device, slug) in [(2e-3, 2e-3), (1e-3, 2e-3), (f64::NAN, 2e-3)] {
            let fault = Inertial::casing_of(device, slug).unwrap_err();
            assert_eq!(fault.field, "device_mass");
            let text = fault.to_string();
            assert!(text.contains("above 0.002") && text.ends_with(": the slug is part of it"), "{fault}");
        }
        assert_eq!(Inertial::casing_of(1.0, 0.0).unwrap_err().field, "slug_mass");
    }
}
