//! What of a patch cannot be felt so strongly as it says.

use super::uses::{Use, uses};
use crate::patch::Patch;
use crate::perception::gauge::Gauge;
use crate::perception::threshold::RANGE;
use crate::rig::{Finder, Rig};
use crate::text::Problem;
use crate::text::sink::Sink;

/// What of a patch cannot be felt so strongly as it says: places of motors, and frequencies beyond what is known.
pub fn check(
    patch: &Patch,
    rig: &Rig,
    finder: &Finder,
    gauges: &[Option<Gauge>],
    problems: &mut Vec<Problem>,
) {
    for used in uses(patch, None) {
        if problems.len() >= Sink::MOST {
            return;
        }
        problems.extend(used.check(rig, finder, gauges));
    }
}

impl Use<'_> {
    /// Why it cannot be felt so strongly where it is played: a motor is there, or its frequency is beyond what is known.
    pub fn check(&self, rig: &Rig, finder: &Finder, gauges: &[Option<Gauge>]) -> Option<Problem> {
        let wrong = self.spots(rig, finder).into_iter().find_map(|spot| {
            let outputs = finder.outputs(spot).into_iter().filter_map(|output| rig.outputs.get(output));
            outputs.into_iter().find_map(|output| {
                let gauge = gauges.get(output.channel.saturating_sub(1) as usize).and_then(Option::as_ref);
                unfelt(&output.name, gauge, self.hertz)
            })
        });
        wrong.map(|(what, help)| Problem::error(self.span, what).help(help))
    }
}

/// Why nothing can be felt on an output at a frequency, and what to do.
pub(crate) fn unfelt(name: &str, gauge: Option<&Gauge>, hertz: f64) -> Option<(String, String)> {
    let Some(gauge) = gauge else {
        let what =
            format!("`felt` cannot be had on `{name}`: what vibrates there is no tone of one frequency");
        return Some((what, "give the event a `level`, or another place".into()));
    };
    if gauge.knows(hertz) {
        return None;
    }
    let [low, high] = gauge.range();
    let whose = if gauge.is_calibrated() && gauge.range() != RANGE {
        format!("its calibration goes from {low:.0} to {high:.0} Hz, and nothing is extrapolated")
    } else {
        format!("thresholds are given from {low:.0} to {high:.0} Hz")
    };
    let what = format!("`felt` cannot be had on `{name}` at {hertz} Hz: {whose}");
    let help = match gauge.is_calibrated() && (RANGE[0]..=RANGE[1]).contains(&hertz) {
        true => "measure it there as well, play another frequency, or give the event a `level`",
        false => "play another frequency, or give the event a `level`",
    };
    Some((what, help.into()))
}
