//! The contract of a node: its kernel over lanes, which the engine runs, and its twin, which says what is right.

use std::sync::Arc;

use super::asset::Asset;
use super::motion::Motion;
use crate::dsp::lanes::{LANES, Real};

/// How far a voice's clock lags behind the engine's, in engine samples. Band-limited jumps need two samples before their
/// instant, so everything a voice does comes that much later; the engine reports it as delay.
pub const LEAD: f64 = 2.0;

/// Inputs a node may have; longer lists of signals are split among several nodes.
pub(crate) const INPUTS: usize = 16;

/// What a node is told when it is built. The same for kernel and twin.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Samples a second at which it will run: the engine's rate for a kernel; for a twin that or a multiple of it.
    pub rate: f64,
    /// The engine's rate, Hz.
    pub engine_rate: f64,
    /// Values of [`super::spec::Kind::Constant`], in the order of the parameters.
    pub constants: Vec<f64>,
    /// Values of [`super::spec::Kind::Choice`] (place in the list) and [`super::spec::Kind::Flag`] (0 or 1), in order.
    pub choices: Vec<usize>,
    /// Breakpoints, where the node has them.
    pub points: Vec<Point>,
    /// The recording, where the node has one.
    pub asset: Option<Arc<Asset>>,
    /// Whether what moves a frequency is 0 before the onset, as an envelope is. Then it may jump
    /// there, and all of it counts; otherwise it runs through the onset, and counts from there on.
    pub begins: bool,
}

/// One breakpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Seconds after the onset.
    pub at: f64,
    /// Value reached then.
    pub value: f64,
    /// Curvature of the segment that leads here; see the node `envelope`.
    pub curve: f64,
}

/// A voice begins.
#[derive(Debug, Clone, Copy)]
pub struct Onset<'a> {
    /// Voice time of the next sample that will be computed, in samples: between −2 and −1, since a voice's clock lags by
    /// [`LEAD`] and an onset may fall between samples.
    pub age: f64,
    /// Names the random numbers of this node in this voice; see [`crate::graph::Node::stream`].
    pub stream: u64,
    /// The part of each input that is known at the onset (a signal's part is 0).
    pub start: &'a [f64],
}

/// An input over one block: `R` values by frame and lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Input<'a, R> {
    /// One row a frame, or a single row that holds for all.
    pub rows: &'a [[R; LANES]],
    /// 1, or 0 where a single row holds for the whole block.
    pub step: usize,
    /// Whether that row holds for the whole life of a voice.
    pub steady: bool,
    /// The part known at the onset, in full precision. `rows` includes it, except for a
    /// [`super::spec::Kind::Frequency`], where they hold the deviation from it.
    pub base: &'a [f64; LANES],
}

impl<'a, R: Real> Input<'a, R> {
    /// The values at a frame.
    #[inline(always)]
    pub fn at(&self, frame: usize) -> [R; LANES] {
        self.rows[frame * self.step]
    }
    /// Whether it stays the same for the whole life of a voice.
    #[inline(always)]
    pub fn is_steady(&self) -> bool {
        self.steady
    }
}

/// What a kernel works on for one block.
#[derive(Debug)]
pub(crate) struct Io<'a, R> {
    /// In the order of the parameters, up to the last that may move while it runs: the rest came with the [`Onset`].
    pub inputs: &'a [Input<'a, R>],
    /// One row a frame; holds old values on entry.
    pub output: &'a mut [[R; LANES]],
    /// Set by a kernel that wrote the first row only, since all rows of this block are the same; false on entry.
    pub still: bool,
}

impl<R: Real> Io<'_, R> {
    /// The rows to compute where a frame depends on its inputs at that frame and on nothing else: all, or the first one if no
    /// input moves in this block.
    #[inline(always)]
    pub fn pointwise(&mut self) -> &mut [[R; LANES]] {
        self.still = self.inputs.iter().all(|input| input.step == 0);
        let rows = if self.still { self.output.len().min(1) } else { self.output.len() };
        &mut self.output[..rows]
    }
}

/// The state of a node for one group of lanes.
///
/// `run` is called from the audio thread: it may not allocate, lock, block or panic, and its result may not depend on how
/// a stretch of time is cut into blocks. Lanes are independent of one another.
pub(crate) trait Kernel<R: Real>: Send + Sized + Clone {
    /// State for a group of silent lanes.
    fn new(setup: &Setup) -> Self;
    /// Bytes that [`Kernel::new`] takes besides the state itself.
    fn heap(setup: &Setup) -> usize {
        let _ = setup;
        0
    }
    /// Becomes a copy of a state of the same node with the same settings, at least of the lanes in `live`, a bit each. Neither allocates nor frees.
    fn copy(&mut self, from: &Self, live: u8) {
        let _ = live;
        self.clone_from(from);
    }
    /// Copies ahead of [`Kernel::copy`] what would take long there, `left` bytes at most, which it lessens by what it copies; nothing is left where it
    /// has not come to the end. What has been copied keeps up from call to call with what the original runs on, for nothing.
    fn copy_ahead(&mut self, from: &Self, live: u8, left: &mut usize) {
        let _ = (from, live, left);
    }
    /// A voice begins on `lane`; whatever was there is forgotten.
    fn start(&mut self, lane: usize, onset: &Onset) {
        let _ = (lane, onset);
    }
    /// The patch of the voice on `lane` was changed while it sounds: what each input had at its onset, and what it would have now. It goes on from
    /// where it is, with no jump, and runs as the new values say from the next sample on. What they say of a course that began at the onset, an
    /// envelope's legs or where a recording starts, holds for the next voice.
    fn retune(&mut self, lane: usize, was: &[f64], now: &[f64]) {
        let _ = (lane, was, now);
    }
    /// The voice on `lane` is released at voice time `at`, in samples: one to two samples after the next one to be computed.
    fn release(&mut self, lane: usize, at: f64) {
        let _ = (lane, at);
    }
    /// The hand that holds the voice on `lane` moves at voice time `at`, as of [`Kernel::release`], or at 0, the onset, before the first
    /// sample. Only the node `touch` listens.
    fn touch(&mut self, lane: usize, motion: Motion, value: f64, at: f64) {
        let _ = (lane, motion, value, at);
    }
    /// Computes `io.output.len()` frames, of which there is at least one.
    fn run(&mut self, io: &mut Io<R>);
    /// For envelopes that end: whether `lane` still sounds. `None` for nodes that do not decide.
    fn sounding(&self, lane: usize) -> Option<bool> {
        let _ = lane;
        None
    }
    /// For envelopes: the value on `lane`, by which the quietest voice is found.
    fn value(&self, lane: usize) -> Option<f64> {
        let _ = lane;
        None
    }
    /// Called every 64 engine samples: state below −120 dB becomes exact zero.
    fn settle(&mut self) {}
}

/// A node's definition in `f64`, slow, for one voice, sharing no code with the kernel.
pub trait Twin: Send {
    /// The value at voice time `t` (seconds, from slightly below zero), called once for every sample in order. `inputs` are the
    /// values at that time, in the order of the parameters (here the whole value, for frequencies too).
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64;
    /// The voice is released at voice time `t` (seconds). A twin is told before the first step that comes later than one
    /// sample before `t`, so that it can average a jump over its sample interval.
    fn release(&mut self, t: f64) {
        let _ = t;
    }
    /// The hand that holds the voice moves at voice time `t` (seconds), of which a twin is told as of a release.
    fn touch(&mut self, t: f64, motion: Motion, value: f64) {
        let _ = (t, motion, value);
    }
    /// For envelopes that end: whether it still sounds.
    fn sounding(&self) -> Option<bool> {
        None
    }
}
