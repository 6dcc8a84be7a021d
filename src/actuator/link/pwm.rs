//! Pulse-width modulation into a bridge: one signal for the direction, one for on and off. While it is off, the bridge shorts the motor.

use crate::actuator::elementary::exp_m1;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// How a bridge is switched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switching {
    /// Samples a period, 2 or more: switches fall on samples, so the voltage has no more steps than these.
    pub period: u32,
    /// Volts across the bridge.
    pub supply: f64,
}

impl Switching {
    /// Hertz at which it switches.
    pub fn hertz(&self, rate: f64) -> f64 {
        rate / f64::from(self.period)
    }

    /// The smallest difference of a period's mean, volts: the supply over the samples of a period.
    pub fn resolution(&self) -> f64 {
        self.supply / f64::from(self.period)
    }

    /// The mean square of what a coil of a time constant L/R (s) lets through of pulses so many samples wide, of `rate` a second, on its resistance, V²: of a
    /// motor that stands, S² (d − (τ/T) (1 − e^(−dT/τ)) (1 − e^(−(1−d)T/τ)) / (1 − e^(−T/τ))), which is S² d without inductance.
    pub fn square(&self, width: u32, rate: f64, time: f64) -> f64 {
        let share = f64::from(width.min(self.period)) / f64::from(self.period);
        let turns = time * self.hertz(rate);
        let lost = |share: f64| exp_m1(-share / turns);
        let smoothed = if turns > 0.0 { -turns * lost(share) * lost(1.0 - share) / lost(1.0) } else { 0.0 };
        self.supply * self.supply * (share - smoothed).max(0.0)
    }

    /// The steps from no voltage to the supply, in bits: log₂ of the samples of a period.
    pub fn bits(&self) -> f64 {
        f64::from(self.period).log2()
    }
}

/// What the two signals say at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bridge {
    /// Whether the motor is on.
    pub on: bool,
    /// Which way round.
    pub reverse: bool,
}

/// A modulator. What a period cannot give for want of resolution is carried to the next, so that volt-seconds are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulator {
    switching: Switching,
    /// Samples of the period that are over, and those at its beginning that are on.
    at: u32,
    width: u32,
    reverse: bool,
    /// Volts wanted in this period so far, and what is owed from those before, in samples of the supply.
    sum: f64,
    owed: f64,
    saturated: u64,
}

impl Modulator {
    /// At rest.
    ///
    /// # Errors
    /// A period below 2, or a supply that is not above 0.
    pub fn new(switching: &Switching) -> Result<Self, Fault> {
        check("period", f64::from(switching.period), Limit::Least(2.0))?;
        positive("supply", switching.supply)?;
        let switching = *switching;
        Ok(Self { switching, at: 0, width: 0, reverse: false, sum: 0.0, owed: 0.0, saturated: 0 })
    }

    /// The next sample, for so many volts wanted; what is not a number is 0. They are summed over a period and given in the next one.
    #[inline]
    pub fn step(&mut self, wanted: f64) -> Bridge {
        let most = f64::from(self.switching.period);
        if self.at == 0 {
            let asked = self.sum + self.owed;
            // Halves are rounded towards 0, or a rest of a half would swing for ever.
            let width = (asked.abs() - 0.5).ceil().max(0.0).min(most);
            let saturates = asked.abs() > most + 0.5;
            self.saturated += u64::from(saturates);
            // At rest both lines are off.
            self.reverse = width > 0.0 && asked < 0.0;
            self.width = width as u32;
            // What the supply does not give is not made up for.
            self.owed = if saturates { 0.0 } else { asked - width.copysign(asked) };
            self.sum = 0.0;
        }
        let on = self.at < self.width;
        let share = wanted / self.switching.supply;
        self.sum += if share.is_finite() { share } else { 0.0 };
        self.at = if self.at + 1 < self.switching.period { self.at + 1 } else { 0 };
        Bridge { on, reverse: self.reverse }
    }

    /// At rest at once: what was wanted and not given is forgotten.
    pub fn reset(&mut self) {
        (self.at, self.width, self.reverse) = (0, 0, false);
        (self.sum, self.owed) = (0.0, 0.0);
    }

    /// Volts that a motor sees of it.
    pub fn volts(&self, bridge: Bridge) -> f64 {
        match (bridge.on, bridge.reverse) {
            (false, _) => 0.0,
            (true, false) => self.switching.supply,
            (true, true) => -self.switching.supply,
        }
    }

    /// Samples by which the motor gets its voltage later: a period.
    pub fn latency(&self) -> u32 {
        self.switching.period
    }

    /// Whether nothing is on and nothing was wanted that is not given yet, but for what is less than half a step.
    pub fn is_idle(&self) -> bool {
        self.width == 0 && self.sum == 0.0
    }

    /// Periods of which more was wanted than the supply gives.
    pub fn saturated(&self) -> u64 {
        self.saturated
    }
}

#[cfg(test)]
mod tests {
    use super::{Bridge, Modulator, Switching};

    const SWITCHING: Switching = Switching { period: 16, supply: 5.0 };

    #[test]
    fn its_resolution_is_stated() {
        assert_eq!(
            (SWITCHING.hertz(48_000.0), SWITCHING.resolution(), SWITCHING.bits()),
            (3000.0, 0.3125, 4.0)
        );
    }

    /// Each period within half a step, and all of them together without any.
    #[test]
    fn volt_seconds_are_kept() {
        for wanted in [0.0, 0.01, 1.0, -2.37, 4.99, -5.0] {
            let mut modulator = Modulator::new(&SWITCHING).unwrap();
            let mut sum = 0.0;
            for n in 0..16 * 1000 {
                let bridge = modulator.step(wanted);
                sum += modulator.volts(bridge);
                if n % 16 == 15 {
                    // Given in the period after it was wanted.
                    let expected = wanted * f64::from(n + 1 - 16);
                    assert!((sum - expected).abs() <= 2.5 + 1e-6, "{wanted} at {n}: {sum} {expected}");
                }
            }
            assert_eq!(modulator.saturated(), 0);
        }
    }

    #[test]
    fn a_voltage_that_turns_turns_the_bridge() {
        let mut modulator = Modulator::new(&SWITCHING).unwrap();
        let (mut given, mut wanted) = (0.0, 0.0);
        for n in 0..4800 {
            let volts = 4.0 * (f64::from(n) * 0.004).sin();
            let bridge = modulator.step(volts);
            given += modulator.volts(bridge);
            wanted += if n < 4800 - 16 { volts } else { 0.0 };
            assert!(modulator.volts(bridge).abs() == if bridge.on { 5.0 } else { 0.0 });
        }
        assert!((given - wanted).abs() <= 2.5 + 1e-9, "{given} {wanted}");
    }

    #[test]
    fn what_is_too_much_saturates_and_is_forgotten() {
        let mut modulator = Modulator::new(&SWITCHING).unwrap();
        (0..1600).for_each(|_| {
            modulator.step(50.0);
        });
        assert_eq!(modulator.saturated(), 99);
        (0..16).for_each(|_| {
            modulator.step(f64::NAN);
        });
        assert_eq!(modulator.step(0.0), Bridge { on: false, reverse: false });
        (0..32).for_each(|_| {
            modulator.step(-5.0);
        });
        assert_eq!(modulator.step(0.0), Bridge { on: true, reverse: true });
        (0..48).for_each(|_| {
            modulator.step(0.0);
        });
        assert_eq!(modulator.step(0.0), Bridge { on: false, reverse: false });
        assert_eq!(Modulator::new(&Switching { period: 1, ..SWITCHING }).unwrap_err().field, "period");
        assert_eq!(Modulator::new(&Switching { supply: 0.0, ..SWITCHING }).unwrap_err().field, "supply");
    }
}
