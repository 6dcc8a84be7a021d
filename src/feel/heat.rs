//! How warm a winding becomes by the current in it.

use crate::actuator::fault::Fault;
use crate::actuator::thermal::{Cooling, Thermal};

/// Seconds over which the mean square of the current is taken as steady.
const TICK: f64 = 0.01;

/// A winding, where its cooling is known.
#[derive(Debug, Clone)]
pub(super) struct Heat {
    thermal: Option<Thermal>,
    period: f64,
    /// Samples of a tick; those since the last, and their sum of squares.
    tick: u32,
    count: u32,
    sum: f64,
    warmest: f64,
}

impl Heat {
    /// As cold as the air, a sample every `period` seconds.
    ///
    /// # Errors
    /// A figure of the cooling that cannot be.
    pub fn new(cooling: Option<&Cooling>, period: f64) -> Result<Self, Fault> {
        let thermal = cooling.map(Thermal::new).transpose()?;
        let tick = (TICK / period).ceil().clamp(1.0, 1e9) as u32;
        Ok(Self { thermal, period, tick, count: 0, sum: 0.0, warmest: 0.0 })
    }

    /// A sample with a mean current, A.
    #[inline]
    pub fn take(&mut self, amperes: f64) {
        self.take_square(amperes * amperes);
    }

    /// A sample with a mean square of the current, A².
    #[inline]
    pub fn take_square(&mut self, square: f64) {
        let Some(thermal) = &mut self.thermal else { return };
        self.sum += square;
        self.count += 1;
        if self.count == self.tick {
            thermal.step(self.sum / f64::from(self.tick), f64::from(self.tick) * self.period);
            self.warmest = self.warmest.max(thermal.winding());
            (self.count, self.sum) = (0, 0.0);
        }
    }

    /// The warmest so far, K above the air; `None` where the cooling is not known.
    pub fn warmest(&self) -> Option<f64> {
        let mut rest = self.thermal?;
        if self.count > 0 {
            rest.step(self.sum / f64::from(self.count), f64::from(self.count) * self.period);
        }
        Some(self.warmest.max(rest.winding()))
    }
}

#[cfg(test)]
mod tests {
    use super::Heat;
    use crate::actuator::thermal::{Cooling, Steady, Thermal};

    #[test]
    fn a_steady_current_warms_as_the_model_says_wherever_it_ends() {
        let cooling = Cooling {
            resistance: 10.0,
            rise: 0.0039,
            to_housing: 40.0,
            to_air: 60.0,
            winding_time: 2.0,
            housing_time: 60.0,
            most: 60.0,
        };
        for samples in [1, 7, 80, 8000, 8003] {
            let mut heat = Heat::new(Some(&cooling), 1.0 / 8000.0).unwrap();
            (0..samples).for_each(|_| heat.take(0.2));
            let mut due = Thermal::new(&cooling).unwrap();
            due.step(0.04, f64::from(samples) / 8000.0);
            let warmest = heat.warmest().unwrap();
            assert!((warmest / due.winding() - 1.0).abs() < 1e-9, "{samples}: {warmest} {}", due.winding());
        }
        // Alternating, it warms by the mean square; and what was warm once is told when it is cold again.
        let mut heat = Heat::new(Some(&cooling), 1.0 / 8000.0).unwrap();
        (0..8_000_000).for_each(|n| heat.take(if n % 2 == 0 { 0.3 } else { -0.1 }));
        let Steady::Rise(rise) = cooling.steady(0.05) else { panic!("no runaway") };
        assert!((heat.warmest().unwrap() / rise - 1.0).abs() < 1e-3, "{:?} {rise}", heat.warmest());
        let before = heat.warmest();
        (0..80_000).for_each(|_| heat.take(0.0));
        assert_eq!(heat.warmest(), before);
        assert_eq!(Heat::new(None, 1e-4).unwrap().warmest(), None);
    }
}
