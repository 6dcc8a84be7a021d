//! What works and was hardly meant so: warnings that need the patch, the rig and the command line together.

use super::loaded::Loaded;
use super::outside::words;
use super::patterns::playing;
use pacinian::patch::{Patch, Pattern, Place, Start, Trigger};
use pacinian::text::problem::escaped;
use pacinian::text::{Problem, Problems, Severity, Span};
use std::collections::HashSet;

/// Warnings, by line; `None` where there are none. `by_default`: nobody named a rig. `deaf`: the patch listens, and nobody said
/// to what; `live`: it is played on a device.
pub fn of(loaded: &Loaded, by_default: bool, deaf: bool, live: bool) -> Option<Problems> {
    let mut list = loaded.rig.advise(&loaded.patch);
    if by_default {
        list.extend(too_long(&loaded.patch));
    }
    if deaf {
        let help = match live {
            true => "give it a sound card, --input-device NAME, or a WAV file, --input FILE.wav",
            false => "give it a WAV file: --input FILE.wav",
        };
        list.push(whole("the patch listens, and hears silence", help));
    }
    let sensed = live && !loaded.options.attached && loaded.patch.knob.is_some();
    let (read, on_line) = loaded
        .rig
        .knob
        .as_ref()
        .map_or((false, false), |knob| (knob.sensor.is_some(), knob.controller.is_some()));
    if sensed && read && !on_line {
        let help = "name the sound card that its sensor is plugged into: --input-device NAME, or [device] input = \"NAME\" in the rig";
        list.push(whole(
            "the rig reads a knob by a sound card's inputs, and none is named: it is simulated",
            help,
        ));
    }
    // Whoever plays it live knows what to do.
    let waits = loaded.options.live && loaded.patch.triggers.iter().any(|t| t.on.is_live());
    if !plays(loaded) && !waits {
        list.push(whole(
            "nothing in this patch plays by itself",
            "give it a [pattern], a [[trigger]] with on = \"start\", or a voice with start = \"always\"",
        ));
    }
    (!list.is_empty()).then(|| loaded.patch.origin.problems(list))
}

/// What it waits for that is played live, where nothing in it plays by itself: none of its patterns does, if `first` is empty.
pub fn waits(loaded: &Loaded, first: &[usize]) -> Option<String> {
    let patch = &loaded.patch;
    let follows = |pattern: &&Pattern| pattern.follows;
    let clocked: Vec<&Pattern> =
        first.iter().filter_map(|place| patch.patterns.get(*place)).filter(follows).collect();
    let live = patch.triggers.iter().any(|trigger| trigger.on.is_live());
    if first.len() > clocked.len() || voices_play(patch) || (clocked.is_empty() && !live) {
        return None;
    }
    let words_of = |trigger: &Trigger| Some(format!("{} ({})", words(&trigger.on)?, trigger.play));
    let mut all: Vec<String> = patch.triggers.iter().filter_map(words_of).collect();
    all.extend(clocked.iter().map(|pattern| format!("the clock of MIDI ({})", pattern.name)));
    let more = all.len().saturating_sub(SHOWN);
    all.truncate(SHOWN);
    if more > 0 {
        all.push(format!("{more} more"));
    }
    Some(escaped(&format!("nothing plays by itself; it waits for {}", all.join(", "))).into_owned())
}

/// Triggers that are listed.
const SHOWN: usize = 6;

fn whole(what: &str, help: &str) -> Problem {
    Problem { severity: Severity::Warning, ..Problem::of_file(what).help(help.to_string()) }
}

/// Whether anything sounds or is marked without somebody to play it.
fn plays(loaded: &Loaded) -> bool {
    voices_play(&loaded.patch) || !playing(loaded).is_empty()
}

/// The same, its patterns aside that play from the beginning.
fn voices_play(patch: &Patch) -> bool {
    let starts = patch.triggers.iter().filter(|t| !t.on.is_live());
    let started: HashSet<&str> = starts.map(|t| t.play.as_str()).collect();
    let voice = patch.voices.iter().any(|v| v.start == Start::Always || started.contains(v.name.as_str()));
    voice || patch.set_off().next().is_some()
}

/// Tactors of the line that there is without a rig.
const LINE: u32 = 8;

/// A place far beyond the line and beyond all others, which makes the line so long.
fn too_long(patch: &Patch) -> Option<Problem> {
    let mut named: Vec<(u32, String, Span)> = Vec::new();
    patch.each_place(|place, span| match place {
        Place::Name(name) => {
            let number = name.strip_prefix('t').and_then(|n| n.parse().ok());
            named.extend(number.map(|n| (n, name.clone(), span.clone())));
        }
        Place::Channel(n) => named.push((*n, format!("channel {n}"), span.clone())),
        // A line has no groups, but those of its tactors may be listed.
        Place::Names(names) => named.extend(names.iter().filter_map(|name| {
            let number = name.strip_prefix('t').and_then(|n| n.parse().ok())?;
            Some((number, name.clone(), span.clone()))
        })),
        Place::Position(_) | Place::Path(_) => {}
    });
    named.retain(|(n, ..)| *n <= pacinian::rig::MAX_CHANNELS);
    let most = named.iter().map(|(n, ..)| *n).max()?;
    let next = named.iter().map(|(n, ..)| *n).filter(|n| *n < most).max().unwrap_or(0).max(LINE);
    if most <= next + 1 {
        return None;
    }
    let (_, name, span) = named.into_iter().find(|(n, ..)| *n == most)?;
    let what = format!("`{name}` makes the line {most} tactors long; without a rig there are {LINE}");
    let help = "if it is meant, name a rig that has it with --rig".to_string();
    Some(Problem::warning(&span, what).help(help))
}

#[cfg(test)]
mod tests {
    use super::too_long;
    use pacinian::patch::{Patch, Place, Voice};

    #[test]
    fn a_line_that_one_place_makes_long_is_told() {
        let with = |places: &[u32]| {
            let name = |n: &u32| Some(Place::Name(format!("t{n}")));
            let voices = places.iter().map(|n| Voice { place: name(n), ..Voice::new("v", "o") }).collect();
            too_long(&Patch { voices, ..Patch::default() }).map(|p| p.what)
        };
        let told = with(&[1, 22]).unwrap_or_default();
        assert!(told.contains("`t22` makes the line 22 tactors long; without a rig there are 8"), "{told}");
        assert_eq!(with(&[1, 2, 8]), None);
        assert_eq!(with(&[8, 9, 10]), None);
        assert_eq!(with(&[]), None);
    }
}
