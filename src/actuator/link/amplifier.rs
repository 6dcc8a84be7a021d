//! An amplifier.

use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// An amplifier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplifier {
    /// Volts, or amperes, for each volt at its input; not 0.
    pub gain: f64,
    /// Whether its output is wired the other way round.
    pub inverted: bool,
    /// What it imposes.
    pub drive: Drive,
    /// The most it gives, volts; `None`: unknown.
    pub volts: Option<f64>,
    /// The most it gives, amperes; `None`: unknown.
    pub amperes: Option<f64>,
}

impl Amplifier {
    pub(super) fn check(&self) -> Result<(), Fault> {
        check("gain", self.gain.abs(), Limit::Above(0.0))?;
        self.volts.map_or(Ok(()), |volts| positive("max_volts", volts))?;
        self.amperes.map_or(Ok(()), |amperes| positive("max_amperes", amperes))
    }

    /// Its gain, negative where it is wired the other way round.
    pub fn signed_gain(&self) -> f64 {
        if self.inverted { -self.gain } else { self.gain }
    }

    /// What it gives of what is asked for, by the limit on the quantity that it imposes. What the other limit leaves depends on the
    /// actuator: see [`Supply`](crate::actuator::coil::supply::Supply).
    #[inline]
    pub fn within(&self, asked: f64) -> f64 {
        let most = match self.drive {
            Drive::Voltage => self.volts,
            Drive::Current => self.amperes,
        };
        most.map_or(asked, |most| asked.max(-most).min(most))
    }
}

#[cfg(test)]
mod tests {
    use super::{Amplifier, Drive};

    #[test]
    fn each_drive_has_its_own_limit() {
        let volts = Amplifier {
            gain: 2.0,
            inverted: true,
            drive: Drive::Voltage,
            volts: Some(5.0),
            amperes: Some(0.5),
        };
        let amperes = Amplifier { drive: Drive::Current, ..volts };
        assert_eq!([-7.0, -1.0, 7.0].map(|x| volts.within(x)), [-5.0, -1.0, 5.0]);
        assert_eq!([-7.0, -0.1, 7.0].map(|x| amperes.within(x)), [-0.5, -0.1, 0.5]);
        assert_eq!(volts.signed_gain(), -2.0);
        assert_eq!(Amplifier { amperes: None, ..amperes }.within(100.0), 100.0);
    }

    #[test]
    fn limits_that_cannot_be_are_refused() {
        let sound =
            Amplifier { gain: -2.0, inverted: false, drive: Drive::Voltage, volts: None, amperes: None };
        assert!(sound.check().is_ok());
        assert_eq!(Amplifier { gain: f64::NAN, ..sound }.check().unwrap_err().field, "gain");
        assert_eq!(Amplifier { volts: Some(0.0), ..sound }.check().unwrap_err().field, "max_volts");
        assert_eq!(Amplifier { amperes: Some(-1.0), ..sound }.check().unwrap_err().field, "max_amperes");
    }
}
