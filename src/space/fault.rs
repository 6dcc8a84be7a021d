//! What cannot be, where, and what to do about it.

use super::point::Point;
use std::fmt;

/// Why an array, a path, a stroke or a layout is refused. `Display` says what it was, where, and what to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// A word that names no law.
    Law(String),
    /// An array without a tactor.
    NoTactor,
    /// More tactors than [`MOST_TACTORS`](super::array::MOST_TACTORS).
    TooMany(usize),
    /// A position of an array, counted from 0, that is not finite or beyond [`FARTHEST`](super::array::FARTHEST).
    Position(usize, Point),
    /// A path with fewer than two points: how many it has.
    FewPoints(usize),
    /// A point of a path, counted from 0, that is not finite or beyond [`FARTHEST`](super::array::FARTHEST).
    PathPoint(usize, Point),
    /// A path whose points are all at one place.
    NoLength(Point),
    /// A path that takes no time, or a time that is no number: its seconds.
    NoTime(f64),
    /// A path with another number of times than points: times, points.
    Times(usize, usize),
    /// A time of a path, counted from 0, that is not after the one before it: its number, the time, and the least it may be.
    TimeOrder(usize, f64, f64),
    /// A stroke that is over before its second burst may begin: its seconds, and what it must be longer than.
    TooFast(f64, f64),
    /// Motion over so many places in so many seconds, which takes at least so many.
    TooShort(usize, f64, f64),
    /// An illusion of motion over fewer than two places.
    FewPlaces(usize),
    /// An illusion of motion of too many bursts: how many, and how many it may have.
    TooManyBursts(usize, usize),
    /// Two tactors of a layout at one place: their numbers, counted from 0, and the place.
    OnePlace(usize, usize, Point),
    /// A quantity outside its range: its name, what it was, the least and the most it may be.
    Range(&'static str, f64, f64, f64),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let far = super::array::FARTHEST;
        match self {
            Self::Law(name) => {
                write!(f, "`{name}` is no law of sharing: write nearest, linear, logarithmic or energy")
            }
            Self::NoTactor => write!(f, "no tactor has a position: give at least one"),
            Self::TooMany(count) => {
                write!(
                    f,
                    "an array has {count} tactors, but may have {}: split it",
                    super::array::MOST_TACTORS
                )
            }
            Self::Position(index, point) => write!(
                f,
                "the position {} of tactor {} must be three numbers within ±{far} metres",
                Shown(*point),
                index + 1
            ),
            Self::FewPoints(count) => {
                let points = if *count == 1 { "point" } else { "points" };
                write!(f, "a path has {count} {points}, but needs two: for a place that stays, give a point")
            }
            Self::PathPoint(index, point) => write!(
                f,
                "point {} of a path, {}, must be three numbers within ±{far} metres",
                index + 1,
                Shown(*point)
            ),
            Self::NoLength(point) => write!(
                f,
                "every point of a path lies at {}: for a place that stays, give a point",
                Shown(*point)
            ),
            Self::NoTime(seconds) => {
                write!(f, "a path takes {} s, but must take more than 0", Number(*seconds))
            }
            Self::Times(times, points) => {
                write!(f, "a path of {points} points has {times} times: give each point one")
            }
            Self::TimeOrder(index, time, least) => write!(
                f,
                "time {} of a path is {} s, but must be {} {}: times rise from point to point",
                index + 1,
                Number(*time),
                if *index == 0 { "at least" } else { "above" },
                Number(*least)
            ),
            Self::TooFast(seconds, least) => write!(
                f,
                "a stroke of {:.1} ms is over before its second burst may begin: let it last more than {:.1} ms",
                seconds * 1e3,
                least * 1e3
            ),
            Self::TooShort(places, seconds, least) => write!(
                f,
                "bursts at {places} places one after another take at least {:.1} ms, but have {:.1} ms: let it last longer, or \
                 take fewer places",
                // Rounded up, so that what is told is enough.
                (least * 1e4).ceil() / 10.0,
                seconds * 1e3
            ),
            Self::FewPlaces(count) => write!(f, "motion needs two places or more, but has {count}: add one"),
            Self::OnePlace(one, other, point) => write!(
                f,
                "tactors {} and {} would both be at {}, to a tenth of a millimetre: set them farther apart",
                one + 1,
                other + 1,
                Shown(*point)
            ),
            Self::TooManyBursts(count, most) => {
                write!(f, "one event of {count} bursts: it may have {most}; make several events of it")
            }
            Self::Range(name, value, least, most) => {
                write!(f, "`{name}` is {}, but must be within {least} and {most}", Number(*value))
            }
        }
    }
}

impl std::error::Error for Fault {}

/// A number that can be read, however large or small.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-6..1e9).contains(&size) || !size.is_finite() {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// A point as a file has it.
struct Shown(Point);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "[{}, {}, {}]", Number(x), Number(y), Number(z))
    }
}

/// An illusion of motion has no more bursts: at 50 ms from one to the next they are felt for three minutes.
pub const MOST_BURSTS: usize = 4096;

/// Refuses an illusion of more bursts.
///
/// # Errors
/// How many, and how many it may have.
pub(super) fn bursts(count: usize) -> Result<(), Fault> {
    if count <= MOST_BURSTS { Ok(()) } else { Err(Fault::TooManyBursts(count, MOST_BURSTS)) }
}

/// Refuses what is outside a range, or no number.
///
/// # Errors
/// Name, value and range.
pub(super) fn within(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), Fault> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(Fault::Range(name, value, least, most)) }
}

#[cfg(test)]
mod tests {
    use super::{Fault, within};

    #[test]
    fn it_says_what_where_and_what_to_do() {
        assert_eq!(
            Fault::Position(2, [0.0, f64::NAN, 1.5]).to_string(),
            "the position [0, NaN, 1.5] of tactor 3 must be three numbers within ±1000000 metres"
        );
        assert_eq!(
            Fault::TimeOrder(1, 0.5, 0.5).to_string(),
            "time 2 of a path is 0.5 s, but must be above 0.5: times rise from point to point"
        );
        assert_eq!(
            Fault::TooFast(0.04, 0.0473).to_string(),
            "a stroke of 40.0 ms is over before its second burst may begin: let it last more than 47.3 ms"
        );
        let text = within("spacing", f64::NAN, 0.001, 1.0).unwrap_err().to_string();
        assert_eq!(text, "`spacing` is NaN, but must be within 0.001 and 1");
        let tiny = Fault::TimeOrder(1, 5e-324, 1e300).to_string();
        assert!(tiny.starts_with("time 2 of a path is 5e-324 s, but must be above 1e300"), "{tiny}");
        assert!(within("x", 0.0, 0.0, 1.0).is_ok() && within("x", 1.0, 0.0, 1.0).is_ok());
        assert!(within("x", -1e-9, 0.0, 1.0).is_err() && within("x", f64::INFINITY, 0.0, 1.0).is_err());
    }
}
