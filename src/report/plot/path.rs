//! Paths of SVG, as short as they can be written.

use std::fmt::Write;

/// A path in steps of a tenth of a pixel, written relative, with straight runs joined.
#[derive(Debug, Clone, Default)]
pub(in crate::report) struct Path {
    points: Vec<(i64, i64)>,
    /// Finished parts, each closed.
    done: String,
}

impl Path {
    /// Adds a point; a point that continues a level run moves the run's end.
    pub fn to(&mut self, x: f64, y: f64) {
        let (x, y) = (tenths(x), tenths(y));
        match self.points.as_slice() {
            [.., last] if *last == (x, y) => return,
            [.., (x0, y0), (x1, y1)] if *y0 == y && *y1 == y && (x - x1).signum() == (x1 - x0).signum() => {
                self.points.pop();
            }
            _ => {}
        }
        self.points.push((x, y));
    }

    /// Adds a closed shape.
    pub fn append(&mut self, shape: Self) {
        self.done.push_str(&shape.closed());
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty() && self.done.is_empty()
    }

    /// The value of a `d` attribute, closed.
    pub fn closed(&self) -> String {
        let mut data = self.data();
        if !self.points.is_empty() {
            data.push('z');
        }
        data
    }

    /// The value of a `d` attribute, its own points not closed.
    pub fn data(&self) -> String {
        let mut data = self.done.clone();
        let mut last = None;
        let mut letter = ' ';
        for &(x, y) in &self.points {
            let Some((x0, y0)) = last.replace((x, y)) else {
                data.push('M');
                push_tenths(&mut data, x, false);
                push_tenths(&mut data, y, true);
                continue;
            };
            let (dx, dy) = (x - x0, y - y0);
            let command = match (dx, dy) {
                (_, 0) => 'h',
                (0, _) => 'v',
                _ => 'l',
            };
            let fresh = command != letter;
            if fresh {
                data.push(command);
                letter = command;
            }
            match command {
                'h' => push_tenths(&mut data, dx, !fresh),
                'v' => push_tenths(&mut data, dy, !fresh),
                _ => {
                    push_tenths(&mut data, dx, !fresh);
                    push_tenths(&mut data, dy, true);
                }
            }
        }
        data
    }
}

/// Appends a number of tenths as short as SVG allows, parted from a number before it where it must be.
fn push_tenths(data: &mut String, tenths: i64, after_number: bool) {
    if after_number && tenths >= 0 {
        data.push(' ');
    }
    let (whole, tenth) = (tenths.unsigned_abs() / 10, tenths.unsigned_abs() % 10);
    if tenths < 0 {
        data.push('-');
    }
    let _ = match (whole, tenth) {
        (whole, 0) => write!(data, "{whole}"),
        (0, tenth) => write!(data, ".{tenth}"),
        (whole, tenth) => write!(data, "{whole}.{tenth}"),
    };
}

/// A coordinate in tenths of a pixel; what is not finite lies at 0.
fn tenths(x: f64) -> i64 {
    if x.is_finite() { (x.clamp(-1e6, 1e6) * 10.0).round() as i64 } else { 0 }
}

/// A coordinate as text, to a tenth.
pub(in crate::report) fn number(x: f64) -> String {
    let mut text = String::new();
    push_tenths(&mut text, tenths(x), false);
    text
}

#[cfg(test)]
mod tests {
    use super::{Path, number};

    #[test]
    fn numbers_are_short() {
        let cases = [(0.0, "0"), (-0.01, "0"), (0.5, ".5"), (-0.25, "-.3"), (12.0, "12"), (-7.12, "-7.1")];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
        assert_eq!(number(f64::NAN), "0");
        assert_eq!(number(f64::INFINITY), "0");
    }

    #[test]
    fn a_path_is_relative_and_joins_level_runs() {
        let mut path = Path::default();
        for (x, y) in [(1.0, 2.0), (2.0, 2.0), (3.0, 2.0), (4.0, 2.5), (5.0, 2.0), (5.0, 2.0), (5.0, 7.0)] {
            path.to(x, y);
        }
        assert_eq!(path.data(), "M1 2h2l1 .5 1-.5v5");
    }

    #[test]
    fn a_run_that_turns_back_keeps_its_turning_point() {
        let mut path = Path::default();
        for x in [0.0, 5.0, 2.0] {
            path.to(x, 0.0);
        }
        assert_eq!(path.data(), "M0 0h5-3");
    }

    #[test]
    fn shapes_are_closed_and_stand_apart() {
        let mut all = Path::default();
        for x in [0.0, 10.0] {
            let mut shape = Path::default();
            [(x, 0.0), (x + 1.0, 2.0), (x, 2.0)].iter().for_each(|(x, y)| shape.to(*x, *y));
            all.append(shape);
        }
        assert_eq!(all.closed(), "M0 0l1 2h-1zM10 0l1 2h-1z");
        assert!(!all.is_empty() && Path::default().closed().is_empty());
    }
}
