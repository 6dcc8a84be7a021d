//! Error against run time of velocity estimators: on a swing whose speed is known, through an encoder that rounds down.
//!
//! What an estimate misses is told three ways. `rms` is all of it ([`velocity::error`](crate::knob::velocity::error)). The rest parts it:
//! the estimate's own share of the swing's frequency (least squares) comes later than the speed by `lag` and is `gain` times as large; what
//! is left beside that share is `noise`.
//!
//! ```
//! use pacinian::report::knob::estimators::{Wish, estimators};
//!
//! let wish = Wish { rates: vec![1000.0], seconds: 0.5, ..Wish::default() };
//! let all = estimators(&wish)?;
//! let of = |name: &str| all.iter().find(|e| e.method == name).expect("one of them");
//! // A difference is late by half a tick and noisy; a low-pass is the other way round.
//! assert!(of("difference").lag < 1e-3 && of("low-pass 100 Hz").lag > 1e-3);
//! assert!(of("difference").noise > 3.0 * of("low-pass 100 Hz").noise);
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

#[cfg(test)]
mod tests;
mod written;

use std::f64::consts::TAU;
use std::hint::black_box;

use crate::actuator::fault::{Fault, within};
use crate::knob::velocity::Estimator;
use crate::knob::velocity::adaptive::{Adaptive, Fit};
use crate::knob::velocity::decimated::Decimated;
use crate::knob::velocity::difference::Difference;
use crate::knob::velocity::edges::Edges;
use crate::knob::velocity::error::{Motion, measure};
use crate::knob::velocity::filtered::Filtered;
use crate::knob::velocity::kalman::Kalman;
use crate::report::cost::clock::nanoseconds;
pub use written::{What, csv, picture, text};

/// Rates that errors are told at, Hz.
pub const RATES: [f64; 6] = [1e3, 4e3, 8e3, 16e3, 48e3, 192e3];
/// The longest window, seconds, and ticks at least.
const WINDOW: f64 = 5.3e-3;
const FEWEST: f64 = 16.0;
/// What a decimated estimator runs at about, Hz.
const SLOW: f64 = 4e3;
/// Without an edge for so long the knob stands, s.
const STANDS: f64 = 0.1;
/// Readings that a timed run has at most.
const TIMED: usize = 4096;

/// A swing: its peak speed (rad/s) and its frequency (hertz).
pub type Swing = (f64, f64);

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// On these swings; peak 1e-3 to 1e3 rad/s, 0.1 to 1000 Hz.
    pub swings: Vec<Swing>,
    /// With an encoder of so many counts a turn, 1 to 1e9.
    pub counts: f64,
    /// At these rates, 200 to 1e6 readings a second.
    pub rates: Vec<f64>,
    /// For so long, to whole swings: 0.01 to 100 s.
    pub seconds: f64,
}

impl Default for Wish {
    /// Slow, usual and fast turning by 4,000 counts at all [`RATES`]: some seconds.
    fn default() -> Self {
        Self {
            swings: vec![(0.5, 1.0), (5.0, 2.0), (20.0, 10.0)],
            counts: 4000.0,
            rates: RATES.to_vec(),
            seconds: 2.0,
        }
    }
}

/// What came of an estimator on a swing at a rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Its name.
    pub method: &'static str,
    /// Readings a second.
    pub rate: f64,
    /// Counts a turn.
    pub counts: f64,
    /// The swing.
    pub swing: Swing,
    /// Root mean square of what it misses, rad/s.
    pub rms: f64,
    /// The most that it misses, rad/s.
    pub worst: f64,
    /// How late it is, s.
    pub lag: f64,
    /// How large its swing is, as a share of the true one.
    pub gain: f64,
    /// Root mean square of what it has beside that swing, rad/s.
    pub noise: f64,
    /// CPU time of a reading, ns, the least of several runs.
    pub ns: f64,
}

/// Measures all estimators on all swings at all rates.
///
/// # Errors
/// A figure of the wish beyond its limits.
pub fn estimators(wish: &Wish) -> Result<Vec<Estimate>, Fault> {
    within("counts", wish.counts, (1.0, 1e9), "counts a turn")?;
    within("seconds", wish.seconds, (0.01, 100.0), "s")?;
    let mut all = Vec::new();
    for (peak, hertz) in &wish.swings {
        within("peak", *peak, (1e-3, 1e3), "rad/s")?;
        within("frequency", *hertz, (0.1, 1e3), "Hz")?;
        for rate in &wish.rates {
            within("rate", *rate, (200.0, 1e6), "readings a second")?;
        }
        let courses: Vec<Course> =
            wish.rates.iter().map(|rate| Course::new((*peak, *hertz), *rate, wish)).collect();
        for name in NAMES {
            for course in &courses {
                all.push(course.measure(name)?);
            }
        }
    }
    Ok(all)
}

const NAMES: [&str; 7] =
    ["difference", "low-pass 100 Hz", "window, end", "window, best", "Kalman", "Kalman at 4 kHz", "edges"];

/// A swing at a rate.
struct Course {
    swing: Swing,
    rate: f64,
    count: f64,
    seconds: f64,
    /// Readings that are timed.
    readings: Vec<f64>,
}

impl Course {
    fn new((peak, hertz): Swing, rate: f64, wish: &Wish) -> Self {
        let (count, motion) = (TAU / wish.counts, Motion::Swing(peak, hertz));
        let seconds = (wish.seconds * hertz).round().max(1.0) / hertz;
        let steps = ((seconds * rate) as usize).min(TIMED);
        let read = |n: usize| count * (motion.at(n as f64 / rate).0 / count).floor();
        Self { swing: (peak, hertz), rate, count, seconds, readings: (0..steps).map(read).collect() }
    }

    fn measure(&self, name: &'static str) -> Result<Estimate, Fault> {
        let ((peak, hertz), count, period) = (self.swing, self.count, 1.0 / self.rate);
        let longest = (WINDOW * self.rate).round().max(FEWEST) as usize;
        let acceleration = TAU * hertz * peak;
        let every = (self.rate / SLOW).round().max(1.0);
        Ok(match name {
            "difference" => self.of(name, &mut Difference::new(period)?),
            // No corner beyond what the rate bears.
            "low-pass 100 Hz" => self.of(name, &mut Filtered::new(f64::min(100.0, 0.2 * self.rate), period)?),
            "window, end" => self.of(name, &mut Adaptive::new(Fit::End, longest, count, period)?),
            "window, best" => self.of(name, &mut Adaptive::new(Fit::Best, longest, count, period)?),
            "Kalman" => self.of(name, &mut Kalman::new(acceleration, count, period)?),
            "Kalman at 4 kHz" => {
                let inner = Kalman::new(acceleration, count, every * period)?;
                self.of(name, &mut Decimated::new(inner, every as u32)?)
            }
            _ => self.of(name, &mut Edges::new(count, STANDS, period)?),
        })
    }

    fn of<E: Estimator>(&self, method: &'static str, estimator: &mut E) -> Estimate {
        let ((peak, hertz), motion) = (self.swing, Motion::Swing(self.swing.0, self.swing.1));
        let period = 1.0 / self.rate;
        estimator.reset(motion.at(0.0).0);
        let error = measure(estimator, motion, self.count, period, self.seconds);
        estimator.reset(motion.at(0.0).0);
        let start = (self.seconds.min(0.5) / period) as usize;
        let steps = (self.seconds / period).round() as usize;
        let mut estimates = Vec::with_capacity(steps);
        for n in 0..start + steps {
            let angle = motion.at(n as f64 * period).0;
            let speed = estimator.push(self.count * (angle / self.count).floor());
            if n >= start {
                estimates.push(speed);
            }
        }
        let (lag, size, noise) = parted(&estimates, TAU * hertz * period, start);
        let ns = nanoseconds(self.readings.len(), || {
            for angle in &self.readings {
                black_box(estimator.push(*angle));
            }
        });
        let (counts, gain) = ((TAU / self.count).round(), size / peak);
        Estimate {
            method,
            rate: self.rate,
            counts,
            swing: self.swing,
            rms: error.rms,
            worst: error.worst,
            lag: lag * period,
            gain,
            noise,
            ns,
        }
    }
}

/// Of values, from the sample `start` on: by how many samples their share of a sine of `turn` radians a sample is late, how large it is,
/// and the root mean square of what is left beside it.
fn parted(values: &[f64], turn: f64, start: usize) -> (f64, f64, f64) {
    let at = |n: usize| (turn * (start + n) as f64).sin_cos();
    // Least squares of a sin + b cos.
    let [mut ss, mut sc, mut cc, mut sv, mut cv] = [0.0f64; 5];
    for (n, v) in values.iter().enumerate() {
        let (s, c) = at(n);
        (ss, sc, cc) = (ss + s * s, sc + s * c, cc + c * c);
        (sv, cv) = (sv + s * v, cv + c * v);
    }
    let determinant = ss * cc - sc * sc;
    if determinant <= 0.0 || values.is_empty() {
        return (f64::NAN, f64::NAN, f64::NAN);
    }
    let (a, b) = ((sv * cc - cv * sc) / determinant, (cv * ss - sv * sc) / determinant);
    let left = values.iter().enumerate().map(|(n, v)| {
        let (s, c) = at(n);
        (v - a * s - b * c).powi(2)
    });
    let noise = (left.sum::<f64>() / values.len() as f64).sqrt();
    (-b.atan2(a) / turn, a.hypot(b), noise)
}
