//! How strongly an event is felt, where that is said in place of a level: at which frequency it holds, and what contradicts itself.

use super::advice::frequency;
use super::event::{LEAST_FELT, MOST_FELT};
use super::expr::Reads;
use super::{Expr, Play, Trigger, Value, Voice};
use crate::text::{Problem, Span};

/// The frequency at which what a voice is felt like holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pitch {
    /// That, Hz, whatever its events say: `felt_at`.
    At(f64),
    /// That of the event, which its nodes read.
    OfEvent,
    /// Nobody says; where its one oscillator has a fixed frequency, that.
    Unsaid(Option<f64>),
}

impl Pitch {
    /// The frequency for an event of that one, Hz; `None` where nobody says.
    pub fn hertz(self, frequency: f64) -> Option<f64> {
        match self {
            Self::At(hertz) => Some(hertz),
            Self::OfEvent => Some(frequency),
            Self::Unsaid(_) => None,
        }
    }
}

impl Voice {
    /// The frequency at which `felt` of its events holds.
    pub fn pitch(&self) -> Pitch {
        if let Some(hertz) = self.felt_at {
            return Pitch::At(hertz);
        }
        if self.reads_frequency() {
            return Pitch::OfEvent;
        }
        let mut fixed = self.nodes.iter().filter_map(frequency);
        let one = fixed.next().and_then(Expr::constant).filter(|hertz| *hertz > 0.0);
        Pitch::Unsaid(one.filter(|_| fixed.next().is_none()))
    }

    /// Whether its nodes read the frequency of the event.
    pub fn reads_frequency(&self) -> bool {
        let mut reads = false;
        let mut see = |expr: &Expr| {
            expr.visit(&mut |read, _| reads |= matches!(read, Reads::Event("frequency")));
        };
        for argument in self.nodes.iter().flat_map(|node| &node.arguments) {
            match &argument.value {
                Value::Expr(expr) => see(expr),
                Value::Signals(list) => list.iter().for_each(&mut see),
                _ => {}
            }
        }
        reads
    }

    /// The level of an event that says one of the two, or none, and the decibels above the threshold that take its place: what the event says goes
    /// before what the voice says, and beside decibels the level is 1.
    pub fn strength(&self, level: Option<f64>, felt: Option<f64>) -> (f64, Option<f64>) {
        strength(level, felt, (self.level, self.felt.as_ref().map(|felt| felt.value)))
    }
}

/// See [`Voice::strength`]: what an event says, and what its voice says.
pub(crate) fn strength(
    level: Option<f64>,
    felt: Option<f64>,
    (default, felt_by_default): (f64, Option<f64>),
) -> (f64, Option<f64>) {
    match (level, felt.or(felt_by_default)) {
        (Some(level), _) => (level, None),
        (None, Some(felt)) => (1.0, Some(felt)),
        (None, None) => (default, None),
    }
}

/// That a level and decibels are said at once.
pub(super) fn both(span: &Span, who: &str) -> Problem {
    Problem::error(span, format!("{who} has `level` and `felt` at once")).help(
        "leave one of them out: a level is a share of the rated vibration, `felt` is dB above the threshold"
            .to_string(),
    )
}

/// That nothing says at which frequency `felt` holds.
pub(super) fn unsaid(voice: &Voice, span: &Span) -> Option<Problem> {
    let Pitch::Unsaid(fixed) = voice.pitch() else { return None };
    let what = format!(
        "`felt` holds at a frequency, and voice `{}` neither reads event.frequency nor says `felt_at`",
        voice.name
    );
    let hertz = fixed.map_or("250".into(), |hertz| hertz.to_string());
    let help =
        format!("write felt_at = {hertz} under [voice.{}]: the frequency that is felt most", voice.name);
    Some(Problem::error(span, what).help(help))
}

/// What is wrong with how strongly an event plays a voice.
pub(super) fn check_play(voice: &Voice, play: &Play, problems: &mut Vec<Problem>) {
    let Some(felt) = &play.felt else { return };
    if play.level.is_some() {
        problems.push(both(&felt.span, &format!("an event of voice `{}`", voice.name)));
    }
    problems.extend(unsaid(voice, &felt.span));
}

/// What is wrong with how strongly a trigger plays a voice.
pub(super) fn check_trigger(voice: &Voice, trigger: &Trigger, problems: &mut Vec<Problem>) {
    let Some((_, _, span)) = trigger.set.iter().find(|(field, ..)| field == "felt") else { return };
    if trigger.set.iter().any(|(field, ..)| field == "level") {
        problems.push(both(span, "`set` of a trigger"));
    }
    problems.extend(unsaid(voice, span));
}

/// What is wrong with how strongly a voice is felt by itself.
pub(super) fn check_voice(voice: &Voice, problems: &mut Vec<Problem>) {
    let Some(felt) = &voice.felt else { return };
    if !(LEAST_FELT..=MOST_FELT).contains(&felt.value) {
        let what = format!("`felt` of voice `{}` is {}", voice.name, felt.value);
        problems.push(Problem::error(&felt.span, what).help(format!("give dB, {LEAST_FELT} to {MOST_FELT}")));
    }
    problems.extend(unsaid(voice, &felt.span));
}
