//! The run-time: runs a plan. It knows no files, no devices and no formats.

#![deny(clippy::disallowed_methods)]

#[doc(hidden)] // for benches/engine.rs
pub mod bank;
mod commander;
mod control;
mod core;

mod drives;
mod edges;
pub mod event;
pub mod exchange;
pub mod guard;
pub mod handover;
mod hush;
mod journey;
pub mod knob;
mod lane;
mod listener;
mod lookup;
pub mod meter;
mod mixer;
mod ops;
mod protection;
mod raw;
pub mod refusal;
mod roster;
pub mod stage;
mod standing;
mod succession;
pub mod task;
mod triggers;
pub mod turnover;
pub mod vibration;
pub mod watch;
#[doc(hidden)] // for benches/engine.rs
pub mod workspace;

use std::ops::Range;
use std::sync::Arc;

use crate::dsp::isa::Isa;
use crate::graph::plan::{Plan, Precision};
use crate::graph::watch::LATENCY;
use crate::knob::angle::decoder::Decoder;
use crate::knob::local_model::link::{Slow, link};
use crate::knob::servo::setup::Unfit;
use crate::node::kernel::LEAD;
use crate::schedule::Instant;
use core::Core;
use event::{Event, Source};
use handover::Handover;
use knob::followed::Followed;
use listener::Listener;
use refusal::Refusal;
use stage::Stage;
use succession::Succession;
use task::Task;
use turnover::Turn;
use watch::Crossing;

pub use roster::Duty;
use workspace::BLOCK;

pub use core::Counters;
pub use drives::halt::BRAKING;

/// A plan at work: give it input frames, get output frames.
///
/// [`Engine::process`] may be called from an audio callback: it does not allocate, lock, block or panic. What it computes
/// depends on input and engine time alone, never on how a stretch of time is cut into calls.
pub struct Engine {
    core: AnyCore,
    channels: usize,
    ratio: usize,
    /// The frames of an engine sample that was not wanted whole.
    carry: Vec<f32>,
    /// What of it is still to be given out.
    carried: Range<usize>,
    listener: Listener,
    /// Reads a knob that is there.
    sensor: Option<Decoder>,
    /// By input channel: the engine samples of the block at hand.
    heard: Vec<Vec<f32>>,
}

/// What lies between an event and its effect at the device, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delay {
    /// Voices lag behind events, so that jumps can be band-limited around their instant.
    pub lead: f64,
    /// The filter that brings the engine's rate to the device's: the same at all frequencies.
    pub up_sampling: f64,
    /// Phase delay of the band limit at 250 Hz.
    pub band_limit_phase: f64,
    /// Group delay of the band limit at 250 Hz.
    pub band_limit_group: f64,
    /// Group delay at 250 Hz of the high-pass that keeps steady voltages off, 2.5 µs, where an output has one, else 0. Outputs that have
    /// none come that much earlier.
    pub high_pass_group: f64,
}

impl Delay {
    /// All of it, for the envelope of a tone of 250 Hz.
    pub fn total(&self) -> f64 {
        self.lead + self.up_sampling + self.band_limit_group + self.high_pass_group
    }
}

enum AnyCore {
    Single(Box<Core<f32>>),
    Double(Box<Core<f64>>),
}

macro_rules! each {
    ($self:expr, $core:ident => $body:expr) => {
        match &$self.core {
            AnyCore::Single($core) => $body,
            AnyCore::Double($core) => $body,
        }
    };
    (mut $self:expr, $core:ident => $body:expr) => {
        match &mut $self.core {
            AnyCore::Single($core) => $body,
            AnyCore::Double($core) => $body,
        }
    };
}

impl Engine {
    /// An engine for a plan, on the best instruction set of this machine.
    ///
    /// # Errors
    /// A rate or a number of taps that the output stage cannot be built for; a place or an output beyond the plan's channels.
    pub fn new(plan: &Plan) -> Result<Self, Refusal> {
        Self::with_isa(plan, Isa::detect())
    }

    /// An engine for a plan on an instruction set; the baseline where this machine lacks it.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn with_isa(plan: &Plan, isa: Isa) -> Result<Self, Refusal> {
        let isa = isa.or_supported();
        let core = match plan.precision {
            Precision::Single => AnyCore::Single(Box::new(Core::new(plan, isa)?)),
            Precision::Double => AnyCore::Double(Box::new(Core::new(plan, isa)?)),
        };
        let carry = vec![0.0; plan.ratio * plan.channels];
        let inputs = plan.inputs().last().map_or(0, |channel| channel + 1);
        let listener = Listener::new(inputs, plan.taps, plan.ratio, plan.engine_rate());
        // A copy of an empty vector has no capacity.
        let heard = (0..inputs).map(|_| Vec::with_capacity(BLOCK)).collect();
        let frames = plan.knob.as_ref().map_or(1, |knob| knob.frames as usize);
        let sensor = plan.sensor().map(|sensor| Decoder::new(sensor, frames)).transpose();
        let sensor = sensor.map_err(Unfit::from)?;
        let (channels, ratio) = (plan.channels, plan.ratio);
        Ok(Self { core, channels, ratio, carry, carried: 0..0, listener, sensor, heard })
    }

    /// Seconds from an event to the middle of what it makes at the device, at 250 Hz.
    pub fn delay(&self) -> Delay {
        let rate = each!(self, core => core.rate());
        let stage = self.stage().vibration().delay();
        Delay {
            lead: LEAD / rate,
            up_sampling: stage.fir_frames / (rate * self.ratio as f64),
            band_limit_phase: stage.band_limit_phase_250,
            band_limit_group: stage.band_limit_group_250,
            high_pass_group: stage.high_pass_group_250,
        }
    }

    /// The output stage: its design, its response and what it has met.
    pub fn stage(&self) -> &Stage {
        each!(self, core => core.stage())
    }

    /// Channels of a frame.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Engine samples computed so far.
    pub fn clock(&self) -> u64 {
        each!(self, core => core.clock())
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        each!(self, core => core.counters())
    }

    /// Voices that sound.
    pub fn sounding(&self) -> usize {
        each!(self, core => core.sounding())
    }

    /// Whether nothing sounds, nothing waits and nothing rings.
    pub fn is_silent(&self) -> bool {
        each!(self, core => core.is_silent())
    }

    /// How many more events may wait.
    pub fn room(&self) -> usize {
        each!(self, core => core.room())
    }

    /// How many frames may be asked for before engine sample `sample` is computed.
    pub fn frames_before(&self, sample: u64) -> usize {
        let samples = usize::try_from(sample.saturating_sub(self.clock())).unwrap_or(usize::MAX);
        samples.saturating_mul(self.ratio).saturating_add(self.carried.len() / self.channels.max(1))
    }

    /// Lets what is due before the next engine sample take place now, as it otherwise would when that sample is computed. Where
    /// more falls on one sample than can wait, this makes room; nothing sounds different for it.
    pub fn run_ahead(&mut self) {
        each!(mut self, core => core.run_ahead());
    }

    /// An event at an instant of engine time; one in the past takes effect with the next sample. Says whether there was
    /// room; an event that found none is counted.
    pub fn schedule(&mut self, at: Instant, source: Source, event: Event) -> bool {
        each!(mut self, core => core.schedule(at, source, event))
    }

    /// Adds a periodic task; what is known of it can be asked from any thread. It allocates: not for the audio thread.
    pub fn add_task(&mut self, task: Box<dyn Task>) -> Arc<Duty> {
        each!(mut self, core => core.tasks().add(task))
    }

    /// Times every run of a task from now on, by a clock that gives nanoseconds. What tasks do does not depend on it.
    pub fn time_tasks(&mut self, clock: fn() -> u64) {
        each!(mut self, core => core.time(clock));
    }

    /// What is known of the engine's own periodic work, which never rests: what turns its motors, and its knob's servo. A run is what belongs to one
    /// engine sample; what was timed together counts by its mean.
    pub fn duties(&self) -> [Arc<Duty>; 2] {
        each!(self, core => core.duties())
    }

    /// Of the ranks that tasks have: the highest below `rank` (256 for the highest of all) that may rest.
    pub fn rank_below(&mut self, rank: u16) -> Option<u8> {
        each!(mut self, core => core.tasks().rank_below(rank))
    }

    /// Of the ranks that tasks have: the lowest above `rank`.
    pub fn rank_above(&mut self, rank: u8) -> Option<u8> {
        each!(mut self, core => core.tasks().rank_above(rank))
    }

    /// Fills `output`, interleaved frames of all channels. Samples beyond the last whole frame become 0.
    pub fn process(&mut self, output: &mut [f32]) {
        self.process_with(&[], output, None);
    }

    /// As [`Engine::process`], with what came in during the same frames: interleaved frames of
    /// [`Engine::input_channels`]. Missing frames count as silence.
    pub fn process_input(&mut self, input: &[f32], output: &mut [f32]) {
        self.process_with(input, output, None);
    }

    /// Channels of an input frame: as many as the plan listens to.
    pub fn input_channels(&self) -> usize {
        self.listener.channels()
    }

    /// Seconds by which what comes in is late at the nodes that read it.
    pub fn input_delay(&self) -> f64 {
        self.listener.delay() / (each!(self, core => core.rate()) * self.ratio as f64)
    }

    /// Seconds from the instant at which a signal passes a threshold to the onset of the voice that this sets off, of the plan's
    /// [watches](crate::graph::watch::Watch).
    pub fn watch_delay(&self) -> f64 {
        LATENCY as f64 / each!(self, core => core.rate())
    }

    /// Seconds from the instant at which a signal or the knob sets off a pattern to the beginning of that, where whoever feeds the engine is in
    /// time.
    pub fn answer_delay(&self) -> f64 {
        each!(self, core => core.answer_delay())
    }

    /// What signals have set off since this was asked last, in the order in which it was; some 4,000 are kept. It is that of the plan that
    /// plays: to be asked before another takes over.
    pub fn crossings(&mut self) -> std::vec::Drain<'_, Crossing> {
        each!(mut self, core => core.watcher().begun())
    }

    /// What became of voices, without an event of theirs, since this was asked last, in its order: some 1,000 are kept, and those that always sound. It is
    /// that of the plan that plays.
    pub fn turnover(&mut self) -> std::vec::Drain<'_, Turn> {
        each!(mut self, core => core.turnover().take())
    }

    /// How much of what signals have set off, and how many worlds that the knob has taken, were not kept since this was asked last.
    pub fn take_unkept(&mut self) -> u64 {
        each!(mut self, core => core.take_unkept())
    }

    /// Signals set off nothing more that would begin at `until` or later.
    #[cfg_attr(not(feature = "report"), allow(dead_code))]
    pub(crate) fn watch_until(&mut self, until: Instant) {
        each!(mut self, core => core.watcher().end_at(until));
    }

    /// Holds motors down, or lets them go, from the next engine sample on: held down they are braked for 4 ms
    /// ([`BRAKING`]) and then get exact zeros. Whoever shuts the output behind the engine does this first.
    pub fn hold_motors(&mut self, held: bool) {
        each!(mut self, core => core.hold_motors(held));
    }

    /// The knob, if the plan has one.
    pub fn knob(&self) -> Option<&knob::Knob> {
        each!(self, core => core.knob())
    }

    /// Lets a slow thread send local models to the knob and see it: that thread gets the end that is returned; `None` where the plan has no
    /// knob. An end that was given out before is then heard no more. It allocates.
    pub fn link_knob(&mut self) -> Option<Slow> {
        let (slow, fast) = link();
        each!(mut self, core => core.link_knob(fast)).then_some(slow)
    }

    /// Hands the worlds that a slow thread has sent to `see`, as the knob took them since this was asked last; some 4,000 are kept.
    pub fn followed(&mut self, mut see: impl FnMut(Followed)) {
        each!(mut self, core => core.followed().for_each(&mut see));
    }

    /// Lets the knob take a world once more that it took in a run that is repeated, at its sample; in order. It allocates.
    pub fn follow_again(&mut self, followed: Followed) {
        each!(mut self, core => core.follow_again(followed));
    }

    /// Makes room to take over the voices of another engine. It allocates.
    fn expect_voices(&mut self) {
        each!(mut self, core => core.expect_voices());
    }

    /// Becomes the engine of `new`, which becomes the old one that fades out. Both must be of the same precision, which
    /// [`handover::prepare`] sees to; otherwise nothing happens.
    fn adopt(&mut self, new: &mut Handover) {
        let Handover { engine, inheritance, .. } = new;
        match (&mut self.core, &mut engine.core) {
            (AnyCore::Single(old), AnyCore::Single(new)) => new.adopt(old, inheritance),
            (AnyCore::Double(old), AnyCore::Double(new)) => new.adopt(old, inheritance),
            _ => return,
        }
        std::mem::swap(&mut self.core, &mut engine.core);
    }

    /// Copies ahead what [`Engine::adopt`] would take long to copy: so many bytes for each engine sample of `frames`. Says whether that is all.
    fn copy_ahead(&self, new: &mut Handover, frames: usize, bytes: usize) -> bool {
        let Handover { engine, inheritance, .. } = new;
        let mut left = bytes * frames.div_ceil(self.ratio.max(1));
        match (&self.core, &mut engine.core) {
            (AnyCore::Single(old), AnyCore::Single(new)) => new.copy_ahead(old, inheritance, &mut left),
            (AnyCore::Double(old), AnyCore::Double(new)) => new.copy_ahead(old, inheritance, &mut left),
            _ => {}
        }
        left > 0
    }

    /// Tells the output stage how it is to take over from that of another engine.
    fn expect_succession(&mut self, succession: Succession) {
        each!(mut self, core => core.expect_succession(succession));
    }

    /// Whether the output stage of the engine before this one still sounds.
    fn is_succeeding(&self) -> bool {
        each!(self, core => core.is_succeeding())
    }

    /// For an old engine: whether all its voices have faded.
    fn is_gone(&self) -> bool {
        each!(self, core => core.is_idle())
    }

    /// As [`Engine::process`], with the voices of an old engine that fade out.
    fn process_with(&mut self, input: &[f32], output: &mut [f32], mut leaving: Option<&mut Engine>) {
        let whole = output.len() - output.len() % self.channels.max(1);
        let (mut output, rest) = output.split_at_mut(whole);
        rest.fill(0.0);

        let taken = output.len().min(self.carried.len());
        output[..taken].copy_from_slice(&self.carry[self.carried.clone()][..taken]);
        self.carried.start += taken;
        output = &mut output[taken..];

        let step = self.ratio * self.channels;
        if step == 0 {
            return;
        }
        // The frames just given out of the carry have their input too.
        let mut frames = input.chunks(self.listener.channels().max(1));
        let mut left = taken / self.channels;
        self.hear(&mut frames, &mut left, 0);
        left = output.len() / self.channels;
        while !output.is_empty() {
            let samples = output.len().div_ceil(step).min(BLOCK);
            self.hear(&mut frames, &mut left, samples);
            let (now, later) = output.split_at_mut((samples * step).min(output.len()));
            self.advance(samples, now, leaving.as_deref_mut());
            if now.len() < samples * step {
                // The last frames of the last sample are for the next call.
                let begin = (samples - 1) * step;
                let over = now.len() - begin;
                now[begin..].copy_from_slice(&self.carry[..over]);
                self.carried = over..step;
            }
            output = later;
        }
        self.hear(&mut frames, &mut left, 0);
    }

    /// Hears frames until `samples` engine samples are known; for 0, all that are left, none of which makes one.
    fn hear(&mut self, frames: &mut std::slice::Chunks<f32>, left: &mut usize, samples: usize) {
        if self.heard.is_empty() {
            return;
        }
        self.heard.iter_mut().for_each(Vec::clear);
        while *left > 0 && (samples == 0 || self.heard[0].len() < samples) {
            *left -= 1;
            let frame = frames.next();
            if let Some(reading) = self.sensor.as_mut().and_then(|sensor| sensor.push(frame)) {
                each!(mut self, core => core.read_knob(reading));
            }
            let heard = &mut self.heard;
            self.listener.hear(frame, |channel, value| {
                // Never more than a block: capacity for that was taken when the engine was made.
                if heard[channel].len() < BLOCK {
                    heard[channel].push(value);
                }
            });
        }
    }

    fn advance(&mut self, samples: usize, output: &mut [f32], leaving: Option<&mut Engine>) {
        let (heard, rest) = (&self.heard, &mut self.carry);
        match (&mut self.core, leaving.map(|old| &mut old.core)) {
            (AnyCore::Single(core), Some(AnyCore::Single(old))) => {
                core.advance(samples, heard, output, rest, Some(old))
            }
            (AnyCore::Double(core), Some(AnyCore::Double(old))) => {
                core.advance(samples, heard, output, rest, Some(old))
            }
            (AnyCore::Single(core), _) => core.advance(samples, heard, output, rest, None),
            (AnyCore::Double(core), _) => core.advance(samples, heard, output, rest, None),
        }
    }
}
