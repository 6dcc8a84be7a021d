//! The scene reference: what a scene should have been.
//!
//! Every voice is computed by the twins of its nodes, in `f64`, at a multiple of the engine's rate, exactly at its instant, and
//! then brought down to the engine's rate by a filter that leaves 0 to 1 kHz alone. Nothing of the engine takes part: no lanes, no
//! blocks, no corrections, no output stage. What both share are definitions that have tests of their own: the compiled plan, the
//! random numbers, and the [fade](crate::dsp::fade) of voices without an envelope.

use std::collections::{HashMap, VecDeque};
use std::convert::Infallible;

use super::decimate::Decimator;
use super::hearing::hearing;
use super::moved::Way;
use crate::dsp::fade::{FADE, fade};
use crate::dsp::random;
use crate::engine::event::{Move, Play};
use crate::graph::Base;
use crate::graph::answer::Answer;
use crate::graph::places::Places;
use crate::graph::plan::{Plan, Shared};
use crate::graph::program::{Feed, Program};
use crate::graph::start::{FIELDS, Fields};
use crate::graph::watch::{LATENCY, id};
use crate::node::kernel::{LEAD, Onset, Twin};
use crate::node::white::REACH;
use crate::node::{spec::Kind, twin};
use crate::schedule::Instant;
use crate::space::spot::Spot;

/// What every channel should hold, before the output stage, at the engine's rate; only 0 to 1 kHz counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Samples a second.
    pub rate: f64,
    /// By channel.
    pub channels: Vec<Vec<f64>>,
}

/// Seconds a voice must have been silent after its envelopes ended before the reference leaves it.
const QUIET: f64 = 0.1;

/// How long before its first number band-limited noise begins, in samples of the engine.
const NOISE_AHEAD: f64 = REACH as f64;

/// What should sound when `events` (in seconds from the start) are played on a plan for `seconds`, computed at `over` times the
/// engine's rate, where there is no audio input. Voices that had to make room for others are not modelled, nor are moved controls.
pub fn reference(plan: &Plan, events: &[(f64, Play)], seconds: f64, over: usize) -> Reference {
    reference_hearing(plan, events, &[], seconds, over)
}

/// As [`reference()`], with the channels of an audio input at the device's rate, from their beginning.
pub fn reference_hearing(
    plan: &Plan,
    events: &[(f64, Play)],
    input: &[Vec<f32>],
    seconds: f64,
    over: usize,
) -> Reference {
    let played = Played { events, moves: &[], input, released: f64::INFINITY };
    let Ok(all) = reference_watched(plan, &played, seconds, over, &mut |_| Ok::<(), Infallible>(()));
    all
}

/// What a reference is of, besides what engine-wide signals of the plan set off.
#[derive(Debug, Clone, Copy)]
pub struct Played<'a> {
    /// Voices, in seconds from the beginning.
    pub events: &'a [(f64, Play)],
    /// How they were moved while they sounded, in order.
    pub moves: &'a [(f64, Move)],
    /// Channels of an audio input at the device's rate, from their beginning.
    pub input: &'a [Vec<f32>],
    /// Every voice that sounds after so many seconds is released then.
    pub released: f64,
}

/// As [`reference()`], of all that can be played, and for somebody who waits: `watch` is asked many times a second with the share that is
/// done, from 0 to 1.
///
/// # Errors
/// The first that `watch` gives, at once.
pub fn reference_watched<S>(
    plan: &Plan,
    &Played { events, moves, input, released }: &Played,
    seconds: f64,
    over: usize,
    watch: &mut dyn FnMut(f64) -> Result<(), S>,
) -> Result<Reference, S> {
    let rate = plan.engine_rate();
    let fine = rate * over as f64;
    let length = (seconds * rate).ceil() as usize;
    let decimator = Decimator::new(over);
    let voices = || plan.always().map(|play| (0.0, play)).chain(events.iter().copied());
    // How long each is computed for, about; what rings on is not known beforehand.
    let lasts = |at: f64, play: &Play| play.duration.min(released - at);
    let work = |at: f64, play: &Play| lasts(at, play).min(seconds - at).max(0.01);
    let of_shared = if plan.shared_program.ops.is_empty() { 0.0 } else { seconds };
    let known = voices().map(|(at, play)| work(at, &play)).sum::<f64>();
    // What signals set off is known only when these are.
    let of_voices = known + if plan.watches.is_empty() { 0.0 } else { seconds };
    let total = of_shared + of_voices;
    let mut share = |done: f64| watch((done / total.max(1e-9)).min(1.0));
    share(0.0)?;
    let shared = shared(plan, length * over, fine, hearing(plan, input, length, over), &mut share)?;
    let crossed = crossings(plan, &shared, over, released);
    let found = known + crossed.iter().map(|(at, play)| work(*at, play)).sum::<f64>();
    let part = if found > 0.0 { of_voices / found } else { 1.0 };
    let mut channels = vec![vec![0.0; length]; plan.channels];
    let mut moves_of: HashMap<u64, Vec<(f64, Move)>> = HashMap::new();
    moves.iter().for_each(|moved| moves_of.entry(moved.1.id).or_default().push(*moved));
    let mut done = of_shared;
    let mut places = Places::new(plan);
    for (at, play) in voices().chain(crossed.iter().copied()) {
        let Some(instrument) = plan.instruments.get(play.instrument as usize) else { continue };
        let (own, lasts) = (work(at, &play), lasts(at, &play));
        let onset = at;
        let at = Instant::of_samples(at * rate);
        let mut voice = Voice::new(&instrument.program, &play, at, plan.seed, rate, fine);
        let its = moves_of.get(&play.id).into_iter().flatten().filter(|(at, _)| *at >= onset);
        voice.moves = its.map(|(at, of)| (at - onset, *of)).collect();
        let mut within = |seconds: f64| share(done + seconds.clamp(0.0, own) * part);
        voice.steered = instrument.steered;
        let born = voice.born;
        let rendered = voice.render(lasts, &shared, length * over, instrument.tail + QUIET, &mut within)?;
        let Rendered { first, samples, gain, steps } = rendered;
        done += own * part;
        if instrument.steered || matches!(play.place, Spot::Path(_)) {
            share(done)?;
            let way = Way { plan, instrument, play: &play, born, steps: &steps };
            for (channel, samples) in way.moved(first, fine, &samples) {
                if let Some(low) = channels.get_mut(channel as usize) {
                    decimator.add(&samples, first, gain, low);
                }
            }
            continue;
        }
        for &(channel, part) in places.felt(play.instrument as usize, play.place, play.strength()) {
            if let Some(low) = channels.get_mut(channel as usize) {
                share(done)?;
                decimator.add(&samples, first, gain * part, low);
            }
        }
    }
    Ok(Reference { rate, channels })
}

/// What the watches of a plan set off before so many seconds, given engine-wide signals at `over` times the engine's rate: a signal is
/// read at the engine's samples, and straight in between, as [`crate::graph::watch::Watch`] has it.
fn crossings(plan: &Plan, shared: &[Vec<f64>], over: usize, until: f64) -> Vec<(f64, Play)> {
    let rate = plan.engine_rate();
    let mut found = Vec::new();
    for (place, watch) in plan.watches.iter().enumerate() {
        let way = if watch.rises { 1.0 } else { -1.0 };
        let (mut before, mut ready, mut number, mut free) = (None::<f64>, true, 0, 0.0);
        let signal = shared.get(watch.signal as usize).into_iter().flatten().step_by(over);
        for (n, value) in signal.enumerate() {
            if !value.is_finite() {
                before = None;
                continue;
            }
            // Past the threshold by so much.
            let past = way * (value - watch.threshold);
            ready |= way * (value - watch.rearm) < 0.0;
            if past >= 0.0 && before.is_none_or(|before| before < 0.0) {
                if let Some(before) = before.filter(|_| ready) {
                    let at = n as f64 - 1.0 + before / (before - past) + LATENCY as f64;
                    if at >= free && at < until * rate {
                        // The events of a pattern are played, and known as such.
                        if let Answer::Voice(voiced) = &watch.answer {
                            found.push((at / rate, Play::of(voiced, id(place, number))));
                        }
                        number += 1;
                        free = at + watch.hold * rate;
                    }
                }
                ready = false;
            }
            before = Some(past);
        }
    }
    found
}

/// Samples between two questions whether to go on.
const ASKED_EVERY: usize = 1 << 10;

/// Engine-wide signals over the whole time. `within` is told how many seconds are done.
fn shared<S>(
    plan: &Plan,
    length: usize,
    fine: f64,
    mut heard: Vec<Vec<f64>>,
    within: &mut dyn FnMut(f64) -> Result<(), S>,
) -> Result<Vec<Vec<f64>>, S> {
    let mut signals: Vec<Vec<f64>> = plan
        .shared
        .iter()
        .map(|source| match *source {
            Shared::Control(c) => vec![plan.controls[c as usize].default; length],
            Shared::Input(c) => heard.get_mut(c as usize).map(std::mem::take).unwrap_or(vec![0.0; length]),
            // Of what vibrates alone, nobody turns a knob.
            Shared::Node(_) | Shared::Knob(_) => vec![0.0; length],
        })
        .collect();
    if plan.shared_program.ops.is_empty() {
        return Ok(signals);
    }
    let play = Play {
        instrument: 0,
        place: Spot::default(),
        level: 1.0,
        felt: None,
        duration: f64::INFINITY,
        own: [0.0; FIELDS],
        id: u64::MAX,
    };
    let mut voice =
        Voice::new(&plan.shared_program, &play, Instant::default(), plan.seed, plan.engine_rate(), fine);
    for n in 0..length {
        if n.is_multiple_of(ASKED_EVERY) {
            within(n as f64 / fine)?;
        }
        voice.step(n as i64, &signals);
        for (i, source) in plan.shared.iter().enumerate() {
            if let Shared::Node(output) = *source {
                signals[i][n] = voice.output(output as usize, n as i64, &signals);
            }
        }
    }
    Ok(signals)
}

/// One voice, by twins.
struct Voice<'a> {
    program: &'a Program,
    twins: Vec<Box<dyn Twin>>,
    steady: Vec<f64>,
    values: Vec<f64>,
    gain: f64,
    /// Which op each input reads, by op and input; ops that write the same buffer make the buffer's number useless here.
    writers: Vec<Vec<Option<usize>>>,
    last_writer: Vec<usize>,
    /// What the hand does, in seconds from the onset.
    moves: VecDeque<(f64, Move)>,
    /// For each late buffer, its values of the last engine sample, oldest first.
    past: Vec<VecDeque<f64>>,
    fine: f64,
    /// Fine samples to an engine sample.
    over: f64,
    /// Onset in fine samples.
    born: f64,
    /// Whether it says where it is.
    steered: bool,
}

/// What a voice has come to.
struct Rendered {
    /// The number of its first fine sample.
    first: i64,
    samples: Vec<f64>,
    /// What they all have.
    gain: f64,
    /// Where it was, and how much wider, if it says so.
    steps: Vec<[f64; 4]>,
}

impl<'a> Voice<'a> {
    fn new(program: &'a Program, play: &Play, at: Instant, seed: u64, rate: f64, fine: f64) -> Self {
        let fields = Fields { level: play.level, duration: play.duration, own: play.own };
        let value = |base: &Base| match *base {
            Base::Constant(x) => x,
            Base::Start(id) => program.starts[id as usize].value(&fields),
        };
        let steady: Vec<f64> = program.steady.iter().map(value).collect();
        let gain = program.gain.iter().map(value).product::<f64>() * play.level;
        let age = at.until(at.ceiling()) - LEAD;
        let mut last_writer = vec![usize::MAX; program.buffers];
        let (mut twins, mut writers) = (Vec::new(), Vec::new());
        for (i, op) in program.ops.iter().enumerate() {
            let start: Vec<f64> = op.inputs.iter().map(|input| steady[input.base as usize]).collect();
            let stream = random::stream(seed, play.id, op.node.stream());
            let onset = Onset { age, stream, start: &start };
            twins.push(twin(op.node.kind, &op.node.setup(fine, rate), &onset));
            let writer = |feed| if let Feed::Buffer(b) = feed { Some(last_writer[b as usize]) } else { None };
            writers.push(op.inputs.iter().map(|input| writer(input.feed)).collect());
            last_writer[op.output as usize] = i;
        }
        let born = (at.sample as f64 + f64::from(at.fraction) / 4_294_967_296.0) * fine / rate;
        let values = vec![0.0; program.ops.len()];
        let over = fine / rate;
        let past = vec![VecDeque::from(vec![0.0; over as usize]); program.late.len()];
        Self {
            program,
            twins,
            steady,
            values,
            gain,
            writers,
            last_writer,
            moves: VecDeque::new(),
            past,
            fine,
            over,
            born,
            steered: false,
        }
    }

    fn value(&self, feed: Feed, n: i64, shared: &[Vec<f64>]) -> f64 {
        match feed {
            Feed::Steady(row) => self.steady[row as usize],
            Feed::Shared(s) => shared[s as usize].get(n.max(0) as usize).copied().unwrap_or(0.0),
            Feed::Buffer(_) | Feed::Late(_) => 0.0,
        }
    }

    fn step(&mut self, n: i64, shared: &[Vec<f64>]) {
        let t = (n as f64 - self.born) / self.fine;
        let mut inputs = [0.0; 64];
        for (i, op) in self.program.ops.iter().enumerate() {
            let params = op.node.kind.spec().params.iter().filter(|p| p.kind.is_input());
            let mut kinds = params.map(|p| matches!(p.kind, Kind::Frequency(_)));
            for (k, input) in op.inputs.iter().enumerate() {
                let value = match (self.writers[i][k], input.feed) {
                    (Some(writer), _) => self.values[writer],
                    (None, Feed::Late(slot)) => self.past[slot as usize].front().copied().unwrap_or(0.0),
                    (None, feed) => self.value(feed, n, shared),
                };
                let frequency = kinds.next().unwrap_or(false);
                inputs[k] = if frequency { value + self.steady[input.base as usize] } else { value };
            }
            self.values[i] = self.twins[i].step(t, &inputs[..op.inputs.len()]);
        }
        // One sample of the engine late, as the program has it.
        for (past, buffer) in self.past.iter_mut().zip(&self.program.late) {
            past.push_back(self.values[self.last_writer[*buffer as usize]]);
            if past.len() > self.over as usize {
                past.pop_front();
            }
        }
    }

    fn output(&self, index: usize, n: i64, shared: &[Vec<f64>]) -> f64 {
        match self.program.outputs.get(index) {
            Some(Feed::Buffer(b)) => self.values[self.last_writer[*b as usize]],
            Some(feed) => self.value(*feed, n, shared),
            None => 0.0,
        }
    }

    /// All of a voice that is released after `duration` seconds. `within` is told how many seconds are done.
    fn render<S>(
        mut self,
        duration: f64,
        shared: &[Vec<f64>],
        length: usize,
        tail: f64,
        within: &mut dyn FnMut(f64) -> Result<(), S>,
    ) -> Result<Rendered, S> {
        let enveloped = self.twins.iter().any(|t| t.sounding().is_some());
        // Noise is band-limited, so it begins before its first number, and so does what filters it. All else is 0 before the
        // onset where it is kept.
        let first = (self.born - (LEAD + NOISE_AHEAD) * self.over).floor() as i64 + 1;
        let released = self.born + duration * self.fine;
        let (mut samples, mut steps, mut quiet, mut is_released) = (Vec::new(), Vec::new(), 0.0, false);
        for n in first..length as i64 {
            if samples.len().is_multiple_of(ASKED_EVERY) {
                within((n - first) as f64 / self.fine)?;
            }
            // Twins want to know of a release one sample ahead.
            if !is_released && released <= n as f64 + 1.0 {
                is_released = true;
                for twin in &mut self.twins {
                    twin.release(duration);
                }
            }
            while let Some(&(at, Move { motion, value, .. })) = self.moves.front()
                && self.born + at * self.fine <= n as f64 + 1.0
            {
                self.moves.pop_front();
                self.twins.iter_mut().for_each(|twin| twin.touch(at, motion, value));
            }
            self.step(n, shared);
            let mut value = self.output(0, n, shared);
            let ended = if enveloped {
                self.twins.iter().all(|t| t.sounding() != Some(true))
            } else {
                let since = (n as f64 - released) / self.fine;
                let age = (n as f64 - self.born) / self.fine;
                value *= (1.0 - fade(age)) * if is_released { fade(since) } else { 1.0 };
                is_released && since > FADE
            };
            samples.push(value);
            if self.steered {
                steps.push([1, 2, 3, 4].map(|output| self.output(output, n, shared)));
            }
            quiet = if ended && value.abs() < 1e-9 { quiet + 1.0 / self.fine } else { 0.0 };
            if quiet > tail {
                break;
            }
        }
        Ok(Rendered { first, samples, gain: self.gain, steps })
    }
}
