//! Courses and corners as the command line says them.

use pacinian::actuator::link::coupling::Corners;
use pacinian::actuator::motor::Drive;
use pacinian::actuator::shape::Course;
use std::str::FromStr;

/// A course: `SECONDS:VOLTS`, or amperes, separated by commas, and what follows for good.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    pieces: Vec<(f64, Piece)>,
    last: Piece,
}

/// What is done for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Piece {
    /// Volts or amperes, as is written behind it; as the amplifier imposes where nothing is.
    Number(f64, Option<Unit>),
    Open,
    Short,
}

/// What a number is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Volts,
    Amperes,
}

/// How units are written, the longer first, and how many of what each is.
const UNITS: [(&str, f64, Unit); 4] = [
    ("mV", 1e-3, Unit::Volts),
    ("mA", 1e-3, Unit::Amperes),
    ("V", 1.0, Unit::Volts),
    ("A", 1.0, Unit::Amperes),
];
const TIMES: [(&str, f64); 2] = [("ms", 1e-3), ("s", 1.0)];

/// Seconds of a course, at most; volts or amperes, at most.
const LONGEST: f64 = 10.0;
const MOST: f64 = 1e6;

impl FromStr for Piece {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let word = word.trim();
        match word {
            "open" => return Ok(Self::Open),
            "short" => return Ok(Self::Short),
            _ => {}
        }
        let with =
            UNITS.into_iter().find_map(|(unit, scale, of)| Some((word.strip_suffix(unit)?, scale, Some(of))));
        let (number, scale, unit) = with.unwrap_or((word, 1.0, None));
        let value = number.trim().parse::<f64>().ok().map(|value| value * scale);
        let value = value.filter(|value| value.abs() <= MOST).ok_or_else(|| {
            format!(
                "`{word}` is neither volts nor amperes (3, 3V, 100mA, within ±{MOST}), nor open, nor short"
            )
        })?;
        Ok(Self::Number(value, unit))
    }
}

impl FromStr for Written {
    type Err = String;

    fn from_str(words: &str) -> Result<Self, String> {
        let mut written = Self { pieces: Vec::new(), last: Piece::Short };
        let mut words = words.split(',').map(str::trim).peekable();
        let mut all = 0.0;
        while let Some(word) = words.next() {
            let Some((seconds, piece)) = word.split_once(':') else {
                if words.peek().is_some() || word.is_empty() {
                    return Err(format!(
                        "`{word}` does not say for how long: a piece is SECONDS:VOLTS, such as 0.02:3; only the last may do without"
                    ));
                }
                written.last = word.parse()?;
                break;
            };
            let seconds = seconds.trim();
            let with = TIMES.into_iter().find_map(|(unit, scale)| Some((seconds.strip_suffix(unit)?, scale)));
            let (number, scale) = with.unwrap_or((seconds, 1.0));
            let length = number.trim().parse::<f64>().ok().map(|length| length * scale);
            let Some(length) = length.filter(|length| *length > 0.0) else {
                return Err(format!("`{seconds}` of `{word}` is no time: it is in seconds, above 0"));
            };
            all += length;
            if all > LONGEST {
                return Err(format!("it lasts longer than {LONGEST} s"));
            }
            written.pieces.push((length, piece.parse()?));
        }
        Ok(written)
    }
}

impl Written {
    /// What is done to the terminals, by volts, or by amperes with so many volts at most.
    ///
    /// # Errors
    /// A number that is of the other one.
    pub fn course(&self, amperes: Option<f64>) -> Result<Course, String> {
        let drive = |piece: Piece| match (piece, amperes) {
            (Piece::Number(amperes, Some(Unit::Amperes)), None) => {
                Err(format!("the course has {amperes} A, and what drives the motor is a voltage"))
            }
            (Piece::Number(volts, Some(Unit::Volts)), Some(_)) => {
                Err(format!("the course has {volts} V, and the amplifier imposes a current"))
            }
            (Piece::Number(volts, _), None) => Ok(Drive::Voltage(volts)),
            (Piece::Number(amperes, _), Some(limit)) => Ok(Drive::Current { amperes, limit }),
            (Piece::Open, _) => Ok(Drive::Open),
            (Piece::Short, _) => Ok(Drive::SHORT),
        };
        let begin = Course::ending_in(drive(self.last)?);
        self.pieces
            .iter()
            .try_fold(begin, |course, (seconds, piece)| Ok(course.then(*seconds, drive(*piece)?)))
    }

    /// The largest number in it.
    pub fn most(&self) -> f64 {
        let all = self.pieces.iter().map(|(_, piece)| piece).chain([&self.last]);
        all.fold(0.0, |most, piece| if let Piece::Number(x, _) = piece { most.max(x.abs()) } else { most })
    }
}

/// Corners of one coupling: `10`, or `20+10` for two in series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Through(pub Corners);

impl FromStr for Through {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let corner = |word: &str| {
            let hertz = word.trim().trim_end_matches("Hz").trim().parse::<f64>();
            let hertz = hertz.ok().filter(|hertz| (1e-3..=1000.0).contains(hertz));
            hertz.ok_or_else(|| format!("`{}` is no corner: it is in Hz, from 0.001 to 1000", word.trim()))
        };
        match word.split('+').collect::<Vec<_>>()[..] {
            [one] => Ok(Self(Corners::one(corner(one)?))),
            [first, second] => Ok(Self(Corners::two(corner(first)?, corner(second)?))),
            _ => Err("at most two are in series: 20+10".into()),
        }
    }
}

/// "10 Hz", "20 and 10 Hz in series".
pub fn corners(corners: &Corners) -> String {
    match corners.hertz() {
        [first, second] => format!("{first} and {second} Hz in series"),
        [one] => format!("{one} Hz"),
        _ => "none".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Corners, Course, Drive, Through, Written};

    #[test]
    fn a_course_is_what_was_written() {
        let read = |words: &str| words.parse::<Written>().unwrap();
        let course = read("0.02:3, 0.01s:-3V , open").course(None).unwrap();
        let due =
            Course::ending_in(Drive::Open).then(0.02, Drive::Voltage(3.0)).then(0.01, Drive::Voltage(-3.0));
        assert_eq!(course, due);
        assert_eq!(read("0.02:short").course(None).unwrap().last(), Drive::SHORT);
        assert_eq!(read("0.1:open, 1.5").course(None).unwrap().last(), Drive::Voltage(1.5));
        assert_eq!(read("20ms:open, 1500mV").course(None), read("0.02 s:open, 1.5 V").course(None));
        let ampere = Drive::Current { amperes: 0.1, limit: 5.0 };
        for words in ["0.02:0.1", "0.02:0.1A", "0.02: 100 mA", "20 ms:0.1 A"] {
            assert_eq!(read(words).course(Some(5.0)).unwrap().pieces(), [(0.02, ampere)], "{words}");
        }
        assert_eq!(read("0.02:3, 0.01:-4.5").most(), 4.5);
        assert_eq!(read("0.02:300mA, 0.01:-0.2A").most(), 0.3);
    }

    /// Amperes are no volts, and volts no amperes, wherever in the course they stand.
    #[test]
    fn a_number_is_of_what_drives_the_motor() {
        for (words, amperes, why) in [
            ("0.02:3A", None, "3 A, and what drives the motor is a voltage"),
            ("0.02:3, 250mA", None, "0.25 A"),
            ("0.02:0.1, 0.01:-3V", Some(5.0), "-3 V, and the amplifier imposes a current"),
            ("2V", Some(5.0), "2 V"),
        ] {
            let said = words.parse::<Written>().unwrap().course(amperes).unwrap_err();
            assert!(said.contains(why), "{words}: {said}");
        }
    }

    #[test]
    fn what_is_no_course_says_which_piece() {
        for (words, why) in [
            ("3, 0.01:3", "`3` does not say for how long"),
            ("", "does not say for how long"),
            ("0.02:3,", "does not say for how long"),
            ("0.02:three", "`three` is neither volts"),
            ("0.02:nan", "`nan` is neither volts"),
            ("0.02:1e9", "`1e9` is neither volts"),
            ("0.02:3VA", "`3VA` is neither volts"),
            ("0.02:V", "`V` is neither volts"),
            ("0.02:3 ohm", "`3 ohm` is neither volts"),
            ("0.02sms:3", "`0.02sms` of `0.02sms:3` is no time"),
            ("-1:3", "`-1` of `-1:3` is no time"),
            ("nan:3", "is no time"),
            ("6:3,6:3", "longer than 10 s"),
        ] {
            let said = words.parse::<Written>().unwrap_err();
            assert!(said.contains(why), "{words}: {said}");
        }
    }

    #[test]
    fn corners_alone_and_in_series() {
        assert_eq!("10".parse(), Ok(Through(Corners::one(10.0))));
        assert_eq!("20 Hz + 10".parse(), Ok(Through(Corners::two(20.0, 10.0))));
        for word in ["0", "-3", "ten", "1+2+3", "nan", "1e4", ""] {
            assert!(word.parse::<Through>().is_err(), "{word}");
        }
    }
}
