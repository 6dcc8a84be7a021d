//! The names of a patch, and what is wrong with an event that is to find its own among them.

use std::collections::{HashMap, HashSet};

use super::event::RESERVED;
use super::steered;
use super::{Action, Event, Patch, Pattern, Play, Setting, Start, Voice};
use crate::text::nearest::suggest;
use crate::text::{Problem, Span};

/// The voices and patterns of a patch by name, to check events by; also those of an events file, one by one.
#[derive(Debug, Clone)]
pub struct Names<'a> {
    pub(super) voices: HashMap<&'a str, &'a Voice>,
    pub(super) patterns: HashMap<&'a str, &'a Pattern>,
    pub(super) fields: HashSet<&'a str>,
}

impl<'a> Names<'a> {
    /// Of a patch.
    pub fn new(patch: &'a Patch) -> Self {
        let fields = patch.voices.iter().flat_map(|v| v.fields.iter().map(|(n, _)| n.as_str()));
        Self {
            voices: patch.voices.iter().map(|v| (v.name.as_str(), v)).collect(),
            patterns: patch.patterns.iter().map(|p| (p.name.as_str(), p)).collect(),
            fields: fields.collect(),
        }
    }
    /// The voice of that name.
    pub fn voice(&self, name: &str) -> Option<&'a Voice> {
        self.voices.get(name).copied()
    }
    /// The pattern of that name.
    pub fn pattern(&self, name: &str) -> Option<&'a Pattern> {
        self.patterns.get(name).copied()
    }
    /// Fields that any voice has, other than `level` and `duration`.
    pub fn fields(&self) -> impl Iterator<Item = &'a str> {
        self.fields.iter().copied()
    }
    /// What is wrong with an event: voices, patterns and fields that there are not.
    pub fn check_event(&self, event: &Event) -> Vec<Problem> {
        let mut problems = Vec::new();
        self.check_action(&event.action, &mut problems);
        problems
    }

    fn check_action(&self, action: &Action, problems: &mut Vec<Problem>) {
        match action {
            Action::Voice(play) => self.check_play(play, problems),
            Action::Pattern { pattern, span, .. } => match self.pattern(pattern) {
                None => {
                    let help = suggest(pattern, self.patterns.keys().copied());
                    problems
                        .push(Problem::error(span, format!("there is no pattern `{pattern}`")).help(help));
                }
                Some(inner) if inner.repeat.is_some_and(|r| r.times.is_none()) => {
                    let what =
                        format!("pattern `{pattern}` repeats for ever, so no other pattern can play it");
                    problems.push(
                        Problem::error(span, what).help("give its `repeat` a number of `times`".to_string()),
                    );
                }
                Some(_) => {}
            },
            Action::Marker(_) => {}
            Action::Choose(alternatives) => {
                alternatives.iter().for_each(|a| self.check_action(&a.action, problems));
            }
        }
    }

    fn check_play(&self, play: &Play, problems: &mut Vec<Problem>) {
        let Some(voice) = self.voice(&play.voice) else {
            let help = suggest(&play.voice, self.voices.keys().copied()).or_else(|| {
                let pattern = self.patterns.contains_key(play.voice.as_str());
                pattern.then(|| format!("`{}` is a pattern: pattern = \"{}\"", play.voice, play.voice))
            });
            problems
                .push(Problem::error(&play.span, format!("there is no voice `{}`", play.voice)).help(help));
            // What no voice has, the one that was meant has not, either.
            for Setting { name, span, .. } in &play.fields {
                if name != "frequency" && !self.fields.contains(name.as_str()) {
                    let what = format!("there is no field `{name}` in events of any voice");
                    let help = suggest(name, self.fields().chain(RESERVED.iter().copied()));
                    problems.push(Problem::error(span, what).help(help));
                }
            }
            return;
        };
        if voice.start == Start::Always {
            let what = format!("voice `{}` is always on, so no event can start it", voice.name);
            problems.push(Problem::error(&play.span, what).help("leave out its `start`".to_string()));
        }
        problems
            .extend(play.places().filter_map(|(place, span)| steered::fits(voice, Some(place), span)).next());
        super::felt::check_play(voice, play, problems);
        for setting in &play.fields {
            if voice.field(&setting.name).is_none() {
                problems.push(no_field(voice, &setting.name, &setting.span));
            }
        }
    }
}

pub(super) fn no_field(voice: &Voice, field: &str, span: &Span) -> Problem {
    let own = voice.fields.iter().map(|(n, _)| n.as_str());
    let help = suggest(field, own.chain(super::event::RESERVED.iter().copied()))
        .unwrap_or_else(|| format!("declare it with its default under [voice.{}.defaults]", voice.name));
    Problem::error(span, format!("events of voice `{}` have no field `{field}`", voice.name)).help(help)
}
