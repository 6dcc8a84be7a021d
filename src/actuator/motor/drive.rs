//! What is done to the terminals of a motor.

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

#[cfg(test)]
mod tests {
    use super::Drive;

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
