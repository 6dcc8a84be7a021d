//! The voices of one instrument: states of its ops, lane by lane, and who sounds on which lane.

use std::sync::Arc;

use super::core::GRID;
use super::event::Play;
use super::mixer::Routes;
use super::workspace::{Bus, Rows, Workspace};
use crate::dsp::fade::{FADE, fade};
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random;
use crate::graph::Base;
use crate::graph::plan::Instrument;
use crate::graph::program::{Feed, OpInput, Program};
use crate::graph::start::Fields;
use crate::node::States;
use crate::node::kernel::{INPUTS, Input, Io, LEAD, Onset};
use crate::schedule::Instant;

/// What counts as silence: −120 dB.
const SILENCE: f64 = 1e-6;

/// The largest gain of a voice: 120 dB over full scale, where the output stage holds its input as well.
const LOUDEST: f64 = 1e6;

/// A voice on its lane.
#[derive(Debug, Clone, Copy)]
pub struct Lane {
    /// The event's id.
    pub id: u64,
    /// Its onset.
    pub born: Instant,
    /// Its order among all voices.
    pub serial: u64,
    /// How loud it may be: the event's level times what folding made gain.
    pub level: f64,
    /// Engine samples it has been silent since its envelopes ended.
    pub quiet: u64,
    /// The event.
    pub play: Play,
    /// What it is doing.
    pub stage: Stage,
}

/// What a lane is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stage {
    /// Nothing; it may be taken.
    Free,
    /// It sounds and was not released.
    Held,
    /// It was released.
    Released,
    /// It falls silent from this instant on.
    Fading(Instant),
}

/// States and lanes of one instrument.
pub struct Bank<R: Real> {
    isa: Isa,
    program: Arc<Program>,
    states: Vec<States<R>>,
    /// By group, then steady row.
    steady: Vec<[R; LANES]>,
    bases: Vec<[f64; LANES]>,
    /// By group, then late buffer: what it held one sample ago.
    late: Vec<[R; LANES]>,
    lanes: Vec<Lane>,
    live: Vec<u8>,
    /// Lanes that are live.
    taken: usize,
    rising: Vec<u8>,
    fading: Vec<u8>,
    ending: Vec<u8>,
    peaks: Vec<[R; LANES]>,
    routes: Vec<Routes<R>>,
    voices: usize,
    /// Engine samples of silence before a voice that has ended is let go.
    tail: u64,
    sounding: usize,
    enveloped: bool,
    /// Ops that say whether a voice still sounds.
    deciding: Vec<usize>,
    rate: f64,
    seed: u64,
    /// Samples that were not finite and were masked.
    pub masked: u64,
    /// Voices that had to make room.
    pub stolen: u64,
}

impl<R: Real> Bank<R> {
    /// Silent lanes for an instrument, in an engine at `rate` with so many groups of channels.
    pub fn new(instrument: &Instrument, rate: f64, seed: u64, channel_groups: usize, isa: Isa) -> Self {
        let program = instrument.program.clone();
        // Spare lanes let a voice that makes room fade while the new one already sounds.
        let groups = (instrument.voices + instrument.voices.min(LANES)).div_ceil(LANES);
        let states: Vec<_> = program
            .ops
            .iter()
            .map(|op| States::new(op.node.kind, &op.node.setup(rate, rate), groups))
            .collect();
        let deciding: Vec<_> = (0..states.len()).filter(|op| states[*op].sounding(0, 0).is_some()).collect();
        let enveloped = !deciding.is_empty();
        let rows = program.steady.len();
        let mut bank = Self {
            isa,
            states,
            steady: vec![[R::ZERO; LANES]; groups * rows],
            bases: vec![[0.0; LANES]; groups * rows],
            late: vec![[R::ZERO; LANES]; groups * program.late.len()],
            lanes: vec![
                Lane {
                    id: 0,
                    born: Instant::default(),
                    serial: 0,
                    level: 0.0,
                    quiet: 0,
                    play: Play::default(),
                    stage: Stage::Free
                };
                groups * LANES
            ],
            live: vec![0; groups],
            taken: 0,
            rising: vec![0; groups],
            fading: vec![0; groups],
            ending: vec![0; groups],
            peaks: vec![[R::ZERO; LANES]; groups],
            routes: (0..groups).map(|_| Routes::new(channel_groups)).collect(),
            voices: instrument.voices,
            tail: (instrument.tail.clamp(0.0, 3600.0) * rate) as u64,
            sounding: 0,
            enveloped,
            deciding,
            rate,
            seed,
            masked: 0,
            stolen: 0,
            program: Arc::new(program),
        };
        for group in 0..groups {
            for (row, base) in bank.program.steady.iter().enumerate() {
                if let Base::Constant(x) = *base {
                    bank.bases[group * rows + row] = [x; LANES];
                    bank.steady[group * rows + row] = [R::of(x); LANES];
                }
            }
        }
        bank
    }

    /// Voices that sound, those that fade aside.
    pub fn sounding(&self) -> usize {
        self.sounding
    }

    /// Whether all lanes are free.
    pub fn is_idle(&self) -> bool {
        self.taken == 0
    }

    /// Starts a voice at `at`, when `clock` is the next sample to be computed, on the channels of `place`. Gives its lane.
    pub fn start(
        &mut self,
        play: &Play,
        at: Instant,
        clock: u64,
        place: &[(u32, f64)],
        serial: u64,
    ) -> usize {
        if self.sounding >= self.voices {
            self.make_room(at);
        }
        let lane = self.free_lane();
        let (group, l) = (lane / LANES, lane % LANES);
        self.lanes[lane] =
            Lane { id: play.id, born: at, serial, level: 0.0, quiet: 0, play: *play, stage: Stage::Held };
        self.work_out(lane);
        let age = at.until(clock) - LEAD;
        for row in &mut self.late[group * self.program.late.len()..][..self.program.late.len()] {
            row[l] = R::ZERO;
        }
        for op in 0..self.states.len() {
            self.start_op(op, lane, age, play.duration);
        }
        self.place(lane, place);
        // A lane that still faded may have been taken over.
        self.taken += usize::from(self.live[group] & (1 << l) == 0);
        self.live[group] |= 1 << l;
        if !self.enveloped {
            self.rising[group] |= 1 << l;
        }
        self.sounding += 1;
        lane
    }

    /// Steady rows of a lane, from its event.
    fn work_out(&mut self, lane: usize) {
        let (group, l) = (lane / LANES, lane % LANES);
        let play = self.lanes[lane].play;
        let fields = Fields { level: play.level, duration: play.duration, own: play.own };
        let rows = self.program.steady.len();
        for (row, base) in self.program.steady.iter().enumerate() {
            if let Base::Start(id) = *base {
                let value = self.program.starts[id as usize].value(&fields);
                self.bases[group * rows + row][l] = value;
                self.steady[group * rows + row][l] = R::of(value);
            }
        }
    }

    /// Sends a lane to the channels of `place`, with the gain of its event.
    fn place(&mut self, lane: usize, place: &[(u32, f64)]) {
        let (group, l) = (lane / LANES, lane % LANES);
        let play = self.lanes[lane].play;
        let fields = Fields { level: play.level, duration: play.duration, own: play.own };
        let gain = self.program.gain.iter().fold(play.level, |gain, base| {
            gain * match *base {
                Base::Constant(x) => x,
                Base::Start(id) => self.program.starts[id as usize].value(&fields),
            }
        });
        let gain = if gain.is_finite() { gain.clamp(-LOUDEST, LOUDEST) } else { 0.0 };
        for &(channel, share) in place {
            self.routes[group].connect(l, channel, share * gain);
        }
        self.lanes[lane].level = gain.abs();
    }

    /// Takes over the voices of an old bank of the same size: its lanes, and the states of the ops that `ops` names. Ops
    /// without a counterpart begin now. The old bank is left empty.
    pub fn adopt(&mut self, old: &mut Self, ops: &[Option<usize>], places: &[Vec<(u32, f64)>]) {
        if self.lanes.len() != old.lanes.len() {
            return;
        }
        self.take_states(old, ops);
        std::mem::swap(&mut self.lanes, &mut old.lanes);
        std::mem::swap(&mut self.live, &mut old.live);
        std::mem::swap(&mut self.taken, &mut old.taken);
        std::mem::swap(&mut self.rising, &mut old.rising);
        std::mem::swap(&mut self.fading, &mut old.fading);
        std::mem::swap(&mut self.ending, &mut old.ending);
        std::mem::swap(&mut self.peaks, &mut old.peaks);
        std::mem::swap(&mut self.sounding, &mut old.sounding);
        (self.masked, self.stolen) = (old.masked, old.stolen);
        for lane in 0..self.lanes.len() {
            let voice = self.lanes[lane];
            if voice.stage == Stage::Free {
                continue;
            }
            self.work_out(lane);
            self.place(lane, places.get(voice.play.place as usize).map_or(&[][..], |p| p));
            let missing = ops.iter().enumerate().filter(|(_, from)| from.is_none());
            for (op, _) in missing {
                // As if the voice began here, so that what is new comes in gently.
                self.start_op(op, lane, -LEAD + 1.0, voice.play.duration);
            }
        }
    }

    /// Lets voices that were started before the engine took over begin now.
    pub fn begin_at(&mut self, now: Instant) {
        for lane in self.lanes.iter_mut().filter(|lane| lane.stage != Stage::Free) {
            lane.born = now;
        }
    }

    /// Swaps in the states of an old program's ops.
    pub fn take_states(&mut self, old: &mut Self, ops: &[Option<usize>]) {
        for (states, from) in self.states.iter_mut().zip(ops) {
            if let Some(from) = from.and_then(|i| old.states.get_mut(i))
                && states.matches(from)
            {
                std::mem::swap(states, from);
            }
        }
    }

    /// Lets all voices fall silent from `at` on.
    pub fn fade_all(&mut self, at: Instant) {
        for lane in 0..self.lanes.len() {
            if matches!(self.lanes[lane].stage, Stage::Held | Stage::Released) {
                self.lanes[lane].stage = Stage::Fading(at);
                self.fading[lane / LANES] |= 1 << (lane % LANES);
                self.sounding -= 1;
            }
        }
    }

    /// Starts one op of a lane at a voice time (samples).
    fn start_op(&mut self, op: usize, lane: usize, age: f64, duration: f64) {
        let (group, l) = (lane / LANES, lane % LANES);
        let rows = self.program.steady.len();
        let of = &self.program.ops[op];
        let mut start = [0.0; INPUTS];
        for (value, input) in start.iter_mut().zip(&of.inputs) {
            *value = self.bases[group * rows + input.base as usize][l];
        }
        let stream = random::stream(self.seed, self.lanes[lane].id, of.node.stream());
        let onset = Onset { age, stream, start: &start[..of.inputs.len().min(INPUTS)], duration };
        self.states[op].start(group, l, &onset);
    }

    /// Releases the voice of that id on `lane`, if it is still there.
    pub fn release(&mut self, lane: usize, id: u64, at: Instant) {
        let Some(voice) = self.lanes.get_mut(lane).filter(|v| v.id == id && v.stage == Stage::Held) else {
            return;
        };
        let (group, l) = (lane / LANES, lane % LANES);
        if self.enveloped {
            voice.stage = Stage::Released;
            let since = at.since(voice.born);
            for states in &mut self.states {
                states.release(group, l, since);
            }
        } else {
            voice.stage = Stage::Fading(at);
            self.fading[group] |= 1 << l;
            self.sounding -= 1;
        }
    }

    /// Releases all voices of that id, or all there are.
    pub fn release_all(&mut self, id: Option<u64>, at: Instant) {
        for lane in 0..self.lanes.len() {
            let voice = self.lanes[lane];
            if voice.stage == Stage::Held && id.is_none_or(|id| id == voice.id) {
                self.release(lane, voice.id, at);
            }
        }
    }

    /// Computes `frames` samples from `clock` on and adds them to the mix at `offset`.
    pub fn run(&mut self, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        if self.taken == 0 {
            return;
        }
        if !self.program.late.is_empty() && frames > 1 {
            for frame in 0..frames {
                self.run(work, 1, offset + frame, clock + frame as u64);
            }
            return;
        }
        match self.isa {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: an engine holds this level only where `Isa::or_supported` found it on this machine.
            Isa::Avx2 => unsafe { self.run_avx2(work, frames, offset, clock) },
            _ => self.run_groups(work, frames, offset, clock),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn run_avx2(&mut self, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        self.run_groups(work, frames, offset, clock);
    }

    #[inline(always)]
    fn run_groups(&mut self, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        for group in 0..self.live.len() {
            if self.live[group] != 0 {
                self.run_ops(group, work, frames, clock);
                self.finish(group, work, frames, offset, clock);
            }
        }
    }

    #[inline(always)]
    fn run_ops(&mut self, group: usize, work: &mut Workspace<R>, frames: usize, clock: u64) {
        let rows = self.program.steady.len();
        let steady = &self.steady[group * rows..][..rows];
        let bases = &self.bases[group * rows..][..rows];
        let late = &self.late[group * self.program.late.len()..][..self.program.late.len()];
        let (isa, shared) = (self.isa, &work.shared);
        for (op, states) in self.program.ops.iter().zip(&mut self.states) {
            // An op never reads what it writes.
            let (before, rest) = work.buffers.split_at_mut(op.output as usize);
            let Some((output, after)) = rest.split_first_mut() else { continue };
            let (before, after) = (&*before, &*after);
            let output = &mut output[..frames];
            let sources = Sources { steady, bases, late, before, after, shared, frames };
            // Most ops have few inputs, and a short list is made sooner than a long one.
            let mut run = |inputs: &[Input<'_, R>]| states.run(isa, group, &mut Io { inputs, output, clock });
            match op.inputs[..op.running.min(INPUTS)] {
                [] => run(&[]),
                [ref a] => run(&[sources.input(a)]),
                [ref a, ref b] => run(&[sources.input(a), sources.input(b)]),
                [ref a, ref b, ref c] => run(&[sources.input(a), sources.input(b), sources.input(c)]),
                [ref first, ref others @ ..] => {
                    let mut inputs = [sources.input(first); INPUTS];
                    for (slot, of) in inputs[1..].iter_mut().zip(others) {
                        *slot = sources.input(of);
                    }
                    run(&inputs[..=others.len()]);
                }
            }
        }
        let late = &mut self.late[group * self.program.late.len()..][..self.program.late.len()];
        for (row, buffer) in late.iter_mut().zip(&self.program.late) {
            *row = work.buffers[*buffer as usize][frames - 1];
        }
    }

    /// Masks what is not finite, fades what fades, notes peaks where a voice may be at its end, and mixes.
    #[inline(always)]
    fn finish(&mut self, group: usize, work: &mut Workspace<R>, frames: usize, offset: usize, clock: u64) {
        let rows = self.program.steady.len();
        let Workspace { buffers, shared, mix, stride, fed } = work;
        // The last buffer of the workspace is the mixer's own.
        let own = buffers.len() - 1;
        let at = match self.program.outputs.first() {
            Some(Feed::Buffer(b)) => *b as usize,
            Some(Feed::Shared(s)) => {
                buffers[own][..frames].copy_from_slice(&shared[*s as usize][..frames]);
                own
            }
            Some(Feed::Steady(row)) => {
                buffers[own][..frames].fill(self.steady[group * rows + *row as usize]);
                own
            }
            Some(Feed::Late(_)) | None => return,
        };
        let block = &mut buffers[at][..frames];
        if !R::all_finite(block) {
            self.masked += mask(block, self.live[group]);
        }
        if (self.rising[group] | self.fading[group]) != 0 {
            self.fade(group, block, clock);
        }
        if self.ending[group] != 0 {
            let mut peak = self.peaks[group];
            for row in block.iter() {
                for l in 0..LANES {
                    peak[l] = peak[l].max(row[l].abs());
                }
            }
            self.peaks[group] = peak;
        }
        self.routes[group].mix(block, &mut Bus { rows: mix, stride: *stride, fed }, offset);
    }

    #[cold]
    fn fade(&mut self, group: usize, block: &mut [[R; LANES]], clock: u64) {
        for l in 0..LANES {
            if self.rising[group] & (1 << l) != 0 {
                let age = self.lanes[group * LANES + l].born.until(clock) - LEAD;
                for (frame, row) in block.iter_mut().enumerate() {
                    row[l] *= R::of(1.0 - fade((age + frame as f64) / self.rate));
                }
                if age > FADE * self.rate {
                    self.rising[group] &= !(1 << l);
                }
            }
            if let Stage::Fading(since) = self.lanes[group * LANES + l].stage {
                let age = since.until(clock) - LEAD;
                for (frame, row) in block.iter_mut().enumerate() {
                    row[l] *= R::of(fade((age + frame as f64) / self.rate));
                }
            }
        }
    }

    /// Every 64 engine samples: settles states, and frees lanes whose voices have ended.
    pub fn settle(&mut self, clock: u64) {
        for group in 0..self.live.len() {
            if self.live[group] == 0 {
                continue;
            }
            for states in &mut self.states {
                states.settle(group);
            }
            let ended = self.ended(group);
            for l in 0..LANES {
                let lane = group * LANES + l;
                let over = match self.lanes[lane].stage {
                    Stage::Free => continue,
                    Stage::Fading(since) => since.until(clock) - LEAD > FADE * self.rate,
                    Stage::Held | Stage::Released => {
                        let bit = 1 << l;
                        if self.ending[group] & bit != 0 && self.peaks[group][l] < R::of(SILENCE) {
                            self.lanes[lane].quiet += GRID;
                        } else {
                            self.lanes[lane].quiet = 0;
                        }
                        self.ending[group] |= ended & bit;
                        self.lanes[lane].quiet > self.tail
                    }
                };
                if over {
                    self.free(lane);
                }
            }
            self.peaks[group] = [R::ZERO; LANES];
        }
    }

    /// Lanes whose envelopes have all ended.
    fn ended(&self, group: usize) -> u8 {
        let all = if self.enveloped { u8::MAX } else { 0 };
        self.deciding.iter().fold(all, |all, op| all & self.states[*op].ended(group))
    }

    fn free(&mut self, lane: usize) {
        let (group, l) = (lane / LANES, lane % LANES);
        if !matches!(self.lanes[lane].stage, Stage::Fading(_) | Stage::Free) {
            self.sounding -= 1;
        }
        self.lanes[lane].stage = Stage::Free;
        let keep = !(1 << l);
        self.taken -= usize::from(self.live[group] & (1 << l) != 0);
        self.live[group] &= keep;
        self.rising[group] &= keep;
        self.fading[group] &= keep;
        self.ending[group] &= keep;
        self.routes[group].disconnect(l);
    }

    /// The lowest free lane; where all are taken, the one that has faded longest.
    fn free_lane(&mut self) -> usize {
        for (group, live) in self.live.iter().enumerate() {
            let l = live.trailing_ones() as usize;
            if l < LANES {
                return group * LANES + l;
            }
        }
        let since = |lane: &Lane| if let Stage::Fading(since) = lane.stage { since } else { Instant::NEVER };
        let lane = (0..self.lanes.len()).min_by_key(|&i| since(&self.lanes[i])).unwrap_or(0);
        self.free(lane);
        lane
    }

    /// Lets a voice fade: of those released the quietest, else the oldest.
    fn make_room(&mut self, at: Instant) {
        let of_stage = |stage| {
            let lanes = self.lanes.iter().enumerate();
            lanes.filter(move |(_, lane)| lane.stage == stage).map(|(i, lane)| (i, lane.serial))
        };
        let quietest = of_stage(Stage::Released)
            .map(|(lane, serial)| (lane, self.loudness(lane), serial))
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.2.cmp(&b.2)))
            .map(|(lane, ..)| lane);
        let victim = quietest
            .or_else(|| of_stage(Stage::Held).min_by_key(|(_, serial)| *serial).map(|(lane, _)| lane));
        if let Some(lane) = victim {
            self.lanes[lane].stage = Stage::Fading(at);
            self.fading[lane / LANES] |= 1 << (lane % LANES);
            self.sounding -= 1;
            self.stolen += 1;
        }
    }

    /// The smallest value of its envelopes times its level.
    fn loudness(&self, lane: usize) -> f64 {
        let (group, l) = (lane / LANES, lane % LANES);
        let of_envelopes = self.states.iter().filter_map(|s| s.value(group, l).map(f64::abs));
        of_envelopes.fold(f64::INFINITY, f64::min) * self.lanes[lane].level
    }

    /// Where the program's output `index` is found, for engine-wide programs.
    pub fn output_feed(&self, index: usize) -> Feed {
        self.program.outputs[index]
    }

    /// Runs all ops of the first group without mixing: for engine-wide programs, which have no loops.
    pub fn run_shared(&mut self, work: &mut Workspace<R>, frames: usize, clock: u64) {
        self.run_ops(0, work, frames, clock);
    }

    /// A value of the first lane's steady row.
    pub fn steady_value(&self, row: u32) -> R {
        self.steady[row as usize][0]
    }
}

/// Where an op finds its inputs.
struct Sources<'a, R> {
    steady: &'a [[R; LANES]],
    bases: &'a [[f64; LANES]],
    late: &'a [[R; LANES]],
    /// Buffers below the one it writes, and above.
    before: &'a [Rows<R>],
    after: &'a [Rows<R>],
    shared: &'a [Rows<R>],
    frames: usize,
}

impl<'a, R: Real> Sources<'a, R> {
    /// Built where it is wanted: a copy would wait for the parts to be written.
    #[inline(always)]
    fn input(&self, input: &OpInput) -> Input<'a, R> {
        let base = &self.bases[input.base as usize];
        let rows = match input.feed {
            Feed::Steady(row) => {
                return Input { rows: &self.steady[row as usize..=row as usize], step: 0, base };
            }
            Feed::Late(i) => return Input { rows: &self.late[i as usize..=i as usize], step: 0, base },
            Feed::Shared(s) => &self.shared[s as usize],
            Feed::Buffer(b) => match self.before.get(b as usize) {
                Some(rows) => rows,
                None => &self.after[b as usize - self.before.len() - 1],
            },
        };
        Input { rows: &rows[..self.frames], step: 1, base }
    }
}

/// Makes what is not finite 0; how many samples of live lanes that were.
#[cold]
fn mask<R: Real>(block: &mut [[R; LANES]], live: u8) -> u64 {
    let mut count = 0;
    for row in block {
        for (l, value) in row.iter_mut().enumerate() {
            if !value.is_finite() {
                *value = R::ZERO;
                count += u64::from(live & (1 << l) != 0);
            }
        }
    }
    count
}
