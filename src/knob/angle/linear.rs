//! A voltage that grows with the angle: a potentiometer or a Hall sensor.

use crate::actuator::fault::{Fault, Limit, check, within};

/// How a voltage says an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Volts at a sample of 1.0, above 0.
    pub full_scale: f64,
    /// Below 0 where it falls; not 0.
    pub radians_per_volt: f64,
    /// Volts at the angle 0.
    pub zero: f64,
    /// Volts between which the sensor is whole: a wire that is off shows something else.
    pub whole: [f64; 2],
}

/// Volts into radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear {
    slope: Slope,
    lost: u64,
}

impl Linear {
    /// For a slope.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(slope: &Slope) -> Result<Self, Fault> {
        within("full_scale", slope.full_scale, (1e-6, 1e6), "V")?;
        within("radians_per_volt", slope.radians_per_volt, (-1e6, 1e6), "rad/V")?;
        if slope.radians_per_volt == 0.0 {
            let because = "then no voltage says an angle";
            return Err(Fault::because("radians_per_volt", 0.0, Limit::Above(0.0), because));
        }
        within("zero", slope.zero, (-1e6, 1e6), "V")?;
        within("whole", slope.whole[0], (-1e6, 1e6), "V")?;
        check("whole", slope.whole[1], Limit::Above(slope.whole[0]))?;
        Ok(Self { slope: *slope, lost: 0 })
    }

    /// Whether the sensor says an angle by this sample.
    #[inline]
    pub fn is_whole(&self, sample: f64) -> bool {
        (self.slope.whole[0]..=self.slope.whole[1]).contains(&(sample * self.slope.full_scale))
    }

    /// A sample; the angle, rad, `None` where it is lost: it is not a number, or beyond where the sensor is whole.
    #[inline]
    pub fn push(&mut self, sample: f64) -> Option<f64> {
        if !self.is_whole(sample) {
            self.lost += 1;
            return None;
        }
        Some((sample * self.slope.full_scale - self.slope.zero) * self.slope.radians_per_volt)
    }

    /// In how many frames it was lost.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}
