//! What many rounds come to.

use super::line::PARTS;
use super::measure::{Measured, Round};
use crate::dsp::student;

/// Two crystals are apart by up to some 100 millionths: from here on, it is the times that are wrong.
const CLOCKS: f64 = 500e-6;

/// Seconds by which one round deviates, or by which the mean may be off, from which on the mean is of no use.
const SPREAD: f64 = 0.000_5;

/// Seconds from the median, from which on it was another sound that came back.
const STRAY: f64 = 0.002;

/// Figures of rounds, seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// The mean latency.
    pub mean: f64,
    /// By how much that may be off, 95 times in 100, to either side: its standard error by Student's quantile; of one round nobody knows it.
    pub mean_margin: Option<f64>,
    /// The standard deviation from round to round; 0 of one.
    pub deviation: f64,
    /// The shortest,
    pub least: f64,
    /// and the longest.
    pub most: f64,
    /// By how much it grows, seconds a second: the slope of the line of least squares.
    pub drift: f64,
    /// The standard error of that; of two or fewer rounds nobody knows it.
    pub error: Option<f64>,
    /// By how much the drift may be off, 95 times in 100, to either side: the standard error by Student's quantile.
    pub margin: Option<f64>,
}

/// Why a latency is not to be relied upon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// The clocks of the two devices come out further apart than crystals are, by this share: the times that the system says are wrong.
    Clocks(f64),
    /// The rounds differ by this much, seconds (standard deviation).
    Spread(f64),
    /// There were too few rounds: the mean may be off by this much, seconds; `None`: nobody knows by how much, as there was one.
    Few(Option<f64>),
}

impl Figures {
    /// Of one or more rounds.
    pub fn of(rounds: &[Round]) -> Self {
        let count = rounds.len().max(1) as f64;
        let mean = rounds.iter().map(|r| r.latency).sum::<f64>() / count;
        let middle = rounds.iter().map(|r| r.at).sum::<f64>() / count;
        let square = |x: f64| x * x;
        let deviation =
            (rounds.iter().map(|r| square(r.latency - mean)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
        let spread: f64 = rounds.iter().map(|r| square(r.at - middle)).sum();
        let rise: f64 = rounds.iter().map(|r| (r.at - middle) * (r.latency - mean)).sum();
        let drift = if spread > 0.0 { rise / spread } else { 0.0 };
        // What the straight line leaves over.
        let left = rounds.iter().map(|r| square(r.latency - mean - drift * (r.at - middle))).sum::<f64>();
        let error = (rounds.len() > 2 && spread > 0.0).then(|| (left / (count - 2.0) / spread).sqrt());
        let mean_margin =
            (rounds.len() > 1).then(|| deviation / count.sqrt() * student::quantile(rounds.len() - 1));
        Self {
            mean,
            mean_margin,
            deviation,
            least: rounds.iter().map(|r| r.latency).fold(f64::INFINITY, f64::min),
            most: rounds.iter().map(|r| r.latency).fold(f64::NEG_INFINITY, f64::max),
            drift,
            error,
            margin: error.map(|error| error * student::quantile(rounds.len() - 2)),
        }
    }

    /// Whether the drift is more than chance may make of none, 95 times in 100; `None` where nobody knows.
    pub fn drifts(&self) -> Option<bool> {
        self.margin.map(|margin| self.drift.abs() > margin)
    }

    /// Why they are not fit to be kept, where the clocks were apart by `clocks` ([`Measured::drift`]); `None` if they are.
    pub fn doubt(&self, clocks: f64) -> Option<Doubt> {
        if clocks.abs() > CLOCKS {
            Some(Doubt::Clocks(clocks))
        } else if self.deviation > SPREAD {
            Some(Doubt::Spread(self.deviation))
        } else {
            self.mean_margin.is_none_or(|margin| margin > SPREAD).then_some(Doubt::Few(self.mean_margin))
        }
    }
}

impl Measured {
    /// Its figures. What the devices' times may be off by is in `mean_margin`, `error` and `margin`: all rounds lie on the same two lines, so that they do not
    /// show it.
    pub fn figures(&self) -> Figures {
        let rounds = Figures::of(&self.rounds);
        let mean = |own: f64| own.hypot(self.times.height * student::quantile(PARTS - 2));
        Figures {
            mean_margin: rounds.mean_margin.map(mean),
            error: rounds.error.map(|own| own.hypot(self.times.slope)),
            margin: rounds.margin.map(|own| own.hypot(self.clocks_margin())),
            ..rounds
        }
    }

    /// By how much [`Measured::drift`] may be off, as a share, 95 times in 100, to either side.
    pub fn clocks_margin(&self) -> f64 {
        self.times.slope * student::quantile(PARTS - 2)
    }

    /// Leaves out rounds that lie further than 2 ms from the median, since that was another sound, and says how many those were.
    pub fn leave_out_strays(&mut self) -> usize {
        let mut all: Vec<f64> = self.rounds.iter().map(|r| r.latency).collect();
        all.sort_by(f64::total_cmp);
        let Some(&median) = all.get(all.len() / 2) else { return 0 };
        self.rounds.retain(|r| (r.latency - median).abs() < STRAY);
        all.len() - self.rounds.len()
    }

    /// What comes back of what goes out, as a share, on the average; below 0 upside down.
    pub fn gain(&self) -> f64 {
        self.rounds.iter().map(|r| r.gain).sum::<f64>() / self.rounds.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::{Doubt, Figures, Measured, Round};

    fn round(at: f64, latency: f64) -> Round {
        Round { at, latency, gain: 1.0 }
    }

    #[test]
    fn figures_are_those_of_the_definitions() {
        let figures = Figures::of(&[round(0.0, 0.001), round(1.0, 0.002), round(2.0, 0.003)]);
        assert!((figures.mean - 0.002).abs() < 1e-12 && (figures.deviation - 0.001).abs() < 1e-12);
        assert!((figures.drift - 0.001).abs() < 1e-12 && (figures.least, figures.most) == (0.001, 0.003));
        let one = Figures::of(&[round(5.0, 0.004)]);
        assert_eq!((one.mean, one.deviation, one.drift, one.error), (0.004, 0.0, 0.0, None));
        let rounds = vec![round(0.0, 0.01), round(1.0, 0.0101), round(2.0, 0.2)];
        let mut measured = Measured { rounds, ..Measured::default() };
        assert_eq!((measured.leave_out_strays(), measured.rounds.len()), (1, 2));
    }

    #[test]
    fn the_error_of_the_drift_is_that_of_the_closed_form() {
        // About (0, 0), (1, 1), (2, 0), (3, 1): slope 0.2, what is left over 0.8, so sqrt(0.8 / 2 / 5).
        let rounds =
            [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 1.0)].map(|(at, x)| round(at, 0.004 + 1e-3 * x));
        let figures = Figures::of(&rounds);
        assert!((figures.drift - 0.2e-3).abs() < 1e-12);
        assert!((figures.error.unwrap() - 1e-3 * 0.08_f64.sqrt()).abs() < 1e-12, "{figures:?}");
        let line = Figures::of(&[round(0.0, 0.001), round(1.0, 0.002), round(2.0, 0.003)]);
        assert!(line.error.unwrap() < 1e-12);
        // Two lie on a line whatever they are; and at one time there is no slope.
        assert_eq!(Figures::of(&rounds[..2]).error, None);
        assert_eq!(Figures::of(&[round(1.0, 0.1), round(1.0, 0.2), round(1.0, 0.3)]).error, None);
    }

    /// Many sets of probes with a known slope and known noise: the slopes scatter as the errors say.
    #[test]
    fn slopes_scatter_by_their_errors() {
        let (slope, noise, count, sets) = (1e-6, 20e-6, 25, 2_000);
        let mut seed = 1_u64;
        let mut even = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        // A sum of twelve is as good as normal, with variance 1.
        let mut normal = || (0..12).map(|_| even()).sum::<f64>() - 6.0;
        let (mut within, mut said, mut square) = (0, 0.0, 0.0);
        for _ in 0..sets {
            let rounds: Vec<Round> = (0..count)
                .map(|n| round(f64::from(n) * 0.25, 0.003 + slope * f64::from(n) * 0.25 + noise * normal()))
                .collect();
            let figures = Figures::of(&rounds);
            let (error, off) = (figures.error.unwrap(), figures.drift - slope);
            within += i32::from(off.abs() <= figures.margin.unwrap());
            said += error * error / f64::from(sets);
            square += off * off / f64::from(sets);
        }
        // Sum of (at - middle)^2 of n points d apart: d^2 n (n^2 - 1) / 12.
        let n = f64::from(count);
        let known = noise * noise / (0.25 * 0.25 * n * (n * n - 1.0) / 12.0);
        assert!(
            (said / known - 1.0).abs() < 0.05 && (square / known - 1.0).abs() < 0.1,
            "{said} {square} {known}"
        );
        let share = f64::from(within) / f64::from(sets);
        assert!((share - 0.95).abs() < 0.015, "{share}");
    }

    #[test]
    fn what_cannot_be_is_doubted() {
        let of = |drift, latencies: [f64; 3]| {
            let rounds = latencies.map(|latency| round(0.0, latency)).to_vec();
            Figures::of(&rounds).doubt(drift)
        };
        let same = [0.01; 3];
        for (drift, latencies) in [(100e-6, same), (-499e-6, same), (0.0, [0.01, 0.0102, 0.0101])] {
            assert_eq!(of(drift, latencies), None);
        }
        assert_eq!(of(501e-6, same), Some(Doubt::Clocks(501e-6)));
        assert_eq!(of(-0.01, same), Some(Doubt::Clocks(-0.01)));
        assert!(matches!(of(0.0, [0.01, 0.0119, 0.0103]), Some(Doubt::Spread(x)) if x > 0.0009));
        // Two that are 0.1 ms apart: half of that, by Student's 12.706 for one degree of freedom.
        let few = |rounds: &[Round]| Figures::of(rounds).doubt(0.0);
        let two = [round(0.0, 0.01), round(1.0, 0.0101)];
        assert!(matches!(few(&two), Some(Doubt::Few(Some(x))) if (x - 0.05e-3 * 12.706_204_7).abs() < 1e-9));
        assert_eq!(few(&[round(0.0, 0.01), round(1.0, 0.01004)]), None);
        assert_eq!(few(&two[..1]), Some(Doubt::Few(None)));
        assert_eq!(Figures::of(&two[..1]).mean_margin, None);
    }
}
