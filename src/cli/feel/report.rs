//! What was felt, for programs.

use super::super::loaded::Loaded;
use pacinian::feel::{Feel, Felt};
use pacinian::io::wav::Written;
use pacinian::rig::part::{self, Origin};
use serde::Serialize;
use std::time::Duration;

/// What was felt.
#[derive(Debug, Serialize)]
pub struct FeelReport {
    pub(super) file: String,
    pub(super) bytes: u64,
    pub(super) frames: u64,
    /// The largest error that was wished for.
    pub(super) error: f64,
    /// Of what is felt at 1 kHz, the share that is lost as drives are held and means are told.
    pub(super) held_loses: f64,
    pub(super) run_time_seconds: f64,
    /// What a frame holds, in order.
    pub(super) channels: Vec<Channel>,
    pub(super) outputs: Vec<OutputReport>,
    pub(super) not_felt: Vec<NotFelt>,
    /// What the rig does not say and was assumed.
    pub(super) assumed: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(super) struct Channel {
    pub(super) channel: usize,
    pub(super) output: String,
    pub(super) axis: &'static str,
    pub(super) unit: &'static str,
}

/// Figures in SI units; null where they are not known.
#[derive(Debug, Serialize)]
pub(super) struct OutputReport {
    pub(super) output: String,
    /// Of the rendering, from 1.
    pub(super) channel: usize,
    pub(super) actuator: String,
    pub(super) part: Option<String>,
    pub(super) model: &'static str,
    pub(super) unit: &'static str,
    pub(super) peak: f64,
    pub(super) peak_at: f64,
    pub(super) rms: f64,
    /// What is felt where the file ends.
    pub(super) last: f64,
    pub(super) farthest: Option<f64>,
    pub(super) of_stroke: Option<f64>,
    pub(super) fastest: Option<f64>,
    pub(super) energy: Option<f64>,
    pub(super) warmest: Option<f64>,
    /// How well a rumble motor was computed; null for what is exact.
    pub(super) level: Option<String>,
    pub(super) steps: u32,
    /// Whether samples are joined as a converter joins them, before diodes; elsewhere they are held.
    pub(super) joined: bool,
    /// The error that is reached where the wish is not granted; else null.
    pub(super) reaches: Option<f64>,
    pub(super) left_out: Vec<String>,
    /// Figures of its part, and which of them nobody measured.
    pub(super) figures: usize,
    pub(super) figures_assumed: Vec<&'static str>,
    pub(super) clipped: u64,
    pub(super) limited: u64,
    pub(super) masked: u64,
}

#[derive(Debug, Serialize)]
pub(super) struct NotFelt {
    pub(super) output: String,
    pub(super) why: Vec<String>,
    pub(super) help: Vec<String>,
}

impl FeelReport {
    /// Of a file that was written.
    pub fn new(
        loaded: &Loaded,
        feel: &Feel,
        file: String,
        written: &Written,
        error: f64,
        took: Duration,
    ) -> Self {
        let mut assumed: Vec<String> = Vec::new();
        for clause in feel.felt().iter().flat_map(|felt| &felt.assumed) {
            if !assumed.contains(clause) {
                assumed.push(clause.clone());
            }
        }
        let channel = |(n, trace): (usize, &pacinian::feel::Trace)| Channel {
            channel: n + 1,
            output: trace.output.clone(),
            axis: trace.axis.word(),
            unit: trace.unit.word(),
        };
        let not_felt = feel.unfelt().iter().map(|unfelt| NotFelt {
            output: unfelt.output.clone(),
            why: unfelt.why.iter().map(|problem| problem.what.clone()).collect(),
            help: unfelt.why.iter().filter_map(|problem| problem.help.clone()).collect(),
        });
        Self {
            file,
            bytes: written.bytes,
            frames: written.frames,
            error,
            held_loses: feel.loses(1000.0),
            run_time_seconds: took.as_secs_f64(),
            channels: feel.traces().iter().enumerate().map(channel).collect(),
            outputs: feel.felt().iter().map(|felt| OutputReport::new(loaded, felt)).collect(),
            not_felt: not_felt.collect(),
            assumed,
        }
    }
}

impl OutputReport {
    fn new(loaded: &Loaded, felt: &Felt) -> Self {
        let (figures, actuator) = (felt.figures(), loaded.rig.actuator(&felt.actuator));
        let part = actuator.and_then(|actuator| actuator.part.as_deref()).and_then(part::find);
        let assumed = part.into_iter().flat_map(|part| &part.values).filter(|(key, value)| {
            let taken = actuator.and_then(|actuator| actuator.value(key)) == Some(value.value);
            taken && value.origin == Origin::Assumed
        });
        Self {
            output: felt.output.clone(),
            channel: felt.channel + 1,
            actuator: felt.actuator.clone(),
            part: part.map(|part| part.name.to_string()),
            model: felt.model.word(),
            unit: felt.unit().word(),
            peak: figures.peak,
            peak_at: figures.peak_at,
            rms: figures.rms,
            last: figures.last,
            farthest: figures.farthest,
            of_stroke: figures.of_stroke,
            fastest: figures.fastest,
            energy: figures.energy,
            warmest: figures.warmest,
            level: felt.level().map(|level| format!("{level:?}").to_lowercase()),
            steps: felt.steps(),
            joined: felt.is_joined(),
            reaches: felt.reaches(),
            left_out: felt.left_out().iter().map(ToString::to_string).collect(),
            figures: part.map_or(0, |part| part.values.len()),
            figures_assumed: assumed.map(|(key, _)| *key).collect(),
            clipped: figures.counts.clipped,
            limited: figures.counts.limited,
            masked: figures.counts.masked,
        }
    }
}
