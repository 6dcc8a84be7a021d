//! Pulses through coupling, one sample after another.

use super::coupling::{Corners, HighPass};
use crate::actuator::fault::{Fault, positive};

/// Sends what coupling takes away before it takes it: what an actuator is to get goes in, what the converter is to give comes out.
///
/// It is [`compensate`](super::pulse::compensate) without a lead-in, for what is not known ahead. What is wanted for long asks for ever more: a
/// converter can make up for pulses, not for anything steady. While nothing is wanted, the coupling's charge is let go by no more than
/// what does not matter. Neither allocates nor locks; all figures in one unit, which is that of the samples where nothing else is said.
#[derive(Debug, Clone)]
pub struct Compensator {
    filter: HighPass,
    quiet: f64,
    limited: u64,
    arrived: f64,
    short: bool,
}

/// Of what does not matter: a charge below that is none.
const NOTHING: f64 = 1e-6;

impl Compensator {
    /// For a converter of `rate` samples a second, and an actuator to which `quiet` does nothing.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(corners: &Corners, rate: f64, quiet: f64) -> Result<Self, Fault> {
        positive("quiet", quiet)?;
        Ok(Self { filter: HighPass::new(corners, rate)?, quiet, limited: 0, arrived: 0.0, short: false })
    }

    /// Samples in which the converter could not give what was needed.
    pub fn limited(&self) -> u64 {
        self.limited
    }

    /// Whether the converter could not give what the last sample needed, be it to let the charge go.
    pub fn is_short(&self) -> bool {
        self.short
    }

    /// What the actuator got in the last sample.
    pub fn arrived(&self) -> f64 {
        self.arrived
    }

    /// Whether nothing is left of what was.
    pub fn is_idle(&self) -> bool {
        self.filter.is_empty()
    }

    /// A sample for which nothing is sent, whatever the coupling makes of that.
    pub fn rest(&mut self) {
        self.short = !self.is_idle();
        self.arrived = self.filter.step(0.0);
        self.filter.forget(NOTHING * self.quiet);
    }

    /// What to send for a sample in which the actuator is to get that on average, of no more than `most`; `None`: nothing is wanted.
    pub fn step(&mut self, wanted: Option<f64>, most: f64) -> f64 {
        let output = wanted.unwrap_or_else(|| self.filter.discharging(self.quiet));
        if wanted.is_none() && output == 0.0 {
            self.short = false;
            self.arrived = self.filter.step(0.0);
            self.filter.forget(NOTHING * self.quiet);
            return 0.0;
        }
        let needed = self.filter.needed(if output.is_finite() { output } else { 0.0 });
        let sample = needed.clamp(-most.abs(), most.abs());
        self.short = sample != needed;
        self.limited += u64::from(wanted.is_some() && self.short);
        self.arrived = self.filter.step(sample);
        sample
    }
}

#[cfg(test)]
mod tests {
    use super::super::pulse::{Allowance, compensate};
    use super::super::tests::chain;
    use super::super::{Chain, Link};
    use super::{Compensator, Corners};

    const RATE: f64 = 48_000.0;
    const QUIET: f64 = 0.15;

    /// 2.25 ms forward, 1.6 ms in reverse: a click.
    fn click(volts: f64) -> Vec<f64> {
        (0..185).map(|n| if n < 108 { volts } else { -volts }).collect()
    }

    fn gain(chain: &Chain) -> f64 {
        chain.full_scale * chain.amplifier.signed_gain()
    }

    fn of(chain: &Chain) -> Compensator {
        Compensator::new(&chain.corners, RATE, QUIET / gain(chain).abs()).unwrap()
    }

    /// The same samples as worked out for the pulse as a whole, and its discharge; and then nothing.
    #[test]
    fn it_is_the_compensation_of_a_pulse() {
        for corners in [
            Corners::none(),
            Corners::one(2.0),
            Corners::one(10.0),
            Corners::one(20.0),
            Corners::two(10.0, 10.0),
            Corners::two(20.0, 2.0),
        ] {
            let (chain, wanted) = (chain(corners), click(2.0));
            let allowance = Allowance { quiet: QUIET, lead: 0.0, tail: 10.0 };
            let whole = compensate(&chain, RATE, &wanted, &allowance).unwrap();
            let mut online = of(&chain);
            let steps = wanted.iter().map(|volts| Some(volts / gain(&chain))).chain(std::iter::repeat(None));
            for (n, (wanted, expected)) in steps.zip(&whole.samples).enumerate() {
                let sample = online.step(wanted, 1.0);
                assert!((sample - expected).abs() < 1e-12, "{corners:?} {n}: {sample} {expected}");
            }
            assert_eq!(online.limited(), 0);
            let left = (0..(8.0 * RATE) as usize).find(|_| online.step(None, 1.0) == 0.0 && online.is_idle());
            assert!(left.is_some(), "{corners:?} never rests");
            assert_eq!(online.step(None, 1.0), 0.0);
        }
    }

    /// Pulses that follow one another before the coupling is empty arrive whole all the same; between them no more than what does not matter.
    #[test]
    fn pulses_in_a_row_arrive_whole() {
        for corners in [Corners::one(10.0), Corners::two(8.0, 20.0)] {
            let chain = chain(corners);
            let (mut online, mut link) = (of(&chain), Link::new(&chain, RATE).unwrap());
            for pulse in 0..6 {
                for volts in click(if pulse % 2 == 0 { 1.9 } else { -1.8 }) {
                    let given = link.step(online.step(Some(volts / gain(&chain)), 1.0));
                    assert!((given - volts).abs() < 1e-9, "{corners:?} {pulse}: {given} {volts}");
                }
                for _ in 0..700 * pulse {
                    let given = link.step(online.step(None, 1.0));
                    assert!(given.abs() < QUIET * (1.0 + 1e-9), "{corners:?} {pulse}: {given}");
                }
            }
            assert_eq!(online.limited(), 0);
        }
    }

    /// What is steady runs out of room, which is counted; nothing leaves beyond it, and nothing that is no number.
    #[test]
    fn what_is_steady_runs_out_of_room() {
        let chain = chain(Corners::one(10.0));
        let mut online = of(&chain);
        let level = 0.5;
        // 1 + ω t of the level are needed: twice as much after 1/ω.
        let room = (RATE / (std::f64::consts::TAU * 10.0)) as usize;
        let sent: Vec<f64> = (0..2 * room).map(|_| online.step(Some(level), 1.0)).collect();
        assert!(sent[..room - 2].iter().all(|x| *x < 1.0) && sent[room + 2..].iter().all(|x| *x == 1.0));
        assert!(online.limited().abs_diff(room as u64) < 4);
        assert!(
            online.step(Some(1.0), 0.25) <= 0.25 && online.step(Some(-f64::INFINITY), 0.25).abs() <= 0.25
        );
        assert!(online.step(Some(f64::NAN), 0.25).abs() <= 0.25);
        assert_eq!(Compensator::new(&Corners::none(), RATE, -1.0).unwrap_err().field, "quiet");
    }
}
