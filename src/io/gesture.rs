//! What a hand does to a simulated knob, from a table: comma-separated values.
//!
//! The first line names the columns: `time` (s, rising), and one or both of `hand_angle` (rad: where the hand holds the knob; straight lines
//! between rows) and `hand_torque` (N m: how it pushes; held from row to row). `angle` and `torque` say the same where the others are not
//! there. An empty cell goes on as before. What `pacinian knob --csv` writes can be read back.

use super::error::{FileError, FileErrorKind};
use super::open::open;
use std::path::Path;

/// Rows of a table, at most.
pub const MOST_ROWS: usize = 1 << 22;

/// The most bytes of a row, and of comments before it.
const LONGEST: usize = 1 << 20;
/// The largest angle (rad) and torque (N m) of a hand.
pub const MOST: [f64; 2] = [1e4, 1e3];

/// A gesture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gesture {
    /// Seconds and angle (rad), times rising.
    pub angles: Vec<(f64, f64)>,
    /// Seconds and torque (N m), times rising.
    pub torques: Vec<(f64, f64)>,
    /// Seconds until its last row.
    pub seconds: f64,
}

impl Gesture {
    /// Reads the table at `path`.
    ///
    /// # Errors
    /// One that cannot be opened; with its line, what is no table of such columns, a time that does not rise, a number beyond [`MOST`] or
    /// that is none, more than [`MOST_ROWS`] rows.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        Self::read(open(path)?).map_err(|(line, what)| {
            let at = if line == 0 { String::new() } else { format!(", line {line}") };
            let message = format!("`{}`{at}: {what}", path.display());
            FileError::new(FileErrorKind::Malformed, message)
        })
    }

    /// Reads a table; what is wrong comes with its line, from 1.
    ///
    /// # Errors
    /// As [`Gesture::open`].
    pub fn read(from: impl std::io::Read) -> Result<Self, (u64, String)> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .flexible(true)
            .from_reader(Bounded { from, since: 0 });
        let headers = reader.headers().map_err(|error| (1, told(&error)))?.clone();
        let column = |names: [&str; 2]| {
            names.iter().find_map(|name| headers.iter().position(|header| header == *name))
        };
        let Some(time) = headers.iter().position(|header| header == "time") else {
            let found: Vec<&str> = headers.iter().collect();
            return Err((
                1,
                format!(
                    "no column `time` among {}: the first line names time, hand_angle, hand_torque",
                    found.join(", ")
                ),
            ));
        };
        let columns = [column(["hand_angle", "angle"]), column(["hand_torque", "torque"])];
        // What a knob did is no gesture of the hand.
        let columns = match columns {
            [Some(a), t]
                if headers.get(a) == Some("hand_angle")
                    && t.and_then(|t| headers.get(t)) == Some("torque") =>
            {
                [Some(a), None]
            }
            [a, Some(t)]
                if headers.get(t) == Some("hand_torque")
                    && a.and_then(|a| headers.get(a)) == Some("angle") =>
            {
                [None, Some(t)]
            }
            columns => columns,
        };
        if columns == [None, None] {
            return Err((1, "neither a column `hand_angle` (rad) nor `hand_torque` (N m)".into()));
        }
        let mut gesture = Self::default();
        let mut last = f64::NEG_INFINITY;
        let mut record = csv::StringRecord::new();
        let mut rows = 0;
        while reader.read_record(&mut record).map_err(|error| (line(&error), told(&error)))? {
            let at = record.position().map_or(0, csv::Position::line);
            reader.get_mut().since = 0;
            rows += 1;
            if rows > MOST_ROWS {
                return Err((at, format!("more than {MOST_ROWS} rows")));
            }
            let number = |column: usize| -> Result<Option<f64>, (u64, String)> {
                let Some(cell) = record.get(column).filter(|cell| !cell.is_empty()) else { return Ok(None) };
                cell.parse().map(Some).map_err(|_| (at, format!("`{cell}` is no number")))
            };
            let Some(seconds) = number(time)? else { return Err((at, "no time".into())) };
            if !(0.0..=1e6).contains(&seconds) {
                return Err((at, format!("a time of {seconds} s; it must be within 0 and 1e6 s")));
            }
            if seconds <= last {
                return Err((at, format!("{seconds} s comes after {last} s: times must rise")));
            }
            last = seconds;
            for (k, (column, list)) in
                columns.iter().zip([&mut gesture.angles, &mut gesture.torques]).enumerate()
            {
                let Some(value) = column.map_or(Ok(None), number)? else { continue };
                if value.is_nan() || value.abs() > MOST[k] {
                    let unit = ["rad", "N m"][k];
                    return Err((at, format!("{value} {unit}; it must be within ±{} {unit}", MOST[k])));
                }
                list.push((seconds, value));
            }
        }
        if rows == 0 {
            return Err((0, "no rows under the names of the columns".into()));
        }
        gesture.seconds = last;
        Ok(gesture)
    }
}

/// What is read, as long as no row of it is longer than [`LONGEST`].
struct Bounded<R> {
    from: R,
    /// Bytes since the last row.
    since: usize,
}

impl<R: std::io::Read> std::io::Read for Bounded<R> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        if self.since > LONGEST {
            return Err(std::io::Error::other(format!(
                "a row, or what stands before it, has more than {LONGEST} bytes"
            )));
        }
        let read = self.from.read(to)?;
        self.since += read;
        Ok(read)
    }
}

fn line(error: &csv::Error) -> u64 {
    error.position().map_or(0, csv::Position::line)
}

fn told(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "it is no text in UTF-8".into(),
        csv::ErrorKind::Io(error) => error.to_string(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Gesture, LONGEST};

    /// Bytes that are made as they are read.
    struct Bytes<I>(I);

    impl<I: Iterator<Item = u8>> std::io::Read for Bytes<I> {
        fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
            Ok(to.iter_mut().zip(&mut self.0).map(|(slot, byte)| *slot = byte).count())
        }
    }

    fn read(text: &str) -> Result<Gesture, (u64, String)> {
        Gesture::read(text.as_bytes())
    }

    #[test]
    fn columns_go_by_their_names_and_empty_cells_go_on() {
        let gesture =
            read("# made by hand\ntime, hand_torque, hand_angle\n0, 0.01, 0\n0.5,, 1\n1, -0.02,\n").unwrap();
        assert_eq!(gesture.angles, [(0.0, 0.0), (0.5, 1.0)]);
        assert_eq!(gesture.torques, [(0.0, 0.01), (1.0, -0.02)]);
        assert_eq!(gesture.seconds, 1.0);
        assert_eq!(read("time,angle\n0.25,3\n").unwrap().angles, [(0.25, 3.0)]);
    }

    #[test]
    fn what_a_knob_did_is_not_what_its_hand_did() {
        let gesture = read("time,angle,torque,hand_angle\n0,9,9,1\n").unwrap();
        assert_eq!((gesture.angles, gesture.torques), (vec![(0.0, 1.0)], vec![]));
        let gesture = read("time,angle,torque,hand_torque\n0,9,9,1\n").unwrap();
        assert_eq!((gesture.angles, gesture.torques), (vec![], vec![(0.0, 1.0)]));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, line, what) in [
            ("", 1, "no column `time`"),
            ("time\n0\n", 1, "neither"),
            ("when,angle\n0,1\n", 1, "no column `time` among when, angle"),
            ("time,angle\n", 0, "no rows"),
            ("time,angle\n0,1\n0,2\n", 3, "times must rise"),
            ("time,angle\n0,1\n-1,2\n", 3, "within 0"),
            ("time,angle\n0,x\n", 2, "`x` is no number"),
            ("time,angle\n0,nan\n", 2, "within ±10000 rad"),
            ("time,torque\n0,1e9\n", 2, "within ±1000 N m"),
            ("time,angle\n,1\n", 2, "no time"),
            ("time,angle\nnan,1\n", 2, "within 0"),
        ] {
            let (at, told) = read(text).unwrap_err();
            assert!(at == line && told.contains(what), "{text:?}: {at} {told}");
        }
        assert!(Gesture::read(&b"time,angle\n0,\xff\n"[..]).unwrap_err().1.contains("UTF-8"));
        // Neither a row without end nor a text in quotes, and a long table all the same.
        let endless = |begin: &'static str| begin.bytes().chain(std::iter::repeat(b'1')).take(1 << 30);
        for begin in ["", "time,angle\n0,", "time,angle\n0,\"1\n", "time,angle\n# "] {
            let told = Gesture::read(Bytes(endless(begin))).unwrap_err().1;
            assert!(told.contains(&format!("more than {LONGEST} bytes")), "{begin}: {told}");
        }
        let long: String = (0..200_000).map(|n| format!("{n},1\n")).collect();
        assert_eq!(read(&format!("time,angle\n{long}")).unwrap().angles.len(), 200_000);
    }
}
