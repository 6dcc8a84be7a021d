//! What of a patch is played in decibels above the threshold.

use std::collections::HashMap;

use crate::patch::{self, Patch, Place, Voice};
use crate::text::Span;

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
}
