//! A first-order high-pass that keeps steady voltages off an actuator.

use std::f64::consts::{PI, TAU};

use super::biquad::Complex;

/// Corner, Hz. What skin feels as vibration begins more than ten times higher: at 20 Hz this takes away 0.011 dB and turns by 2.9°,
/// and of a steady voltage nothing that heats is left after a second (time constant 0.16 s, -80 dB after 1.5 s).
pub const CORNER: f64 = 1.0;

/// A DC blocker: y = `keep` (x - m), and the mean m follows by `pull` (x - m).
///
/// It is (1 + s/ω)⁻¹ s/ω by the bilinear transform, the corner prewarped: exactly -3.01 dB there, and 0 dB at half the rate, above which
/// it never is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Of what differs from the mean, so much goes out.
    pub keep: f64,
    /// And by so much the mean follows it, each sample.
    pub pull: f64,
}

impl Blocker {
    /// With its corner (Hz, below half the rate) at a rate (Hz).
    pub fn new(corner: f64, rate: f64) -> Self {
        let warped = (PI * corner / rate).tan();
        Self { keep: 1.0 / (1.0 + warped), pull: 2.0 * warped / (1.0 + warped) }
    }

    /// Response at `frequency` (Hz) for a sampling `rate` (Hz).
    pub fn response(&self, frequency: f64, rate: f64) -> Complex {
        let z = Complex::turned(TAU * frequency / rate);
        let above = z - Complex::from(1.0);
        Complex::from(self.keep) * above / (above + Complex::from(self.pull))
    }

    /// Group delay at `frequency` (Hz, above 0) for a sampling `rate` (Hz), in seconds. The phase comes about as much earlier.
    pub fn group_delay(&self, frequency: f64, rate: f64) -> f64 {
        let (pole, cos) = (1.0 - self.pull, (TAU * frequency / rate).cos());
        // That of the pole, less that of the zero, which is half a sample at every frequency.
        ((1.0 - pole * cos) / (1.0 - 2.0 * pole * cos + pole * pole) - 0.5) / rate
    }
}

#[cfg(test)]
mod tests {
    use super::{Blocker, CORNER};
    use std::f64::consts::TAU;

    const RATES: [f64; 4] = [6000.0, 7350.0, 8000.0, 12_000.0];

    #[test]
    fn the_response_is_that_of_a_resistor_and_a_capacitor() {
        for rate in RATES {
            let blocker = Blocker::new(CORNER, rate);
            for hertz in [0.1, 1.0, 20.0, 250.0, 1000.0] {
                let digital = blocker.response(hertz, rate);
                // x / (x - i), x the frequency over the corner.
                let x = hertz / CORNER;
                let (level, angle) = (x / x.hypot(1.0), (1.0 / x).atan());
                // The bilinear transform bends frequencies, by 5 % at 1 kHz and 8 kHz.
                assert!((digital.abs() - level).abs() < 1e-6, "{rate} {hertz}: {digital:?}");
                assert!((digital.angle() - angle).abs() < 2e-4, "{rate} {hertz}: {digital:?}");
                assert!(digital.abs() <= 1.0);
            }
            assert_eq!(blocker.response(0.0, rate).abs(), 0.0);
            assert!((blocker.response(CORNER, rate).abs() - 0.5_f64.sqrt()).abs() < 1e-12);
            assert!((blocker.response(rate / 2.0, rate).abs() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_step_decays_with_the_time_constant() {
        for rate in RATES {
            let blocker = Blocker::new(CORNER, rate);
            let (mut mean, mut decay) = (0.0, 1.0);
            for n in 0..(2.0 * rate) as usize {
                let apart = 1.0 - mean;
                let y = blocker.keep * apart;
                mean += blocker.pull * apart;
                // keep × (1 - pull)ⁿ, which is exp(-2π t) but for a little.
                assert!((y - blocker.keep * decay).abs() < 1e-12, "{rate} {n}");
                let time = n as f64 / rate;
                assert!((y - (-TAU * CORNER * time).exp()).abs() < 1e-3, "{rate} {n}: {y}");
                decay *= 1.0 - blocker.pull;
            }
        }
    }

    #[test]
    fn the_group_delay_is_the_slope_of_the_phase() {
        for rate in RATES {
            let blocker = Blocker::new(CORNER, rate);
            for hertz in [20.0, 250.0] {
                let angle = |hertz: f64| blocker.response(hertz, rate).angle();
                let slope = (angle(hertz - 0.1) - angle(hertz + 0.1)) / (TAU * 0.2);
                let group = blocker.group_delay(hertz, rate);
                assert!((group - slope).abs() < 1e-8, "{rate} {hertz}: {group} {slope}");
            }
            assert!((blocker.group_delay(250.0, rate) - 2.5e-6).abs() < 0.1e-6);
        }
    }
}
