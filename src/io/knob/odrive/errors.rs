//! The errors of an axis, bit by bit.

use super::setup::Errors;

/// `axis.error` of firmware 0.5.
const OLD: [(u32, &str); 14] = [
    (0, "invalid state"),
    (6, "motor failed"),
    (7, "sensorless estimator failed"),
    (8, "encoder failed"),
    (9, "controller failed"),
    (11, "watchdog expired"),
    (12, "lower end stop pressed"),
    (13, "upper end stop pressed"),
    (14, "emergency stop"),
    (17, "homing without end stop"),
    (18, "too hot"),
    (19, "position unknown"),
    (4, "brake resistor disarmed"),
    (5, "motor disarmed"),
];

/// `axis.active_errors` of firmware 0.6.
const NEW: [(u32, &str); 22] = [
    (0, "initializing"),
    (1, "system level"),
    (2, "timing"),
    (3, "estimate missing"),
    (4, "bad configuration"),
    (5, "gate driver"),
    (6, "input missing"),
    (8, "supply voltage too high"),
    (9, "supply voltage too low"),
    (10, "supply current too high"),
    (11, "regenerated current too high"),
    (12, "current limit"),
    (13, "motor too hot"),
    (14, "inverter too hot"),
    (15, "speed limit"),
    (16, "position limit"),
    (24, "watchdog expired"),
    (25, "emergency stop"),
    (26, "spin-out"),
    (27, "brake resistor disarmed"),
    (28, "thermistor disconnected"),
    (30, "calibration"),
];

impl Errors {
    /// The bit of the watchdog alone.
    pub(super) fn watchdog(self) -> u64 {
        match self {
            Self::Old => 1 << 11,
            Self::New => 1 << 24,
        }
    }

    /// Those that are set, by name.
    pub(super) fn names(self, bits: u64) -> String {
        let table: &[(u32, &str)] = match self {
            Self::Old => &OLD,
            Self::New => &NEW,
        };
        let named = |bit: u32| table.iter().find(|(b, _)| *b == bit).map_or("unnamed", |(_, name)| name);
        let set: Vec<&str> = (0..64).filter(|bit| bits >> bit & 1 == 1).map(named).collect();
        if set.is_empty() { "none".into() } else { set.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use super::Errors;

    #[test]
    fn bits_have_names() {
        assert_eq!(Errors::Old.names(0x900), "encoder failed, watchdog expired");
        assert_eq!(Errors::New.names(1 << 24 | 1 << 63), "watchdog expired, unnamed");
        assert_eq!(Errors::Old.names(0), "none");
    }
}
