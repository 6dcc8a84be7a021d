//! What is played in decibels above the threshold: what each channel needs for it, and where that cannot be had.

use std::collections::HashMap;
use std::sync::Arc;

use super::places::Places;
use super::plan::{Output, Plan};
use super::scene::Scene;
use crate::dsp::biquad::Biquad;
use crate::dsp::blocker::CORNER;
use crate::dsp::elliptic::Elliptic;
use crate::patch::{self, Patch, Place, Voice};
use crate::perception::calibration::{Per, Quantity, Table, Unit};
use crate::perception::gauge::{Gauge, Path};
use crate::perception::threshold::{CONTACTOR, RANGE, Threshold};
use crate::rig::{self, Finder, Rig};
use crate::text::sink::Sink;
use crate::text::{Problem, Span};

/// A voice that a patch plays in decibels above the threshold, where both are known beforehand.
#[derive(Debug, Clone)]
pub struct Use<'a> {
    /// The voice.
    pub voice: &'a Voice,
    /// Decibels above the threshold.
    pub felt: f64,
    /// The frequency at which that holds, Hz.
    pub hertz: f64,
    /// Where; `None`: on the first tactor.
    pub place: Option<&'a Place>,
    /// Where it stands in the patch.
    pub span: &'a Span,
}

/// Whether anything in a patch, but for its events files, is played in decibels above the threshold.
pub fn is_felt(patch: &Patch) -> bool {
    let mut felt = patch.voices.iter().any(|voice| voice.felt.is_some());
    patch.each_play(|play, _| felt |= play.felt.is_some());
    felt || patch.triggers.iter().any(|trigger| trigger.set.iter().any(|(field, ..)| field == "felt"))
}

/// Everything in a patch that is, where its strength and frequency are numbers; what is always on is among it.
pub fn uses(patch: &Patch) -> Vec<Use<'_>> {
    let voices: HashMap<&str, &Voice> =
        patch.voices.iter().map(|voice| (voice.name.as_str(), voice)).collect();
    let mut uses = Vec::new();
    patch.each_play(|play, _| uses.extend(Use::each(&voices, play)));
    for trigger in &patch.triggers {
        let Some(voice) = voices.get(trigger.play.as_str()) else { continue };
        let set = |wanted: &str| trigger.set.iter().find(|(field, ..)| field == wanted);
        let number =
            |wanted: &str| set(wanted).map(|(_, expr, _)| expr.value(&|name| trigger.on.known(name)));
        // Of what is worked out as it is set off, only whoever does so knows.
        let (level, felt, frequency) = (number("level"), number("felt"), number("frequency"));
        if [level, felt, frequency].contains(&Some(None)) {
            continue;
        }
        let span = set("felt").map_or(&trigger.play_span, |(.., span)| span);
        let place = trigger.place.as_ref();
        let said = Said {
            level: level.flatten(),
            felt: felt.flatten(),
            frequency: frequency.flatten(),
            place,
            span,
        };
        uses.extend(said.of(voice));
    }
    for voice in patch.voices.iter().filter(|voice| voice.start == crate::patch::Start::Always) {
        let span = voice.felt.as_ref().map_or(&voice.span, |felt| &felt.span);
        uses.extend(Said { level: None, felt: None, frequency: None, place: None, span }.of(voice));
    }
    uses
}

/// What an event says.
struct Said<'a> {
    level: Option<f64>,
    felt: Option<f64>,
    frequency: Option<f64>,
    place: Option<&'a Place>,
    span: &'a Span,
}

impl<'a> Said<'a> {
    /// Of a voice; `None` where it is played by its level, or nobody knows at which frequency.
    fn of(self, voice: &'a Voice) -> Option<Use<'a>> {
        let felt = voice.strength(self.level, self.felt).1?;
        let frequency = self.frequency.or_else(|| voice.field("frequency"))?;
        let hertz = voice.pitch().hertz(frequency)?;
        Some(Use { voice, felt, hertz, place: self.place.or(voice.place.as_ref()), span: self.span })
    }
}

/// What each channel needs to be felt, at the engine's rate, of what vibrates on it. Where `must`, problems are told of calibrations that are missing.
pub fn gauges(
    rig: &Rig,
    planned: &[Output],
    rate: f64,
    must: bool,
    problems: &mut Vec<Problem>,
) -> Arc<[Option<Gauge>]> {
    let mut gauges = vec![None; rig.device.channels as usize];
    for output in &rig.outputs {
        if !matches!(output.kind, rig::OutputKind::Vibration | rig::OutputKind::Raw) {
            continue;
        }
        let channel = output.channel.saturating_sub(1);
        let Some(slot) = gauges.get_mut(channel as usize) else { continue };
        let Some(planned) = planned.iter().find(|planned| planned.channel == channel) else { continue };
        match gauge(rig, output, planned, rate) {
            Ok(gauge) => *slot = Some(gauge),
            Err(problem) if must => problems.push(problem),
            Err(_) => {}
        }
    }
    gauges.into()
}

fn gauge(rig: &Rig, output: &rig::Output, planned: &Output, rate: f64) -> Result<Gauge, Problem> {
    let mut path = Path {
        gain: output.gain,
        per_sample: 1.0,
        corners: if planned.keeps_dc_off { vec![CORNER] } else { Vec::new() },
        filters: filters(output, planned, rate),
        rate,
        most: most(rig, output),
    };
    let site = rig.site_of(output);
    let Some(calibration) = rig.calibration_of(output) else {
        let threshold = Threshold::new(site, CONTACTOR);
        return Ok(match modelled(rig, output) {
            Some(shape) => Gauge::relative(threshold, shape, path),
            None => Gauge::unknown(threshold, path),
        });
    };
    let of_file = |what: String| {
        let problem =
            Problem::of_file(format!("calibration `{}` of `{}`: {what}", calibration.name, output.name));
        problem.help("the rig is read with `pacinian::io::load::rig`".to_string())
    };
    let table = match calibration.response() {
        Some(Ok(table)) => table,
        Some(Err(fault)) => return Err(of_file(fault.to_string())),
        None => {
            let file = calibration.file.as_deref().unwrap_or_default();
            return Err(of_file(format!("its file `{file}` was not read")));
        }
    };
    path.per_sample =
        rig.per_sample(output, calibration).map_err(|problem| Problem { span: None, ..problem })?;
    // Over full scale, it was measured behind everything.
    if calibration.unit.per != Per::FullScale {
        path.behind(&rig.corners(output));
    }
    Ok(Gauge::calibrated(Threshold::new(site, calibration.area), table, path))
}

/// What is done to it on its way out: the actuator's equaliser and the band limit.
fn filters(output: &rig::Output, planned: &Output, rate: f64) -> Vec<Biquad> {
    let mut filters = planned.equaliser.clone();
    if output.kind == rig::OutputKind::Vibration {
        let Elliptic { gain, mut sections, .. } = Elliptic::band_limit(rate);
        sections.iter_mut().take(1).for_each(|section| section.b = section.b.map(|b| gain * b));
        filters.append(&mut sections);
    }
    filters
}

/// The share of `max_level` up to which the limiter lets a steady tone pass as it is. Above 500 Hz that becomes less, to 0.7 at 800 Hz.
const STEADY: f64 = 0.9;

/// The largest sample of a tone that leaves an output as it is, by its `max_level` and by what amplifier and actuator bear.
fn most(rig: &Rig, output: &rig::Output) -> f64 {
    let amplifier = output.amplifier.as_ref().and_then(|name| rig.amplifier(name));
    let actuator = output.actuator.as_ref().and_then(|name| rig.actuator(name));
    let (volts, amperes) = match (amplifier, rig.device.full_scale_volts) {
        (Some(amplifier), Some(scale)) if amplifier.drive == rig::Drive::Current => {
            (None, Some((scale * amplifier.gain).abs()))
        }
        _ => (rig.volts_per_sample(output), None),
    };
    let passes = if output.kind == rig::OutputKind::Vibration { STEADY } else { 1.0 };
    let share = |bears: Option<f64>, scale: Option<f64>| Some(bears? / scale?);
    [
        share(actuator.and_then(rig::Actuator::most_volts), volts),
        share(amplifier.and_then(|amplifier| amplifier.max_volts), volts),
        share(actuator.and_then(|actuator| actuator.value("max_amperes")), amperes),
        share(amplifier.and_then(|amplifier| amplifier.max_amperes), amperes),
    ]
    .into_iter()
    .flatten()
    .fold(passes * rig.max_level(output), f64::min)
}

/// Frequencies at which a model is asked, evenly spaced on a logarithm.
const ASKED: i32 = 96;

/// The shape of what an output's actuator does by its model, in no unit: the displacement of a contactor, or that of a casing. `None` without one.
fn modelled(rig: &Rig, output: &rig::Output) -> Option<Table> {
    let actuator = rig.actuator(output.actuator.as_ref()?)?;
    let plant = actuator.coil().ok()?;
    let amplifier = output.amplifier.as_ref().and_then(|name| rig.amplifier(name));
    let is_current = amplifier.is_some_and(|amplifier| amplifier.drive == rig::Drive::Current);
    let pushes = actuator.model == rig::Model::VoiceCoil;
    let does = |hertz: f64| {
        let response = if is_current { plant.per_ampere(hertz) } else { plant.per_volt(hertz) };
        if pushes { response.acceleration.abs() } else { response.casing.abs() }
    };
    let at = |n: i32| {
        if n == ASKED {
            RANGE[1]
        } else {
            RANGE[0] * (RANGE[1] / RANGE[0]).powf(f64::from(n) / f64::from(ASKED))
        }
    };
    let shape: Vec<[f64; 2]> = (0..=ASKED).map(|n| [at(n), does(at(n))]).collect();
    Table::new(&shape, Unit { quantity: Quantity::Acceleration, scale: 1.0, per: Per::Volt }).ok()
}

/// What of a patch cannot be felt so strongly as it says: places of motors, and frequencies beyond what is known.
pub fn check(
    patch: &Patch,
    rig: &Rig,
    finder: &Finder,
    gauges: &[Option<Gauge>],
    problems: &mut Vec<Problem>,
) {
    for used in uses(patch) {
        if problems.len() >= Sink::MOST {
            return;
        }
        problems.extend(used.check(rig, finder, gauges));
    }
}

impl<'a> Use<'a> {
    /// An event of an events file, where it is played in decibels above the threshold.
    pub fn of(voices: &HashMap<&str, &'a Voice>, play: &'a patch::Play) -> Option<Self> {
        let voice = voices.get(play.voice.as_str())?;
        let felt = play.felt.as_ref().map(|felt| felt.value);
        let span = play.felt.as_ref().map_or(&play.span, |felt| &felt.span);
        let frequency = play.fields.iter().find(|field| field.name == "frequency").map(|field| field.value);
        Said { level: play.level, felt, frequency, place: play.place.as_ref(), span }.of(voice)
    }

    /// The same at each place of an event, which may be several bursts.
    fn each(voices: &HashMap<&str, &'a Voice>, play: &'a patch::Play) -> Vec<Self> {
        let Some(one) = Self::of(voices, play) else { return Vec::new() };
        let Some(motion) = &play.motion else { return vec![one] };
        motion.places.iter().map(|place| Self { place: Some(place), ..one.clone() }).collect()
    }

    /// Why it cannot be felt so strongly where it is played: a motor is there, or its frequency is beyond what is known.
    pub fn check(&self, rig: &Rig, finder: &Finder, gauges: &[Option<Gauge>]) -> Option<Problem> {
        // A place that is not there is told elsewhere.
        let spot = rig.resolve_by(finder, self.place, self.span).ok()?;
        let outputs = finder.outputs(spot).into_iter().filter_map(|output| rig.outputs.get(output));
        let wrong = outputs.into_iter().find_map(|output| {
            let gauge = gauges.get(output.channel.saturating_sub(1) as usize).and_then(Option::as_ref);
            unfelt(&output.name, gauge, self.hertz)
        });
        wrong.map(|(what, help)| Problem::error(self.span, what).help(help))
    }
}

/// What becomes of what is played in decibels above the threshold in a scene.
pub struct Judge<'a> {
    rig: &'a Rig,
    finder: Finder,
    plan: &'a Plan,
    places: Places,
    /// By voice, its instrument.
    instruments: HashMap<&'a str, u32>,
}

/// What becomes of it on one output.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The channel, from 0.
    pub channel: u32,
    /// By how much it is capped, dB; 0 where it is not.
    pub missing: f64,
    /// The most decibels above the threshold that the tactor gives there.
    pub most: f64,
    /// Whether it was measured, so that all of these are what they say.
    pub is_calibrated: bool,
}

impl<'a> Judge<'a> {
    /// Of a scene that was made of these.
    pub fn new(patch: &'a Patch, rig: &'a Rig, scene: &'a Scene) -> Self {
        let instruments = patch.voices.iter().zip(&scene.instruments);
        Self {
            rig,
            finder: Finder::with(rig, patch),
            plan: &scene.plan,
            places: Places::new(&scene.plan),
            instruments: instruments
                .filter_map(|(voice, number)| Some((voice.name.as_str(), (*number)?)))
                .collect(),
        }
    }

    /// Why something cannot be felt so strongly.
    pub fn check(&self, used: &Use) -> Option<Problem> {
        used.check(self.rig, &self.finder, &self.plan.gauges)
    }

    /// What becomes of it on each output on which it sounds; nothing of a voice that was left out.
    pub fn of(&mut self, used: &Use) -> Vec<Verdict> {
        let Some(number) = self.instruments.get(used.voice.name.as_str()) else { return Vec::new() };
        let Ok(spot) = self.rig.resolve_by(&self.finder, used.place, used.span) else { return Vec::new() };
        let gauges = &self.plan.gauges;
        let verdict = |&(channel, gain): &(u32, f64)| {
            let gauge = gauges.get(channel as usize)?.as_ref()?;
            Some(Verdict {
                channel,
                missing: gauge.missing(used.felt, gauge.share(gain), used.hertz),
                most: gauge.most(used.hertz),
                is_calibrated: gauge.is_calibrated(),
            })
        };
        self.places.of(*number as usize, spot).iter().filter_map(verdict).collect()
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
        "its calibration goes"
    } else {
        "thresholds are known"
    };
    let what = format!(
        "`felt` cannot be had on `{name}` at {hertz} Hz: {whose} from {low:.0} to {high:.0} Hz, and nothing is extrapolated"
    );
    let help = match gauge.is_calibrated() && (RANGE[0]..=RANGE[1]).contains(&hertz) {
        true => "measure it there as well, play another frequency, or give the event a `level`",
        false => "play another frequency, or give the event a `level`",
    };
    Some((what, help.into()))
}
