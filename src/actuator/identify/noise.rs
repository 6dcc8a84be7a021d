//! Noise for tests: a counter's mix (splitmix64, Steele, Lea & Flood 2014), and normal deviates from it (Box & Muller).

/// A source of normal deviates.
pub struct Noise(u64);

impl Noise {
    /// A stream of its own for every seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xD1B5_4A32_D192_ED03))
    }

    fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Mean 0, deviation 1.
    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = ((-2.0 * (1.0 - self.even()).ln()).sqrt(), std::f64::consts::TAU * self.even());
        radius * angle.cos()
    }

    /// Adds noise to a signal, so many decibels below its mean square.
    pub fn add(&mut self, signal: &[f64], decibels: f64) -> Vec<f64> {
        let mean = signal.iter().sum::<f64>() / signal.len() as f64;
        let square = signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / signal.len() as f64;
        let deviation = square.sqrt() * 10f64.powf(-decibels / 20.0);
        signal.iter().map(|x| x + deviation * self.normal()).collect()
    }
}
