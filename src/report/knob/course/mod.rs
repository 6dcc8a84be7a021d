//! What a knob's run was: angle, speed, torque, energy, and what happened, as long as it may be in a bounded size.
//!
//! Stretches of time hold the least and the greatest of each quantity and, for the phase plot, where angle and speed were at their ends; when
//! there are [`MOST_COLUMNS`] of them, two become one. So an hour at 48 kHz takes as much room as a second, nothing that
//! stuck out is lost, and the picture is the same however the run was cut.
//!
//! ```
//! use pacinian::report::knob::course::{Course, Sample};
//!
//! let mut course = Course::new(1000.0);
//! for n in 0..2000 {
//!     let (sin, cos) = (f64::from(n) * 0.01).sin_cos();
//!     course.push(&Sample { angle: sin, speed: 10.0 * cos, ..Sample::default() });
//! }
//! course.event(0.5, "detent");
//! assert!(course.svg("A swing").contains("angle (rad)"));
//! assert!(course.csv().starts_with("time_s,"));
//! ```

mod column;
mod picture;
#[cfg(test)]
mod tests;

use std::fmt::Write;

use crate::knob::effect::events::What;
use column::Column;

/// Stretches of time that are kept at most.
pub const MOST_COLUMNS: usize = 4096;
/// Events that are kept at most; those beyond are counted.
pub const MOST_EVENTS: usize = 16_384;

/// What is recorded of a tick. What is not a number is left out.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Angle, rad.
    pub angle: f64,
    /// Speed, rad/s.
    pub speed: f64,
    /// Speed as it was estimated, rad/s.
    pub estimated: f64,
    /// Torque that effects asked for, N m.
    pub asked: f64,
    /// Torque that the amplifier got, N m.
    pub given: f64,
    /// Energy, J: the plant's, or what passivity has booked.
    pub energy: f64,
    /// Where a hand holds it, rad; `None`: no hand does.
    pub hand: Option<f64>,
}

/// How many quantities there are.
const QUANTITIES: usize = 7;
/// Their names in CSV.
const NAMES: [&str; QUANTITIES] = [
    "angle_rad",
    "speed_rad_s",
    "estimated_speed_rad_s",
    "torque_asked_nm",
    "torque_given_nm",
    "energy_j",
    "hand_rad",
];

impl Sample {
    /// The line of names over [`Sample::line`]s, without its end.
    pub fn names() -> String {
        format!("time_s,{}", NAMES.join(","))
    }

    /// The sample as comma-separated values, without the line's end: for runs that are written as they go, in full. What is not a number
    /// is empty.
    pub fn line(&self, time: f64) -> String {
        let mut line = format!("{time}");
        for x in self.all() {
            let _ = if x.is_finite() { write!(line, ",{x}") } else { write!(line, ",") };
        }
        line
    }

    fn all(&self) -> [f64; QUANTITIES] {
        [
            self.angle,
            self.speed,
            self.estimated,
            self.asked,
            self.given,
            self.energy,
            self.hand.unwrap_or(f64::NAN),
        ]
    }
}

/// Something that happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// When, s.
    pub time: f64,
    /// What: "detent", "wall".
    pub kind: &'static str,
}

/// The name of what effects report.
pub fn kind(what: &What) -> &'static str {
    match what {
        What::Detent { .. } => "detent",
        What::Wall { .. } => "wall",
    }
}

/// The record of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    rate: f64,
    columns: Vec<Column>,
    /// Samples a column, and in the last one.
    each: u64,
    filled: u64,
    samples: u64,
    /// Values that were no numbers.
    unsound: u64,
    events: Vec<Event>,
    lost: u64,
}

impl Course {
    /// Of `rate` samples a second; what is not a number above 0 counts as 1.
    pub fn new(rate: f64) -> Self {
        let rate = if rate.is_finite() && rate > 0.0 { rate } else { 1.0 };
        Self {
            rate,
            columns: Vec::new(),
            each: 1,
            filled: 0,
            samples: 0,
            unsound: 0,
            events: Vec::new(),
            lost: 0,
        }
    }

    /// The next sample. The first is at 0 s.
    pub fn push(&mut self, sample: &Sample) {
        let values = sample.all();
        let unsound = values.iter().filter(|x| !x.is_finite()).count() as u64;
        // No hand is no fault.
        self.unsound += unsound - u64::from(sample.hand.is_none());
        self.samples += 1;
        match self.columns.last_mut() {
            Some(column) if self.filled < self.each => {
                column.take(&values);
                self.filled += 1;
                return;
            }
            _ => {}
        }
        if self.columns.len() == MOST_COLUMNS {
            self.columns = self.columns.chunks(2).map(Column::joined).collect();
            self.each = self.each.saturating_mul(2);
        }
        self.columns.push(Column::of(&values));
        self.filled = 1;
    }

    /// Something that happened at a time, s. Of times that are no numbers and events beyond [`MOST_EVENTS`] only the count is kept.
    pub fn event(&mut self, time: f64, kind: &'static str) {
        if time.is_finite() && self.events.len() < MOST_EVENTS {
            self.events.push(Event { time, kind });
        } else {
            self.lost += 1;
        }
    }

    /// How long it is, s.
    pub fn seconds(&self) -> f64 {
        self.samples as f64 / self.rate
    }

    /// What happened, as it came.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Events of which only the count was kept.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Seconds from column to column: a tick until there are more than [`MOST_COLUMNS`] of them.
    pub fn resolution(&self) -> f64 {
        self.each as f64 / self.rate
    }

    /// What was kept as comma-separated values: the time at which each stretch begins, and the least and the greatest of each quantity
    /// in it, which are the same as long as a stretch is a tick. What was no number is empty.
    pub fn csv(&self) -> String {
        let mut out = String::from("time_s");
        NAMES.iter().for_each(|name| _ = write!(out, ",{name}_least,{name}_greatest"));
        out.push('\n');
        for (n, column) in self.columns.iter().enumerate() {
            let _ = write!(out, "{}", n as f64 * self.resolution());
            for [least, most] in column.extremes {
                let _ = if least <= most { write!(out, ",{least},{most}") } else { write!(out, ",,") };
            }
            out.push('\n');
        }
        out
    }

    /// Events as comma-separated values: `time_s,kind`.
    pub fn events_csv(&self) -> String {
        let mut out = String::from("time_s,kind\n");
        self.events.iter().for_each(|event| _ = writeln!(out, "{},{}", event.time, event.kind));
        out
    }
}
