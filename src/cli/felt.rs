//! What of what is played in decibels above the threshold a rig cannot give, and of what nobody knows it: warnings, and a line for each tactor.

use super::left_out::ranges;
use super::loaded::Loaded;
use pacinian::graph::felt::{Judge, Use, Verdict, is_felt, uses};
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::Scene;
use pacinian::patch::{Patch, Place, Play, Voice};
use pacinian::perception::gauge::{FULL, Gauge, REFERENCE};
use pacinian::perception::summation::{ABOVE, WHOLE, least_loss, loss};
use pacinian::perception::threshold::MICRO;
use pacinian::rig::Rig;
use pacinian::space::spot::Spread;
use pacinian::text::{Problem, Problems, Severity, Sink};
use serde::Serialize;
use std::collections::{BTreeSet, HashMap};

/// Less than that nobody misses, dB.
const MISSED: f64 = 0.05;

/// What there is to say of a patch on a rig.
pub struct Felt<'a> {
    judge: Judge<'a>,
    voices: HashMap<&'a str, &'a Voice>,
    patch: &'a Patch,
    plan: &'a Plan,
    /// Channels on which something is to be felt so strongly and which nobody has measured.
    unmeasured: BTreeSet<u32>,
    measured: bool,
    short: Short,
}

/// Events that are shorter than what thresholds were measured with.
#[derive(Default)]
struct Short {
    events: u64,
    /// Of the one that loses most: how much, dB, at most and at least, its voice, and seconds and hertz.
    worst: Option<([f64; 2], String, [f64; 2])>,
}

/// Events that last as long lose less than what one person differs from another, s.
const LONG: f64 = 0.5;

impl Short {
    fn see(&mut self, used: &Use) {
        let Some(seconds) = used.seconds.filter(|seconds| *seconds < LONG) else { return };
        let lost = [loss(seconds, used.hertz), least_loss(seconds, used.hertz)];
        if lost[0] > 0.0 {
            self.events += 1;
            if self.worst.as_ref().is_none_or(|(worst, ..)| lost[0] > worst[0]) {
                self.worst = Some((lost, used.voice.name.clone(), [seconds, used.hertz]));
            }
        }
    }

    fn told(&self) -> Option<Problem> {
        let ([most, least], voice, [seconds, hertz]) = self.worst.as_ref()?;
        let (is, them) = if self.events == 1 { ("event", "it is") } else { ("events", "they are") };
        let what = format!(
            "{} {is} with `felt` above {ABOVE:.0} Hz, shorter than {LONG} s: {them} likely felt weaker than said, by {least:.0} to {most:.0} dB at the shortest (voice \
             `{voice}`, {:.3} s at {hertz} Hz), as thresholds hold for {WHOLE:.0} s",
            self.events, seconds
        );
        let help = "make such events longer, or ask for more; `pacinian format --markdown felt` has a table"
            .to_string();
        Some(Problem { severity: Severity::Warning, ..Problem::of_file(what).help(help) })
    }
}

impl<'a> Felt<'a> {
    /// Of a scene that was made of these.
    pub fn new(patch: &'a Patch, rig: &'a Rig, scene: &'a Scene) -> Self {
        Self {
            judge: Judge::new(patch, rig, scene),
            voices: patch.voices.iter().map(|voice| (voice.name.as_str(), voice)).collect(),
            patch,
            plan: &scene.plan,
            unmeasured: BTreeSet::new(),
            measured: false,
            short: Short::default(),
        }
    }

    /// What is wrong with an event of an events file, or doubtful, in a pattern in which a unit of time takes so many seconds.
    pub fn event(&mut self, play: &Play, unit: f64) -> Option<Problem> {
        let voices = std::mem::take(&mut self.voices);
        let used = Use::of(&voices, play, unit, self.plan.spread.as_ref().map(Spread::array));
        let told = used.as_ref().and_then(|used| self.judge.check(used).or_else(|| self.capped(used)));
        self.voices = voices;
        told
    }

    /// Warnings of the patch itself, and which tactors nobody has measured, events files included; `None` where there are none.
    pub fn advice(mut self) -> Option<Problems> {
        let mut list = Vec::new();
        for used in uses(self.patch, self.plan.spread.as_ref().map(Spread::array)) {
            let told = self.capped(&used);
            if list.len() < Sink::MOST {
                list.extend(told);
            }
        }
        list.extend(self.relative());
        list.extend(self.short.told());
        (!list.is_empty()).then(|| self.patch.origin.problems(list))
    }

    /// That a tactor cannot give so much.
    fn capped(&mut self, used: &Use) -> Option<Problem> {
        let verdicts = self.judge.of(used);
        if !verdicts.is_empty() {
            self.short.see(used);
        }
        for verdict in &verdicts {
            self.measured |= verdict.is_calibrated;
            if !verdict.is_calibrated {
                self.unmeasured.insert(verdict.channel);
            }
        }
        let short: Vec<&Verdict> = verdicts.iter().filter(|verdict| verdict.missing > MISSED).collect();
        let worst = short.iter().max_by(|a, b| a.missing.total_cmp(&b.missing))?;
        let name = self.name(worst.channel);
        let others = match short.len() - 1 {
            0 => String::new(),
            1 => ", and another tactor falls short, too".into(),
            more => format!(", and {more} more tactors fall short, too"),
        };
        let place = match used.places.first().map(|place| &**place) {
            Some(Place::Position(_)) => " with its share of the place",
            Some(Place::Path(_)) => " with its share of the path",
            _ => "",
        };
        let what = format!(
            "{} dB of voice `{}` at {} Hz is {:.1} dB more than `{name}` can give{place}: it gives {:.1} dB at most{others}",
            used.felt, used.voice.name, used.hertz, worst.missing, worst.most
        );
        let help = "it is capped there, and feels weaker than on the others; ask for less, or give it more volts (`max_level`, the amplifier's `gain`)";
        Some(Problem::warning(used.span, what).help(help.to_string()))
    }

    /// That nobody has measured some tactors.
    fn relative(&self) -> Option<Problem> {
        let names: Vec<&str> = self.unmeasured.iter().map(|channel| self.name(*channel)).collect();
        if names.is_empty() {
            return None;
        }
        let (is, them) = if names.len() == 1 { ("is", "there") } else { ("are", "on them") };
        let apart = if self.measured { ", and not to be compared with those that are" } else { "" };
        let what = format!(
            "{} {is} not calibrated: `felt` is relative {them}{apart}. A level of 1 at {REFERENCE} Hz counts for {FULL} dB, whatever it really is",
            ranges(&names)
        );
        let help = "measure them and write [calibration.NAME]: see `pacinian format calibration`".to_string();
        Some(Problem { severity: Severity::Warning, ..Problem::of_file(what).help(help) })
    }

    fn name(&self, channel: u32) -> &'a str {
        self.plan.outputs.iter().find(|output| output.channel == channel).map_or("", |output| &output.name)
    }
}

/// How a tactor is felt, for people and for programs.
#[derive(Debug, Serialize)]
pub struct FeltReport {
    site: &'static str,
    /// The day of its calibration; `None`: nobody has measured it.
    calibrated: Option<String>,
    /// Hz.
    range: [f64; 2],
    /// The threshold at 250 Hz, dB above 1 µm, and by how much it may be off.
    threshold: [f64; 2],
    /// Hz, and the most dB above the threshold there.
    most: Vec<[f64; 2]>,
}

/// Frequencies at which it is told how much a tactor gives, Hz.
const TOLD: [f64; 3] = [40.0, 100.0, 250.0];

impl FeltReport {
    /// Of an output of a plan; `None` where nothing is played that says how strongly it is felt.
    pub fn of(loaded: &Loaded, plan: &Plan, output: &pacinian::graph::plan::Output) -> Option<Self> {
        let rig = &loaded.rig;
        // Whoever has measured nothing and asks for nothing of the kind hears nothing of it.
        if rig.calibrations.is_empty() && !is_felt(&loaded.patch) {
            return None;
        }
        let gauge: &Gauge = plan.gauges.get(output.channel as usize)?.as_ref()?;
        let described = rig.outputs.iter().find(|described| *described.name == *output.name)?;
        let threshold = gauge.threshold();
        Some(Self {
            site: threshold.site().word,
            calibrated: rig.calibration_of(described).map(|calibration| calibration.date.clone()),
            range: gauge.range(),
            threshold: [threshold.metres(REFERENCE) - MICRO, threshold.error(REFERENCE)],
            most: TOLD
                .into_iter()
                .filter(|hertz| gauge.knows(*hertz))
                .map(|hertz| [hertz, gauge.most(hertz)])
                .collect(),
        })
    }

    /// In words.
    pub fn text(&self) -> String {
        let most: Vec<String> =
            self.most.iter().map(|[hertz, most]| format!("{most:.0} dB at {hertz:.0} Hz")).collect();
        let most = if most.is_empty() { String::new() } else { format!(", at most {}", most.join(", ")) };
        match &self.calibrated {
            Some(date) => {
                let ([low, high], [threshold, error]) = (self.range, self.threshold);
                format!(
                    "calibrated {date} from {low:.0} to {high:.0} Hz, {}: felt from {threshold:.0} dB re 1 um ±{error:.0} dB at 250 Hz{most}",
                    self.site
                )
            }
            None => format!("not calibrated, {}: `felt` is relative", self.site),
        }
    }
}
