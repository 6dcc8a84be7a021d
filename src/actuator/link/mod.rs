//! From the value of a sample to the terminals of an actuator: converter, coupling, amplifier.

pub mod amplifier;
pub mod carrier;
pub mod compensator;
pub mod conduction;
pub mod converter;
pub mod coupling;
pub mod diodes;
pub mod effective;
pub mod fineness;
pub mod pulse;
pub mod pwm;
pub mod wave;

use crate::actuator::fault::{Fault, positive};
use amplifier::Amplifier;
use coupling::{Corners, HighPass};

/// What stands between a sample and an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chain {
    /// Volts at a sample of 1.
    pub full_scale: f64,
    /// What keeps steady voltages off.
    pub corners: Corners,
    /// What drives the actuator.
    pub amplifier: Amplifier,
}

impl Chain {
    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first figure that cannot be.
    pub fn check(&self) -> Result<(), Fault> {
        positive("full_scale_volts", self.full_scale)?;
        self.corners.check()?;
        self.amplifier.check()
    }

    /// The most that reaches the actuator where nothing is held off, volts or amperes.
    pub fn most(&self) -> f64 {
        self.amplifier.within(self.full_scale * self.amplifier.gain.abs())
    }
}

/// A chain in time.
///
/// ```
/// use pacinian::actuator::drive::Drive;
/// use pacinian::actuator::link::amplifier::Amplifier;
/// use pacinian::actuator::link::coupling::Corners;
/// use pacinian::actuator::link::{Chain, Link};
///
/// let amplifier =
///     Amplifier { gain: 6.0, inverted: false, drive: Drive::Voltage, volts: Some(5.0), amperes: None };
/// let chain = Chain { full_scale: 1.4, corners: Corners::two(8.0, 2.0), amplifier };
/// let mut link = Link::new(&chain, 48_000.0)?;
/// let volts = link.step(0.5);
/// assert!((volts - 0.5 * 1.4 * 6.0).abs() < 0.01);
/// # Ok::<(), pacinian::actuator::fault::Fault>(())
/// ```
#[derive(Debug, Clone)]
pub struct Link {
    chain: Chain,
    high_pass: HighPass,
    counts: Counts,
}

/// What a chain could not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Samples beyond full scale.
    pub clipped: u64,
    /// Samples of which the amplifier gave less than was asked for.
    pub limited: u64,
    /// Samples that were no numbers.
    pub masked: u64,
}

impl Link {
    /// At rest, `rate` samples a second.
    ///
    /// # Errors
    /// A figure of the chain, or a rate, that cannot be.
    pub fn new(chain: &Chain, rate: f64) -> Result<Self, Fault> {
        chain.check()?;
        let high_pass = HighPass::new(&chain.corners, rate)?;
        Ok(Self { chain: *chain, high_pass, counts: Counts::default() })
    }

    /// Volts or amperes that a sample asks of the actuator: their mean over the time for which it is held.
    ///
    /// A sample beyond ±1 is cut as the converter cuts it; one that is not a number is 0.
    #[inline]
    pub fn step(&mut self, sample: f64) -> f64 {
        let sample = self.cut(sample);
        let (given, within) = self.give(sample);
        self.counts.limited += u64::from(!within);
        given
    }

    /// A sample as the converter takes it: within ±1, and 0 where it is not a number.
    #[inline]
    pub fn cut(&mut self, sample: f64) -> f64 {
        self.counts.masked += u64::from(!sample.is_finite());
        let sample = if sample.is_finite() { sample } else { 0.0 };
        self.counts.clipped += u64::from(sample.abs() > 1.0);
        sample.clamp(-1.0, 1.0)
    }

    /// What the parts of a frame that leaves the converter, as shares of full scale, ask of the actuator: volts or amperes in their place. Of a link
    /// whose rate is that of the parts. A converter may give more than its largest sample between two of them, and that is not cut.
    #[inline]
    pub fn parts(&mut self, parts: &mut [f64]) {
        let mut all = true;
        for part in parts {
            let (given, within) = self.give(*part);
            *part = given;
            all &= within;
        }
        self.counts.limited += u64::from(!all);
    }

    /// What is given for a share of full scale, and whether that is all that was asked for.
    #[inline]
    fn give(&mut self, share: f64) -> (f64, bool) {
        let volts = self.high_pass.step(share * self.chain.full_scale);
        let asked = volts * self.chain.amplifier.signed_gain();
        let given = self.chain.amplifier.within(asked);
        (given, given == asked)
    }

    /// What it could not do so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::amplifier::Amplifier;
    use super::coupling::Corners;
    use super::{Chain, Counts, Link};
    use crate::actuator::drive::Drive;

    pub fn chain(corners: Corners) -> Chain {
        let amplifier =
            Amplifier { gain: 2.2, inverted: false, drive: Drive::Voltage, volts: Some(12.0), amperes: None };
        Chain { full_scale: 1.4, corners, amplifier }
    }

    #[test]
    fn a_coupled_link_is_a_gain() {
        let mut link = Link::new(&chain(Corners::none()), 48_000.0).unwrap();
        assert_eq!(link.step(0.5), 0.5 * 1.4 * 2.2);
        let inverted = Amplifier { inverted: true, ..chain(Corners::none()).amplifier };
        let mut link = Link::new(&Chain { amplifier: inverted, ..chain(Corners::none()) }, 48_000.0).unwrap();
        assert_eq!(link.step(0.5), -0.5 * 1.4 * 2.2);
    }

    #[test]
    fn what_it_cannot_do_is_counted() {
        let small = Amplifier { volts: Some(2.0), ..chain(Corners::none()).amplifier };
        let mut link = Link::new(&Chain { amplifier: small, ..chain(Corners::none()) }, 48_000.0).unwrap();
        assert_eq!([1.5, f64::NAN, -1.0, 0.1].map(|x| link.step(x)), [2.0, 0.0, -2.0, 0.1 * 1.4 * 2.2]);
        assert_eq!(link.counts(), Counts { clipped: 1, limited: 2, masked: 1 });
        // A frame in parts of which several are too much is one of which less was given.
        let mut parts = [1.1, -2.0, 0.5];
        assert_eq!(link.cut(1.5), 1.0);
        link.parts(&mut parts);
        assert_eq!(parts, [2.0, -2.0, 0.5 * 1.4 * 2.2]);
        assert_eq!(link.counts(), Counts { clipped: 2, limited: 3, masked: 1 });
        assert_eq!(Chain { amplifier: small, ..chain(Corners::none()) }.most(), 2.0);
        assert!((chain(Corners::none()).most() - 3.08).abs() < 1e-12);
    }

    #[test]
    fn a_chain_that_cannot_be_is_refused() {
        let fault = |chain: Chain, rate: f64| Link::new(&chain, rate).unwrap_err().field;
        assert_eq!(fault(Chain { full_scale: 0.0, ..chain(Corners::none()) }, 48e3), "full_scale_volts");
        assert_eq!(fault(chain(Corners::one(-1.0)), 48e3), "high_pass");
        assert_eq!(fault(chain(Corners::one(8.0)), f64::NAN), "rate");
        let none = Amplifier { gain: 0.0, ..chain(Corners::none()).amplifier };
        assert_eq!(fault(Chain { amplifier: none, ..chain(Corners::none()) }, 48e3), "gain");
    }
}
