//! What is wrong with a table of a calibration.

use std::fmt;

/// Why a table is refused. Points count from 0; `Display` counts them from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// So many points, of which there must be two: between them, and nowhere else, is something known.
    FewPoints(usize),
    /// So many points, which are too many.
    ManyPoints(usize),
    /// The frequency of a point that cannot be: Hz.
    Frequency(usize, f64),
    /// The output of a point that cannot be: metres, metres a second, or metres a second squared.
    Output(usize, f64),
    /// A frequency that is not above the one before it: the point, that frequency, and the one before, Hz.
    Order(usize, f64, f64),
}

/// The most points of a table.
pub const MOST_POINTS: usize = 4096;

/// Frequencies of a table, Hz.
pub const HERTZ: [f64; 2] = [1.0, 5000.0];

/// Outputs of a table, in SI units.
pub const OUTPUT: [f64; 2] = [1e-12, 1e6];

impl Fault {
    /// The point that is wrong, from 0; `None`: the table as a whole.
    pub fn point(&self) -> Option<usize> {
        match self {
            Self::FewPoints(_) | Self::ManyPoints(_) => None,
            Self::Frequency(n, _) | Self::Output(n, _) | Self::Order(n, ..) => Some(*n),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::FewPoints(0) => {
                write!(f, "a table without points says nothing: give two or more, [Hz, output]")
            }
            Self::FewPoints(count) => write!(
                f,
                "a table of {count} point says nothing of other frequencies, as nothing is extrapolated: give two or more, [Hz, output]"
            ),
            Self::ManyPoints(count) => write!(f, "a table has {count} points; {MOST_POINTS} are the most"),
            Self::Frequency(n, hertz) => {
                let [least, most] = HERTZ;
                write!(f, "point {}: {hertz} Hz is no frequency from {least} to {most} Hz", n + 1)
            }
            Self::Output(n, output) => {
                let [least, most] = OUTPUT;
                write!(
                    f,
                    "point {}: {output:e} in SI units is no output from {least:e} to {most:e}: give an amplitude above 0, and check the `unit`",
                    n + 1
                )
            }
            Self::Order(n, hertz, before) if hertz == before => {
                write!(f, "point {}: {hertz} Hz stands there twice: keep one of them", n + 1)
            }
            Self::Order(n, hertz, before) => {
                write!(f, "point {}: {hertz} Hz comes after {before} Hz: sort the points by frequency", n + 1)
            }
        }
    }
}

impl std::error::Error for Fault {}
