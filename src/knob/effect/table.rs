//! Torque over angle, point by point.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, Limit, check};

/// Straight lines between points; beyond the ends the torque of the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    angles: Box<[f64]>,
    torques: Box<[f64]>,
    slopes: Box<[f64]>,
    /// Potential energy at the points, 0 at the first.
    energies: Box<[f64]>,
}

/// Points of a table, at most.
pub const MOST_POINTS: usize = 65_536;

impl Table {
    /// Of points (radians, N m), angles rising.
    ///
    /// # Errors
    /// `points`: fewer than two or more than [`MOST_POINTS`]; `angle`: not above the one before; `torque`: not a number.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, Fault> {
        check("points", points.len() as f64, Limit::Within(2.0, MOST_POINTS as f64, "points"))?;
        for (k, point) in points.iter().enumerate() {
            let limit = if k == 0 { Limit::Least(f64::MIN) } else { Limit::Above(points[k - 1].0) };
            check("angle", point.0, limit)?;
            check("torque", point.1, Limit::Least(f64::MIN))?;
        }
        let slope = |p: &[(f64, f64)]| (p[1].1 - p[0].1) / (p[1].0 - p[0].0);
        let mut energies = vec![0.0];
        for p in points.windows(2) {
            energies.push(energies[energies.len() - 1] - 0.5 * (p[0].1 + p[1].1) * (p[1].0 - p[0].0));
        }
        Ok(Self {
            angles: points.iter().map(|p| p.0).collect(),
            torques: points.iter().map(|p| p.1).collect(),
            slopes: points.windows(2).map(slope).collect(),
            energies: energies.into(),
        })
    }

    /// The line under an angle: its number, and the angle within the table.
    #[inline(always)]
    fn line(&self, angle: f64) -> (usize, f64) {
        let n = self.angles.len();
        let within = f64::min(f64::max(angle, self.angles[0]), self.angles[n - 1]);
        (self.angles[1..n - 1].partition_point(|a| *a <= within), within)
    }
}

impl Effect for Table {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        Ok(())
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.slopes.iter().fold(0.0, |most, s| f64::max(most, s.abs())), damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        let (k, within) = self.line(r.angle);
        m.gain * m.stiffness * (self.torques[k] + self.slopes[k] * (within - self.angles[k]))
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let (k, within) = self.line(angle);
        let along = within - self.angles[k];
        let torque = self.torques[k] + self.slopes[k] * along;
        Some(
            self.energies[k]
                - (self.torques[k] + 0.5 * self.slopes[k] * along) * along
                - torque * (angle - within),
        )
    }
}
