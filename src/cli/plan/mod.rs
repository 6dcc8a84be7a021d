//! What a patch on a rig will run, and what was left out: for people and for programs.

mod output;

use super::input::InputReport;
use super::knob::figures::Figures;
use super::left_out::{Left, left_out, left_out_text};
use super::loaded::Loaded;
use super::outside::{self, OutsideReport};
use super::paint::Paint;
use super::patterns::{PatternReport, lines, patterns};
use super::table::{Table, hertz, many};
use output::OutputReport;
use pacinian::graph::answer::{Answer, Started, Voiced};
use pacinian::graph::plan::{Plan, Precision};
use pacinian::player::Player;
use serde::Serialize;

pub use super::patterns::{is_endless, playing};

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
    /// What plays it and moves its controls from outside.
    outside: Vec<OutsideReport>,
    /// Voices that nodes set off.
    triggers: Vec<WatchReport>,
    /// What the patch listens to; null where that is nothing.
    input: Option<InputReport>,
    channels: usize,
    outputs: Vec<OutputReport>,
    /// The force-feedback knob; null where the patch has none.
    knob: Option<Figures>,
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
    /// Of the high-pass that keeps steady voltages off; 0 where no output has one.
    high_pass: f64,
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
    /// Seconds by which one that is a stream is later than what comes; 0 of any other.
    stream: f64,
}

#[derive(Debug, Serialize)]
struct WatchReport {
    /// What sets it off, as the patch has it.
    on: String,
    play: String,
    /// Of a voice; null of a pattern, whose events say so.
    place: Option<String>,
    /// Seconds during which it does not set it off again.
    hold: f64,
    rearm: f64,
    /// From the instant at which the threshold is passed to the onset of the voice or the beginning of the pattern.
    delay_ms: f64,
}

/// Channels, and nodes that set something off, listed one by one, at most.
const SHOWN: usize = 16;

impl PlanReport {
    /// Of a player that has not begun.
    pub fn new(loaded: &Loaded, player: &Player) -> Self {
        let (plan, delay) = (player.plan(), player.engine().delay());
        let written = |name: &str| loaded.patch.controls.iter().find(|c| c.name == name);
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
                high_pass: 1e3 * delay.high_pass_group,
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
                    unit: written(&c.name).map_or(String::new(), |c| c.unit.clone()),
                    smoothing: c.smoothing,
                    stream: written(&c.name).map_or(0.0, |c| c.stream),
                })
                .collect(),
            outside: outside::all(&loaded.patch),
            triggers: watches(plan, player.engine().watch_delay()),
            input: InputReport::of(loaded, player),
            channels: plan.channels,
            outputs: plan.outputs.iter().map(|output| OutputReport::of(loaded, player, output)).collect(),
            knob: player.knob().and_then(|knob| Figures::new(plan, knob)),
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
        let mut knob = Table::default();
        self.knob.iter().for_each(|figures| figures.rows(&mut knob));
        section("knob", knob.text());
        section("patterns", lines(&self.patterns));
        section("played live", outside::lines(&self.outside));
        section("set off by nodes", self.watch_lines());
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
                match c.stream > 0.0 {
                    true => format!("a stream, {} ms later", 1e3 * c.stream),
                    false => format!("within {} ms", 1e3 * c.smoothing),
                },
            ]);
        }
        table.text()
    }

    fn watch_lines(&self) -> String {
        let mut table = Table::default();
        for watch in self.triggers.iter().take(SHOWN) {
            let hold =
                if watch.hold > 0.0 { format!("; not again within {} s", watch.hold) } else { String::new() };
            table.row([
                watch.on.clone(),
                match &watch.place {
                    Some(place) => format!("{} on {place}", watch.play),
                    None => format!("pattern {}", watch.play),
                },
                format!("{:.2} ms later{hold}", watch.delay_ms),
            ]);
        }
        let more = self.triggers.len().saturating_sub(SHOWN);
        if more > 0 {
            table.row(["...".into(), format!("and {more} more")]);
        }
        table.text()
    }

    fn channel_lines(&self) -> String {
        let mut table = Table::default();
        self.outputs.iter().take(SHOWN).for_each(|output| table.row(output.row()));
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

fn watches(plan: &Plan, delay: f64) -> Vec<WatchReport> {
    let report = |watch: &pacinian::graph::watch::Watch| {
        let (play, place, delay) = match watch.answer {
            Answer::Voice(Voiced { instrument, place, .. }) => {
                let name = plan.instruments.get(instrument as usize).map(|i| i.name.to_string());
                (name, Some(plan.called(place).into_owned()), delay)
            }
            Answer::Pattern(Started { pattern, .. }) => {
                let name = plan.answering.get(pattern as usize).map(ToString::to_string);
                (name, None, plan.answer as f64 / plan.engine_rate())
            }
        };
        WatchReport {
            on: watch.name.to_string(),
            play: play.unwrap_or_default(),
            place,
            hold: watch.hold,
            rearm: watch.rearm,
            delay_ms: 1e3 * delay,
        }
    };
    plan.watches.iter().map(report).collect()
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
