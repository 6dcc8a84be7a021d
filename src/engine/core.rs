//! The engine for one number type: clock, events, voices, mix and output stage.

use super::bank::Bank;
use super::commander::Commander;
use super::control::Ramp;
use super::event::{Event, Source};
use super::knob::Knob;
use super::knob::followed::Followed;
use super::ops::Ops;
use super::refusal::Refusal;
use super::roster::{Duty, Roster};
use super::stage::Stage;
use super::standing::Standing;
use super::succession::Succession;
use super::task::Board;
use super::turnover::{Turned, Turnover};
use super::watch::{self, Watcher};
use super::workspace::{BLOCK, Workspace};
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::graph::places::Places;
use crate::graph::plan::{Instrument, Plan, Shared};
use crate::graph::program::Feed;
use crate::graph::start::{FIELDS, Fields};
use crate::knob::local_model::link::Fast;
use crate::node::kernel::LEAD;
use crate::schedule::{Deadlines, Instant, Queue};
use crate::space::moving::Mover;
use crate::space::path::Route;
use std::sync::Arc;

mod adopt;
mod events;

/// Engine samples between two looks at what has become silent.
pub const GRID: u64 = 64;

/// Events that may wait.
pub const WAITING: usize = 16_384;

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Voices started.
    pub started: u64,
    /// Voices that had to make room for others.
    pub stolen: u64,
    /// Samples of voices that were not finite and became 0.
    pub masked: u64,
    /// Events that found the queue full and were dropped.
    pub dropped: u64,
    /// Events that came after their time and were played at once.
    pub late: u64,
}

/// A plan at work.
pub struct Core<R: Real> {
    clock: u64,
    rate: f64,
    queue: Queue<Event>,
    /// When voices have sounded their time: a slot for each lane of all banks, under the serial number of its voice.
    ends: Deadlines,
    /// By bank: the slot of its first lane.
    first: Vec<usize>,
    /// The latest end of the voices that died away before theirs and whose lanes were taken since.
    outlasted: Option<Instant>,
    places: Places,
    commander: Commander,
    banks: Vec<Bank<R>>,
    shared: Option<Ops<R>>,
    sources: Vec<Shared>,
    controls: Vec<Ramp<R>>,
    work: Workspace<R>,
    latest: Vec<R>,
    watcher: Watcher,
    turnover: Turnover,
    /// Engine samples from what sets off a pattern to its beginning.
    answer: u64,
    stage: Stage,
    knob: Option<Box<Knob>>,
    tasks: Roster,
    standing: Standing,
    counters: Counters,
    /// The clock of the last housekeeping.
    settled: Option<u64>,
    /// What has been silenced since an old engine was told last.
    silenced: Option<(u64, u8, Instant)>,
}

impl<R: Real> Core<R> {
    /// Everything a plan needs, allocated.
    ///
    /// # Errors
    /// A rate or a number of taps that the output stage cannot be built for; a place or an output beyond the plan's channels.
    pub fn new(plan: &Plan, isa: Isa) -> Result<Self, Refusal> {
        Refusal::check(plan)?;
        let rate = plan.engine_rate();
        let groups = plan.channels.div_ceil(LANES);
        let paths: Arc<[Route]> = plan.paths.as_slice().into();
        let bank = |i: &Instrument| Bank::new(i, (&paths, &plan.gauges), rate, plan.seed, groups, isa);
        let banks: Vec<_> = plan.instruments.iter().map(bank).collect();
        let shared = &plan.shared_program;
        // A program of no ops may still hand on what a control says.
        let shared = (!shared.outputs.is_empty()).then(|| Ops::new(shared, 1, rate, plan.seed, isa));
        let controls =
            plan.controls.iter().map(|c| Ramp::new(c.default, c.least, c.most, c.smoothing * rate)).collect();
        let programs = plan.instruments.iter().map(|i| &i.program).chain([&plan.shared_program]);
        let buffers = programs.map(|p| p.buffers).max().unwrap_or(0) + 1;
        let (mut first, mut lanes) = (Vec::with_capacity(banks.len()), 0);
        for bank in &banks {
            first.push(lanes);
            lanes += bank.lanes();
        }
        let mut core = Self {
            clock: 0,
            rate,
            queue: Queue::new(WAITING),
            ends: Deadlines::new(lanes),
            first,
            outlasted: None,
            places: Places::new(plan),
            commander: Commander::new(plan),
            banks,
            shared,
            sources: plan.shared.clone(),
            controls,
            work: Workspace::new(buffers, plan.shared.len(), plan.channels),
            latest: vec![R::ZERO; plan.shared.len()],
            watcher: Watcher::new(plan, rate),
            turnover: Turnover::new(plan.always().count()),
            answer: plan.answer,
            stage: Stage::new(plan, isa)?,
            knob: Knob::new(plan)?.map(Box::new),
            tasks: Roster::default(),
            standing: Standing::default(),
            counters: Counters::default(),
            settled: None,
            silenced: None,
        };
        if plan.moves() {
            core.work.mover = plan.spread.as_ref().map(Mover::new);
        }
        core.begin(plan);
        Ok(core)
    }

    /// Starts what sounds from the beginning.
    fn begin(&mut self, plan: &Plan) {
        if let Some(shared) = &mut self.shared {
            let fields = Fields { level: 1.0, duration: f64::INFINITY, own: [0.0; FIELDS] };
            shared.set(0, &fields);
            shared.start(0, u64::MAX, -LEAD);
        }
        for play in plan.always() {
            self.turnover.note(Instant::default(), Turned::Began(play));
            self.play(&play, Instant::default());
        }
    }

    /// Times tasks and standing work from now on, by a clock that gives nanoseconds.
    pub fn time(&mut self, clock: fn() -> u64) {
        self.tasks.time(clock);
        self.standing.time(clock);
    }

    /// What is known of the standing work.
    pub fn duties(&self) -> [Arc<Duty>; 2] {
        self.standing.duties()
    }

    /// The periodic tasks.
    pub fn tasks(&mut self) -> &mut Roster {
        &mut self.tasks
    }

    /// Seconds from what sets off a pattern to its beginning.
    pub fn answer_delay(&self) -> f64 {
        self.answer as f64 / self.rate
    }

    /// What signals set off.
    pub fn watcher(&mut self) -> &mut Watcher {
        &mut self.watcher
    }

    /// What became of voices without an event of theirs.
    pub fn turnover(&mut self) -> &mut Turnover {
        &mut self.turnover
    }

    /// Engine samples a second.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Engine samples computed so far.
    pub fn clock(&self) -> u64 {
        self.clock
    }

    /// Room in the queue of events.
    pub fn room(&self) -> usize {
        self.queue.room()
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        let mut counters = self.counters;
        for bank in &self.banks {
            counters.masked += bank.masked;
            counters.stolen += bank.stolen;
        }
        counters
    }

    /// The output stage.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// As [`Engine::hold_motors`](super::Engine::hold_motors).
    pub fn hold_motors(&mut self, held: bool) {
        self.stage.hold_motors(held);
    }

    /// The knob.
    pub fn knob(&self) -> Option<&Knob> {
        self.knob.as_deref()
    }

    /// The angle of a knob that is there, of the next tick that has none yet; `None`: it is lost.
    pub fn read_knob(&mut self, angle: Option<f64>) {
        self.knob.iter_mut().for_each(|knob| knob.read(angle));
    }

    /// Lets a slow thread send worlds to the knob; `false` where there is none.
    pub fn link_knob(&mut self, link: Fast) -> bool {
        let Some(knob) = &mut self.knob else { return false };
        knob.listen(link);
        true
    }

    /// Lets the knob take a world once more that was taken in a run that is repeated.
    pub fn follow_again(&mut self, followed: Followed) {
        self.knob.iter_mut().for_each(|knob| knob.follow_again(followed));
    }

    /// Worlds that the knob has taken since this was asked last.
    pub fn followed(&mut self) -> impl Iterator<Item = Followed> {
        self.knob.iter_mut().flat_map(|knob| knob.followed())
    }

    /// How much of what signals have set off, and how many worlds that the knob has taken, were not kept since this was asked last.
    pub fn take_unkept(&mut self) -> u64 {
        self.watcher.take_unkept() + self.knob.as_mut().map_or(0, |knob| knob.take_unkept())
    }

    /// Voices that sound.
    pub fn sounding(&self) -> usize {
        self.banks.iter().map(Bank::sounding).sum()
    }

    /// Whether nothing sounds, nothing waits and nothing rings.
    pub fn is_silent(&self) -> bool {
        let lasts = |end: Instant| end.ceiling() >= self.clock;
        let due = !self.queue.is_empty() || !self.ends.is_empty() || !self.watcher.is_empty();
        let waits = due || self.outlasted.is_some_and(lasts);
        !waits && self.banks.iter().all(Bank::is_idle) && self.stage.is_asleep()
    }

    /// An event at an instant; one in the past takes effect with the next sample. Says whether there was room.
    pub fn schedule(&mut self, at: Instant, source: Source, event: Event) -> bool {
        // What falls between the last sample and the next takes effect with the next. What is late comes before it, as it was due before it: a voice begins
        // before it is let go of.
        let at = if at.ceiling() < self.clock {
            self.counters.late += 1;
            Instant::first_of(self.clock)
        } else {
            at
        };
        let taken = self.queue.push(at, source as u16, event).is_ok();
        self.counters.dropped += u64::from(!taken);
        taken
    }

    /// What is due before the next sample takes place now, as it otherwise would with that sample; so there is room for more.
    pub fn run_ahead(&mut self) {
        self.settle();
        self.run_events();
    }

    /// Computes `samples` engine samples (at most 64), and what they amount to at the device: `samples` × ratio frames. Where
    /// `output` has no room for the last of them, it goes to `rest`. The voices of an old core that fades out are added.
    pub fn advance(
        &mut self,
        samples: usize,
        input: &[Vec<f32>],
        output: &mut [f32],
        rest: &mut [f32],
        mut leaving: Option<&mut Self>,
    ) {
        let samples = samples.min(BLOCK);
        self.work.clear_mix(samples);
        if let Some(old) = &mut leaving {
            old.work.clear_mix(samples);
        }
        let begin = self.clock;
        let mut done = 0;
        while done < samples {
            self.run_due();
            let silenced = self.silenced.take();
            if let Some(old) = &mut leaving {
                if let Some((id, bits, at)) = silenced {
                    old.banks
                        .iter_mut()
                        .for_each(|bank| bank.silence(|play| play.is_of(id, bits), at, |_, _| ()));
                }
                old.settle();
            }
            let left = (samples - done) as u64;
            let mut stretch = u64::MAX;
            if let Some(knob) = &mut self.knob {
                // Ahead of what is computed next, and no further than what came in.
                stretch = Knob::until(self.clock);
                let until = stretch.min(self.clock + left);
                let (queue, watcher) = (&mut self.queue, &mut self.watcher);
                if let samples @ 1.. = knob.ahead(until) {
                    self.standing.knob(samples, || knob.run(until, queue, watcher));
                }
                self.counters.dropped += knob.take_dropped();
                self.run_events();
            }
            let end = self.ends.next().map_or(u64::MAX, Instant::ceiling);
            let next = self.queue.next().unwrap_or(u64::MAX).min(end).min((self.clock / GRID + 1) * GRID);
            let mut next = next.min(self.tasks.next(self.clock + 1)).min(stretch);
            if !self.watcher.is_idle() {
                let start = self.watcher.next().map_or(u64::MAX, Instant::ceiling);
                next = next.min(start).min(self.clock + watch::STRETCH);
            }
            let frames = (next - self.clock).min(left) as usize;
            self.render(frames, done, input);
            if let Some(old) = &mut leaving {
                if !old.is_idle() {
                    old.signals(frames, done, input, self.knob.as_deref());
                }
                old.sound(frames, done);
                old.clock += frames as u64;
            }
            for (latest, signal) in self.latest.iter_mut().zip(&self.work.shared) {
                *latest = signal.at(frames - 1)[0];
            }
            if let Some(knob) = &mut self.knob {
                knob.note(&mut self.work, frames, done, self.clock);
            }
            self.clock += frames as u64;
            done += frames;
        }
        if let Some(old) = &leaving {
            self.work.add_mix(&old.work);
        }
        let before = leaving.map(|old| &mut old.stage);
        self.stage.process(
            &mut self.work.mix,
            &self.work.fed,
            samples,
            begin,
            output,
            rest,
            before,
            &self.standing,
        );
        if let Some(knob) = &self.knob {
            knob.write(samples, self.stage.vibration().channels(), output, rest);
        }
    }

    /// Housekeeping, on its grid.
    fn settle(&mut self) {
        if self.clock.is_multiple_of(GRID) && self.settled != Some(self.clock) {
            self.settled = Some(self.clock);
            for bank in &mut self.banks {
                bank.settle(self.clock);
            }
            if let Some(shared) = &mut self.shared {
                shared.settle(0);
            }
        }
    }

    /// Makes room to take over the voices of another engine. It allocates.
    pub fn expect_voices(&mut self) {
        self.banks.iter_mut().for_each(Bank::expect_voices);
    }

    /// Tells the output stage how it is to take over from another.
    pub fn expect_succession(&mut self, succession: Succession) {
        self.stage.expect_succession(succession);
    }

    /// Whether the output stage before this one still sounds.
    pub fn is_succeeding(&self) -> bool {
        self.stage.is_succeeding()
    }

    /// Whether no voice sounds or fades.
    pub fn is_idle(&self) -> bool {
        self.banks.iter().all(Bank::is_idle)
    }

    /// Computes all voices and mixes them.
    fn sound(&mut self, frames: usize, offset: usize) {
        for bank in &mut self.banks {
            bank.run(&mut self.work, frames, offset, self.clock);
        }
    }

    /// Events, tasks and housekeeping that are due before the next sample.
    fn run_due(&mut self) {
        self.settle();
        self.run_events();
        let clock = self.clock;
        self.tasks.run(clock, &mut Board { controls: &mut self.controls, latest: &self.latest, clock });
    }

    fn render(&mut self, frames: usize, offset: usize, input: &[Vec<f32>]) {
        self.signals(frames, offset, input, None);
        if !self.watcher.is_idle() {
            self.watch(frames);
        }
        self.sound(frames, offset);
    }

    /// Computes engine-wide signals, those of a knob after its own or another's.
    fn signals(&mut self, frames: usize, offset: usize, input: &[Vec<f32>], knob: Option<&Knob>) {
        let knob = knob.or(self.knob.as_deref());
        for (i, source) in self.sources.iter().enumerate() {
            match *source {
                Shared::Control(c) => {
                    self.controls[c as usize].fill(&mut self.work.shared[i], frames, self.clock)
                }
                Shared::Input(channel) => {
                    let signal = &mut self.work.shared[i];
                    match input.get(channel as usize).and_then(|c| c.get(offset..offset + frames)) {
                        Some(values) => {
                            signal.still = false;
                            for (row, value) in signal.rows.iter_mut().zip(values) {
                                let value = if value.is_finite() { *value } else { 0.0 };
                                *row = [R::of(f64::from(value)); LANES];
                            }
                        }
                        None => signal.hold(R::ZERO),
                    }
                }
                Shared::Knob(reading) => {
                    let signal = &mut self.work.shared[i];
                    match knob {
                        Some(knob) => {
                            signal.still = false;
                            for (frame, row) in signal.rows.iter_mut().take(frames).enumerate() {
                                let value = knob.reading(reading, self.clock + frame as u64);
                                *row = [R::of(value); LANES];
                            }
                        }
                        None => signal.hold(R::ZERO),
                    }
                }
                Shared::Node(_) => {}
            }
        }
        if let Some(shared) = &mut self.shared {
            shared.run(0, &mut self.work, frames);
            for (i, source) in self.sources.iter().enumerate() {
                let Shared::Node(output) = *source else { continue };
                let Workspace { buffers, shared: signals, .. } = &mut self.work;
                match shared.output(output as usize) {
                    Some(Feed::Buffer(b)) => {
                        let (from, to) = (&buffers[b as usize], &mut signals[i]);
                        let rows = if from.still { 1 } else { frames };
                        to.still = from.still;
                        for (row, value) in to.rows[..rows].iter_mut().zip(&from.rows) {
                            let value = if value[0].is_finite() { value[0] } else { R::ZERO };
                            *row = [value; LANES];
                        }
                    }
                    Some(Feed::Steady(s)) => signals[i].hold(shared.steady(0, s)[0]),
                    Some(Feed::Late(_)) | None => {}
                    Some(Feed::Shared(s)) => {
                        if let Ok([from, to]) = signals.get_disjoint_mut([s as usize, i]) {
                            to.still = from.still;
                            to.rows.copy_from_slice(&from.rows);
                        }
                    }
                }
            }
        }
    }

    /// Looks at the signals that are watched, as they are before what is no number in them becomes 0.
    fn watch(&mut self, frames: usize) {
        let Self { watcher, sources, shared, work, clock, counters, .. } = self;
        let dropped = watcher.look(*clock, frames, |signal| {
            let output = match (sources.get(signal)?, &*shared) {
                (Shared::Node(output), Some(shared)) => shared.output(*output as usize),
                _ => None,
            };
            let buffer = match output {
                Some(Feed::Buffer(b)) => work.buffers.get(b as usize)?,
                _ => work.shared.get(signal)?,
            };
            Some(|frame: usize| buffer.at(frame)[0].wide())
        });
        counters.dropped += dropped;
    }
}
