//! The carrier, sample by sample: as large as it takes for what is wanted of a motor.

use super::carrier::Carrier;
use super::conduction::Conduction;
use crate::actuator::elementary::cosine;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// The most of a device's rate that a carrier may have: beyond, converters let less through.
pub const HIGHEST: f64 = 0.45;

/// A carrier that is given out.
///
/// It neither allocates nor locks, and a sample is a look into a table and a cosine. Its phase goes on while it is given, and for a turn
/// after; then it begins anew, as a cosine: behind coupling, one that begins as a sine stands off centre for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Wave {
    conduction: Conduction,
    /// Samples for each volt of the amplitude.
    samples: f64,
    /// Turns a sample, those that are over, and those since it was last given.
    step: f64,
    phase: f64,
    rests: f64,
    /// What was asked for last, and the amplitude for it, in samples.
    asked: [f64; 2],
    amplitude: f64,
}

impl Wave {
    /// A carrier into a winding of a time constant L/R (s), at `rate` samples a second, of which one of 1.0 is so many volts at the diodes.
    ///
    /// # Errors
    /// A figure that cannot be; a carrier beyond [`HIGHEST`] of the rate.
    pub fn new(carrier: &Carrier, electrical_time: f64, rate: f64, per_sample: f64) -> Result<Self, Fault> {
        positive("rate", rate)?;
        positive("full_scale_volts", per_sample)?;
        check("carrier", carrier.hertz, Limit::Most(HIGHEST * rate))?;
        Ok(Self {
            conduction: Conduction::new(carrier, electrical_time)?,
            samples: 1.0 / per_sample,
            step: carrier.hertz / rate,
            phase: 0.0,
            rests: 1.0,
            asked: [0.0; 2],
            amplitude: 0.0,
        })
    }

    /// The next sample for a mean of so many volts beyond what the motor makes itself (V), no larger than `most`; and whether that holds it
    /// back. Where nothing is wanted, exactly 0.
    #[inline]
    pub fn step(&mut self, beyond: f64, emf: f64, most: f64) -> (f64, bool) {
        let phase = self.phase;
        self.phase += self.step;
        if self.phase > 0.5 {
            self.phase -= 1.0;
        }
        if self.asked != [beyond, emf] {
            self.asked = [beyond, emf];
            self.amplitude = self.conduction.amplitude(beyond, emf) * self.samples;
        }
        if self.amplitude == 0.0 {
            self.rests += self.step;
            if self.rests > 1.0 {
                (self.rests, self.phase) = (1.0, 0.0);
            }
            return (0.0, false);
        }
        self.rests = 0.0;
        let within = self.amplitude <= most;
        (if within { self.amplitude } else { most } * cosine(phase), !within)
    }
}

#[cfg(test)]
mod tests {
    use super::super::carrier::{Carrier, Rectifier};
    use super::super::conduction::Conduction;
    use super::super::coupling::{Corners, HighPass};
    use super::{HIGHEST, Wave};
    use std::f64::consts::TAU;

    const CARRIER: Carrier = Carrier { hertz: 4100.0, rectifier: Rectifier { full_wave: true, drop: 1.4 } };

    #[test]
    fn it_is_a_cosine_of_the_amplitude_that_it_takes() {
        let mut wave = Wave::new(&CARRIER, 1e-5, 48_000.0, 6.0).unwrap();
        let conduction = Conduction::new(&CARRIER, 1e-5).unwrap();
        let mut all = Vec::new();
        for n in 0..4800 {
            let (beyond, emf) = (0.8, 0.3 + 1e-4 * f64::from(n / 6));
            let (sample, held) = wave.step(beyond, emf, 1.0);
            let expected =
                conduction.amplitude(beyond, emf) / 6.0 * (TAU * 4100.0 * f64::from(n) / 48_000.0).cos();
            assert!((sample - expected).abs() < 1e-9 && !held, "{n}: {sample} {expected}");
            all.push(sample);
        }
        // Nothing is exactly nothing; a short pause keeps the phase, a long one ends it.
        assert_eq!(wave.step(0.0, 0.5, 1.0), (0.0, false));
        let goes_on = wave.step(0.8, 0.3, 1.0).0 * 6.0 / conduction.amplitude(0.8, 0.3);
        assert!((goes_on - (TAU * 4100.0 * 4801.0 / 48_000.0).cos()).abs() < 1e-9, "{goes_on}");
        (0..20).for_each(|_| assert_eq!(wave.step(-1.0, 0.5, 1.0), (0.0, false)));
        assert_eq!(wave.step(0.8, 0.3, 1.0).0, all[0]);
        // One that was never given begins so too, however soon.
        let mut fresh = Wave::new(&CARRIER, 1e-5, 48_000.0, 6.0).unwrap();
        (0..3).for_each(|_| assert_eq!(fresh.step(0.0, 0.0, 1.0), (0.0, false)));
        assert_eq!(fresh.step(0.8, 0.3, 1.0).0, all[0]);
        assert_eq!(wave.step(f64::NAN, 0.3, 1.0), (0.0, false));
        // And no more than may leave.
        let (mut most, mut times) = (0.0_f64, 0);
        for _ in 0..480 {
            let (sample, held) = wave.step(5.0, 0.0, 0.4);
            most = most.max(sample.abs());
            times += u32::from(held);
        }
        assert!(most <= 0.4 && most > 0.39 && times == 480);
    }

    /// Behind two capacitors, its mean over each turn stays nothing from the first turn on. One that began as a sine would not.
    #[test]
    fn coupling_makes_no_offset() {
        let corners = Corners::two(20.0, 10.0);
        let carrier = Carrier { hertz: 4000.0, ..CARRIER };
        let offset = |late: usize| {
            let mut wave = Wave::new(&carrier, 0.0, 48_000.0, 6.0).unwrap();
            let mut passes = HighPass::new(&corners, 48_000.0).unwrap();
            let samples: Vec<f64> = (0..4800 + late).map(|_| wave.step(1.0, 0.5, 1.0).0).collect();
            let volts: Vec<f64> = samples[late..].iter().map(|x| passes.step(*x)).collect();
            let means = volts.chunks_exact(12).map(|turn| (turn.iter().sum::<f64>() / 12.0).abs());
            means.fold(0.0, f64::max) / samples[0]
        };
        let (is, as_sine) = (offset(0), offset(9));
        assert!(is < 2e-3 && as_sine > 3.0 * is, "{is} {as_sine}");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let field = |carrier: Carrier, rate: f64, volts: f64| {
            Wave::new(&carrier, 0.0, rate, volts).unwrap_err().field
        };
        assert_eq!(field(Carrier { hertz: 4000.0, ..CARRIER }, 8000.0, 1.0), "carrier");
        assert!(Wave::new(&Carrier { hertz: HIGHEST * 8000.0, ..CARRIER }, 0.0, 8000.0, 1.0).is_ok());
        assert_eq!(field(CARRIER, 48_000.0, 0.0), "full_scale_volts");
        assert_eq!(field(CARRIER, f64::NAN, 1.0), "rate");
    }
}
