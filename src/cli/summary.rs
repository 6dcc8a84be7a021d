//! What a rendering turned out to be.

use super::feel::FeelReport;
use super::held_back::{self, HeldBack};
use super::input::InputReport;
use super::left_out::{Left, left_out, left_out_text};
use super::loaded::Loaded;
use super::paint::Paint;
use super::perform::Performed;
use super::setting::{Setting, named};
use super::table::{Table, dbfs, grouped, hertz, many};
use pacinian::io::wav::{Encoding, Written};
use pacinian::live::midi_board::MidiBoard;
use pacinian::player::Player;
use pacinian::score::HORIZON;
use serde::Serialize;
use std::collections::BTreeMap;

/// What a rendering turned out to be.
#[derive(Debug, Serialize)]
pub struct Summary {
    file: String,
    /// Whether it went to its end.
    complete: bool,
    format: String,
    rate: f64,
    channels: usize,
    frames: u64,
    seconds: f64,
    bytes: u64,
    rf64: bool,
    /// Controls that the command line set.
    set: Vec<Setting>,
    /// What the patch listens to; null where that is nothing.
    input: Option<InputReport>,
    /// Largest magnitude by channel.
    peaks: Vec<Peak>,
    run_time_seconds: f64,
    times_real_time: f64,
    voices_started: u64,
    voices_stolen: u64,
    /// Channel-samples at the engine's rate that the limiter turned down.
    limited: u64,
    /// Samples that the clamp at full scale cut.
    clamped: u64,
    /// Samples that were no numbers and became 0.
    masked: u64,
    /// Samples beyond 120 dB over full scale that were held there.
    held: u64,
    /// What was held back for the sake of actuators, by output.
    held_back: Vec<HeldBack>,
    /// Whether patterns were cut at the end of the time that a score covers.
    cut: bool,
    events_dropped: u64,
    events_late: u64,
    /// Messages of a song that could not be used, by kind.
    midi: BTreeMap<&'static str, u64>,
    left_out: Vec<Left>,
    /// What was felt; null where nobody asked.
    pub feel: Option<FeelReport>,
    #[serde(skip)]
    left_out_text: String,
    #[serde(skip)]
    midi_text: Option<String>,
}

#[derive(Debug, Serialize)]
struct Peak {
    channel: usize,
    name: String,
    peak: f32,
    /// Decibels of full scale; null for silence.
    dbfs: Option<f64>,
}

/// Channels listed one by one, at most.
const SHOWN: usize = 32;

impl Summary {
    /// Of a file that was written.
    pub fn new(
        loaded: &Loaded,
        file: String,
        format: Encoding,
        player: &Player,
        performed: &Performed,
        written: &Written,
    ) -> Self {
        let (plan, names) = (player.plan(), loaded.tactors());
        let (counters, counts) = (player.counters(), player.engine().stage().counts());
        let seconds = written.frames as f64 / plan.device_rate;
        let run_time = performed.run_time.as_secs_f64();
        let midi = MidiBoard::from(player.midi_counts());
        let peak = |(i, peak): (usize, &f32)| Peak {
            channel: i + 1,
            name: names.get(i).cloned().unwrap_or_default(),
            peak: *peak,
            dbfs: (*peak > 0.0).then(|| 20.0 * f64::from(*peak).log10()),
        };
        Self {
            file,
            complete: performed.stopped.is_none() && player.trouble().is_none(),
            format: format.to_string(),
            rate: plan.device_rate,
            channels: plan.channels,
            frames: written.frames,
            seconds,
            bytes: written.bytes,
            rf64: written.rf64,
            set: loaded.settings.clone(),
            input: InputReport::of(loaded, player),
            peaks: performed.peaks.iter().enumerate().map(peak).collect(),
            run_time_seconds: run_time,
            times_real_time: if run_time > 0.0 { seconds / run_time } else { 0.0 },
            voices_started: counters.started,
            voices_stolen: counters.stolen,
            limited: counts.limited,
            clamped: counts.clamped + written.clipped,
            masked: counters.masked + counts.masked + written.non_finite,
            held: counts.held,
            held_back: held_back::held_back(plan, player.engine().stage()),
            cut: player.is_cut(),
            events_dropped: counters.dropped,
            events_late: counters.late,
            midi: midi.named().into_iter().filter(|(_, n, _)| *n > 0).map(|(name, n, _)| (name, n)).collect(),
            midi_text: midi.trouble(),
            left_out: left_out(&plan.left_out),
            feel: None,
            left_out_text: left_out_text(&plan.left_out),
        }
    }

    /// As lines for people.
    pub fn text(&self, paint: Paint) -> String {
        let mut table = Table::default();
        let rf64 = if self.rf64 { " (RF64)" } else { "" };
        let form = format!("{}, {}", self.format, hertz(self.rate));
        table.row(["channels".into(), format!("{}, {form}{rf64}", self.channels)]);
        table.row(["length".into(), format!("{:.3} s, {}", self.seconds, size(self.bytes))]);
        let speed = format!("{:.0} x real time", self.times_real_time);
        table.row(["run time".into(), format!("{:.3} s of wall time, {speed}", self.run_time_seconds)]);
        if !self.set.is_empty() {
            table.row(["set".into(), named(&self.set)]);
        }
        if let Some(input) = &self.input {
            table.row(["input".into(), input.text()]);
        }
        let voices =
            format!("{} started, {} stolen", grouped(self.voices_started), grouped(self.voices_stolen));
        table.row(["voices".into(), voices]);
        table.row(["limiter".into(), acted(self.limited, "sample turned down", "samples turned down")]);
        for (name, count, one, more) in [
            ("clamp", self.clamped, "sample cut at full scale", "samples cut at full scale"),
            (
                "masked",
                self.masked,
                "sample that was no number became 0",
                "samples that were no numbers became 0",
            ),
            (
                "held",
                self.held,
                "sample 120 dB over full scale was held there",
                "samples 120 dB over full scale were held there",
            ),
            ("dropped", self.events_dropped, "event found no room", "events found no room"),
            ("late", self.events_late, "event came after its time", "events came after their time"),
        ] {
            if count > 0 {
                table.row([name.into(), paint.yellow(&acted(count, one, more))]);
            }
        }
        if let Some(midi) = self.midi_text.as_deref().and_then(|text| text.strip_prefix("MIDI, ")) {
            table.row(["MIDI".into(), paint.yellow(midi)]);
        }
        if self.cut {
            let what = format!("what lies past {HORIZON:e} s was left out");
            table.row(["cut".into(), paint.yellow(&what)]);
        }
        let mut text =
            format!("{}\n{}", paint.bold(&pacinian::text::problem::escaped(&self.file)), table.text());
        text += &format!("\n{}\n{}", paint.bold("peaks"), self.peak_lines());
        let held_back = held_back::text(&self.held_back);
        if !held_back.is_empty() {
            text += &format!("\n{}\n{held_back}", paint.bold("held back, so that actuators bear it"));
        }
        if !self.left_out_text.is_empty() {
            text += &format!("\n{}\n{}", paint.bold("left out, and why"), self.left_out_text);
        }
        text + &self.feel.as_ref().map_or(String::new(), |feel| feel.text(paint))
    }

    fn peak_lines(&self) -> String {
        let mut table = Table::default();
        let silent = self.peaks.iter().filter(|p| p.dbfs.is_none()).count();
        let heard = || self.peaks.iter().filter(|p| p.dbfs.is_some());
        for peak in heard().take(SHOWN) {
            table.row([peak.channel.to_string(), peak.name.clone(), format!("{:>11}", dbfs(peak.peak))]);
        }
        let mut text = table.text();
        let more = heard().count().saturating_sub(SHOWN);
        if more > 0 {
            text += &format!("  and {more} more; --json shows all\n");
        }
        if silent > 0 {
            text += &format!("  {} of {} silent\n", silent, many(self.channels, "channel"));
        }
        text
    }
}

fn acted(count: u64, one: &str, more: &str) -> String {
    match count {
        0 => "did nothing".into(),
        1 => format!("1 {one}"),
        _ => format!("{} {more}", grouped(count)),
    }
}

pub fn size(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e6 => format!("{:.1} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.2} GB", b / 1e9),
    }
}
