//! What is done to the terminals of a motor.

use std::fmt;

/// Beyond this, in volts or amperes, a drive counts as none.
pub const MOST_DRIVE: f64 = 1e6;

/// What is done to the terminals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// A voltage, V; 0 is a short circuit.
    Voltage(f64),
    /// A current, as long as a voltage within a limit can hold it; beyond, that limit is the voltage, until the current is back where it
    /// should be. Within the limit the source sets the current at once, whatever the inductance.
    Current {
        /// A.
        amperes: f64,
        /// The largest voltage of either sign, V; infinite: no limit.
        limit: f64,
    },
    /// Nothing is connected, or the motor is unplugged. What the coil still held is lost in that instant.
    Open,
}

impl Drive {
    /// Both terminals joined.
    pub const SHORT: Self = Self::Voltage(0.0);

    /// The same drive with another amount, volts or amperes as it is; open terminals stay open.
    #[must_use]
    pub fn with(self, amount: f64) -> Self {
        match self {
            Self::Voltage(_) => Self::Voltage(amount),
            Self::Current { limit, .. } => Self::Current { amperes: amount, limit },
            Self::Open => Self::Open,
        }
    }

    /// Volts or amperes; 0 of open terminals.
    pub fn amount(self) -> f64 {
        match self {
            Self::Voltage(volts) => volts,
            Self::Current { amperes, .. } => amperes,
            Self::Open => 0.0,
        }
    }

    /// The drive, or a short circuit and `true` where it is no number or beyond [`MOST_DRIVE`].
    #[inline]
    pub(super) fn masked(self) -> (Self, bool) {
        let sane = match self {
            Self::Voltage(v) => v.abs() <= MOST_DRIVE,
            Self::Current { amperes, limit } => amperes.abs() <= MOST_DRIVE && limit >= 0.0,
            Self::Open => true,
        };
        if sane { (self, false) } else { (Self::SHORT, true) }
    }
}

impl fmt::Display for Drive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Three digits.
        let written = |x: f64| format!("{x:.2e}").parse().unwrap_or(x);
        match self {
            Self::Voltage(volts) => write!(f, "{} V", written(*volts)),
            Self::Current { amperes, .. } => write!(f, "{} A", written(*amperes)),
            Self::Open => write!(f, "open terminals"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Drive;

    #[test]
    fn amounts_are_taken_and_given() {
        for drive in [Drive::Voltage(2.0), Drive::Current { amperes: 2.0, limit: 5.0 }] {
            assert_eq!((drive.amount(), drive.with(-1.0).amount()), (2.0, -1.0));
            assert_eq!(drive.with(-1.0).with(2.0), drive);
        }
        assert_eq!((Drive::Open.amount(), Drive::Open.with(3.0)), (0.0, Drive::Open));
        let written =
            [Drive::Voltage(0.5).to_string(), Drive::Current { amperes: 0.0206, limit: 3.0 }.to_string()];
        assert_eq!(written, ["0.5 V", "0.0206 A"]);
        assert_eq!(Drive::Voltage(4.123_456e-4).to_string(), "0.000412 V");
    }

    #[test]
    fn what_is_no_number_is_a_short_circuit() {
        let limit = 3.0;
        for bad in [
            Drive::Voltage(f64::NAN),
            Drive::Voltage(f64::NEG_INFINITY),
            Drive::Voltage(1e300),
            Drive::Current { amperes: f64::NAN, limit },
            Drive::Current { amperes: 0.1, limit: f64::NAN },
            Drive::Current { amperes: 0.1, limit: -1.0 },
        ] {
            assert_eq!(bad.masked(), (Drive::SHORT, true));
        }
        for good in [Drive::Voltage(-3.0), Drive::Open, Drive::Current { amperes: 0.1, limit: f64::INFINITY }]
        {
            assert_eq!(good.masked(), (good, false));
        }
    }
}
