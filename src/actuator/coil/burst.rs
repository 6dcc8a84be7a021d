//! Overdrive and braking of a resonant actuator.
//!
//! Driven at its resonance, its amplitude follows the drive's with τ = 2 Q / ω. With g times the rated voltage it is at the rated
//! amplitude after τ ln(g / (g − 1)); g times that voltage in the opposite phase takes it to rest in τ ln(1 + 1/g). Both are of the slow
//! envelope and leave about (1 + g) / 2Q of the rated amplitude; [`Burst::settle`] takes the exact motion to rest.

use super::plant::{Plant, Touch};
use super::resonance::Resonance;
use crate::actuator::drive::Drive;
use crate::actuator::exponential::exponential;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// A burst of vibration: overdriven, held, braked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Burst {
    /// What it is played on.
    pub resonance: Resonance,
    /// Drive at the rated amplitude, peak: volts or amperes.
    pub rated: f64,
    /// The most there may be, peak.
    pub most: f64,
    /// Seconds until the brake.
    pub length: f64,
    /// Seconds of overdrive at the beginning, no more than `length`.
    pub rise: f64,
    /// Seconds of braking after the length.
    pub brake: f64,
    /// By how much the brake's phase is ahead of the opposite phase, radians.
    pub lead: f64,
}

/// What is left of a motion, as a share of the rated amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// Displacement and velocity over ω, together.
    pub amplitude: f64,
    /// The two apart, each over the rated amplitude.
    pub parts: [f64; 2],
}

/// Newton steps, at most, and the change for a difference quotient.
const STEPS: usize = 40;
const DIFFERENCE: f64 = 1e-6;

impl Burst {
    /// A burst of `length` seconds, with as much overdrive and brake as there is voltage for.
    ///
    /// # Errors
    /// A figure that cannot be; a rated drive above the most there may be.
    pub fn new(resonance: Resonance, rated: f64, most: f64, length: f64) -> Result<Self, Fault> {
        positive("resonance", resonance.hertz)?;
        // Below that there is nothing to swing.
        check("q", resonance.q, Limit::Above(0.5))?;
        positive("rated", rated)?;
        check("length", length, Limit::Least(0.0))?;
        if !(most.is_finite() && most >= rated) {
            return Err(Fault::because(
                "most",
                most,
                Limit::Least(rated),
                "the rated drive is to be within the limit",
            ));
        }
        let gain = most / rated;
        let decay = resonance.decay();
        // With no more than the rated drive there is no overdrive, and all the length is spent on the way.
        let rise = if gain > 1.0 { decay * (gain / (gain - 1.0)).ln() } else { 0.0 };
        let mut new = Self { resonance, rated, most, length, rise: rise.min(length), brake: 0.0, lead: 0.0 };
        new.brake = decay * (new.reached() / gain).ln_1p();
        Ok(new)
    }

    /// Amplitude as a share of the rated one, by the slow envelope, at a time of the burst (seconds).
    pub fn envelope(&self, time: f64) -> f64 {
        let (gain, decay) = (self.most / self.rated, self.resonance.decay());
        let towards = |from: f64, to: f64, time: f64| to + (from - to) * (-time / decay).exp();
        let risen = towards(0.0, gain, time.clamp(0.0, self.rise));
        let held = towards(risen, 1.0, (time.min(self.length) - self.rise).max(0.0));
        let braked = towards(held, -gain, (time - self.length).clamp(0.0, self.brake));
        towards(braked, 0.0, (time - self.length - self.brake).max(0.0))
    }

    /// Amplitude at the end of its length.
    fn reached(&self) -> f64 {
        Self { brake: 0.0, ..*self }.envelope(self.length)
    }

    /// Drive at a time (seconds), volts or amperes.
    pub fn drive(&self, time: f64) -> f64 {
        let turn = self.resonance.omega() * time;
        if !(time >= 0.0 && time < self.length + self.brake) {
            0.0
        } else if time < self.rise {
            self.most * turn.sin()
        } else if time < self.length {
            self.rated * turn.sin()
        } else {
            -self.most * (turn + self.lead).sin()
        }
    }

    /// The same as samples, each the mean over its time: `rate` a second.
    pub fn samples(&self, rate: f64) -> Vec<f64> {
        let count = ((self.length + self.brake) * rate).ceil();
        (0..count as usize).map(|n| self.mean(n as f64 / rate, (n as f64 + 1.0) / rate)).collect()
    }

    /// Mean of the drive over a time.
    fn mean(&self, from: f64, to: f64) -> f64 {
        let omega = self.resonance.omega();
        let integral = |a: f64, b: f64, amplitude: f64, lead: f64| {
            let (a, b) = (a.max(from), b.min(to));
            if b > a {
                amplitude * ((omega * a + lead).cos() - (omega * b + lead).cos()) / omega
            } else {
                0.0
            }
        };
        let end = self.length;
        let sum = integral(0.0, self.rise, self.most, 0.0)
            + integral(self.rise, end, self.rated, 0.0)
            + integral(end, end + self.brake, -self.most, self.lead);
        sum / (to - from)
    }

    /// Exactly what is left when the brake ends, on an actuator that rested before.
    pub fn rest(&self, plant: &Plant, drive: Drive) -> Rest {
        let system = plant.system(drive, &Touch::default());
        let (n, omega) = (system.size, self.resonance.omega());
        // The drive is a state of its own: it turns.
        let mut a = system.matrix;
        a[n][n + 1] = omega;
        a[n + 1][n] = -omega;
        a.iter_mut().take(n).for_each(|row| row[n + 1] = 0.0);
        let mut x = [0.0; crate::actuator::exponential::MOST];
        let segments = [
            (0.0, self.rise, self.most, 0.0),
            (self.rise, self.length - self.rise, self.rated, 0.0),
            (self.length, self.brake, -self.most, self.lead),
        ];
        for (begin, time, amplitude, lead) in segments {
            let (sin, cos) = (omega * begin + lead).sin_cos();
            (x[n], x[n + 1]) = (amplitude * sin, amplitude * cos);
            let d = exponential(&a, n + 2, time);
            let before = x;
            for i in 0..n {
                x[i] += (0..n + 2).map(|j| d[i][j] * before[j]).sum::<f64>();
            }
        }
        let at = |p: &Plant| match drive {
            Drive::Voltage => p.per_volt(self.resonance.hertz),
            Drive::Current => p.per_ampere(self.resonance.hertz),
        };
        let rated = at(plant).displacement.abs() * self.rated;
        let parts = [x[0] / rated, x[1] / (omega * rated)];
        Rest { amplitude: parts[0].hypot(parts[1]), parts }
    }

    /// Changes the brake's length and phase, little, until it takes the exact motion to rest; if it cannot, nothing is changed.
    /// Returns what is left.
    pub fn settle(&mut self, plant: &Plant, drive: Drive) -> Rest {
        let unit = 1.0 / self.resonance.omega();
        let mut best = (*self, self.rest(plant, drive));
        let mut now = best;
        for _ in 0..STEPS {
            let shifted = |brake: f64, lead: f64| {
                Self { brake: now.0.brake + brake * unit, lead: now.0.lead + lead, ..now.0 }
                    .rest(plant, drive)
                    .parts
            };
            let (p, by_brake, by_lead) = (now.1.parts, shifted(DIFFERENCE, 0.0), shifted(0.0, DIFFERENCE));
            let slope = |of: [f64; 2]| [(of[0] - p[0]) / DIFFERENCE, (of[1] - p[1]) / DIFFERENCE];
            let (u, v) = (slope(by_brake), slope(by_lead));
            let determinant = u[0] * v[1] - u[1] * v[0];
            let brake = (p[1] * v[0] - p[0] * v[1]) / determinant;
            let lead = (p[0] * u[1] - p[1] * u[0]) / determinant;
            if !(brake.is_finite() && lead.is_finite()) {
                break;
            }
            // No more than a quarter of a turn at once.
            let step = |x: f64| x.clamp(-1.5, 1.5);
            let next = Self {
                brake: (now.0.brake + step(brake) * unit).max(0.0),
                lead: now.0.lead + step(lead),
                ..now.0
            };
            now = (next, next.rest(plant, drive));
            if now.1.amplitude < best.1.amplitude {
                best = now;
            } else if best.1.amplitude < 1e-12 {
                break;
            }
        }
        *self = best.0;
        best.1
    }
}

#[cfg(test)]
mod tests;
