//! A motor behind an AC-coupled card: a carrier whose amplitude is the voltage wanted, and a rectifier. It turns one way, and nothing brakes it.

use super::Chain;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Diodes between an amplifier and a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectifier {
    /// Whether both half-waves pass: a bridge.
    pub full_wave: bool,
    /// Volts that the diodes in the path take together.
    pub drop: f64,
}

impl Rectifier {
    /// What passes at an instant, volts.
    pub fn passes(&self, volts: f64) -> f64 {
        let volts = if self.full_wave { volts.abs() } else { volts };
        (volts - self.drop).max(0.0)
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

    /// The amplitude whose mean is this, volts; 0 for what is not above 0.
    pub fn amplitude(&self, mean: f64) -> f64 {
        if !(mean > 0.0 && mean.is_finite()) {
            return 0.0;
        }
        // A mean of at least (2/π) (A − (π/2) d), or half of that.
        let share = if self.full_wave { 1.0 } else { 2.0 };
        let (mut low, mut high) = (self.drop, mean * share * FRAC_PI_2 + FRAC_PI_2 * self.drop);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if self.mean(middle) < mean { low = middle } else { high = middle }
        }
        high
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

/// Samples of a carrier.
#[derive(Debug, Clone, PartialEq)]
pub struct Modulated {
    /// Samples, within ±1.
    pub samples: Vec<f64>,
    /// The most that the motor can get, volts on average.
    pub most: f64,
    /// Volt-seconds that were wanted beyond that.
    pub missing: f64,
    /// Volt-seconds that were wanted in reverse, which a rectifier never gives.
    pub reverse: f64,
}

impl Carrier {
    /// Samples for which a motor gets the `wanted` volts, on average over each half-wave, at `rate` samples a second.
    ///
    /// # Errors
    /// A figure that cannot be; a carrier at or beyond half the rate.
    pub fn modulate(&self, chain: &Chain, rate: f64, wanted: &[f64]) -> Result<Modulated, Fault> {
        chain.check()?;
        positive("rate", rate)?;
        positive("carrier", self.hertz)?;
        check("carrier", self.hertz, Limit::Below(0.5 * rate))?;
        not_negative("drop", self.rectifier.drop)?;
        // What the coupling takes is made up for. The converter takes nothing: it gives back the sine between its samples, and where they are held
        // instead, it is the samples' own mean that passes the diodes.
        let passed = chain.corners.response(self.hertz).abs();
        let gain = chain.full_scale * chain.amplifier.gain.abs() * passed;
        let most_amplitude = chain.amplifier.within(gain);
        let most = self.rectifier.mean(most_amplitude);
        let (mut missing, mut reverse) = (0.0, 0.0);
        let mut samples = Vec::with_capacity(wanted.len());
        // A cosine: behind coupling, one that begins as a sine would stand off centre for a while.
        let mut phase = 0.0;
        for &volts in wanted {
            let volts = if volts.is_finite() { volts } else { 0.0 };
            reverse += (-volts).max(0.0) / rate;
            missing += (volts - most).max(0.0) / rate;
            let amplitude = self.rectifier.amplitude(volts.min(most)).min(most_amplitude);
            samples.push(amplitude / gain * f64::cos(TAU * phase));
            phase += self.hertz / rate;
            phase -= phase.floor();
        }
        Ok(Modulated { samples, most, missing, reverse })
    }
}

#[cfg(test)]
mod tests {
    use super::super::coupling::Corners;
    use super::super::tests::chain;
    use super::super::{Chain, Link};
    use super::{Carrier, Rectifier, TAU};
    use std::f64::consts::PI;

    #[test]
    fn means_are_those_of_the_rectified_sine() {
        for full_wave in [true, false] {
            for drop in [0.0, 0.3, 1.4] {
                let rectifier = Rectifier { full_wave, drop };
                for amplitude in [0.1, 1.0, 1.41, 5.0] {
                    let count = 200_000;
                    let at = |n: i32| amplitude * (TAU * (f64::from(n) + 0.5) / f64::from(count)).sin();
                    let sum: f64 =
                        (0..count).map(|n| rectifier.passes(at(n))).sum::<f64>() / f64::from(count);
                    assert!((rectifier.mean(amplitude) - sum).abs() < 1e-8, "{rectifier:?} {amplitude}");
                    if amplitude > drop {
                        let back = rectifier.amplitude(rectifier.mean(amplitude));
                        assert!((back / amplitude - 1.0).abs() < 1e-7, "{rectifier:?} {amplitude}: {back}");
                    }
                }
            }
        }
        assert!((Rectifier { full_wave: true, drop: 0.0 }.mean(1.0) - 2.0 / PI).abs() < 1e-15);
        assert_eq!(Rectifier { full_wave: true, drop: 0.0 }.amplitude(f64::NAN), 0.0);
    }

    /// Through the link and the diodes, the motor gets on average what was wanted: also behind two corners, and right away.
    #[test]
    fn the_motor_gets_its_mean() {
        for corners in [Corners::none(), Corners::one(20.0), Corners::two(10.0, 20.0)] {
            for full_wave in [true, false] {
                let rectifier = Rectifier { full_wave, drop: 0.4 };
                let carrier = Carrier { hertz: 2000.0, rectifier };
                let rate = 192_000.0;
                let wanted = vec![if full_wave { 1.2 } else { 0.5 }; 19_200];
                let made = carrier.modulate(&chain(corners), rate, &wanted).unwrap();
                assert_eq!((made.missing, made.reverse), (0.0, 0.0));
                let mut link = Link::new(&chain(corners), rate).unwrap();
                let got: Vec<f64> = made.samples.iter().map(|&x| rectifier.passes(link.step(x))).collect();
                for part in got.chunks(1920) {
                    let mean = part.iter().sum::<f64>() / part.len() as f64;
                    assert!((mean / wanted[0] - 1.0).abs() < 0.01, "{corners:?} {mean}");
                }
            }
        }
    }

    /// A carrier not far above the corner, and one of few samples a turn.
    #[test]
    fn what_coupling_takes_is_given_before() {
        let rectifier = Rectifier { full_wave: true, drop: 0.4 };
        for (hertz, corners, rate) in
            [(50.0, Corners::one(40.0), 48_000.0), (9600.0, Corners::none(), 192_000.0)]
        {
            let carrier = Carrier { hertz, rectifier };
            let made = carrier.modulate(&chain(corners), rate, &vec![0.8; rate as usize]).unwrap();
            let mut link = Link::new(&chain(corners), rate).unwrap();
            let got: Vec<f64> = made.samples.iter().map(|&x| rectifier.passes(link.step(x))).collect();
            let part = &got[got.len() / 2..];
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            // Of a held sine, twenty samples a turn, steps pass.
            assert!((mean / 0.8 - 1.0).abs() < 0.02, "{hertz}: {mean}");
            let gain = 1.4 * 2.2;
            let amplitude = made.samples.iter().fold(0.0f64, |m, x| m.max(x.abs())) * gain;
            let passed = corners.response(hertz).abs();
            let expected = rectifier.amplitude(0.8) / passed;
            assert!((amplitude / expected - 1.0).abs() < 1e-3, "{hertz}: {amplitude} {expected}");
        }
    }

    #[test]
    fn what_a_rectifier_cannot_give_is_told() {
        let carrier = Carrier { hertz: 1000.0, rectifier: Rectifier { full_wave: true, drop: 0.0 } };
        let wanted: Vec<f64> = (0..480).map(|n| if n < 240 { 9.0 } else { -1.0 }).collect();
        let made = carrier.modulate(&chain(Corners::one(10.0)), 48_000.0, &wanted).unwrap();
        // Full scale is 3.08 V.
        assert!((made.most - 2.0 / PI * 3.08).abs() < 0.01, "{}", made.most);
        assert!((made.missing - (9.0 - made.most) * 5e-3).abs() < 1e-9);
        assert!((made.reverse - 5e-3).abs() < 1e-9);
        assert!(made.samples.iter().all(|x| x.abs() <= 1.0) && made.samples[240..].iter().all(|&x| x == 0.0));
        for (carrier, field) in [
            (Carrier { hertz: 24_000.0, ..carrier }, "carrier"),
            (Carrier { hertz: 0.0, ..carrier }, "carrier"),
            (Carrier { rectifier: Rectifier { full_wave: true, drop: -0.1 }, ..carrier }, "drop"),
        ] {
            assert_eq!(carrier.modulate(&chain(Corners::none()), 48_000.0, &[1.0]).unwrap_err().field, field);
        }
        let broken = Chain { full_scale: -1.0, ..chain(Corners::none()) };
        assert_eq!(carrier.modulate(&broken, 48_000.0, &[1.0]).unwrap_err().field, "full_scale_volts");
    }
}
