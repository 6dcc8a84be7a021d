//! How warm the winding of a knob's motor and its housing are.

use crate::actuator::fault::{Fault, Limit, check, positive};
use crate::actuator::thermal::{Cooling, Thermal};

/// Mean square of the current, gathered over steps, and what it warms: [`Thermal`] is exact for a mean square that stands still over its step.
#[derive(Debug, Clone)]
pub struct Heat {
    thermal: Thermal,
    sum: f64,
    steps: u32,
    every: u32,
    period: f64,
}

impl Heat {
    /// Of a winding, for steps of `period` seconds; temperatures move every `every` steps, 1 or more: what is faster than that is averaged.
    ///
    /// # Errors
    /// A figure of the cooling that cannot be; a period that is not above 0; 0 steps.
    pub fn new(cooling: &Cooling, period: f64, every: u32) -> Result<Self, Fault> {
        positive("period", period)?;
        check("every", f64::from(every), Limit::Least(1.0))?;
        Ok(Self { thermal: Thermal::new(cooling)?, sum: 0.0, steps: 0, every, period })
    }

    /// A step in which the current (A) went from one value to another, in a straight line: whether temperatures moved with it. What is no number
    /// warms nothing.
    #[inline]
    pub fn pass(&mut self, from: f64, to: f64) -> bool {
        let square = (from * from + from * to + to * to) / 3.0;
        self.sum += if square.is_finite() { square } else { 0.0 };
        self.steps += 1;
        if self.steps >= self.every {
            let count = f64::from(self.steps);
            self.thermal.step(self.sum / count, count * self.period);
            (self.sum, self.steps) = (0.0, 0);
        }
        self.steps == 0
    }

    /// Temperatures, and what is left of what the winding bears.
    pub fn thermal(&self) -> &Thermal {
        &self.thermal
    }
}

#[cfg(test)]
mod tests {
    use super::{Cooling, Heat, Thermal};
    use crate::actuator::thermal::RE25;

    #[test]
    fn a_held_current_warms_as_the_exact_step_says() {
        let mut heat = Heat::new(&RE25, 1e-3, 10).unwrap();
        let mut thermal = Thermal::new(&RE25).unwrap();
        let moved = (0..60_000).filter(|_| heat.pass(1.4, 1.4)).count();
        assert_eq!(moved, 6_000);
        thermal.step(1.96, 60.0);
        assert!((heat.thermal().winding() / thermal.winding() - 1.0).abs() < 1e-11);
        assert!((heat.thermal().housing() / thermal.housing() - 1.0).abs() < 1e-11);
    }

    #[test]
    fn a_ramp_warms_by_its_mean_square_and_nonsense_by_nothing() {
        let mut heat = Heat::new(&RE25, 0.5, 1).unwrap();
        let mut thermal = Thermal::new(&RE25).unwrap();
        heat.pass(0.0, 3.0);
        thermal.step(3.0, 0.5);
        assert!((heat.thermal().winding() - thermal.winding()).abs() < 1e-15);
        heat.pass(f64::NAN, 1e300);
        assert!(heat.thermal().winding() < thermal.winding() && heat.thermal().winding() > 0.0);
        assert!(Heat::new(&RE25, 0.0, 1).is_err() && Heat::new(&RE25, 1.0, 0).is_err());
        assert!(Heat::new(&Cooling { most: 0.0, ..RE25 }, 1.0, 1).is_err());
    }
}
