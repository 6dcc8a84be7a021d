//! From a multiple of the engine's rate down to it, for the reference: only 0 to 1 kHz must survive, so only what would fold
//! there is taken away.

/// A low-pass for decimation: flat within 1e-7 to 1/8 of the low rate, below −140 dB where the band folds from.
#[derive(Debug, Clone)]
pub struct Decimator {
    ratio: usize,
    taps: Vec<f64>,
}

impl Decimator {
    /// Keeps one of `ratio` samples.
    pub fn new(ratio: usize) -> Self {
        // Kaiser window for 150 dB between 1/8 and 7/8 of the low rate (Kaiser 1974).
        let beta = 0.1102 * (150.0 - 8.7);
        let half = 10 * ratio as i64;
        let cutoff = 0.5 / ratio as f64;
        let taps: Vec<f64> = (-half..=half)
            .map(|n| {
                let x = n as f64 / (half + 1) as f64;
                let window = bessel(beta * (1.0 - x * x).sqrt()) / bessel(beta);
                2.0 * cutoff * sinc(2.0 * cutoff * n as f64) * window
            })
            .collect();
        let sum: f64 = taps.iter().sum();
        Self { ratio, taps: taps.iter().map(|t| t / sum).collect() }
    }

    /// Adds `gain` times the low-rate version of `high` to `low`. Sample `first` of the high rate is `high[0]`; low sample n
    /// lies at high sample n × ratio. What falls outside `low` is dropped.
    pub fn add(&self, high: &[f64], first: i64, gain: f64, low: &mut [f64]) {
        let (ratio, half) = (self.ratio as i64, (self.taps.len() / 2) as i64);
        let from = (first - half).div_euclid(ratio).max(0);
        let to = ((first + high.len() as i64 + half) / ratio).min(low.len() as i64 - 1);
        for n in from..=to {
            let centre = n * ratio - first;
            let begin = (centre - half).max(0);
            let end = (centre + half + 1).min(high.len() as i64);
            if begin >= end {
                continue;
            }
            let taps = &self.taps[(begin - centre + half) as usize..];
            let sum: f64 = high[begin as usize..end as usize].iter().zip(taps).map(|(x, t)| x * t).sum();
            low[n as usize] += gain * sum;
        }
    }
}

fn sinc(x: f64) -> f64 {
    let x = std::f64::consts::PI * x;
    if x.abs() < 1e-9 { 1.0 } else { x.sin() / x }
}

/// Modified Bessel function of the first kind and order 0, by its series.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term, mut k) = (1.0, 1.0, 1.0);
    while term > sum * 1e-18 {
        term *= (x / (2.0 * k)).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::Decimator;

    fn level(hertz: f64) -> f64 {
        let decimator = Decimator::new(16);
        let high: Vec<f64> =
            (0..16 * 4000).map(|n| (std::f64::consts::TAU * hertz * n as f64 / 128_000.0).sin()).collect();
        let mut low = vec![0.0; 4000];
        decimator.add(&high, 0, 1.0, &mut low);
        let middle = &low[1000..3000];
        (middle.iter().map(|x| x * x).sum::<f64>() / 1000.0).sqrt()
    }

    #[test]
    fn the_band_passes_and_what_would_fold_into_it_does_not() {
        assert!((level(36.0) - 1.0).abs() < 1e-6, "{}", level(36.0));
        assert!((level(988.0) - 1.0).abs() < 1e-6, "{}", level(988.0));
        for hertz in [7_010.0, 8_300.0, 15_200.0, 63_000.0] {
            assert!(level(hertz) < 1e-7, "{hertz} Hz: {}", level(hertz));
        }
    }

    #[test]
    fn low_samples_lie_on_high_ones() {
        let decimator = Decimator::new(8);
        let mut low = vec![0.0; 40];
        decimator.add(&[1.0], 160, 2.0, &mut low);
        let peak = (0..40).max_by(|&a, &b| low[a].total_cmp(&low[b])).unwrap();
        assert_eq!(peak, 20);
        let mut early = vec![0.0; 40];
        decimator.add(&[0.5; 3], -1, 1.0, &mut early);
        assert!(early[0] > 0.0);
    }
}
