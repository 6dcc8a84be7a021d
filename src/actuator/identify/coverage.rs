//! Whether intervals hold what they should as often as they say, and are no wider than that takes.

/// The chance that a value is inside of the interval that is told.
const CHANCE: f64 = 0.95;

/// The chance at which fewer are inside though all is well; the noise of a test is always the same.
const UNLUCKY: f64 = 1e-2;

/// The fewest of so many draws that are inside, as less is a matter of bad luck: P(X < fewest) is below 1e-2 of a binomial distribution.
pub fn fewest(draws: u64) -> u64 {
    let mut term = (1.0 - CHANCE).powi(draws as i32);
    let (mut below, mut k) = (0.0, 0);
    while k < draws && below + term < UNLUCKY {
        below += term;
        term *= (draws - k) as f64 / (k + 1) as f64 * CHANCE / (1.0 - CHANCE);
        k += 1;
    }
    k
}

/// Draws of an estimate: how many were inside, and how far off they were, root mean square.
#[derive(Debug, Clone, Copy, Default)]
pub struct Coverage {
    draws: u64,
    inside: u64,
    squares: f64,
    shares: f64,
}

impl Coverage {
    /// One more, of which the truth is known.
    pub fn take(&mut self, value: f64, interval: [f64; 2], truth: f64) {
        self.draws += 1;
        self.inside += u64::from((interval[0]..=interval[1]).contains(&truth));
        // Half of the interval is 1.96 standard deviations.
        let deviation = (interval[1] - interval[0]) / 2.0 / 1.96;
        self.shares += (value / truth - 1.0).powi(2);
        self.squares += ((value - truth) / deviation).powi(2);
    }

    /// How far they are off, as a share of the deviations that intervals tell: 1 where noise alone has made them.
    pub fn off(&self) -> f64 {
        (self.squares / self.draws as f64).sqrt()
    }

    /// How far they are off as a share of the truth.
    pub fn share(&self) -> f64 {
        (self.shares / self.draws as f64).sqrt()
    }

    /// Whether as many are inside as is to be expected.
    pub fn holds(&self) -> bool {
        self.inside >= fewest(self.draws)
    }
}

/// Against the distribution summed up the other way, from all down, in whole numbers of logarithms.
#[test]
fn the_fewest_is_that_of_the_distribution() {
    let chance = |draws: u64, k: u64| {
        let choose: f64 = (1..=draws - k).map(|n| f64::ln((k + n) as f64 / n as f64)).sum();
        (choose + k as f64 * CHANCE.ln() + (draws - k) as f64 * (1.0 - CHANCE).ln()).exp()
    };
    for draws in [1, 4, 10, 40, 100] {
        let least = fewest(draws);
        let below: f64 = (0..least).map(|k| chance(draws, k)).sum();
        assert!(below < UNLUCKY && below + chance(draws, least) >= UNLUCKY, "{draws}: {least}");
    }
    // One draw may be outside. Of a hundred, 5 are on average, and 2.2 more or less is usual.
    assert_eq!((fewest(1), fewest(100)), (0, 89));
}
