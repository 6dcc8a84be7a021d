//! The ops of one program at work: their states and constants, lane by lane.

use super::workspace::{Buffer, Workspace};
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random;
use crate::graph::Base;
use crate::graph::program::{Feed, OpInput, Program};
use crate::graph::start::Fields;
use crate::node::kernel::{INPUTS, Input, Io, Onset};
use crate::node::motion::Motion;
use crate::node::{NodeKind, States};

/// States of the ops of a program, for groups of lanes.
pub struct Ops<R: Real> {
    isa: Isa,
    program: Program,
    states: Vec<States<R>>,
    /// By group, then steady row.
    steady: Vec<[R; LANES]>,
    bases: Vec<[f64; LANES]>,
    /// By group, then late buffer: what it held one sample ago.
    late: Vec<[R; LANES]>,
    /// Ops that say whether a voice still sounds.
    deciding: Vec<usize>,
    /// Ops that listen to what the hand does.
    touched: Vec<usize>,
    /// By op, then lane: by how many samples an op began after its voice, whose plan did not have it then. Empty where none can have.
    behind: Vec<f64>,
    groups: usize,
    seed: u64,
}

impl<R: Real> Ops<R> {
    /// Silent lanes, in an engine at `rate`.
    pub fn new(program: &Program, groups: usize, rate: f64, seed: u64, isa: Isa) -> Self {
        let new =
            |op: &crate::graph::program::Op| States::new(op.node.kind, &op.node.setup(rate, rate), groups);
        let states: Vec<_> = program.ops.iter().map(new).collect();
        let deciding = (0..states.len()).filter(|op| states[*op].sounding(0, 0).is_some()).collect();
        let touched = (0..states.len()).filter(|op| program.ops[*op].node.kind == NodeKind::TOUCH).collect();
        let rows = program.steady.len();
        let mut ops = Self {
            isa,
            states,
            steady: vec![[R::ZERO; LANES]; groups * rows],
            bases: vec![[0.0; LANES]; groups * rows],
            late: vec![[R::ZERO; LANES]; groups * program.late.len()],
            deciding,
            touched,
            behind: Vec::new(),
            groups,
            seed,
            program: program.clone(),
        };
        for group in 0..groups {
            for (row, base) in ops.program.steady.iter().enumerate() {
                if let Base::Constant(x) = *base {
                    ops.bases[group * rows + row] = [x; LANES];
                    ops.steady[group * rows + row] = [R::of(x); LANES];
                }
            }
        }
        ops
    }

    /// Whether some of them say when a voice has ended.
    pub fn decide(&self) -> bool {
        !self.deciding.is_empty()
    }

    /// Whether they must run sample by sample, as one reads what another gave a sample ago.
    pub fn have_loops(&self) -> bool {
        !self.program.late.is_empty()
    }

    /// Works out the steady rows of a lane from its event.
    pub fn set(&mut self, lane: usize, fields: &Fields) {
        let (group, l) = (lane / LANES, lane % LANES);
        let rows = self.program.steady.len();
        for (row, base) in self.program.steady.iter().enumerate() {
            if let Base::Start(id) = *base {
                let value = self.program.starts[id as usize].value(fields);
                self.bases[group * rows + row][l] = value;
                self.steady[group * rows + row][l] = R::of(value);
            }
        }
    }

    /// What folding made gain, for an event.
    pub fn gain(&self, fields: &Fields) -> f64 {
        let value = |base: &Base| match *base {
            Base::Constant(x) => x,
            Base::Start(id) => self.program.starts[id as usize].value(fields),
        };
        self.program.gain.iter().map(value).product()
    }

    /// Starts a lane, whose steady rows are set, at the voice time `age` (samples). `id` names its random numbers.
    pub fn start(&mut self, lane: usize, id: u64, age: f64) {
        let late = self.program.late.len();
        for row in &mut self.late[lane / LANES * late..][..late] {
            row[lane % LANES] = R::ZERO;
        }
        for op in 0..self.states.len() {
            self.start_one(op, lane, id, age);
            self.delay(op, lane, 0.0);
        }
    }

    /// Makes room to remember which ops began after their voices. It allocates.
    pub fn expect_voices(&mut self) {
        self.behind = vec![0.0; self.states.len() * self.lanes()];
    }

    /// Starts one op of a lane whose voice has had its onset `age` samples before the next sample is computed.
    pub fn start_late(&mut self, op: usize, lane: usize, id: u64, age: f64) {
        let own = -1.0;
        self.start_one(op, lane, id, own);
        self.delay(op, lane, age - own);
    }

    /// Whether an op says when a voice has ended.
    pub fn decides(&self, op: usize) -> bool {
        self.deciding.contains(&op)
    }

    fn lanes(&self) -> usize {
        self.groups * LANES
    }

    fn delay(&mut self, op: usize, lane: usize, behind: f64) {
        let number = op * self.lanes() + lane;
        if let Some(slot) = self.behind.get_mut(number) {
            *slot = behind;
        }
    }

    /// A voice time as an op counts it.
    fn own(&self, op: usize, lane: usize, at: f64) -> f64 {
        at - self.behind.get(op * self.lanes() + lane).copied().unwrap_or(0.0)
    }

    /// Starts one op of a lane.
    fn start_one(&mut self, op: usize, lane: usize, id: u64, age: f64) {
        let (start, inputs) = self.known(op, lane);
        let stream = random::stream(self.seed, id, self.program.ops[op].node.stream());
        let onset = Onset { age, stream, start: &start[..inputs] };
        self.states[op].start(lane / LANES, lane % LANES, &onset);
    }

    /// What is known of the inputs of an op of a lane before it runs, and how many there are.
    fn known(&self, op: usize, lane: usize) -> ([f64; INPUTS], usize) {
        let (group, l) = (lane / LANES, lane % LANES);
        let rows = self.program.steady.len();
        let inputs = &self.program.ops[op].inputs;
        let mut known = [0.0; INPUTS];
        for (value, input) in known.iter_mut().zip(inputs) {
            *value = self.bases[group * rows + input.base as usize][l];
        }
        (known, inputs.len().min(INPUTS))
    }

    /// Lets the ops of a lane, whose steady rows are set, run on as those say, where they were those of an old program whose rows said something else.
    pub fn retune(&mut self, lane: usize, old: &Self, ops: &[Option<usize>]) {
        for (op, from) in ops.iter().enumerate() {
            let Some(from) = *from else { continue };
            let ((was, inputs), (now, _)) = (old.known(from, lane), self.known(op, lane));
            if was != now {
                self.states[op].retune(lane / LANES, lane % LANES, &was[..inputs], &now[..inputs]);
            }
        }
    }

    /// Releases a lane at the voice time `at` (samples).
    pub fn release(&mut self, lane: usize, at: f64) {
        for op in 0..self.states.len() {
            let at = self.own(op, lane, at);
            self.states[op].release(lane / LANES, lane % LANES, at);
        }
    }

    /// Whether some of them listen to what the hand does.
    pub fn listen(&self) -> bool {
        !self.touched.is_empty()
    }

    /// The hand that holds a lane moves at the voice time `at` (samples).
    pub fn touch(&mut self, lane: usize, motion: Motion, value: f64, at: f64) {
        for number in 0..self.touched.len() {
            let op = self.touched[number];
            let at = self.own(op, lane, at);
            self.states[op].touch(lane / LANES, lane % LANES, motion, value, at);
        }
    }

    /// Swaps in the states of an old program's ops.
    pub fn take_states(&mut self, old: &mut Self, ops: &[Option<usize>]) {
        self.take_late(old, ops);
        let lanes = self.lanes();
        for (op, (states, from)) in self.states.iter_mut().zip(ops).enumerate() {
            let Some(from) = *from else { continue };
            if let Some(old) = old.states.get_mut(from)
                && states.matches(old)
            {
                std::mem::swap(states, old);
            }
            let old = old.behind.get(from * lanes..(from + 1) * lanes);
            if let (Some(behind), Some(old)) = (self.behind.get_mut(op * lanes..(op + 1) * lanes), old) {
                behind.copy_from_slice(old);
            }
        }
    }

    /// Copies ahead what [`Ops::copy_states`] would take long to copy, as [`Kernel::copy_ahead`](crate::node::kernel::Kernel::copy_ahead) says.
    pub fn copy_ahead(&mut self, old: &Self, ops: &[Option<usize>], live: &[u8], left: &mut usize) {
        for (states, from) in self.states.iter_mut().zip(ops) {
            if let Some(old) = from.and_then(|from| old.states.get(from)) {
                states.copy_ahead(old, live, left);
            }
        }
    }

    /// Makes the states of the lanes that live, as far as there are as many here and there, copies of those of an old program's ops, which it keeps.
    /// `live` has a bit for each lane of a group.
    pub fn copy_states(&mut self, old: &Self, ops: &[Option<usize>], live: &[u8]) {
        self.take_late(old, ops);
        let (here, there) = (self.lanes(), old.lanes());
        for (op, (states, from)) in self.states.iter_mut().zip(ops).enumerate() {
            let Some(from) = *from else { continue };
            if let Some(old) = old.states.get(from) {
                states.copy(old, live);
            }
            let old = old.behind.get(from * there..(from + 1) * there);
            if let (Some(behind), Some(old)) = (self.behind.get_mut(op * here..(op + 1) * here), old) {
                behind.iter_mut().zip(old).for_each(|(behind, old)| *behind = *old);
            }
        }
    }

    /// What ops read of others a sample later goes on where the same op is read late in both programs.
    fn take_late(&mut self, old: &Self, ops: &[Option<usize>]) {
        let (here, there) = (self.program.late.len(), old.program.late.len());
        for (place, buffer) in self.program.late.iter().enumerate() {
            let op = self.program.ops.iter().position(|op| op.output == *buffer);
            let from = op.and_then(|op| old.program.ops.get((*ops.get(op)?)?));
            let Some(was) = from.and_then(|from| old.program.late.iter().position(|b| *b == from.output))
            else {
                continue;
            };
            for group in 0..self.groups.min(old.groups) {
                self.late[group * here + place] = old.late[group * there + was];
            }
        }
    }

    /// Runs all ops of a group.
    #[inline(always)]
    pub fn run(&mut self, group: usize, work: &mut Workspace<R>, frames: usize) {
        let rows = self.program.steady.len();
        let steady = &self.steady[group * rows..][..rows];
        let bases = &self.bases[group * rows..][..rows];
        let late = &self.late[group * self.program.late.len()..][..self.program.late.len()];
        let Workspace { buffers, shared, .. } = work;
        let isa = self.isa;
        for (op, states) in self.program.ops.iter().zip(&mut self.states) {
            // An op never reads what it writes.
            let (before, rest) = buffers.split_at_mut(op.output as usize);
            let Some((output, after)) = rest.split_first_mut() else { continue };
            let (before, after) = (&*before, &*after);
            let rows = &mut output.rows[..frames];
            let sources = Sources { steady, bases, late, before, after, shared, frames };
            // Most ops have few inputs, and a short list is made sooner than a long one.
            let mut run = |inputs: &[Input<'_, R>]| {
                let mut io = Io { inputs, output: &mut *rows, still: false };
                states.run(isa, group, &mut io);
                io.still
            };
            output.still = match op.inputs[..op.running.min(INPUTS)] {
                [] => run(&[]),
                [ref a] => run(&[sources.input(a)]),
                [ref a, ref b] => run(&[sources.input(a), sources.input(b)]),
                [ref a, ref b, ref c] => run(&[sources.input(a), sources.input(b), sources.input(c)]),
                [ref first, ref others @ ..] => {
                    let mut inputs = [sources.input(first); INPUTS];
                    for (slot, of) in inputs[1..].iter_mut().zip(others) {
                        *slot = sources.input(of);
                    }
                    run(&inputs[..=others.len()])
                }
            };
        }
        let late = &mut self.late[group * self.program.late.len()..][..self.program.late.len()];
        for (row, buffer) in late.iter_mut().zip(&self.program.late) {
            *row = work.buffers[*buffer as usize].at(frames - 1);
        }
    }

    /// Where an output is found once they have run.
    pub fn output(&self, index: usize) -> Option<Feed> {
        self.program.outputs.get(index).copied()
    }

    /// A steady row of a group.
    pub fn steady(&self, group: usize, row: u32) -> [R; LANES] {
        self.steady[group * self.program.steady.len() + row as usize]
    }

    /// A steady row of one lane, in full precision.
    pub fn base(&self, lane: usize, row: u32) -> f64 {
        self.bases[lane / LANES * self.program.steady.len() + row as usize][lane % LANES]
    }

    /// Every 64 engine samples: what has died away becomes exact zero.
    pub fn settle(&mut self, group: usize) {
        for states in &mut self.states {
            states.settle(group);
        }
    }

    /// Lanes of a group, a bit each, whose envelopes have all ended; none where there are no envelopes.
    pub fn ended(&self, group: usize) -> u8 {
        let all = if self.decide() { u8::MAX } else { 0 };
        self.deciding.iter().fold(all, |all, op| all & self.states[*op].ended(group))
    }

    /// The smallest value of a lane's envelopes.
    pub fn loudness(&self, lane: usize) -> f64 {
        let values = self.states.iter().filter_map(|s| s.value(lane / LANES, lane % LANES));
        values.map(f64::abs).fold(f64::INFINITY, f64::min)
    }
}

/// Where an op finds its inputs.
struct Sources<'a, R> {
    steady: &'a [[R; LANES]],
    bases: &'a [[f64; LANES]],
    late: &'a [[R; LANES]],
    /// Buffers below the one it writes, and above.
    before: &'a [Buffer<R>],
    after: &'a [Buffer<R>],
    shared: &'a [Buffer<R>],
    frames: usize,
}

impl<'a, R: Real> Sources<'a, R> {
    /// Built where it is wanted: a copy would wait for the parts to be written.
    #[inline(always)]
    fn input(&self, input: &OpInput) -> Input<'a, R> {
        let base = &self.bases[input.base as usize];
        let buffer = match input.feed {
            Feed::Steady(row) => {
                let rows = &self.steady[row as usize..=row as usize];
                return Input { rows, step: 0, steady: true, base };
            }
            Feed::Late(i) => {
                let rows = &self.late[i as usize..=i as usize];
                return Input { rows, step: 0, steady: false, base };
            }
            Feed::Shared(s) => &self.shared[s as usize],
            Feed::Buffer(b) => match self.before.get(b as usize) {
                Some(buffer) => buffer,
                None => &self.after[b as usize - self.before.len() - 1],
            },
        };
        buffer.input(self.frames, base)
    }
}
