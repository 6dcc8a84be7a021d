//! A spring that pushes and never pulls.

use crate::actuator::coil::parameters::Spring;

/// A spring that only pushes.
#[derive(Debug, Clone, Copy)]
pub(super) struct OneSided {
    /// +1 where it is met upwards, −1 downwards.
    pub side: f64,
    /// Where it is met.
    pub origin: f64,
    pub stiffness: f64,
    /// Damping over stiffness, seconds.
    pub relaxation: f64,
}

impl OneSided {
    pub fn new(side: f64, origin: f64, spring: Spring) -> Self {
        Self { side, origin, stiffness: spring.stiffness, relaxation: spring.damping / spring.stiffness }
    }

    #[inline(always)]
    pub fn depth(&self, y: f64) -> f64 {
        self.side * (y - self.origin)
    }

    /// Above 0 where it pushes: the depth, and where it is left faster than it follows, the force over the stiffness.
    #[inline(always)]
    pub fn guard(&self, y: f64, velocity: f64) -> f64 {
        let along = self.side * velocity;
        self.depth(y) + self.relaxation * if along < 0.0 { along } else { 0.0 }
    }
}
