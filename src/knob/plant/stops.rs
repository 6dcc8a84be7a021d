//! The end stops of a knob: a stiff spring with a damper, that pushes and never pulls.

use crate::actuator::fault::{Fault, Limit, within};

/// Where a knob ends. Beyond a stop by p > 0 it pushes back with K p + D ṗ where that is above 0 and with nothing where it is not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stops {
    /// Lower end, rad, within ±1e6; −∞: none.
    pub low: f64,
    /// Upper end, rad, above the lower one; ∞: none.
    pub high: f64,
    /// K, 1e-6 to 1e9 N m/rad. A stiffness in N/m at a rim of radius r is that times r².
    pub stiffness: f64,
    /// D, 0 to 1e6 N m s/rad (Kelvin and Voigt).
    pub damping: f64,
}

impl Stops {
    /// One stop above, one below, or both, of a damping ratio ζ for an inertia (kg m²): D = 2 ζ √(K J).
    pub fn of_ratio(low: f64, high: f64, stiffness: f64, ratio: f64, inertia: f64) -> Self {
        Self { low, high, stiffness, damping: 2.0 * ratio * (stiffness * inertia).sqrt() }
    }

    /// Whether such stops can be.
    ///
    /// # Errors
    /// The first field beyond its limits; an upper end that is not above the lower one.
    pub fn check(&self) -> Result<(), Fault> {
        if self.low != f64::NEG_INFINITY {
            within("stop low", self.low, (-1e6, 1e6), "rad, or -inf for none")?;
        }
        if self.high != f64::INFINITY {
            within("stop high", self.high, (-1e6, 1e6), "rad, or inf for none")?;
        }
        if self.high <= self.low {
            let limit = Limit::Above(self.low);
            return Err(Fault::because("stop high", self.high, limit, "it has to be above the lower stop"));
        }
        within("stop stiffness", self.stiffness, (1e-6, 1e9), "N m/rad")?;
        within("stop damping", self.damping, (0.0, 1e6), "N m s/rad")
    }
}
