//! The vibration that is wanted of a motor over time.

use std::f64::consts::TAU;

use crate::actuator::fault::{Fault, within};
use crate::actuator::motor::Parameters;

/// A burst of vibration from time 0 on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// The most of it, as a share of the rated vibration: 1e-4 to 1.
    pub level: f64,
    /// How long it is, 1e-3 to 10 s.
    pub seconds: f64,
    /// Its course.
    pub envelope: Envelope,
}

/// The course of a burst between its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Envelope {
    /// At its level all the time.
    Rectangle,
    /// ½ (1 − cos 2πt/T): up and down, at its level in the middle.
    RaisedCosine,
}

impl Envelope {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rectangle => "rectangle",
            Self::RaisedCosine => "raised-cosine",
        }
    }
}

impl Wish {
    /// Refuses what is no wish.
    ///
    /// # Errors
    /// A number beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        within("level", self.level, (1e-4, 1.0), "of the rated vibration")?;
        within("seconds", self.seconds, (1e-3, 10.0), "s")
    }

    /// What is wanted at a time (s), as a share of the rated vibration: 0 outside of the burst and at its ends.
    pub fn at(&self, time: f64) -> f64 {
        if !(time > 0.0 && time < self.seconds) {
            return 0.0;
        }
        match self.envelope {
            Envelope::Rectangle => self.level,
            Envelope::RaisedCosine => 0.5 * self.level * (1.0 - (TAU * time / self.seconds).cos()),
        }
    }

    /// The same at the beginning of each sample of 1/`rate` and at the end of the last one, for a burst of whole samples.
    pub fn shares(&self, rate: f64) -> Vec<f64> {
        let samples = (self.seconds * rate).round().clamp(1.0, 1e8);
        let at = |n: usize| self.at(n as f64 / samples * self.seconds);
        (0..=samples as usize).map(at).collect()
    }

    /// The speeds (rad/s) for those: vibration goes with the square of the speed, so that a share of it takes the root of that of the
    /// rated speed.
    pub fn speeds(&self, parameters: &Parameters, rate: f64) -> Vec<f64> {
        let rated = parameters.rated_speed();
        self.shares(rate).into_iter().map(|share| rated * share.sqrt()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Envelope, Wish};
    use crate::actuator::motor::Parameters;

    const BURST: Wish = Wish { level: 0.64, seconds: 0.1, envelope: Envelope::RaisedCosine };

    #[test]
    fn it_begins_and_ends_at_rest() {
        for envelope in [Envelope::Rectangle, Envelope::RaisedCosine] {
            let shares = Wish { envelope, ..BURST }.shares(8000.0);
            assert_eq!((shares.len(), shares[0], shares[800]), (801, 0.0, 0.0), "{envelope:?}");
            assert!((shares[400] - 0.64).abs() < 1e-15);
        }
        let quarter = BURST.at(0.025);
        assert!((quarter - 0.32).abs() < 1e-12, "half of it after a quarter of its time: {quarter}");
        assert_eq!([-1.0, 0.2, f64::NAN].map(|t| BURST.at(t)), [0.0; 3]);
    }

    #[test]
    fn vibration_goes_with_the_square_of_the_speed() {
        let speeds = BURST.speeds(&Parameters::COIN, 8000.0);
        assert!((speeds[400] / Parameters::COIN.rated_speed() - 0.8).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_wish_is_refused_by_name() {
        let field = |wish: Wish| wish.check().unwrap_err().field;
        assert_eq!(field(Wish { level: 1.1, ..BURST }), "level");
        assert_eq!(field(Wish { level: f64::NAN, ..BURST }), "level");
        assert_eq!(field(Wish { seconds: 0.0, ..BURST }), "seconds");
        assert!(BURST.check().is_ok());
    }
}
