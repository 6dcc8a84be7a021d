//! What `pacinian identify` says, as people read it.

use super::super::motor::ms;
use super::super::nodes::wrapped;
use super::super::paint::Paint;
use super::super::parts::number;
use super::super::table::{Table, hertz};
use super::answer::Answer;
use super::figures::{Figure, Lacking};
use super::stimulus::tidy;

impl Answer {
    /// All of it.
    pub fn text(&self, paint: Paint) -> String {
        let mut text = format!("{}: {}, {}\n", paint.bold(&self.recording), self.of, self.model);
        let mut table = Table::default();
        table.row([
            "recording".to_string(),
            format!(
                "{:.3} s at {}, {:.1} dB signal to noise",
                self.seconds,
                hertz(self.rate_hz),
                self.signal_to_noise_db
            ),
        ]);
        table.row([
            "drive".to_string(),
            format!("{}, {} V at most{}", self.drive, tidy(self.peak_volts), self.cut()),
        ]);
        table.row(["delay".to_string(), self.late()]);
        text += &table.text();
        text += &format!("\n{}\n", paint.bold("told"));
        let mut table = Table::default();
        let before = if self.rig.is_some() { "the rig has" } else { "known so far" };
        table.row(["figure", "value", "95 % interval", "unit", before].map(|head| paint.dim(head)));
        // How late the fit finds it is part of the delay above.
        let shown = self
            .told
            .iter()
            .filter(|figure| !["lateness", "current_lateness", "delay"].contains(&figure.name));
        shown.for_each(|figure| table.row(figure.row(paint)));
        text += &table.text();
        let groups = grouped(&self.untold);
        if !groups.is_empty() {
            text += &format!("\n{}\n", paint.bold("not told"));
            for (names, why) in groups {
                text += &format!("  {}\n{}\n", names.join(", "), wrapped(&why, "      "));
            }
        }
        text + &self.end(paint)
    }

    /// What of recording and drive was left out.
    fn cut(&self) -> String {
        let [before, behind] = self.left_out;
        let [first, last] = self.missed;
        let said = [
            (before, "of the recording before it left out"),
            (behind, "behind it left out"),
            (first, "of its beginning not recorded"),
            (last, "of its end not recorded"),
        ];
        let said = said.iter().filter(|(seconds, _)| *seconds > 0.0);
        said.map(|(seconds, what)| format!("; {seconds:.3} s {what}")).collect()
    }

    fn late(&self) -> String {
        if let Some(later) = self.later {
            let begin =
                self.delay.map_or(String::new(), |delay| format!("{}, by {}; ", ms(delay), self.delay_by));
            return format!(
                "{begin}the acceleration is {} behind the drive on its channel: measure that, and time_constant is told more closely, --delay S",
                ms(later)
            );
        }
        match (self.delay, self.delay_by) {
            (_, "one recording") => "none: drive and answer are one recording".into(),
            (Some(delay), by) => {
                let close =
                    self.model == "rumble-motor" && !["the looped-back drive", "the current"].contains(&by);
                let more = if close {
                    "; with the drive looped back time_constant is told more closely"
                } else {
                    ""
                };
                format!("{}, by {by}{more}", ms(delay))
            }
            (None, _) => "not told: the drive does not switch while it moves; taken as none".into(),
        }
    }

    /// What becomes of it in the rig.
    fn end(&self, paint: Paint) -> String {
        let Some(rig) = &self.rig else { return String::new() };
        let kept = self.told.iter().filter(|figure| figure.is_kept()).map(|figure| figure.name);
        let kept: Vec<&str> = kept.chain(self.given.iter().map(|said| said.name)).collect();
        let left = self.told.iter().filter_map(|figure| Some((figure.name, figure.left_out.as_ref()?)));
        let mut text = String::from("\n");
        text += &match (kept.len(), self.written) {
            (0, _) => format!("Nothing of it goes into {rig}.\n"),
            (_, true) => format!("{} {rig}: {}\n", paint.green("Written into"), kept.join(", ")),
            (_, false) => format!("--write would put into {rig}: {}\n", kept.join(", ")),
        };
        for (name, why) in left {
            text += &format!("  not {name}: {why}\n");
        }
        for said in &self.contradictions {
            text += &format!("  {}\n", paint.yellow(said));
        }
        if !self.missing.is_empty() {
            let list: Vec<String> = self.missing.iter().map(|key| format!("`{key}`")).collect();
            text +=
                &format!("  {}\n", paint.yellow(&format!("its model needs besides: {}", list.join(", "))));
        }
        text
    }
}

impl Figure {
    fn row(&self, paint: Paint) -> [String; 5] {
        let [least, most] = self.interval.map(number);
        let before = match self.before {
            Some(before) if (self.interval[0]..=self.interval[1]).contains(&before) => number(before),
            Some(before) => paint.yellow(&number(before)),
            None if self.is_key => "-".into(),
            None => paint.dim("no key"),
        };
        [self.name.into(), number(self.value), format!("{least} to {most}"), self.unit.into(), before]
    }
}

/// Those of one reason together, in their order.
fn grouped(all: &[Lacking]) -> Vec<(Vec<&str>, String)> {
    let mut groups: Vec<(Vec<&str>, String)> = Vec::new();
    for one in all {
        match groups.iter_mut().find(|(_, why)| *why == one.why) {
            Some((names, _)) => names.push(one.name),
            None => groups.push((vec![one.name], one.why.clone())),
        }
    }
    groups
}
