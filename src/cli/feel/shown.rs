//! What was felt, as people read it.

use super::super::left_out::ranges;
use super::super::paint::Paint;
use super::super::table::{Table, grouped};
use super::report::{FeelReport, OutputReport};

/// Outputs told one by one, at most.
const SHOWN: usize = 32;

impl FeelReport {
    /// As lines for people.
    pub fn text(&self, paint: Paint) -> String {
        let file = paint.bold(&pacinian::text::problem::escaped(&self.file));
        let mut text = format!("\n{file}, what is felt by the models: figures, not sound\n");
        let mut table = Table::default();
        let heads = ["", "peak", "at", "RMS", "at most", "drew"];
        table.row(heads.map(|head| paint.dim(head)));
        for output in self.outputs.iter().take(SHOWN) {
            table.row(output.cells(paint));
        }
        text += &table.text();
        let more = self.outputs.len().saturating_sub(SHOWN);
        if more > 0 {
            text += &format!("  and {more} more; --json shows all\n");
        }
        let mut table = Table::default();
        let mut lines = |head: &str, lines: Vec<String>| {
            for (n, line) in lines.into_iter().enumerate() {
                table.row([if n == 0 { head.to_string() } else { String::new() }, line]);
            }
        };
        lines("channels", self.channel_lines());
        let level = format!(
            "in {:.3} s, for an error of {:e}; drives are held, which loses {:.2} % of 1 kHz at most",
            self.run_time_seconds,
            self.error,
            100.0 * self.held_loses
        );
        let more = [self.level_line(), self.joined_line(), self.reached_line()];
        lines("computed", std::iter::once(level).chain(more.into_iter().flatten()).collect());
        lines("left out", self.left_out_lines());
        lines("assumed", self.assumed.clone());
        lines("figures", self.figure_lines());
        lines("not felt", self.not_felt_lines());
        text + "\n" + &table.text()
    }

    /// "1, 2 wrist: across, upright, m/s2".
    fn channel_lines(&self) -> Vec<String> {
        let mut lines: Vec<(&str, Vec<String>, Vec<&str>, &str)> = Vec::new();
        for channel in &self.channels {
            match lines.last_mut().filter(|line| line.0 == channel.output) {
                Some(line) => {
                    line.1.push(channel.channel.to_string());
                    line.2.push(channel.axis);
                }
                None => lines.push((
                    &channel.output,
                    vec![channel.channel.to_string()],
                    vec![channel.axis],
                    channel.unit,
                )),
            }
        }
        let more = lines.len().saturating_sub(SHOWN);
        let line = |(output, numbers, axes, unit): &(&str, Vec<String>, Vec<&str>, &str)| {
            format!("{}  {output}: {}, {unit}", numbers.join(", "), axes.join(", "))
        };
        let mut told: Vec<String> = lines.iter().take(SHOWN).map(line).collect();
        if more > 0 {
            told.push(format!("and those of {more} more outputs"));
        }
        told
    }

    /// "motors at level default (`wrist`), economy (`grip`)".
    fn level_line(&self) -> Option<String> {
        let told = self.outputs.iter().filter_map(|o| Some((o.told_level()?, o.output.as_str())));
        let told: Vec<(String, &str)> = told.collect();
        let groups = together(told.iter().map(|(level, name)| (level.as_str(), *name)));
        let told: Vec<String> =
            groups.iter().map(|(level, names)| format!("{level} ({})", ranges(names))).collect();
        (!told.is_empty()).then(|| format!("motors at level {}", told.join(", ")))
    }

    /// "before diodes samples are joined as a converter joins them, not held (`palm`); nothing is shifted".
    fn joined_line(&self) -> Option<String> {
        let names: Vec<&str> = self.outputs.iter().filter(|o| o.joined).map(|o| o.output.as_str()).collect();
        let told = "before diodes samples are joined as a converter joins them, and not held";
        (!names.is_empty()).then(|| format!("{told} ({}); nothing is shifted by that", ranges(&names)))
    }

    /// "the error may be up to 3.1e-5 (`palm`)".
    fn reached_line(&self) -> Option<String> {
        let told = self.outputs.iter().filter_map(|o| Some((o.reaches?, o.output.as_str())));
        let told: Vec<(String, &str)> = told.map(|(error, name)| (format!("{error:.1e}"), name)).collect();
        let groups = together(told.iter().map(|(error, name)| (error.as_str(), *name)));
        let told: Vec<String> =
            groups.iter().map(|(error, names)| format!("{error} ({})", ranges(names))).collect();
        (!told.is_empty())
            .then(|| format!("the error may be up to {}, more than was wished for", told.join(", ")))
    }

    fn left_out_lines(&self) -> Vec<String> {
        let all = self
            .outputs
            .iter()
            .flat_map(|o| o.left_out.iter().map(|left| (left.as_str(), o.output.as_str())));
        together(all).into_iter().map(|(left, names)| format!("{left} ({})", ranges(&names))).collect()
    }

    fn figure_lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for output in self.outputs.iter().filter(|output| !output.figures_assumed.is_empty()) {
            let (part, few) = (output.part.as_deref().unwrap_or_default(), output.figures_assumed.len());
            let few = if few == output.figures { "any".into() } else { few.to_string() };
            let line = format!(
                "of the {} figures of `{}` nobody measured {few}: see pacinian parts {part}",
                output.figures, output.actuator
            );
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }

    fn not_felt_lines(&self) -> Vec<String> {
        let all = self
            .not_felt
            .iter()
            .flat_map(|not| not.why.iter().map(|why| (why.as_str(), not.output.as_str())));
        let line = |(why, names): (&str, Vec<&str>)| {
            let own = names.len() == 1 && why.starts_with("output ");
            if own { why.to_string() } else { format!("{}: {why}", ranges(&names)) }
        };
        let mut lines: Vec<String> = together(all).into_iter().map(line).collect();
        let more = lines.len().saturating_sub(SHOWN);
        lines.truncate(SHOWN);
        if more > 0 {
            lines.push(format!("and {more} more; --json shows all"));
        }
        lines
    }
}

/// What is said of several is said once, in the order in which it comes first.
fn together<'a>(all: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<(&'a str, Vec<&'a str>)> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for (said, name) in all {
        match groups.iter_mut().find(|(group, _)| *group == said) {
            Some((_, names)) => names.push(name),
            None => groups.push((said, vec![name])),
        }
    }
    groups
}

impl OutputReport {
    /// "fine, 2 steps a frame".
    fn told_level(&self) -> Option<String> {
        let level = self.level.as_ref()?;
        Some(if self.steps > 1 { format!("{level}, {} steps a frame", self.steps) } else { level.clone() })
    }

    fn cells(&self, paint: Paint) -> Vec<String> {
        let Self { output, unit, .. } = self;
        if self.peak == 0.0 {
            return vec![output.clone(), "did not move".into()];
        }
        let mut most = Vec::new();
        most.extend(self.fastest.map(|speed| format!("{} rad/s", digits(speed))));
        most.extend(self.farthest.map(|metres| {
            let share = self.of_stroke.map(|share| format!(", {:.0} % of its stroke", 100.0 * share));
            let told = format!("{} mm{}", digits(1e3 * metres), share.unwrap_or_default());
            let beyond = self.of_stroke.is_some_and(|share| share > 1.0);
            if beyond { paint.yellow(&(told + ", beyond which the model knows no stop")) } else { told }
        }));
        most.extend(self.warmest.map(|kelvins| format!("{} K warmer", digits(kelvins))));
        let drew = self.energy.map_or("not known".into(), |joules| match joules.abs() {
            small if small < 0.1 => format!("{} mJ", digits(1e3 * joules)),
            _ => format!("{} J", digits(joules)),
        });
        let mut cells = vec![
            output.clone(),
            format!("{} {unit}", digits(self.peak)),
            format!("{:.3} s", self.peak_at),
            format!("{} {unit}", digits(self.rms)),
            most.join(", "),
            drew,
        ];
        if self.last > 1.01 * super::DIED_AWAY * self.peak {
            cells.push(paint.yellow(&format!("still {} {unit} where the file ends", digits(self.last))));
        }
        for (count, what) in [
            (self.clipped, "samples cut at full scale"),
            (self.limited, "samples more than the amplifier gives"),
            (self.masked, "samples that were no numbers"),
        ] {
            if count > 0 {
                cells.push(paint.yellow(&format!("{} {what}", grouped(count))));
            }
        }
        cells
    }
}

/// Three digits that count, and no power of ten where it can be helped.
fn digits(x: f64) -> String {
    let places = if x == 0.0 { 0.0 } else { 2.0 - x.abs().log10().floor() };
    match places {
        places if places <= 0.0 => format!("{x:.0}"),
        places if places <= 6.0 => format!("{x:.*}", places as usize),
        _ => format!("{x:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{digits, together};

    #[test]
    fn three_digits_count() {
        for (x, told) in [
            (0.0, "0"),
            (1551.4, "1551"),
            (17.648, "17.6"),
            (9.9961, "10.00"),
            (0.012_345, "0.0123"),
            (-3.25e-9, "-3.25e-9"),
            (123.5, "124"),
        ] {
            assert_eq!(digits(x), told);
        }
    }

    #[test]
    fn what_is_said_of_several_is_said_once() {
        let all = [("a", "x"), ("b", "x"), ("a", "y")];
        assert_eq!(together(all.into_iter()), [("a", vec!["x", "y"]), ("b", vec!["x"])]);
    }
}
