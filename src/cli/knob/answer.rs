//! What a knob did that was turned.

use super::figures::{Figures, short};
use super::set_off::{Set, SetOff};
use crate::cli::paint::Paint;
use crate::cli::table::{Table, many};
use pacinian::engine::knob::tally::Tally;
use pacinian::knob::safety::chain::{Stage, Trip};
use serde::Serialize;
use std::collections::BTreeMap;

/// All of it.
#[derive(Debug, Serialize)]
pub struct Answer {
    patch: String,
    knob: Option<Figures>,
    seconds: f64,
    /// How often each trigger set off its voice.
    set_off: BTreeMap<String, usize>,
    /// Each of them, with its seconds.
    events: Vec<Set>,
    /// Of the knob, rad.
    least_angle: f64,
    most_angle: f64,
    /// rad/s.
    most_speed: f64,
    /// Root-mean-square error of the estimated speed, rad/s.
    speed_error: f64,
    /// N m.
    most_torque: f64,
    /// K above the air, of its winding, at most; null where nobody has said how it sheds its heat.
    winding_rise: Option<f64>,
    /// Joules that went into the virtual world, and that it gave more than it was given, at most.
    absorbed: f64,
    created: f64,
    /// In how many ticks each stage of the chain of safety acted.
    held_back: BTreeMap<&'static str, u64>,
    tripped: Option<&'static str>,
}

const STAGES: [(Stage, &str); 8] = [
    (Stage::NonFinite, "no number"),
    (Stage::Governor, "governor"),
    (Stage::Slew, "slew"),
    (Stage::Budget, "heat budget"),
    (Stage::Peak, "peak"),
    (Stage::Stale, "stale reading"),
    (Stage::OverSpeed, "over-speed"),
    (Stage::Latch, "latched"),
];

impl Answer {
    /// Of a knob of a patch: what it is; what it did, at so many samples a second; what it set off.
    pub fn new(patch: &str, knob: Option<Figures>, rate: f64, tally: &Tally, set_off: SetOff) -> Self {
        let [low, high] = if tally.samples > 0 { tally.angle } else { [0.0; 2] };
        let held = |stage: Stage| tally.stages[stage as usize];
        Self {
            patch: patch.into(),
            knob,
            seconds: tally.samples as f64 / rate,
            set_off: set_off.times,
            events: set_off.each.unwrap_or_default(),
            least_angle: low,
            most_angle: high,
            most_speed: tally.most_speed,
            speed_error: tally.speed_error(),
            most_torque: tally.most_torque,
            winding_rise: tally.most_warm,
            absorbed: tally.absorbed,
            created: -tally.least_absorbed,
            held_back: STAGES
                .iter()
                .map(|(stage, word)| (*word, held(*stage)))
                .filter(|(_, n)| *n > 0)
                .collect(),
            tripped: tally.trip.map(|trip| match trip {
                Trip::Reading => "the angle was no number",
                Trip::Lost => "readings failed",
                Trip::OverSpeed => "the knob was too fast",
                Trip::Panic => "somebody asked for it",
            }),
        }
    }

    /// For people.
    pub fn text(&self, paint: Paint) -> String {
        let mut figures = Table::default();
        self.knob.iter().for_each(|knob| knob.rows(&mut figures));
        let mut table = Table::default();
        let (least, most) = (self.least_angle, self.most_angle);
        table.row(["turned".into(), format!("{:.2} s, from {least:.2} to {most:.2} rad", self.seconds)]);
        let error = short(self.speed_error);
        table.row([
            "speed".into(),
            format!("{:.1} rad/s at most, estimated within {error} rad/s rms", self.most_speed),
        ]);
        table.row(["torque".into(), format!("{} N m at most", short(self.most_torque))]);
        if let Some(warm) = self.winding_rise {
            table.row(["winding".into(), format!("{} K warmer than the air at most", short(warm))]);
        }
        let created = match self.created > 0.0 {
            true => format!("; {} J more than it was given, at most", short(self.created)),
            false => String::new(),
        };
        table.row(["energy".into(), format!("{} J went into what is felt{created}", short(self.absorbed))]);
        for (n, (what, times)) in self.set_off.iter().enumerate() {
            let head = if n == 0 { "set off" } else { "" };
            table.row([head.to_string(), format!("{what}: {}", many(*times, "time"))]);
        }
        for (n, (stage, ticks)) in self.held_back.iter().enumerate() {
            let head = if n == 0 { "held back" } else { "" };
            table.row([head.to_string(), format!("{stage}: {}", many(*ticks as usize, "tick"))]);
        }
        if let Some(why) = self.tripped {
            table.row(["torque is off".to_string(), paint.red(why)]);
        }
        let (is, did) = (paint.bold("what it is"), paint.bold("what it did"));
        format!("{}\n\n{is}\n{}\n{did}\n{}", paint.bold(&self.patch), figures.text(), table.text())
    }
}
