//! The patterns of a patch: which play, how long and how often; for people and for programs.

use super::loaded::Loaded;
use super::table::{Table, many};
use pacinian::patch::{Action, Events, Patch, Pattern, Source};
use pacinian::score::Score;
use pacinian::space::spot::Spot;
use pacinian::text::Problem;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A pattern.
#[derive(Debug, Serialize)]
pub struct PatternReport {
    name: String,
    /// From the beginning.
    plays: bool,
    /// Whether it waits where it is played live, since keys or messages play the patch then.
    waits: bool,
    /// Whether it plays or one that plays plays it.
    reached: bool,
    /// Patterns that play it.
    played_by: Vec<String>,
    /// What nodes or a knob do that sets it off.
    set_off_by: Vec<String>,
    endless: bool,
    seconds: Option<f64>,
    file: Option<String>,
    /// As they stand in the patch or its file.
    events: u64,
    /// How often they begin, repetitions counted; null where that depends on chance, is endless or not known.
    onsets: Option<u64>,
}

/// As lines for people.
pub fn lines(patterns: &[PatternReport]) -> String {
    let mut table = Table::default();
    for p in patterns {
        let length = match p.seconds {
            _ if p.endless => "without end".into(),
            Some(seconds) => format!("{seconds:.2} s"),
            None if p.file.is_some() => "length depends on the file".into(),
            None => "length depends on chance".into(),
        };
        let from = p.file.as_ref().map_or(String::new(), |file| format!(" from {file}"));
        let plays = match (p.plays, p.reached) {
            (true, _) if p.waits => "plays; live, it waits".into(),
            (true, _) => "plays".into(),
            (false, _) if !p.set_off_by.is_empty() => format!("set off by {}", p.set_off_by.join(", ")),
            (false, true) => format!("played by {}", p.played_by.join(", ")),
            (false, false) => "does not play".into(),
        };
        let events = many(p.events as usize, "event") + &from;
        let onsets = p.onsets.filter(|n| *n != p.events).map(|n| many(n as usize, "onset"));
        let again = if p.endless && p.onsets.is_none() { Some("again and again".into()) } else { None };
        let more = onsets.or(again).map_or(String::new(), |more| format!(", {more}"));
        table.row([p.name.clone(), plays, length, events + &more]);
    }
    table.text()
}

/// All patterns, in the order of the patch.
pub fn patterns(loaded: &Loaded) -> Vec<PatternReport> {
    let patch = &loaded.patch;
    let playing = playing(loaded);
    let set_off: Vec<(&str, String)> = patch.set_off().collect();
    let waiting =
        patch.patterns.iter().enumerate().filter(|(_, p)| set_off.iter().any(|(name, _)| *name == p.name));
    let roots: Vec<usize> = playing.iter().copied().chain(waiting.map(|(number, _)| number)).collect();
    let reached = reached(patch, &roots);
    let (players, mut onsets) = (players(patch), Onsets::new(patch));
    let report = |(i, pattern): (usize, &Pattern)| {
        let refuse = |path: &str| Err(Problem::of_file(path));
        let score = Score::new(patch, |_| Ok(Spot::Row(0)), &[(i, 0.0)], 0, refuse);
        let (file, events) = match &pattern.events {
            Events::Inline(events) => (None, events.len() as u64),
            Events::File(path, _) => {
                let found = loaded.surveyed.iter().find(|(p, _)| p == path);
                (Some(path.clone()), found.map_or(0, |(_, events)| *events))
            }
        };
        PatternReport {
            name: pattern.name.clone(),
            plays: playing.contains(&i),
            waits: playing.contains(&i) && !pattern.follows && waits_live(loaded),
            reached: reached.contains(&i),
            played_by: players.get(pattern.name.as_str()).cloned().unwrap_or_default(),
            set_off_by: set_off
                .iter()
                .filter(|(name, _)| *name == pattern.name)
                .map(|(_, by)| by.clone())
                .collect(),
            endless: is_endless(pattern),
            seconds: score.ok().and_then(|s| s.length()),
            file,
            events,
            onsets: onsets.of(&pattern.name, 0),
        }
    };
    patch.patterns.iter().enumerate().map(report).collect()
}

/// For each pattern, by its name, the names of those that play it, by themselves or as one of a choice.
fn players(patch: &Patch) -> BTreeMap<&str, Vec<String>> {
    let mut players: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for pattern in &patch.patterns {
        let Events::Inline(events) = &pattern.events else { continue };
        let actions = events.iter().flat_map(|event| match &event.action {
            Action::Choose(list) => list.iter().map(|a| &a.action).collect(),
            action => vec![action],
        });
        for action in actions {
            let Action::Pattern { pattern: inner, .. } = action else { continue };
            let of = players.entry(inner).or_default();
            if of.last() != Some(&pattern.name) {
                of.push(pattern.name.clone());
            }
        }
    }
    players
}

/// How often voices and markers begin while a pattern plays once, with its repetitions and all that it plays.
struct Onsets<'a> {
    patterns: BTreeMap<&'a str, &'a Pattern>,
    known: BTreeMap<&'a str, Option<u64>>,
}

impl<'a> Onsets<'a> {
    fn new(patch: &'a Patch) -> Self {
        let patterns = patch.patterns.iter().map(|p| (p.name.as_str(), p)).collect();
        Self { patterns, known: BTreeMap::new() }
    }

    /// `None` where it depends on what is drawn, is read from a file or without end, or where patterns nest deeper than any that plays.
    fn of(&mut self, name: &str, depth: usize) -> Option<u64> {
        let pattern = *self.patterns.get(name)?;
        if let Some(known) = self.known.get(name) {
            return *known;
        }
        let found = if depth > DEEPEST { None } else { self.count(pattern, depth) };
        self.known.insert(&pattern.name, found);
        found
    }

    fn count(&mut self, pattern: &Pattern, depth: usize) -> Option<u64> {
        let Events::Inline(events) = &pattern.events else { return None };
        let mut sum: u64 = 0;
        for event in events {
            let one = self.begun(&event.action, depth)?;
            let times = event.repeat.map_or(Some(1), |r| r.times)?;
            sum = sum.checked_add(one.checked_mul(times)?)?;
        }
        sum.checked_mul(pattern.repeat.map_or(Some(1), |r| r.times)?)
    }

    fn begun(&mut self, action: &Action, depth: usize) -> Option<u64> {
        match action {
            Action::Voice(_) | Action::Marker(_) => Some(1),
            Action::Pattern { pattern, .. } => self.of(pattern, depth + 1),
            // Whatever is drawn, where all that may be begins as often.
            Action::Choose(list) => {
                let mut counts = list.iter().map(|a| self.begun(&a.action, depth));
                let first = counts.next()??;
                counts.all(|n| n == Some(first)).then_some(first)
            }
        }
    }
}

/// How deep patterns may nest for their onsets to be counted.
const DEEPEST: usize = 64;

/// Patterns that those in `playing` play, they among them.
fn reached(patch: &Patch, playing: &[usize]) -> BTreeSet<usize> {
    let find = |name: &str| patch.patterns.iter().position(|p| p.name == name);
    let (mut found, mut open) = (BTreeSet::new(), playing.to_vec());
    while let Some(index) = open.pop() {
        let Some(pattern) = patch.patterns.get(index).filter(|_| found.insert(index)) else { continue };
        let Events::Inline(events) = &pattern.events else { continue };
        let mut visit = |action: &Action| match action {
            Action::Pattern { pattern, .. } => open.extend(find(pattern)),
            Action::Voice(_) | Action::Marker(_) | Action::Choose(_) => {}
        };
        for event in events {
            visit(&event.action);
            if let Action::Choose(list) = &event.action {
                list.iter().for_each(|a| visit(&a.action));
            }
        }
    }
    found
}

/// Whether it repeats for ever.
pub fn is_endless(pattern: &Pattern) -> bool {
    pattern.repeat.is_some_and(|r| r.times.is_none())
}

/// Patterns that play from the beginning, by their place in the patch.
pub fn playing(loaded: &Loaded) -> Vec<usize> {
    let patch = &loaded.patch;
    let find = |name: &str| patch.patterns.iter().position(|p| p.name == name);
    if let Some(name) = &loaded.options.pattern {
        return find(name).into_iter().collect();
    }
    let mut starts = patch.triggers.iter().filter(|t| t.on == Source::Start).peekable();
    // Where nodes or a knob set some off, or a song plays, they wait for that.
    let sung = loaded.song_name.is_some() && patch.triggers.iter().any(|t| t.on.is_live());
    let waits = sung || patch.set_off().next().is_some();
    if starts.peek().is_none() && !patch.patterns.is_empty() && !waits {
        return vec![0];
    }
    starts.filter_map(|t| find(&t.play)).collect()
}

/// Whether what plays from the beginning without being told to waits where the patch is played live.
fn waits_live(loaded: &Loaded) -> bool {
    let triggers = &loaded.patch.triggers;
    let is_told = loaded.options.pattern.is_some() || triggers.iter().any(|t| t.on == Source::Start);
    !is_told && triggers.iter().any(|t| t.on.is_live())
}

#[cfg(test)]
mod tests {
    use super::{Onsets, players};
    use pacinian::patch::Patch;

    /// Patterns that each play the next twice begin 2^n times, and are counted in n steps.
    #[test]
    fn nested_patterns_are_counted_once_each() {
        let mut text = String::from("format = \"pacinian-patch/1\"\ntitle = \"T\"\n");
        for i in 0..50 {
            let inner = format!("pattern = \"p{}\"", i + 1);
            text += &format!("[pattern.p{i}]\nevents = [{{ at = 0, {inner} }}, {{ at = 1, {inner} }}]\n");
        }
        text += "[pattern.p50]\nevents = [{ at = 0, marker = \"m\" }]\n";
        let patch = Patch::parse("p.toml", text.as_bytes()).unwrap().value;
        assert_eq!(Onsets::new(&patch).of("p0", 0), Some(1 << 50));
    }

    #[test]
    fn onsets_count_every_repetition() {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.v]\noutput = \"n\"\nnodes.n = { type = \"white\" }\n\
            [pattern.a]\nrepeat = { every = 1, times = 3 }\nevents = [{ at = 0, pattern = \"b\", repeat = { every = 1, times = 2 } }, { at = 0, marker = \"m\" }]\n\
            [pattern.b]\nevents = [{ at = 0, voice = \"v\", repeat = { every = 0.1, times = 5 } }]\n\
            [pattern.c]\nrepeat = { every = 1 }\nevents = [{ at = 0, voice = \"v\" }]\n\
            [pattern.d]\nevents = [{ at = 0, choose = [{ voice = \"v\" }, { marker = \"m\" }], repeat = { every = 1, times = 4 } }]\n\
            [pattern.e]\nevents = [{ at = 0, choose = [{ voice = \"v\" }, { pattern = \"b\" }] }]\n";
        let patch = Patch::parse("p.toml", text.as_bytes()).unwrap().value;
        let mut onsets = Onsets::new(&patch);
        assert_eq!(
            ["a", "b", "c", "d", "e"].map(|p| onsets.of(p, 0)),
            [Some(33), Some(5), None, Some(4), None]
        );
        assert_eq!(players(&patch).get("b"), Some(&vec!["a".to_string(), "e".to_string()]));
    }
}
