//! What a knob may have beside its one inertia: a shaft with the knob proper, a drive, a hand, torque over its angle.

use super::parameters::Parameters;
use super::wave::Wave;
use crate::actuator::fault::{Fault, within};

/// A shaft that gives way, and the knob at its end. The motor with its encoder is the inertia of [`Parameters`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// Of the knob, J_k: 1e-12 to 1e3 kg m².
    pub inertia: f64,
    /// Viscous friction of the knob against the housing, 0 to 1e3 N m s/rad.
    pub viscous: f64,
    /// k_s, 1e-9 to 1e9 N m/rad.
    pub stiffness: f64,
    /// c_s, 0 to 1e6 N m s/rad.
    pub damping: f64,
}

impl Shaft {
    /// k_s of a motor of inertia J_m (kg m²) whose shaft, clamped at the knob, has its resonance at `frequency` hertz: J_m (2π F_0)².
    pub fn stiffness_of(inertia: f64, frequency: f64) -> f64 {
        let w = std::f64::consts::TAU * frequency;
        inertia * w * w
    }
}

/// What makes the torque of a command.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Drive {
    /// It is there at once. The command is a torque, N m.
    #[default]
    Torque,
    /// A voltage at the winding, V, within ± the supply: L i̇ = V − R i − k ω.
    Voltage(Winding),
    /// A current loop. The command is a torque, N m, and its current is the torque over k, within ± the peak. The voltage is
    /// K_p (i* − i) + K_i q with K_p = L ω_i and K_i = R ω_i, so that the current of a held rotor follows as of first order with ω_i. Beyond
    /// ± the supply it stays there, and q is led back with the winding's time constant (back-calculation).
    Current {
        /// The winding and its supply.
        winding: Winding,
        /// ω_i, 1 to 1e7 rad/s.
        bandwidth: f64,
        /// I_pk, 1e-6 to 1e6 A.
        peak: f64,
    },
}

/// A winding and its supply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// R, 1e-6 to 1e6 ohms.
    pub resistance: f64,
    /// L, 1e-9 to 1e3 henries. For none take [`Drive::Torque`] and add k²/R to the viscous friction.
    pub inductance: f64,
    /// k, 1e-9 to 1e3 N m/A, which is V s/rad.
    pub gain: f64,
    /// V_bus, 1e-6 to 1e6 V.
    pub supply: f64,
}

/// How a hand holds the knob: a spring and a damper to a point that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grasp {
    /// 0 to 1e6 N m/rad.
    pub stiffness: f64,
    /// 0 to 1e3 N m s/rad.
    pub damping: f64,
}

/// What a hand does over a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hand {
    /// A torque on the knob, N m, held over the step.
    pub torque: f64,
    /// Where the point that it holds by is at the step's beginning, rad, and at what speed that goes on, rad/s.
    pub target: f64,
    /// Speed of that point, rad/s.
    pub target_speed: f64,
}

/// All that a knob may have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Build {
    /// The inertia on the motor's side, its friction, and stops. Where there is a shaft the stops act on the knob at its end.
    pub parameters: Parameters,
    /// A second inertia.
    pub shaft: Option<Shaft>,
    /// What makes the torque.
    pub drive: Drive,
    /// A hand that grasps the knob.
    pub grasp: Option<Grasp>,
    /// Torque over the motor's angle, N m: cogging, or a detent that acts continuously.
    pub cogging: Wave,
    /// By what share k is larger than it is on the mean, over the motor's angle: of torque, and of the voltage of the speed likewise.
    pub ripple: Wave,
}

impl Build {
    /// Whether such a knob can be.
    ///
    /// # Errors
    /// The first field beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        self.parameters.check()?;
        if let Some(shaft) = &self.shaft {
            within("shaft inertia", shaft.inertia, (1e-12, 1e3), "kg m2")?;
            within("shaft viscous", shaft.viscous, (0.0, 1e3), "N m s/rad")?;
            within("shaft stiffness", shaft.stiffness, (1e-9, 1e9), "N m/rad")?;
            within("shaft damping", shaft.damping, (0.0, 1e6), "N m s/rad")?;
        }
        if let Some(winding) = self.winding() {
            within("resistance", winding.resistance, (1e-6, 1e6), "ohms")?;
            within("inductance", winding.inductance, (1e-9, 1e3), "henries")?;
            within("gain", winding.gain, (1e-9, 1e3), "N m/A")?;
            within("supply", winding.supply, (1e-6, 1e6), "V")?;
        }
        if let Drive::Current { bandwidth, peak, .. } = self.drive {
            within("bandwidth", bandwidth, (1.0, 1e7), "rad/s")?;
            within("peak", peak, (1e-6, 1e6), "A")?;
        }
        if let Some(grasp) = &self.grasp {
            within("grasp stiffness", grasp.stiffness, (0.0, 1e6), "N m/rad")?;
            within("grasp damping", grasp.damping, (0.0, 1e3), "N m s/rad")?;
        }
        Ok(())
    }

    /// The winding, where there is one.
    pub fn winding(&self) -> Option<Winding> {
        match self.drive {
            Drive::Torque => None,
            Drive::Voltage(winding) | Drive::Current { winding, .. } => Some(winding),
        }
    }

    /// Whether one inertia and a torque are all.
    pub fn is_plain(&self) -> bool {
        self.shaft.is_none()
            && self.drive == Drive::Torque
            && self.grasp.is_none()
            && self.cogging.is_flat()
            && self.ripple.is_flat()
    }
}
