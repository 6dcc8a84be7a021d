//! What is done to the terminals of a motor over time.

use crate::actuator::motor::{Drive, Motor};

/// Drives one after the other, from time 0 on, and a last one for good.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// When each ends (s, ascending), and what it is.
    pieces: Vec<(f64, Drive)>,
    /// What comes behind them.
    last: Drive,
}

impl Course {
    /// Nothing yet: `last` from the beginning on.
    pub fn ending_in(last: Drive) -> Self {
        Self { pieces: Vec::new(), last }
    }

    /// With one more drive before the last: `seconds` long, or left out where that is not above 0.
    #[must_use]
    pub fn then(mut self, seconds: f64, drive: Drive) -> Self {
        if seconds > 0.0 && seconds.is_finite() {
            self.pieces.push((self.duration() + seconds, drive));
        }
        self
    }

    /// On at a voltage (V) for `seconds`, then shorted.
    pub fn on(volts: f64, seconds: f64) -> Self {
        Self::ending_in(Drive::SHORT).then(seconds, Drive::Voltage(volts))
    }

    /// Seconds until the last drive begins.
    pub fn duration(&self) -> f64 {
        self.pieces.last().map_or(0.0, |(end, _)| *end)
    }

    /// When each drive before the last ends (s), and what it is.
    pub fn pieces(&self) -> &[(f64, Drive)] {
        &self.pieces
    }

    /// What is done for good.
    pub fn last(&self) -> Drive {
        self.last
    }

    /// Gives it to a motor of `rate` steps a second for so many of them, switching at the exact instants; `seen` after each step.
    pub fn play<const BOOKED: bool>(
        &self,
        motor: &mut Motor<BOOKED>,
        rate: f64,
        steps: usize,
        mut seen: impl FnMut(&Motor<BOOKED>),
    ) {
        let mut at = 0;
        let mut switches: Vec<(f64, Drive)> = Vec::new();
        motor.drive(self.pieces.first().map_or(self.last, |(_, drive)| *drive));
        for n in 0..steps {
            switches.clear();
            while let Some((end, _)) = self.pieces.get(at).filter(|(end, _)| end * rate < (n + 1) as f64) {
                at += 1;
                let next = self.pieces.get(at).map_or(self.last, |(_, drive)| *drive);
                switches.push((end * rate - n as f64, next));
            }
            motor.step_with(&switches);
            seen(motor);
        }
    }

    /// The volts, or the amperes, of a converter that holds each for a sample of 1/`rate`: where a drive ends within one, its mean over the
    /// sample, so that the motor gets the same volt-seconds. `None` where they are not all volts, or all amperes.
    pub fn means(&self, rate: f64) -> Option<Vec<f64>> {
        let alike = |drive: &Drive| {
            !matches!(drive, Drive::Open)
                && std::mem::discriminant(drive) == std::mem::discriminant(&self.last)
        };
        if !alike(&self.last) || !self.pieces.iter().all(|(_, drive)| alike(drive)) {
            return None;
        }
        let last = self.last.amount();
        let mut means = vec![last; (self.duration() * rate).ceil() as usize];
        let mut begin = 0.0_f64;
        for (end, drive) in &self.pieces {
            let (more, end) = (drive.amount() - last, end * rate);
            let (first, behind) = (begin as usize, (end.ceil() as usize).min(means.len()));
            for (n, mean) in means.iter_mut().enumerate().take(behind).skip(first) {
                let share = (end.min((n + 1) as f64) - begin.max(n as f64)).max(0.0);
                *mean += more * share;
            }
            begin = end;
        }
        Some(means)
    }
}

#[cfg(test)]
mod tests {
    use super::{Course, Drive};

    #[test]
    fn a_converter_gives_the_same_volt_seconds() {
        let course =
            Course::on(3.0, 0.012_34).then(0.004_001, Drive::Voltage(-2.5)).then(1e-5, Drive::Voltage(1.0));
        for rate in [1000.0, 44_100.0, 48_000.0] {
            let sum = course.means(rate).unwrap().iter().sum::<f64>() / rate;
            let due = 3.0 * 0.012_34 - 2.5 * 0.004_001 + 1e-5;
            assert!((sum - due).abs() < 1e-15, "{sum} {due}");
        }
        // By hand: 1.5 samples of 3 V, then half a sample of −2 V, and a short circuit.
        let course = Course::on(3.0, 1.5e-3).then(0.5e-3, Drive::Voltage(-2.0));
        let volts = course.means(1000.0).unwrap();
        assert!(
            volts.len() == 2 && (volts[0] - 3.0).abs() < 1e-12 && (volts[1] - 0.5).abs() < 1e-12,
            "{volts:?}"
        );
        assert_eq!(Course::ending_in(Drive::Open).means(48e3), None);
        let amperes = Drive::Current { amperes: 0.5, limit: 3.0 };
        assert_eq!(
            Course::ending_in(amperes.with(0.0)).then(2.5e-3, amperes).means(1e3).unwrap(),
            [0.5, 0.5, 0.25]
        );
        assert_eq!(Course::ending_in(Drive::SHORT).then(2.5e-3, amperes).means(1e3), None);
        assert_eq!(Course::on(3.0, -1.0).pieces(), []);
        assert_eq!(Course::on(3.0, f64::NAN).duration(), 0.0);
    }
}
