//! How a tactor's weight becomes its gain.

use super::fault::Fault;
use crate::dsp::elementary::ln;
use std::fmt;
use std::str::FromStr;

/// The law by which tactors share what is felt between them. Weights are 0 or more and 1 in sum.
///
/// Between two tactors, β of the way from the first to the second, these are the laws of the phantom sensation: linear A(1 − β) and
/// Aβ, logarithmic A log₂(2 − β) and A log₂(1 + β), energy A √(1 − β) and A √β (that of Israr & Poupyrev, "Tactile Brush", CHI 2011). As functions of the weight they hold for more tactors than two as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Law {
    /// The nearest tactor alone, at its whole gain.
    Nearest,
    /// The weight itself: gains are 1 in sum.
    Linear,
    /// log₂(1 + w): between linear and energy.
    Logarithmic,
    /// √w: the squares of the gains are 1 in sum, so that the power stays.
    #[default]
    Energy,
}

impl Law {
    /// All of them, in the order of their gains.
    pub const ALL: [Self; 4] = [Self::Nearest, Self::Linear, Self::Logarithmic, Self::Energy];

    /// Its word in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Linear => "linear",
            Self::Logarithmic => "logarithmic",
            Self::Energy => "energy",
        }
    }

    /// The gain of a weight, within 0 and 1 as the weight is; what is not a number counts as 0. For the audio thread.
    #[inline]
    pub fn gain(self, weight: f64) -> f64 {
        let w = if weight > 0.0 { weight.min(1.0) } else { 0.0 };
        match self {
            Self::Nearest | Self::Linear => w,
            Self::Logarithmic => ln(1.0 + w) * std::f64::consts::LOG2_E,
            Self::Energy => w.sqrt(),
        }
    }

    /// The mean gain while a weight goes from one to another, both within 0 and 1, on a parabola: `bend` s (1 − s) below the straight way at each share s
    /// of it. For the audio thread.
    ///
    /// (a + b) / 2 − c / 6; of √w, with p = √a and q = √b, (2/3) (p² + p q + q²) / (p + q) − (2 c / 15) (p² + 3 p q + q²) / (p + q)³, which is exact where it goes
    /// straight and of the first order in c, so that what is bent more is halved; of log₂(1 + w) by Simpson's rule, within 1e-3 for all of it (5e-3 if bent) and 3e-7
    /// for a tenth.
    #[inline]
    pub fn mean(self, from: f64, to: f64, bend: f64) -> f64 {
        let middle = 0.5 * (from + to);
        match self {
            Self::Nearest | Self::Linear => middle - bend / 6.0,
            Self::Logarithmic => {
                (self.gain(from) + 4.0 * self.gain(middle - 0.25 * bend) + self.gain(to)) / 6.0
            }
            Self::Energy => root_mean(from, to, bend, HALVED),
        }
    }
}

/// How often a bent way is halved, and by which share of the square of its ends' roots it has to be bent.
const HALVED: usize = 5;
const BENT: f64 = 0.1;

fn root_mean(from: f64, to: f64, bend: f64, halvings: usize) -> f64 {
    let (p, q) = (Law::Energy.gain(from), Law::Energy.gain(to));
    let (sum, product) = (p + q, p * q);
    let squares = p * p + q * q;
    if bend == 0.0 || bend.abs() <= BENT * sum * sum {
        if sum <= 0.0 {
            return 0.0;
        }
        let off = if bend == 0.0 { 0.0 } else { bend * (squares + 3.0 * product) / (7.5 * sum * sum * sum) };
        return (squares + product) / (1.5 * sum) - off;
    }
    let middle = (0.5 * (from + to) - 0.25 * bend).max(0.0);
    if halvings == 0 {
        return (p + 4.0 * Law::Energy.gain(middle) + q) / 6.0;
    }
    let mean = |from, to| root_mean(from, to, 0.25 * bend, halvings - 1);
    0.5 * (mean(from, middle) + mean(middle, to))
}

impl FromStr for Law {
    type Err = Fault;
    fn from_str(word: &str) -> Result<Self, Fault> {
        Self::ALL.into_iter().find(|law| law.name() == word).ok_or_else(|| Fault::Law(word.to_string()))
    }
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::Law;

    #[test]
    fn half_way_between_two_tactors_each_has_the_published_gain() {
        let half = |law: Law| law.gain(0.5);
        assert_eq!(half(Law::Linear), 0.5);
        assert!((half(Law::Logarithmic) - 0.584_962_500_721_156_2).abs() < 1e-15);
        assert!((half(Law::Energy) - 0.5_f64.sqrt()).abs() < 1e-15);
        for n in 0..=1000 {
            let beta = f64::from(n) / 1000.0;
            let (first, second) = (Law::Logarithmic.gain(1.0 - beta), Law::Logarithmic.gain(beta));
            assert!((first - (2.0 - beta).log2()).abs() < 1e-15, "{beta}");
            assert!((second - (1.0 + beta).log2()).abs() < 1e-15, "{beta}");
        }
    }

    #[test]
    fn the_mean_over_a_way_is_the_integral() {
        let pieces = 100_000;
        for law in [Law::Linear, Law::Logarithmic, Law::Energy] {
            for (from, to) in [
                (0.0, 1.0),
                (1.0, 0.0),
                (0.0, 0.1),
                (0.9, 1.0),
                (0.3, 0.3),
                (0.0, 0.0),
                (0.0, 1e-9),
                (0.2, 0.25),
            ] {
                let at = |n: i32| from + (to - from) * (f64::from(n) + 0.5) / f64::from(pieces);
                let wanted = (0..pieces).map(|n| law.gain(at(n))).sum::<f64>() / f64::from(pieces);
                let most = match law {
                    Law::Logarithmic if (to - from).abs() > 0.5 => 1e-3,
                    Law::Logarithmic => 3e-7,
                    // What is left is of the midpoints.
                    _ => 1e-8,
                };
                assert!((law.mean(from, to, 0.0) - wanted).abs() < most, "{law}: {from} {to}");
            }
        }
    }

    /// As weights of a rectangle do: products of two that go straight.
    #[test]
    fn the_mean_over_a_bent_way_is_the_integral() {
        let pieces = 100_000;
        let mut worst = [0.0_f64; 3];
        for (n, law) in [Law::Linear, Law::Logarithmic, Law::Energy].into_iter().enumerate() {
            for (u, v) in [
                ([0.0, 0.1], [0.0, 0.1]),
                ([0.0, 0.1], [0.1, 0.0]),
                ([0.0, 1.0], [1.0, 0.0]),
                ([0.0, 1.0], [0.0, 1.0]),
                ([0.3, 0.4], [0.5, 0.55]),
                ([1e-6, 0.05], [0.02, 1e-4]),
                ([0.0, 0.2], [0.9, 0.7]),
                ([0.001, 0.03], [0.002, 0.04]),
            ] {
                let at = |[from, to]: [f64; 2], s: f64| from + (to - from) * s;
                let weight = |s: f64| at(u, s) * at(v, s);
                let share = |n: i32| (f64::from(n) + 0.5) / f64::from(pieces);
                let wanted = (0..pieces).map(|n| law.gain(weight(share(n)))).sum::<f64>() / f64::from(pieces);
                let found = law.mean(weight(0.0), weight(1.0), (u[1] - u[0]) * (v[1] - v[0]));
                worst[n] = worst[n].max((found - wanted).abs());
            }
        }
        assert!(worst[0] < 1e-9 && worst[1] < 5e-3 && worst[2] < 1e-4, "{worst:?}");
    }

    #[test]
    fn ends_are_exact_gains_rise_and_nothing_but_numbers_comes_out() {
        for law in Law::ALL {
            assert_eq!((law.gain(0.0), law.gain(1.0)), (0.0, 1.0), "{law}");
            let wild = [f64::NAN, f64::NEG_INFINITY, -1.0, f64::INFINITY, 7.0];
            assert_eq!(wild.map(|w| law.gain(w)), [0.0, 0.0, 0.0, 1.0, 1.0], "{law}");
            assert!(
                (0..1000).all(|n| law.gain(f64::from(n) * 1e-3) < law.gain(f64::from(n + 1) * 1e-3)),
                "{law}"
            );
        }
        // Each is at least as loud as the one before it.
        for n in 1..1000 {
            let gains = Law::ALL.map(|law| law.gain(f64::from(n) * 1e-3));
            assert!(gains.windows(2).all(|pair| pair[0] <= pair[1]), "{n}");
        }
    }

    #[test]
    fn words_name_laws_and_back() {
        assert!(Law::ALL.into_iter().all(|law| law.to_string().parse() == Ok(law)));
        assert_eq!(Law::default(), Law::Energy);
        let problem = "Energy".parse::<Law>().unwrap_err().to_string();
        assert_eq!(problem, "`Energy` is no law of sharing: write nearest, linear, logarithmic or energy");
    }
}
