//! Events that are over before their actuator has risen: warnings.

use pacinian::graph::motions;
use pacinian::graph::scene::Scene;
use pacinian::patch::{Events, Patch, Place, Play, Source, Trigger, Voice};
use pacinian::rig::rise::{RISEN, Rise, Way};
use pacinian::rig::{Finder, Rig};
use pacinian::space::spot::Spread;
use pacinian::text::{Problem, Problems, Span};
use std::collections::{BTreeMap, HashMap, HashSet};

/// The event of a voice that falls shortest of the rise of an actuator.
struct Shortest<'a> {
    seconds: f64,
    rise: Rise,
    span: &'a Span,
    output: &'a str,
}

/// What is looked for.
struct Search<'a> {
    rig: &'a Rig,
    finder: Finder,
    voices: HashMap<&'a str, &'a Voice>,
    /// Voices that sound and order no clicks or spins, which have a length of their own.
    plain: HashSet<&'a str>,
    /// By voice and actuator.
    found: BTreeMap<(&'a str, &'a str), Shortest<'a>>,
}

/// Warnings of a scene that was made of these: of each voice on each actuator one; `None` where there are none.
pub fn short(patch: &Patch, rig: &Rig, scene: &Scene) -> Option<Problems> {
    let orders_nothing = |number: &Option<u32>| {
        let instrument = number.and_then(|number| scene.plan.instruments.get(number as usize));
        instrument.is_some_and(|instrument| instrument.commands().is_empty())
    };
    let voices = patch.voices.iter().zip(&scene.instruments);
    let mut search = Search {
        rig,
        finder: Finder::with(rig, patch),
        voices: patch.voices.iter().map(|voice| (voice.name.as_str(), voice)).collect(),
        plain: voices
            .filter(|(_, number)| orders_nothing(number))
            .map(|(voice, _)| voice.name.as_str())
            .collect(),
        found: BTreeMap::new(),
    };
    let array = scene.plan.spread.as_ref().map(Spread::array);
    motions::each(patch, array, |voice, play, _, bursts| {
        let level = voice.strength(play.level, play.felt.as_ref().map(|felt| felt.value)).0;
        for burst in bursts.map(|bursts| bursts.list).unwrap_or_default() {
            search.see(voice, burst.seconds, level, Some(&burst.place), &play.span);
        }
    });
    for pattern in &patch.patterns {
        let Events::Inline(events) = &pattern.events else { continue };
        let unit = pattern.time.seconds() / pattern.rate;
        for action in events.iter().flat_map(|event| event.action.each()) {
            if let pacinian::patch::Action::Voice(play) = action
                && play.motion.is_none()
            {
                search.event(play, unit);
            }
        }
    }
    patch.triggers.iter().for_each(|trigger| search.trigger(trigger));
    let list: Vec<Problem> = search.found.iter().map(|(of, shortest)| shortest.told(*of)).collect();
    (!list.is_empty()).then(|| patch.origin.problems(list))
}

impl<'a> Search<'a> {
    /// An event of a pattern in which a unit of time takes so many seconds.
    fn event(&mut self, play: &'a Play, unit: f64) {
        let Some(voice) = self.voices.get(play.voice.as_str()).copied() else { return };
        let seconds = play.duration.unwrap_or(voice.duration) * unit;
        let level = voice.strength(play.level, play.felt.as_ref().map(|felt| felt.value)).0;
        self.see(voice, seconds, level, play.place.as_ref(), &play.span);
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
        if !self.plain.contains(voice.name.as_str()) {
            return;
        }
        let place = place.or(voice.place.as_ref());
        let Ok(spot) = self.rig.resolve_by(&self.finder, place, span) else { return };
        for output in self.finder.outputs(spot) {
            let Some(output) = self.rig.outputs.get(output) else { continue };
            let Some(actuator) = &output.actuator else { continue };
            let Some(rise) = self.rig.rise(output, level) else { continue };
            if seconds >= rise.seconds {
                continue;
            }
            let new = Shortest { seconds, rise, span, output: &output.name };
            let known = self.found.entry((&voice.name, actuator));
            let shorter =
                |known: &Shortest| new.seconds / new.rise.seconds < known.seconds / known.rise.seconds;
            match known {
                std::collections::btree_map::Entry::Vacant(slot) => drop(slot.insert(new)),
                std::collections::btree_map::Entry::Occupied(mut slot) => {
                    if shorter(slot.get()) {
                        slot.insert(new);
                    }
                }
            }
        }
    }
}

impl Shortest<'_> {
    fn told(&self, (voice, actuator): (&str, &str)) -> Problem {
        let (event, rise) = (1e3 * self.seconds, 1e3 * self.rise.seconds);
        let what = format!(
            "the shortest event of voice `{voice}` on `{}` lasts {event:.1} ms; its actuator `{actuator}` takes {rise:.0} ms to {:.0} % of what it is to shake \
             with, so it is felt weaker",
            self.output,
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
        Problem::warning(self.span, what).help(help.to_string())
    }
}
