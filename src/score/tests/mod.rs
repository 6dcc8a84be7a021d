//! Tests of the score, with what they share.

mod draws;
mod files;
mod hostile;
mod motions;
mod naive;
mod stop;
mod time;

use super::{EventStream, Note, Score, Timed, What};
use crate::patch::{
    self, Action, Alternative, Event, Events, Patch, Pattern, Place, Play, Repeat, TimeBase, Voice,
};
use crate::space::spot::Spot;
use crate::text::Problem;

fn pattern(name: &str, events: Vec<Event>) -> Pattern {
    Pattern {
        name: name.into(),
        time: TimeBase::Seconds,
        follows: false,
        events: Events::Inline(events),
        repeat: None,
        gain: 1.0,
        rate: 1.0,
        shuffle: false,
        jitter: None,
        span: 0..0,
    }
}

fn event(at: f64, action: Action) -> Event {
    Event { at, delay: 0.0, repeat: None, action, span: 0..0 }
}

fn voice(name: &str, level: Option<f64>, duration: Option<f64>, fields: &[(&str, f64)]) -> Action {
    let fields = fields.iter().map(setting).collect();
    Action::Voice(Play {
        voice: name.into(),
        span: 0..0,
        level,
        felt: None,
        duration,
        place: None,
        place_span: 0..0,
        motion: None,
        fields,
    })
}

fn setting((name, value): &(&str, f64)) -> patch::Setting {
    patch::Setting { name: name.to_string(), value: *value, span: 0..0 }
}

/// Voice `a`, at full level for 1/8 s.
fn beat(at: f64) -> Event {
    event(at, voice("a", Some(1.0), Some(0.125), &[]))
}

fn nested(name: &str, gain: f64, rate: f64) -> Action {
    Action::Pattern { pattern: name.into(), span: 0..0, gain, rate }
}

fn choice(all: &[(f64, Action)]) -> Action {
    let alternative =
        |(weight, action): &(f64, Action)| Alternative { weight: *weight, action: action.clone() };
    Action::Choose(all.iter().map(alternative).collect())
}

fn jitter(at: f64, fractions: &[(&str, f64)]) -> patch::Jitter {
    patch::Jitter { at, fractions: fractions.iter().map(setting).collect() }
}

fn every(every: f64, times: impl Into<Option<u64>>) -> Option<Repeat> {
    Some(Repeat { every, times: times.into() })
}

/// Voices `a` and `b`; `b` has a default level of 1/2, a duration of 2, a place and a field of its own.
fn patch(patterns: Vec<Pattern>) -> Patch {
    let mut b = Voice::new("b", "out");
    b.level = 0.5;
    b.duration = 2.0;
    b.place = Some(Place::Channel(7));
    b.fields.push(("depth".into(), 3.0));
    Patch { voices: vec![Voice::new("a", "out"), b], patterns, ..Patch::default() }
}

fn output(place: Option<&Place>) -> Result<Spot, Problem> {
    match place {
        None => Ok(Spot::Row(0)),
        Some(Place::Channel(n)) => Ok(Spot::Row(*n)),
        Some(_) => Err(Problem::of_file("only channels here")),
    }
}

fn no_files(path: &str) -> Result<EventStream<'static>, Problem> {
    Err(Problem::of_file(format!("no {path}")))
}

fn score(patch: &Patch, roots: &[(usize, f64)], seed: u64) -> Result<Score<'static>, Problem> {
    Score::new(patch, output, roots, seed, no_files)
}

/// All that a score plays from its first pattern.
fn all(patch: &Patch, seed: u64) -> Vec<Timed> {
    score(patch, &[(0, 0.0)], seed).unwrap().map(Result::unwrap).collect()
}

fn note(timed: &Timed) -> &Note {
    match &timed.what {
        What::Play(note) => note,
        What::Marker(name) => panic!("marker {name}"),
    }
}

fn times(all: &[Timed]) -> Vec<f64> {
    all.iter().map(|t| t.at).collect()
}

fn refused(patch: &Patch) -> String {
    match score(patch, &[(0, 0.0)], 0) {
        Ok(score) => score.filter_map(Result::err).next().expect("an error").what,
        Err(problem) => problem.what,
    }
}
