//! What a patch on a rig will run, and what was left out: for people and for programs.

use super::input::InputReport;
use super::load::Loaded;
use super::paint::Paint;
use super::table::{Table, hertz, many};
use pacinian::graph::plan::{LeftOut, OutputKind, Plan, Precision, Why};
use pacinian::patch::{Action, Events, Patch, Pattern, Source};
use pacinian::player::Player;
use pacinian::rig::Peak;
use pacinian::score::Score;
use pacinian::text::Problem;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What will run.
#[derive(Debug, Serialize)]
pub struct PlanReport {
    title: String,
    rig: String,
    device_rate: f64,
    engine_rate: f64,
    ratio: usize,
    precision: &'static str,
    taps: usize,
    seed: u64,
    delay_ms: DelayMs,
    voices: Vec<VoiceReport>,
    shared: SharedReport,
    controls: Vec<ControlReport>,
    /// What the patch listens to; null where that is nothing.
    input: Option<InputReport>,
    channels: usize,
    outputs: Vec<OutputReport>,
    patterns: Vec<PatternReport>,
    /// Until the last event has ended; null where that is not known beforehand.
    seconds: Option<f64>,
    left_out: Vec<Left>,
}

#[derive(Debug, Serialize)]
struct DelayMs {
    total: f64,
    voices: f64,
    up_sampling: f64,
    band_limit: f64,
}

#[derive(Debug, Serialize)]
struct VoiceReport {
    name: String,
    voices: usize,
    ops: usize,
    buffers: usize,
    lanes: usize,
    always: bool,
}

#[derive(Debug, Serialize)]
struct SharedReport {
    ops: usize,
    buffers: usize,
}

#[derive(Debug, Serialize)]
struct ControlReport {
    name: String,
    default: f64,
    least: f64,
    most: f64,
    unit: String,
    smoothing: f64,
}

#[derive(Debug, Serialize)]
struct OutputReport {
    channel: u32,
    name: String,
    kind: &'static str,
    equaliser: Vec<PeakReport>,
}

#[derive(Debug, Serialize)]
struct PeakReport {
    frequency: f64,
    gain_db: f64,
    q: f64,
}

#[derive(Debug, Serialize)]
struct PatternReport {
    name: String,
    /// From the beginning.
    plays: bool,
    /// Whether it plays or one that plays plays it.
    reached: bool,
    /// Patterns that play it.
    played_by: Vec<String>,
    endless: bool,
    seconds: Option<f64>,
    file: Option<String>,
    /// As they stand in the patch or its file.
    events: u64,
    /// How often they begin, repetitions counted; null where that is drawn, endless or not known.
    onsets: Option<u64>,
}

/// Something left out.
#[derive(Debug, Serialize)]
pub struct Left {
    what: String,
    why: String,
}

/// What was left out, for programs.
pub fn left_out(list: &[LeftOut]) -> Vec<Left> {
    list.iter().map(|l| Left { what: l.what.clone(), why: l.why.to_string() }).collect()
}

/// What was left out, as lines; outputs that nothing feeds in one.
pub fn left_out_text(list: &[LeftOut]) -> String {
    let mut table = Table::default();
    let unfed: Vec<&str> = list.iter().filter_map(unfed).collect();
    let mut told = unfed.len() < 2;
    for left in list {
        if unfed.len() < 2 || self::unfed(left).is_none() {
            table.row([left.what.clone(), left.why.to_string()]);
        } else if !told {
            told = true;
            table.row([format!("outputs {}", ranges(&unfed)), "nothing feeds them".into()]);
        }
    }
    table.text()
}

/// The name of an output that nothing feeds.
fn unfed(left: &LeftOut) -> Option<&str> {
    let name = left.what.strip_prefix("output `").and_then(|rest| rest.strip_suffix('`'));
    name.filter(|_| left.why == Why::NeverFed)
}

/// "`t3` to `t8`, `top`": three names or more that count up are told by their ends.
fn ranges(names: &[&str]) -> String {
    let split = |name: &str| {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        Some((stem.to_string(), name[stem.len()..].parse::<u64>().ok()?))
    };
    let mut runs: Vec<Vec<&str>> = Vec::new();
    for name in names {
        let follows = |run: &Vec<&str>| {
            let last = run.last().and_then(|last| split(last));
            last.zip(split(name)).is_some_and(|((a, m), (b, n))| a == b && m.checked_add(1) == Some(n))
        };
        match runs.last_mut().filter(|run| follows(run)) {
            Some(run) => run.push(name),
            None => runs.push(vec![name]),
        }
    }
    let shown = |run: &Vec<&str>| match run.as_slice() {
        [first, _, .., last] => format!("`{first}` to `{last}`"),
        few => few.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
    };
    runs.iter().map(shown).collect::<Vec<_>>().join(", ")
}

/// Channels listed one by one, at most.
const SHOWN: usize = 16;

impl PlanReport {
    /// Of a player that has not begun.
    pub fn new(loaded: &Loaded, player: &Player) -> Self {
        let (plan, delay) = (player.plan(), player.engine().delay());
        let unit = |name: &str| {
            loaded.patch.controls.iter().find(|c| c.name == name).map_or(String::new(), |c| c.unit.clone())
        };
        Self {
            title: loaded.patch.title.clone(),
            rig: loaded.rig.title.clone(),
            device_rate: plan.device_rate,
            engine_rate: plan.engine_rate(),
            ratio: plan.ratio,
            precision: precision(plan.precision),
            taps: plan.taps,
            seed: plan.seed,
            delay_ms: DelayMs {
                total: 1e3 * delay.total(),
                voices: 1e3 * delay.lead,
                up_sampling: 1e3 * delay.up_sampling,
                band_limit: 1e3 * delay.band_limit_group,
            },
            voices: voices(plan),
            shared: SharedReport { ops: plan.shared_program.ops.len(), buffers: plan.shared_program.buffers },
            controls: plan
                .controls
                .iter()
                .map(|c| ControlReport {
                    name: c.name.to_string(),
                    default: c.default,
                    least: c.least,
                    most: c.most,
                    unit: unit(&c.name),
                    smoothing: c.smoothing,
                })
                .collect(),
            input: InputReport::of(loaded, player),
            channels: plan.channels,
            outputs: plan
                .outputs
                .iter()
                .map(|o| OutputReport {
                    channel: o.channel + 1,
                    name: o.name.to_string(),
                    kind: kind(o.kind),
                    equaliser: if o.equaliser.is_empty() { Vec::new() } else { peaks(loaded, &o.name) },
                })
                .collect(),
            patterns: patterns(loaded),
            seconds: player.length(),
            left_out: left_out(&plan.left_out),
        }
    }

    /// As lines for people.
    pub fn text(&self, plan: &Plan, paint: Paint) -> String {
        let mut facts = Table::default();
        facts.row(["title", &self.title]);
        let given = if self.rig.is_empty() { "without a title" } else { &self.rig };
        facts.row(["rig".into(), format!("{given}, {}", many(self.channels, "channel"))]);
        facts.row(["device".into(), hertz(self.device_rate)]);
        let (rate, ratio, taps) = (hertz(self.engine_rate), self.ratio, self.taps);
        facts.row(["engine".into(), format!("{rate} (1/{ratio}), {}, {taps} taps a phase", self.precision)]);
        let d = &self.delay_ms;
        facts.row([
            "delay".into(),
            format!(
                "{:.2} ms at 250 Hz = {:.2} voices + {:.2} up-sampling + {:.2} band limit",
                d.total, d.voices, d.up_sampling, d.band_limit
            ),
        ]);
        if let Some(input) = &self.input {
            facts.row(["input".into(), input.text()]);
        }
        facts.row(["seed".into(), self.seed.to_string()]);
        let mut text = facts.text();
        let mut section = |title: &str, lines: String| {
            if !lines.is_empty() {
                text += &format!("\n{}\n{lines}", paint.bold(title));
            }
        };
        section("voices", self.voice_lines());
        section("controls", self.control_lines());
        section("patterns", self.pattern_lines());
        section("channels", self.channel_lines());
        section("left out, and why", left_out_text(&plan.left_out));
        text
    }

    fn voice_lines(&self) -> String {
        let mut table = Table::default();
        for voice in &self.voices {
            table.row([
                voice.name.clone(),
                many(voice.voices, "voice"),
                many(voice.ops, "op"),
                many(voice.buffers, "buffer"),
                many(voice.lanes, "lane"),
                if voice.always { "always on".into() } else { String::new() },
            ]);
        }
        if self.shared.ops > 0 {
            let (ops, buffers) = (many(self.shared.ops, "op"), many(self.shared.buffers, "buffer"));
            table.row(["shared nodes", "", &ops, &buffers, "", ""]);
        }
        table.text()
    }

    fn control_lines(&self) -> String {
        let mut table = Table::default();
        for c in &self.controls {
            let unit = if c.unit.is_empty() { String::new() } else { format!(" {}", c.unit) };
            let range = format!("from {} to {}{unit}", c.least, c.most);
            table.row([
                c.name.clone(),
                format!("{}{unit}", c.default),
                range,
                format!("within {} ms", 1e3 * c.smoothing),
            ]);
        }
        table.text()
    }

    fn pattern_lines(&self) -> String {
        let mut table = Table::default();
        for p in &self.patterns {
            let length = match p.seconds {
                _ if p.endless => "without end".into(),
                Some(seconds) => format!("{seconds:.2} s"),
                None if p.file.is_some() => "length depends on the file".into(),
                None => "length depends on chance".into(),
            };
            let from = p.file.as_ref().map_or(String::new(), |file| format!(" from {file}"));
            let plays = match (p.plays, p.reached) {
                (true, _) => "plays".into(),
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

    fn channel_lines(&self) -> String {
        let mut table = Table::default();
        for output in self.outputs.iter().take(SHOWN) {
            let peak = |p: &PeakReport| format!("{:+} dB at {} (q {})", p.gain_db, hertz(p.frequency), p.q);
            let peaks: Vec<String> = output.equaliser.iter().map(peak).collect();
            let equaliser =
                if peaks.is_empty() { String::new() } else { format!("equaliser {}", peaks.join(", ")) };
            table.row([output.channel.to_string(), output.name.clone(), output.kind.into(), equaliser]);
        }
        let more = self.outputs.len().saturating_sub(SHOWN);
        if more > 0 {
            table.row(["...".into(), format!("and {more} more")]);
        }
        table.text()
    }
}

/// "f32" or "f64".
pub fn precision(precision: Precision) -> &'static str {
    match precision {
        Precision::Single => "f32",
        Precision::Double => "f64",
    }
}

fn kind(kind: OutputKind) -> &'static str {
    match kind {
        OutputKind::Vibration => "vibration",
        OutputKind::Raw => "raw: no limiter, no band limit",
        OutputKind::Silent => "not rendered, stays at zero",
        OutputKind::Trigger { .. } => "trigger",
    }
}

/// The equaliser of an output.
fn peaks(loaded: &Loaded, name: &str) -> Vec<PeakReport> {
    let output = loaded.rig.outputs.iter().find(|o| o.name == name);
    let actuator = output.and_then(|o| loaded.rig.actuator(o.actuator.as_deref()?));
    let report = |p: &Peak| PeakReport { frequency: p.frequency, gain_db: p.gain_db, q: p.q };
    actuator.map_or(Vec::new(), |a| a.equaliser.iter().map(report).collect())
}

fn voices(plan: &Plan) -> Vec<VoiceReport> {
    let lanes = pacinian::dsp::lanes::LANES;
    let report = |i: &pacinian::graph::plan::Instrument| VoiceReport {
        name: i.name.to_string(),
        voices: i.voices,
        ops: i.program.ops.len(),
        buffers: i.program.buffers,
        lanes: i.voices.div_ceil(lanes) * lanes,
        always: i.always,
    };
    plan.instruments.iter().map(report).collect()
}

fn patterns(loaded: &Loaded) -> Vec<PatternReport> {
    let patch = &loaded.patch;
    let playing = playing(loaded);
    let reached = reached(patch, &playing);
    let (players, mut onsets) = (players(patch), Onsets::new(patch));
    let report = |(i, pattern): (usize, &Pattern)| {
        let refuse = |path: &str| Err(Problem::of_file(path));
        let score = Score::new(patch, |_| Ok(0), &[(i, 0.0)], 0, refuse);
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
            reached: reached.contains(&i),
            played_by: players.get(pattern.name.as_str()).cloned().unwrap_or_default(),
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

    /// `None` where it is drawn, read from a file or without end, or where patterns nest deeper than any that plays.
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
            let one = match &event.action {
                Action::Voice(_) | Action::Marker(_) => 1,
                Action::Pattern { pattern, .. } => self.of(pattern, depth + 1)?,
                Action::Choose(_) => return None,
            };
            let times = event.repeat.map_or(Some(1), |r| r.times)?;
            sum = sum.checked_add(one.checked_mul(times)?)?;
        }
        sum.checked_mul(pattern.repeat.map_or(Some(1), |r| r.times)?)
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
    if starts.peek().is_none() && !patch.patterns.is_empty() {
        return vec![0];
    }
    starts.filter_map(|t| find(&t.play)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Onsets, left_out_text, players, ranges};
    use pacinian::graph::plan::{LeftOut, Why};
    use pacinian::patch::Patch;

    #[test]
    fn outputs_that_nothing_feeds_are_told_in_one_line() {
        let left = |what: &str, why| LeftOut { what: what.into(), why };
        let mut list = vec![left("node `a`", Why::Pruned)];
        list.extend((3..=8).map(|n| left(&format!("output `t{n}`"), Why::NeverFed)));
        list.push(left("trigger `key.1`", Why::NotYet));
        let text = left_out_text(&list);
        assert_eq!(text.lines().count(), 3, "{text}");
        let line = text.lines().nth(1).unwrap_or_default();
        assert_eq!(
            line.split_whitespace().collect::<Vec<_>>().join(" "),
            "outputs `t3` to `t8` nothing feeds them"
        );
        assert!(left_out_text(&list[..2]).contains("output `t3`"), "one alone is told as it is");
    }

    #[test]
    fn names_that_count_up_are_told_by_their_ends() {
        assert_eq!(ranges(&["t1", "t2", "t4", "t5", "t6", "top"]), "`t1`, `t2`, `t4` to `t6`, `top`");
        assert_eq!(ranges(&["a1", "b2", "9", "10", "11"]), "`a1`, `b2`, `9` to `11`");
        assert_eq!(ranges(&["t99999999999999999999", "t18446744073709551615"]).matches('`').count(), 4);
    }

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
            [pattern.d]\nevents = [{ at = 0, choose = [{ voice = \"v\" }] }]\n";
        let patch = Patch::parse("p.toml", text.as_bytes()).unwrap().value;
        let mut onsets = Onsets::new(&patch);
        assert_eq!(["a", "b", "c", "d", "e"].map(|p| onsets.of(p, 0)), [Some(33), Some(5), None, None, None]);
        assert_eq!(players(&patch).get("b"), Some(&vec!["a".to_string()]));
    }
}
