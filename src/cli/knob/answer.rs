//! What a knob did that was turned.

use super::figures::{Figures, short};
use super::turn::{Set, Turned};
use crate::cli::load::Loaded;
use crate::cli::paint::Paint;
use crate::cli::table::{Table, many};
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
    /// Of a knob that was turned.
    pub fn new(loaded: &Loaded, turned: &Turned) -> Self {
        let knob = turned.player.knob();
        let chain = knob.map(|knob| knob.servo().chain());
        let figures = &turned.record.figures;
        let mut set_off = BTreeMap::new();
        for set in &turned.set_off {
            *set_off.entry(format!("{} plays {}", set.by, set.voice)).or_insert(0) += 1;
        }
        let held = |stage: Stage| chain.map_or(0, |chain| chain.count(stage));
        Self {
            patch: loaded.name().into(),
            knob: knob.and_then(|knob| Figures::new(turned.player.plan(), knob)),
            seconds: turned.record.seconds(),
            set_off,
            events: turned.set_off.clone(),
            least_angle: figures.angle[0],
            most_angle: figures.angle[1],
            most_speed: figures.most_speed,
            speed_error: figures.speed_error(),
            most_torque: figures.most_torque,
            winding_rise: figures.most_warm,
            absorbed: figures.absorbed,
            created: -figures.least_absorbed,
            held_back: STAGES
                .iter()
                .map(|(stage, word)| (*word, held(*stage)))
                .filter(|(_, n)| *n > 0)
                .collect(),
            tripped: chain.and_then(|chain| chain.trip()).map(|trip| match trip {
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
