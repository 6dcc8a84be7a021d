//! The record of a run as SVG.

use super::column::Column;
use super::{Course, Event};
use crate::report::plot::axis::{short, whole};
use crate::report::plot::colour::Ink;
use crate::report::plot::panels::{Across, Form, Panel, Panels, Shape, span};

const LEFT: f64 = 108.0;
/// Widths of the panels over time and of the phase plot.
const WIDE: f64 = 640.0;
const PLANE: f64 = 330.0;
const BESIDE: f64 = 104.0;
const HIGH: f64 = 132.0;
const GAP: f64 = 20.0;
/// Height of a row of events.
const ROW: f64 = 16.0;
/// Kinds of events that have a row of their own; the others share one.
const KINDS: usize = 5;

/// A curve: what the key calls it, which quantity it is, and how it is drawn.
type Curve = (&'static str, usize, Ink, Form);

impl Course {
    /// The sheet as SVG, light, and dark where the reader prefers that: angle, speed, torque and energy over time, the phase plot, and
    /// marks of events. It has some hundred kilobytes at most, however long the run is. `title` is its first line.
    pub fn svg(&self, title: &str) -> String {
        let group = self.columns.len().div_ceil(WIDE as usize).max(1);
        let columns: Vec<Column> = self.columns.chunks(group).map(Column::joined).collect();
        let step = self.resolution() * group as f64;
        let seconds = [0.0, self.seconds().max(1.0 / self.rate)];
        let kind = |index| Ink::Kind { index };
        let line = Form::Line(1.4);
        let panels: [(&str, &[Curve], bool); 4] = [
            (
                "angle (rad)",
                &[("where the hand holds it", 6, kind(5), Form::Line(2.4)), ("angle", 0, kind(0), line)],
                false,
            ),
            (
                "speed (rad/s)",
                &[("speed as estimated", 2, kind(1), Form::Line(1.0)), ("speed", 1, kind(0), line)],
                true,
            ),
            (
                "torque (N m)",
                &[
                    ("torque asked", 3, kind(5), Form::Line(2.4)),
                    ("torque given", 4, kind(3), Form::Line(1.2)),
                ],
                true,
            ),
            ("energy (J)", &[("energy", 5, kind(2), line)], true),
        ];
        let (rows, more) = self.rows(seconds[1]);
        let events = ROW * (rows.len() as f64).max(1.0);
        let time = |label: &str| Across { label: label.into(), range: seconds, log: false, rows: Vec::new() };
        let mut drawn = Vec::new();
        let mut top = 4.0;
        let last = panels.len() - 1;
        for (n, (label, curves, zero)) in panels.into_iter().enumerate() {
            let values = curves.iter().flat_map(|curve| columns.iter().flat_map(|c| c.extremes[curve.1]));
            let range = span(values, if zero { &[0.0] } else { &[] });
            let of = |(name, quantity, ink, form): &Curve| Shape {
                name: (*name).into(),
                ink: *ink,
                form: *form,
                points: self.points(&columns, *quantity, step),
            };
            drawn.push(Panel {
                frame: [LEFT, top, WIDE, HIGH],
                x: time(if n == last && rows.is_empty() { "time (s)" } else { "" }),
                y: Across { label: label.into(), range, log: false, rows: Vec::new() },
                shapes: curves.iter().map(of).collect(),
            });
            top += HIGH + GAP;
        }
        if !rows.is_empty() {
            let names = rows.iter().enumerate().map(|(n, (name, ..))| (-(n as f64), name.clone())).collect();
            let ticks = rows.iter().enumerate().map(|(n, (_, times, _))| Shape {
                name: String::new(),
                ink: kind(n % 6),
                form: Form::Ticks,
                points: times.iter().map(|t| (*t, -(n as f64))).collect(),
            });
            drawn.push(Panel {
                frame: [LEFT, top, WIDE, events],
                x: time("time (s)"),
                y: Across {
                    label: String::new(),
                    range: [0.5 - rows.len() as f64, 0.5],
                    log: false,
                    rows: names,
                },
                shapes: ticks.collect(),
            });
        }
        drawn.push(self.plane(&columns, kind(0)));
        Panels {
            title: title.into(),
            about: vec![self.about(step)],
            panels: drawn,
            notes: self.notes(&rows, more),
            width: LEFT + WIDE + BESIDE + PLANE + 28.0,
        }
        .svg()
    }

    /// Both extremes of each column where they lie within a pixel of each other, one where they are the same.
    fn points(&self, columns: &[Column], quantity: usize, step: f64) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for (n, column) in columns.iter().enumerate() {
            let time = n as f64 * step;
            let [first, second] = column.ends(quantity);
            if !(first.is_finite() && second.is_finite()) {
                points.push((f64::NAN, f64::NAN));
            } else if first == second {
                points.push((time, first));
            } else {
                points.extend([(time, first), (time + 0.5 * step, second)]);
            }
        }
        points
    }

    fn plane(&self, columns: &[Column], ink: Ink) -> Panel {
        let way: Vec<(f64, f64)> = columns.iter().flat_map(Column::way).collect();
        let axis = |label: &str, range| Across { label: label.into(), range, log: false, rows: Vec::new() };
        let shape = |name: &str, form, points| Shape { name: name.into(), ink, form, points };
        let ends = [way.first(), way.last()].map(|end| end.copied().into_iter().collect::<Vec<_>>());
        let [begins, stops] = ends;
        Panel {
            frame: [LEFT + WIDE + BESIDE, 4.0, PLANE, PLANE],
            x: axis("angle (rad)", span(way.iter().map(|p| p.0), &[])),
            y: axis("speed (rad/s)", span(way.iter().map(|p| p.1), &[0.0])),
            shapes: vec![
                shape("", Form::Line(1.1), way),
                Shape { ink: Ink::Dim, ..shape("begins here", Form::Marks(1), begins) },
                Shape { ink: Ink::Text, ..shape("ends here", Form::Marks(0), stops) },
            ],
        }
    }

    /// Rows of events: a name, times of which no two share a pixel, and how many there were; and events beyond the run.
    fn rows(&self, seconds: f64) -> (Vec<(String, Vec<f64>, usize)>, usize) {
        let mut rows: Vec<(String, Vec<f64>, usize)> = Vec::new();
        let within = |e: &&Event| (0.0..=seconds).contains(&e.time);
        for event in self.events.iter().filter(within) {
            let known = rows.iter().position(|(name, ..)| name == event.kind);
            let row = known.unwrap_or_else(|| {
                if rows.len() <= KINDS {
                    let name = if rows.len() < KINDS { event.kind } else { "others" };
                    rows.push((name.to_string(), Vec::new(), 0));
                }
                rows.len() - 1
            });
            rows[row].1.push(event.time);
            rows[row].2 += 1;
        }
        for (_, times, _) in &mut rows {
            times.sort_by(f64::total_cmp);
            let pixel = |t: f64| (t / seconds * WIDE).floor();
            times.dedup_by(|a, b| pixel(*a) == pixel(*b));
        }
        (rows, self.events.len() - self.events.iter().filter(within).count())
    }

    fn about(&self, step: f64) -> String {
        let mut about = format!("{} s, {} samples a second", short(self.seconds()), whole(self.rate));
        if step * self.rate > 1.5 {
            about +=
                &format!("; a point stands for {} s, with the least and the greatest in it", short(step));
        }
        about
    }

    fn notes(&self, rows: &[(String, Vec<f64>, usize)], beyond: usize) -> Vec<(String, bool)> {
        let mut notes = Vec::new();
        if !rows.is_empty() {
            let counts: Vec<String> = rows.iter().map(|(name, _, count)| format!("{name} {count}")).collect();
            notes.push((format!("Events: {}.", counts.join(", ")), false));
        }
        for (count, what) in [
            (self.unsound, "Values that were no numbers, and are left out"),
            (self.lost, "Events of which only the count was kept"),
            (beyond as u64, "Events beyond the run"),
        ] {
            if count > 0 {
                notes.push((format!("{what}: {count}."), true));
            }
        }
        notes
    }
}
