//! A parameter that cannot be.

use std::fmt;

/// A parameter that cannot be, and what it would have to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// The field, as a file calls it.
    pub field: &'static str,
    /// What it was.
    pub value: f64,
    /// What it must keep to.
    pub limit: Limit,
    /// Where the limit comes from, if not from the field alone.
    pub because: Option<&'static str>,
}

/// What a parameter must keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// More than this.
    Above(f64),
    /// This or more.
    Least(f64),
    /// Less than this.
    Below(f64),
    /// This or less.
    Most(f64),
    /// Between these, ends included, in this unit.
    Within(f64, f64, &'static str),
    /// Nothing: here it has no meaning.
    Absent,
}

impl Fault {
    /// A value that breaks a limit which another field sets.
    pub(crate) fn because(field: &'static str, value: f64, limit: Limit, because: &'static str) -> Self {
        Self { field, value, limit, because: Some(because) }
    }
}

impl Limit {
    /// Whether a value keeps to it; what is not a number keeps to nothing, nor does an infinite value.
    fn admits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Above(limit) => value > limit,
                Self::Least(limit) => value >= limit,
                Self::Below(limit) => value < limit,
                Self::Most(limit) => value <= limit,
                Self::Within(least, most, _) => (least..=most).contains(&value),
                Self::Absent => false,
            }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { field, value, limit, because } = self;
        write!(f, "`{field}` is {}, but must be ", Shown(*value))?;
        match limit {
            Limit::Above(limit) => write!(f, "above {}", Shown(brief(*limit, f64::ceil))),
            Limit::Least(limit) => write!(f, "at least {}", Shown(brief(*limit, f64::ceil))),
            Limit::Below(limit) => write!(f, "below {}", Shown(brief(*limit, f64::floor))),
            Limit::Most(limit) => write!(f, "at most {}", Shown(brief(*limit, f64::floor))),
            Limit::Within(least, most, unit) => {
                let [least, most] = [brief(*least, f64::ceil), brief(*most, f64::floor)];
                write!(f, "within {} and {} {unit}", Shown(least), Shown(most))
            }
            Limit::Absent => write!(f, "left out"),
        }?;
        if !value.is_finite() && !matches!(limit, Limit::Absent | Limit::Within(..)) {
            write!(f, ", and finite")?;
        }
        because.map_or(Ok(()), |because| write!(f, ": {because}"))
    }
}

impl std::error::Error for Fault {}

/// A limit in four digits, where it has more: rounded to the side on which what is written by it is admitted.
fn brief(limit: f64, round: fn(f64) -> f64) -> f64 {
    let whole: f64 = format!("{limit:.5e}").parse().unwrap_or(limit);
    if whole == limit || !limit.is_finite() {
        return limit;
    }
    // Powers of ten by their text: those are exact.
    let exponent = limit.abs().log10().floor() as i32 - 3;
    let digits = round(limit / 10f64.powi(exponent));
    format!("{digits}e{exponent}").parse().unwrap_or(limit)
}

/// A number with a power of ten where it would have many zeros.
pub(super) struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        match size == 0.0 || !size.is_finite() || (1e-6..1e10).contains(&size) {
            true => write!(f, "{}", self.0),
            false => write!(f, "{:e}", self.0),
        }
    }
}

/// Refuses a value that breaks a limit.
///
/// # Errors
/// The field, the value and the limit.
pub(crate) fn check(field: &'static str, value: f64, limit: Limit) -> Result<(), Fault> {
    if limit.admits(value) { Ok(()) } else { Err(Fault { field, value, limit, because: None }) }
}

/// Refuses what is not between two ends, given in a unit.
///
/// # Errors
/// The field, the value and the limits.
pub(crate) fn within(
    field: &'static str,
    value: f64,
    (least, most): (f64, f64),
    unit: &'static str,
) -> Result<(), Fault> {
    check(field, value, Limit::Within(least, most, unit))
}

/// Refuses what is not above 0.
///
/// # Errors
/// The field, the value and the limit.
pub(crate) fn positive(field: &'static str, value: f64) -> Result<(), Fault> {
    check(field, value, Limit::Above(0.0))
}

/// Refuses what is below 0.
///
/// # Errors
/// The field, the value and the limit.
pub(crate) fn not_negative(field: &'static str, value: f64) -> Result<(), Fault> {
    check(field, value, Limit::Least(0.0))
}

#[cfg(test)]
mod tests {
    use super::{Fault, Limit, check, not_negative, positive, within};

    #[test]
    fn it_names_field_value_and_limit() {
        let text = |r: Result<(), Fault>| r.unwrap_err().to_string();
        assert_eq!(text(positive("mass", 0.0)), "`mass` is 0, but must be above 0");
        assert_eq!(text(positive("mass", -1e-300)), "`mass` is -1e-300, but must be above 0");
        assert_eq!(
            text(within("volts", 1e300, (1e-9, 1e6), "V")),
            "`volts` is 1e300, but must be within 1e-9 and 1000000 V"
        );
        assert_eq!(text(not_negative("inductance", -0.5)), "`inductance` is -0.5, but must be at least 0");
        assert_eq!(
            text(check("volts", f64::INFINITY, Limit::Least(1.0))),
            "`volts` is inf, but must be at least 1, and finite"
        );
        let fault = Fault::because("amperes", 2.0, Limit::Most(1.0), "that is what the amplifier gives");
        assert_eq!(
            fault.to_string(),
            "`amperes` is 2, but must be at most 1: that is what the amplifier gives"
        );
        assert_eq!(
            text(within("rate", f64::NAN, (1.0, 1e8), "steps a second")),
            "`rate` is NaN, but must be within 1 and 100000000 steps a second"
        );
        assert!(within("rate", 1.0, (1.0, 2.0), "").is_ok() && within("rate", 2.0, (1.0, 2.0), "").is_ok());
        let fault = Fault::because("preload", f64::NAN, Limit::Absent, "there is no skin");
        assert_eq!(fault.to_string(), "`preload` is NaN, but must be left out: there is no skin");
    }

    /// Who writes what is told is admitted.
    #[test]
    fn limits_have_four_digits_and_hold() {
        for limit in [
            19.554_089_080_311_243,
            2.960_555_555_5e-4,
            3.331_900_01e-7,
            555_555_555.555_5,
            9.999_994e3,
            -1.234_567_8,
        ] {
            for (of, word) in [
                (Limit::Above as fn(f64) -> Limit, "above "),
                (Limit::Least, "at least "),
                (Limit::Below, "below "),
                (Limit::Most, "at most "),
            ] {
                let told = Fault::because("x", f64::NAN, of(limit), "in V").to_string();
                let number = told.split_once(word).unwrap().1.split_once(',').unwrap().0;
                let number: f64 = number.parse().unwrap();
                assert!(check("x", number, of(limit)).is_ok(), "{told}");
                assert!((number / limit - 1.0).abs() < 1.1e-3, "{told}");
            }
        }
        let told = |limit| Fault::because("x", 1.0, Limit::Above(limit), "in kg").to_string();
        assert_eq!(told(0.000_296_055_555_555), "`x` is 1, but must be above 0.0002961: in kg");
        // What needs no more is told as it is.
        assert_eq!(told(0.001_5), "`x` is 1, but must be above 0.0015: in kg");
        assert_eq!(told(123_456.0), "`x` is 1, but must be above 123456: in kg");
    }

    #[test]
    fn what_is_not_a_number_keeps_to_no_limit() {
        for limit in [Limit::Above(0.0), Limit::Least(0.0), Limit::Below(0.0), Limit::Most(0.0)] {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert!(check("x", value, limit).is_err());
            }
        }
        assert!(positive("x", f64::MIN_POSITIVE).is_ok() && not_negative("x", 0.0).is_ok());
        assert!(check("x", 1.0, Limit::Below(1.0)).is_err() && check("x", 1.0, Limit::Most(1.0)).is_ok());
    }
}
