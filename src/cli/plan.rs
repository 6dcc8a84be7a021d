//! What a patch on a rig will run, and what was left out: for people and for programs.

use super::input::InputReport;
use super::load::Loaded;
use super::paint::Paint;
use super::table::{Table, hertz, many};
use pacinian::graph::plan::{LeftOut, OutputKind, Plan, Precision};
use pacinian::patch::{Action, Events, Patch, Pattern, Source};
use pacinian::player::Player;
use pacinian::rig::Peak;
use pacinian::score::Score;
use pacinian::text::Problem;
use serde::Serialize;
use std::collections::BTreeSet;

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
    /// Within one that plays.
    nested: bool,
    endless: bool,
    seconds: Option<f64>,
    file: Option<String>,
    events: u64,
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

/// What was left out, as lines.
pub fn left_out_text(list: &[LeftOut]) -> String {
    let mut table = Table::default();
    for left in list {
        table.row([left.what.clone(), left.why.to_string()]);
    }
    table.text()
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
                None => "length is drawn or read".into(),
            };
            let from = p.file.as_ref().map_or(String::new(), |file| format!(" from {file}"));
            let plays = match (p.plays, p.nested) {
                (true, _) => "plays",
                (false, true) => "within",
                (false, false) => "does not play",
            };
            table.row([p.name.clone(), plays.into(), length, many(p.events as usize, "event") + &from]);
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
            nested: reached.contains(&i),
            endless: is_endless(pattern),
            seconds: score.ok().and_then(|s| s.length()),
            file,
            events,
        }
    };
    patch.patterns.iter().enumerate().map(report).collect()
}

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
