//! What a tactor was measured to give: a table over the frequency, in the unit of whoever measured it.

use std::f64::consts::TAU;

use super::fault::{Fault, HERTZ, MOST_POINTS, OUTPUT};
use super::threshold::{RANGE, decibels};
use crate::actuator::elementary::ln;

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Metres.
    Displacement,
    /// Metres a second.
    Velocity,
    /// Metres a second squared.
    Acceleration,
}

/// For what it was given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Per {
    /// For each volt at its terminals.
    Volt,
    /// For each ampere.
    Ampere,
    /// For full scale of the device, everything in between included.
    FullScale,
}

/// The unit of a table: peak over peak, or root mean square over root mean square, which is the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// What was measured.
    pub quantity: Quantity,
    /// What one is in SI units.
    pub scale: f64,
    /// For what.
    pub per: Per,
}

/// Standard gravity, m/s², in which accelerometers are read.
const G: f64 = 9.806_65;

/// The words for units: what was measured over what it was given.
pub const UNITS: &[&str] = &[
    "m/V", "mm/V", "um/V", "m/s/V", "mm/s/V", "m/s2/V", "g/V", "m/A", "mm/A", "um/A", "m/s/A", "mm/s/A",
    "m/s2/A", "g/A", "m/FS", "mm/FS", "um/FS", "m/s/FS", "mm/s/FS", "m/s2/FS", "g/FS",
];

impl Unit {
    /// The word at a place in [`UNITS`], and its unit; beyond them, the first.
    pub fn at(place: usize) -> (&'static str, Self) {
        let word = UNITS.get(place).unwrap_or(&UNITS[0]);
        (word, Self::of(word))
    }

    /// The unit of one of [`UNITS`].
    fn of(word: &str) -> Self {
        let (above, below) = word.rsplit_once('/').unwrap_or((word, "V"));
        let per = match below {
            "V" => Per::Volt,
            "A" => Per::Ampere,
            _ => Per::FullScale,
        };
        let (quantity, scale) = match above {
            "m" => (Quantity::Displacement, 1.0),
            "mm" => (Quantity::Displacement, 1e-3),
            "um" => (Quantity::Displacement, 1e-6),
            "m/s" => (Quantity::Velocity, 1.0),
            "mm/s" => (Quantity::Velocity, 1e-3),
            "g" => (Quantity::Acceleration, G),
            _ => (Quantity::Acceleration, 1.0),
        };
        Self { quantity, scale, per }
    }
}

/// A point of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    hertz: f64,
    /// ln of that.
    log: f64,
    /// Displacement for each volt, ampere or full scale, dB above 1 m.
    decibels: f64,
}

/// Displacement over the frequency. Between points it is straight in dB over the logarithm of the frequency; beyond them nothing is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    points: Vec<Point>,
}

impl Table {
    /// Of points [Hz, output] in a unit.
    ///
    /// # Errors
    /// Fewer than two points, or too many; frequencies or outputs that cannot be, or that do not rise.
    pub fn new(points: &[[f64; 2]], unit: Unit) -> Result<Self, Fault> {
        if points.len() < 2 {
            return Err(Fault::FewPoints(points.len()));
        }
        if points.len() > MOST_POINTS {
            return Err(Fault::ManyPoints(points.len()));
        }
        let mut read: Vec<Point> = Vec::with_capacity(points.len());
        for (n, &[hertz, output]) in points.iter().enumerate() {
            if !(HERTZ[0]..=HERTZ[1]).contains(&hertz) {
                return Err(Fault::Frequency(n, hertz));
            }
            if let Some(before) = read.last().filter(|before| hertz <= before.hertz) {
                return Err(Fault::Order(n, hertz, before.hertz));
            }
            let output = output * unit.scale;
            if !(OUTPUT[0]..=OUTPUT[1]).contains(&output) {
                return Err(Fault::Output(n, output));
            }
            let omega = TAU * hertz;
            let metres = match unit.quantity {
                Quantity::Displacement => output,
                Quantity::Velocity => output / omega,
                Quantity::Acceleration => output / (omega * omega),
            };
            read.push(Point { hertz, log: ln(hertz), decibels: decibels(metres) });
        }
        Ok(Self { points: read })
    }

    /// The same acceleration at all frequencies at which something is felt, in no unit.
    pub(super) fn flat_acceleration() -> Self {
        let point = |hertz: f64| Point { hertz, log: ln(hertz), decibels: -2.0 * decibels(hertz) };
        Self { points: RANGE.map(point).into() }
    }

    /// The frequencies between which it says something, Hz.
    pub fn range(&self) -> [f64; 2] {
        let hertz = |point: Option<&Point>| point.map_or(0.0, |point| point.hertz);
        [hertz(self.points.first()), hertz(self.points.last())]
    }

    /// Displacement for each volt, ampere or full scale, dB above 1 m; `None` beyond its points.
    pub fn metres(&self, hertz: f64) -> Option<f64> {
        let next = self.points.partition_point(|point| point.hertz < hertz);
        let after = self.points.get(next)?;
        if after.hertz == hertz {
            return Some(after.decibels);
        }
        let before = self.points.get(next.checked_sub(1)?)?;
        let share = (ln(hertz) - before.log) / (after.log - before.log);
        Some(before.decibels + (after.decibels - before.decibels) * share)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::{Fault, MOST_POINTS, Per, Quantity, Table, UNITS, Unit};

    fn of(points: &[[f64; 2]]) -> Result<Table, Fault> {
        Table::new(points, Unit::at(0).1)
    }

    #[test]
    fn points_come_back_and_between_them_it_is_straight() {
        let points = [[40.0, 3e-5], [100.0, 1.7e-5], [160.0, 9e-6], [640.0, 2.25e-6], [800.0, 1e-7]];
        let table = of(&points).unwrap();
        for [hertz, metres] in points {
            let is = table.metres(hertz).unwrap();
            assert!((is - 20.0 * metres.log10()).abs() < 1e-11, "{hertz}");
        }
        // Twice the octaves, twice the decibels: half way from 160 to 640 Hz lies 320 Hz, half way in dB one half.
        assert!((table.metres(320.0).unwrap() - 20.0 * 4.5e-6f64.log10()).abs() < 1e-11);
        assert_eq!(table.range(), [40.0, 800.0]);
        for beyond in [0.0, -40.0, 39.999, 800.001, f64::INFINITY, f64::NAN] {
            assert_eq!(table.metres(beyond), None, "{beyond}");
        }
    }

    #[test]
    fn every_unit_is_what_its_word_says() {
        for (place, word) in UNITS.iter().enumerate() {
            let (said, unit) = Unit::at(place);
            assert_eq!(said, *word);
            assert_eq!(unit.per == Per::Ampere, word.ends_with("/A"), "{word}");
            assert_eq!(unit.per == Per::FullScale, word.ends_with("/FS"), "{word}");
            let times = match unit.quantity {
                Quantity::Displacement => 0,
                Quantity::Velocity => 1,
                Quantity::Acceleration => 2,
            };
            let said = if word.starts_with("g/") || word.contains("s2") {
                2
            } else {
                i32::from(word.contains("/s/"))
            };
            assert_eq!(times, said, "{word}");
            // One micrometre at 100 Hz, in each.
            let amount = 1e-6 * (TAU * 100.0).powi(times) / unit.scale;
            let table = Table::new(&[[100.0, amount], [200.0, amount]], unit).unwrap();
            assert!((table.metres(100.0).unwrap() + 120.0).abs() < 1e-9, "{word}");
        }
        assert_eq!((Unit::at(UNITS.len()), Unit::at(0).0), (Unit::at(0), "m/V"));
        assert_eq!(Unit::of("g/V").scale, 9.80665);
    }

    #[test]
    fn tables_that_cannot_be_are_refused_at_their_point() {
        let good = [50.0, 1e-6];
        assert_eq!(of(&[]), Err(Fault::FewPoints(0)));
        assert_eq!(of(&[good]), Err(Fault::FewPoints(1)));
        assert_eq!(of(&[good, [40.0, 1e-6]]), Err(Fault::Order(1, 40.0, 50.0)));
        assert_eq!(of(&[good, [50.0, 2e-6]]), Err(Fault::Order(1, 50.0, 50.0)));
        for hertz in [0.0, -1.0, 1e300, f64::INFINITY, 5001.0] {
            assert_eq!(of(&[[hertz, 1e-6], good]), Err(Fault::Frequency(0, hertz)));
        }
        for output in [0.0, -1e-6, 1e300, f64::INFINITY, 1e-300] {
            assert_eq!(of(&[good, [60.0, output]]), Err(Fault::Output(1, output)));
        }
        assert!(matches!(of(&[[f64::NAN, 1e-6], good]), Err(Fault::Frequency(0, _))));
        assert!(matches!(of(&[good, [60.0, f64::NAN]]), Err(Fault::Output(1, _))));
        let many: Vec<[f64; 2]> = (0..=MOST_POINTS).map(|n| [10.0 + n as f64, 1e-6]).collect();
        assert_eq!(of(&many), Err(Fault::ManyPoints(MOST_POINTS + 1)));
        assert!(of(&many[1..]).is_ok());
    }
}
