//! Events that are over before their actuator has risen: warnings.

use pacinian::graph::motions;
use pacinian::graph::scene::Scene;
use pacinian::patch::{Patch, Pattern, Place, Play, Source, Trigger, Voice};
use pacinian::rig::rise::{RISEN, Rise, Way};
use pacinian::rig::{Finder, Rig};
use pacinian::space::spot::Spread;
use pacinian::text::{Problem, Problems, Span};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

/// An event that is over before an actuator has risen.
struct Short<'a> {
    seconds: f64,
    rise: Rise,
    output: &'a str,
    actuator: &'a str,
}

/// What is looked for.
pub struct Search<'a> {
    patch: &'a Patch,
    rig: &'a Rig,
    finder: Finder,
    voices: HashMap<&'a str, &'a Voice>,
    /// Voices that sound and order no clicks or spins, which have a length of their own.
    plain: HashSet<&'a str>,
    /// By voice and actuator, that which falls shortest of the rise, and where it stands.
    found: BTreeMap<(&'a str, &'a str), (Short<'a>, &'a Span)>,
    /// Of which voices and actuators a line of an events file was told.
    told: HashSet<(&'a str, &'a str)>,
}

/// Looks through the events of a scene that was made of these; those of events files are given to [`Search::row`].
pub fn search<'a>(patch: &'a Patch, rig: &'a Rig, scene: &Scene) -> Search<'a> {
    let orders_nothing = |number: &Option<u32>| {
        let instrument = number.and_then(|number| scene.plan.instruments.get(number as usize));
        instrument.is_some_and(|instrument| instrument.commands().is_empty())
    };
    let voices = patch.voices.iter().zip(&scene.instruments);
    let mut search = Search {
        patch,
        rig,
        finder: Finder::with(rig, patch),
        voices: patch.voices.iter().map(|voice| (voice.name.as_str(), voice)).collect(),
        plain: voices
            .filter(|(_, number)| orders_nothing(number))
            .map(|(voice, _)| voice.name.as_str())
            .collect(),
        found: BTreeMap::new(),
        told: HashSet::new(),
    };
    let array = scene.plan.spread.as_ref().map(Spread::array);
    motions::each(patch, array, |voice, play, _, bursts| {
        let level = voice.strength(play.level, play.felt.as_ref().map(|felt| felt.value)).0;
        for burst in bursts.map(|bursts| bursts.list).unwrap_or_default() {
            search.see(voice, burst.seconds, level, Some(&burst.place), &play.span);
        }
    });
    patch.each_play(|play, pattern| {
        if play.motion.is_none()
            && let Some((voice, seconds, level)) = search.event(play, pattern)
        {
            search.see(voice, seconds, level, play.place.as_ref(), &play.span);
        }
    });
    patch.triggers.iter().for_each(|trigger| search.trigger(trigger));
    search
}

impl<'a> Search<'a> {
    /// Warnings: of each voice on each actuator one, of its shortest event; `None` where there are none.
    pub fn advice(self) -> Option<Problems> {
        let list: Vec<Problem> = self
            .found
            .iter()
            .map(|((voice, _), (short, span))| short.told("the shortest event", voice, span))
            .collect();
        (!list.is_empty()).then(|| self.patch.origin.problems(list))
    }

    /// A warning of a line of an events file that a pattern plays: the first one of its voice on an actuator.
    pub fn row(&mut self, play: &Play, pattern: &'a Pattern) -> Option<Problem> {
        let (voice, seconds, level) = self.event(play, pattern)?;
        let all = self.short(voice, seconds, level, play.place.as_ref());
        let new =
            all.into_iter().find(|short| !self.told.contains(&(voice.name.as_str(), short.actuator)))?;
        self.told.insert((&voice.name, new.actuator));
        Some(new.told("an event", &voice.name, &play.span))
    }

    /// The voice of an event of a pattern, how long it is, s, and its level.
    fn event(&self, play: &Play, pattern: &Pattern) -> Option<(&'a Voice, f64, f64)> {
        let voice = self.voices.get(play.voice.as_str()).copied()?;
        let seconds = play.duration.unwrap_or(voice.duration) * pattern.time.seconds() / pattern.rate;
        let level = voice.strength(play.level, play.felt.as_ref().map(|felt| felt.value)).0;
        Some((voice, seconds, level))
    }

    /// What is set off for a time that is known.
    fn trigger(&mut self, trigger: &'a Trigger) {
        let Some(voice) = self.voices.get(trigger.play.as_str()).copied() else { return };
        let set = |wanted: &str| trigger.set.iter().find(|(field, ..)| field == wanted);
        let number = |wanted: &str| set(wanted).map(|(_, expr, _)| expr.constant());
        let seconds = match (number("duration"), &trigger.on) {
            (Some(seconds), _) => seconds,
            // A key holds what has no duration of its own.
            (None, Source::MidiNote) => None,
            (None, _) => Some(voice.duration),
        };
        let level = number("level").unwrap_or(Some(voice.strength(None, None).0));
        if let (Some(seconds), Some(level)) = (seconds, level) {
            self.see(voice, seconds, level, trigger.place.as_ref(), &trigger.play_span);
        }
    }

    fn see(&mut self, voice: &'a Voice, seconds: f64, level: f64, place: Option<&Place>, span: &'a Span) {
        let far = |short: &Short| short.seconds / short.rise.seconds;
        for new in self.short(voice, seconds, level, place) {
            match self.found.entry((&voice.name, new.actuator)) {
                Entry::Vacant(slot) => drop(slot.insert((new, span))),
                Entry::Occupied(mut slot) => {
                    if far(&new) < far(&slot.get().0) {
                        slot.insert((new, span));
                    }
                }
            }
        }
    }

    /// The outputs on which an event is over too soon.
    fn short(&self, voice: &Voice, seconds: f64, level: f64, place: Option<&Place>) -> Vec<Short<'a>> {
        if !self.plain.contains(voice.name.as_str()) {
            return Vec::new();
        }
        let place = place.or(voice.place.as_ref());
        let Ok(spot) = self.rig.resolve_by(&self.finder, place, &(0..0)) else { return Vec::new() };
        let (rig, outputs) = (self.rig, self.finder.outputs(spot));
        let short = |number: usize| {
            let output = rig.outputs.get(number)?;
            let (actuator, rise) = (output.actuator.as_ref()?, rig.rise(output, level)?);
            (seconds < rise.seconds).then_some(Short { seconds, rise, output: &output.name, actuator })
        };
        outputs.into_iter().filter_map(short).collect()
    }
}

impl Short<'_> {
    fn told(&self, which: &str, voice: &str, span: &Span) -> Problem {
        let (event, rise) = (1e3 * self.seconds, 1e3 * self.rise.seconds);
        let what = format!(
            "{which} of voice `{voice}` on `{}` lasts {event:.1} ms; its actuator `{}` takes {rise:.0} ms to {:.0} % of what it is to shake \
             with, so it is felt weaker",
            self.output,
            self.actuator,
            100.0 * RISEN
        );
        let help = match self.rise.way {
            Way::EvenOut => "make the event longer, or let the rig overdrive the actuator: even_out = {}",
            Way::Overdrive => {
                "make the event longer, or let the drive overdrive the motor: shaping = \"inverse\""
            }
            Way::Volts => {
                "make the event longer, or give the motor more volts to be overdriven with: the amplifier's `gain` and `max_volts`"
            }
            Way::None => "make the event longer",
        };
        Problem::warning(span, what).help(help.to_string())
    }
}
