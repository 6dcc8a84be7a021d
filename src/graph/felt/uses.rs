//! What of a patch is played in decibels above the threshold.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::patch::event::LEAST_FELT;
use crate::patch::{self, Patch, Place, Source, Voice};
use crate::rig::{Finder, Rig};
use crate::space::array::Array;
use crate::space::spot::Spot;
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
    /// Where: one place, or those of its bursts. None: on the first tactor.
    pub places: Vec<Cow<'a, Place>>,
    /// How long, or how long its shortest burst is, s; `None`: as long as it is held.
    pub seconds: Option<f64>,
    /// Where it stands in the patch.
    pub span: &'a Span,
}

/// Whether anything in a patch, but for its events files, is played in decibels above the threshold.
pub fn is_felt(patch: &Patch) -> bool {
    let mut felt = patch.voices.iter().any(|voice| voice.felt.is_some());
    patch.each_play(|play, _| felt |= play.felt.is_some());
    felt || patch.triggers.iter().any(|trigger| trigger.set.iter().any(|(field, ..)| field == "felt"))
}

/// Everything in a patch that is, where its strength and frequency are numbers; what is always on is among it. Bursts of a stroke are known where
/// the array is.
pub fn uses<'a>(patch: &'a Patch, array: Option<&Array>) -> Vec<Use<'a>> {
    let voices: HashMap<&str, &Voice> =
        patch.voices.iter().map(|voice| (voice.name.as_str(), voice)).collect();
    let mut uses = Vec::new();
    patch.each_play(|play, pattern| {
        uses.extend(Use::of(&voices, play, pattern.time.seconds() / pattern.rate, array));
    });
    for trigger in &patch.triggers {
        let Some(voice) = voices.get(trigger.play.as_str()) else { continue };
        let set = |wanted: &str| trigger.set.iter().find(|(field, ..)| field == wanted);
        let number =
            |wanted: &str| set(wanted).map(|(_, expr, _)| expr.value(&|name| trigger.on.known(name)));
        // Of what is worked out as it is set off, only whoever does so knows; however weak it is, it is played on these tactors.
        let (level, mut felt, frequency) = (number("level"), number("felt"), number("frequency"));
        if [level, frequency].contains(&Some(None)) {
            continue;
        }
        if felt == Some(None) {
            felt = Some(Some(LEAST_FELT));
        }
        let span = set("felt").map_or(&trigger.play_span, |(.., span)| span);
        let seconds = match (set("duration"), &trigger.on) {
            (Some((_, expr, _)), _) => expr.constant(),
            // A key holds what has no duration of its own.
            (None, Source::MidiNote) => None,
            (None, _) => Some(voice.duration),
        };
        let said = Said {
            level: level.flatten(),
            felt: felt.flatten(),
            frequency: frequency.flatten(),
            place: trigger.place.as_ref(),
            seconds,
            span,
        };
        uses.extend(said.of(voice));
    }
    for voice in patch.voices.iter().filter(|voice| voice.start == crate::patch::Start::Always) {
        let span = voice.felt.as_ref().map_or(&voice.span, |felt| &felt.span);
        uses.extend(
            Said { span, level: None, felt: None, frequency: None, place: None, seconds: None }.of(voice),
        );
    }
    uses
}

/// What an event says.
struct Said<'a> {
    level: Option<f64>,
    felt: Option<f64>,
    frequency: Option<f64>,
    place: Option<&'a Place>,
    seconds: Option<f64>,
    span: &'a Span,
}

impl<'a> Said<'a> {
    /// Of a voice; `None` where it is played by its level, or nobody knows at which frequency.
    fn of(self, voice: &'a Voice) -> Option<Use<'a>> {
        let felt = voice.strength(self.level, self.felt).1?;
        let frequency = self.frequency.or_else(|| voice.field("frequency"))?;
        let hertz = voice.pitch().hertz(frequency)?;
        let places = self.place.or(voice.place.as_ref()).into_iter().map(Cow::Borrowed).collect();
        Some(Use { voice, felt, hertz, places, seconds: self.seconds, span: self.span })
    }
}

impl<'a> Use<'a> {
    /// An event of a pattern in which a unit of time takes so many seconds, where it is played in decibels above the threshold.
    pub fn of(
        voices: &HashMap<&str, &'a Voice>,
        play: &'a patch::Play,
        unit: f64,
        array: Option<&Array>,
    ) -> Option<Self> {
        let voice = voices.get(play.voice.as_str())?;
        let felt = play.felt.as_ref().map(|felt| felt.value);
        let span = play.felt.as_ref().map_or(&play.span, |felt| &felt.span);
        let frequency = play.fields.iter().find(|field| field.name == "frequency").map(|field| field.value);
        let seconds = play.duration.unwrap_or(voice.duration) * unit;
        let place = play.place.as_ref();
        let said = Said { level: play.level, felt, frequency, place, seconds: Some(seconds), span };
        let one = said.of(voice)?;
        let Some(motion) = &play.motion else { return Some(one) };
        Some(match motion.bursts(seconds, array) {
            Ok(bursts) => {
                let shortest = bursts.list.iter().map(|burst| burst.seconds).reduce(f64::min);
                let mut places: Vec<_> =
                    bursts.list.into_iter().map(|burst| Cow::Owned(burst.place)).collect();
                places.dedup();
                Self { places, seconds: shortest, ..one }
            }
            // Why it cannot be is told elsewhere.
            Err(_) => Self { places: motion.places.iter().map(Cow::Borrowed).collect(), ..one },
        })
    }

    /// Where it is on a rig. Places that are not there are left out: they are told elsewhere.
    pub(super) fn spots(&self, rig: &Rig, finder: &Finder) -> Vec<Spot> {
        let find = |place| rig.resolve_by(finder, place, self.span).ok();
        if self.places.is_empty() {
            return find(None).into_iter().collect();
        }
        self.places.iter().filter_map(|place| find(Some(&**place))).collect()
    }
}
