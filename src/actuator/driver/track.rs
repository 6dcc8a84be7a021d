//! Envelopes that are known as a whole before they are played, made into speeds that the motor can follow.
//!
//! Forward, no speed rises faster than the motor can; backward, none falls faster than it can be braked, so that a brake begins in time whatever the
//! latency. That is done for some strengths beforehand. What lies between is interpolated: what a motor can do to its speed is bounded by straight
//! lines, so what lies between two speeds that it can follow it can follow too.

use super::ahead::Rates;
use super::setup::Setup;
use crate::actuator::fault::{Fault, within};

/// The longest envelope, s.
pub const LONGEST: f64 = 10.0;

/// Strengths for which plans are made.
const ROWS: usize = 8;

/// An envelope of a motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// The speeds that were wished at every sample, rad/s, the last of them 0; and those that can be followed, by the root of the level.
    wished: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Track {
    /// Of an envelope of so many seconds: the level (see [`Setup::speed_of`]) at every instant.
    ///
    /// # Errors
    /// A motor that cannot be; an envelope of more than [`LONGEST`], or of no time at all.
    pub fn new(setup: &Setup, seconds: f64, level: impl Fn(f64) -> f64) -> Result<Self, Fault> {
        setup.check()?;
        within("seconds", seconds, (1e-4, LONGEST), "s")?;
        let rates = Rates::new(setup);
        let samples = (seconds * setup.rate).ceil() as usize;
        let speed = |n: usize| {
            let speed = setup.speed_of(level(n as f64 / setup.rate));
            if setup.one_way { speed.max(0.0) } else { speed }
        };
        let mut wished: Vec<f64> = (0..samples).map(speed).collect();
        wished.push(0.0);
        let row = |n: usize| {
            let root = (n + 1) as f64 / ROWS as f64;
            let mut row: Vec<f64> = wished.iter().map(|speed| root * speed).collect();
            rates.make_feasible(&mut row, setup.one_way);
            row
        };
        let rows = (0..ROWS).map(row).collect();
        Ok(Self { wished, rows })
    }

    /// Samples that it lasts.
    pub fn samples(&self) -> usize {
        self.wished.len() - 1
    }

    /// The speed that was wished so many samples after its beginning, at the root of a level (-1 to 1).
    pub fn wished(&self, samples: f64, root: f64) -> f64 {
        root * between(&self.wished, samples)
    }

    /// The speed there that can be followed.
    pub fn planned(&self, samples: f64, root: f64) -> f64 {
        let at = root.abs().min(1.0) * ROWS as f64;
        let below = (at.floor() as usize).min(ROWS - 1);
        let low = below.checked_sub(1).map_or(0.0, |row| between(&self.rows[row], samples));
        let high = between(&self.rows[below], samples);
        (low + (at - below as f64) * (high - low)) * root.signum()
    }

    /// Of the strongest: the share of the largest vibration that is reached, and the share of all speeds that is missed.
    pub fn reach(&self) -> [f64; 2] {
        let planned = self.rows.last().map_or(&self.wished, |row| row);
        let most = |row: &[f64]| row.iter().fold(0.0_f64, |most, speed| most.max(speed.abs()));
        let sum = |row: &[f64]| row.iter().map(|speed| speed.abs()).sum::<f64>();
        if most(&self.wished) == 0.0 {
            return [1.0, 0.0];
        }
        let differs: f64 = self.wished.iter().zip(planned).map(|(wish, plan)| (wish - plan).abs()).sum();
        [(most(planned) / most(&self.wished)).powi(2), differs / sum(&self.wished)]
    }
}

/// What lies between two samples.
fn between(row: &[f64], at: f64) -> f64 {
    let at = at.max(0.0);
    let n = at as usize;
    let of = |n: usize| row.get(n).copied().unwrap_or(0.0);
    of(n) + (at - n as f64) * (of(n + 1) - of(n))
}
