//! What an actuator did under a patch, as people read it.

use super::super::super::paint::Paint;
use super::super::super::table::{Table, hertz};
use super::super::shown::ms;
use super::super::subject::Subject;
use super::{Answer, Computed};
use pacinian::rig::Model;
use std::fmt::Write;

/// Names of voices told of a stretch, at most.
const VOICES: usize = 6;

impl Answer {
    /// All of it.
    pub fn text(&self, subject: &Subject, paint: Paint) -> String {
        let mut text = format!("{}: {}\n", paint.bold(&self.name), self.title);
        let mut table = Table::default();
        let assumed = match subject.known.assumed.as_slice() {
            [] => String::new(),
            assumed => format!("; nobody measured {}", assumed.join(", ")),
        };
        table.row(["model".into(), self.model.to_string()]);
        table.row(["figures".into(), format!("{}{assumed}", subject.known.text())]);
        self.computed.rows(&mut table);
        text += &table.text();
        for way in &self.ways {
            let shaped = way.shaping.map_or(String::new(), |shaping| format!(", levels shaped by {shaping}"));
            let _ = writeln!(
                text,
                "\n{} of {:.2} s{shaped}; sent {} later than these times, which are the patch's",
                paint.bold(&self.patch),
                way.seconds,
                ms(way.late)
            );
            let mut table = Table::default();
            let peak = format!("peak {}", self.unit);
            let heads =
                ["at", "lasts", "to 50 %", "to 90 %", &peak, "at", "stop", "error", "turns", "mJ in", ""];
            table.row(heads.map(|head| paint.dim(head)));
            let or_none = |value: Option<String>| value.unwrap_or_else(|| "-".into());
            let is_motor = subject.actuator.model == Model::RumbleMotor;
            for stretch in &way.stretches {
                table.row([
                    format!("{:.3} s", stretch.at),
                    ms(stretch.seconds),
                    or_none(stretch.rise_50.map(ms)),
                    or_none(stretch.rise_90.map(ms)),
                    format!("{:.3}", stretch.peak),
                    format!("{:.3} s", stretch.peak_at),
                    stretch.stop.map_or(if is_motor { "goes on" } else { "-" }.into(), ms),
                    or_none(stretch.error.map(|error| format!("{:.1} %", 100.0 * error))),
                    or_none(stretch.turns.map(|turns| format!("{turns:.2}"))),
                    or_none(stretch.energy.map(|energy| format!("{:.3}", 1e3 * energy))),
                    voices(&stretch.voices),
                ]);
            }
            text += &table.text();
        }
        text
    }
}

impl Computed {
    fn rows(&self, table: &mut Table) {
        let level = self.level.map_or("exactly".into(), |level| format!("at level {level}"));
        let steps = if self.steps == 1 { String::new() } else { format!(", {} steps a sample", self.steps) };
        let error = self.wished_error;
        table.row([
            "computed".into(),
            format!("{level}, {}{steps}, for an error of {error:e} of what is felt", hertz(self.rate)),
        ]);
        if let Some(reaches) = self.reaches {
            table.row(["".into(), format!("the error may be up to {reaches:.1e}, more than was wished for")]);
        }
        for (head, lines) in [("left out", &self.left_out), ("assumed", &self.assumed)] {
            for (n, line) in lines.iter().enumerate() {
                table.row([if n == 0 { head.into() } else { String::new() }, line.clone()]);
            }
        }
    }
}

/// "click (12 times), buzz": each once, and no more than a few.
fn voices(names: &[String]) -> String {
    let mut counted: Vec<(&str, usize)> = Vec::new();
    for name in names {
        match counted.iter_mut().find(|(of, _)| of == name) {
            Some((_, count)) => *count += 1,
            None => counted.push((name, 1)),
        }
    }
    let shown = |(name, count): &(&str, usize)| match count {
        1 => name.to_string(),
        count => format!("{name} ({count} times)"),
    };
    let mut told: Vec<String> = counted.iter().take(VOICES).map(shown).collect();
    let more = counted.len().saturating_sub(VOICES);
    if more > 0 {
        told.push(format!("and {more} more"));
    }
    told.join(", ")
}
