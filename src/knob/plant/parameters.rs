//! What a knob is made of.

use super::stops::Stops;
use crate::actuator::fault::{Fault, within};

/// Torques beyond this, N m, are no torques.
pub const MOST_TORQUE: f64 = 1e12;

/// The numbers of a knob of one inertia: J θ̈ = τ − b ω − T_c sgn ω, set-valued, held at rest by up to T_s.
///
/// [`Parameters::check`] says what is wrong with them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// All that turns on the motor's side of the shaft, J: 1e-12 to 1e3 kg m².
    pub inertia: f64,
    /// Viscous friction b, 0 to 1e3 N m s/rad. Of a motor that a current drives this is the bearing's alone: the damping of a
    /// shorted one is not there.
    pub viscous: f64,
    /// Friction while it turns, T_c: 0 to 1e3 N m.
    pub coulomb: f64,
    /// Friction that holds it at rest, T_s: T_c to 1e3 N m. With 0 there is no dry friction at all.
    pub stiction: f64,
    /// End stops, if there are any.
    pub stops: Option<Stops>,
}

impl Default for Parameters {
    /// A small knob: 6e-6 kg m², 2e-5 N m s/rad, no dry friction, no stops.
    fn default() -> Self {
        Self { inertia: 6e-6, viscous: 2e-5, coulomb: 0.0, stiction: 0.0, stops: None }
    }
}

impl Parameters {
    /// Whether such a knob can be.
    ///
    /// # Errors
    /// The first field that is beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        within("inertia", self.inertia, (1e-12, 1e3), "kg m2")?;
        within("viscous", self.viscous, (0.0, 1e3), "N m s/rad")?;
        within("coulomb", self.coulomb, (0.0, 1e3), "N m")?;
        within("stiction", self.stiction, (self.coulomb, 1e3), "N m: no less than holds it while it turns")?;
        self.stops.map_or(Ok(()), |stops| stops.check())
    }
}
