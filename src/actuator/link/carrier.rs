//! A motor behind an AC-coupled card: a carrier and a rectifier. It turns one way, and nothing brakes it.

use std::f64::consts::FRAC_PI_2;

/// Diodes between an amplifier and a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectifier {
    /// Whether both half-waves pass: a bridge.
    pub full_wave: bool,
    /// Volts that the diodes in the path take together.
    pub drop: f64,
}

impl Rectifier {
    /// What stands behind the diodes while they let something through, volts; where it is not above what is there, they do not.
    #[inline]
    pub fn behind(&self, volts: f64) -> f64 {
        if self.full_wave { volts.abs() - self.drop } else { volts - self.drop }
    }

    /// Mean of what passes of a sine of an amplitude, volts: (√(A² − d²) − d acos(d / A)) · 2/π for a bridge, half of that for one diode.
    pub fn mean(&self, amplitude: f64) -> f64 {
        let (a, d) = (amplitude.abs(), self.drop);
        if a.is_nan() || a <= d {
            return 0.0;
        }
        let angle = (d / a).clamp(0.0, 1.0).acos();
        let full = (a * angle.sin() - d * angle) / FRAC_PI_2;
        if self.full_wave { full } else { 0.5 * full }
    }
}

/// A carrier through a chain and a rectifier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carrier {
    /// Hertz, below half the rate.
    pub hertz: f64,
    /// What is behind the amplifier.
    pub rectifier: Rectifier,
}

#[cfg(test)]
mod tests {
    use super::Rectifier;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn means_are_those_of_the_rectified_sine() {
        for full_wave in [true, false] {
            for drop in [0.0, 0.3, 1.4] {
                let rectifier = Rectifier { full_wave, drop };
                for amplitude in [0.1, 1.0, 1.41, 5.0] {
                    let count = 200_000;
                    let at = |n: i32| amplitude * (TAU * (f64::from(n) + 0.5) / f64::from(count)).sin();
                    let sum: f64 =
                        (0..count).map(|n| rectifier.behind(at(n)).max(0.0)).sum::<f64>() / f64::from(count);
                    assert!((rectifier.mean(amplitude) - sum).abs() < 1e-8, "{rectifier:?} {amplitude}");
                }
            }
        }
        assert!((Rectifier { full_wave: true, drop: 0.0 }.mean(1.0) - 2.0 / PI).abs() < 1e-15);
    }
}
