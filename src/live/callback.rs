//! What runs in the audio callback: takes what the other threads have sent, lets the engine play, and watches over what goes out.
//!
//! It knows no device, and reads a clock for nothing but to say what its work has cost. Everything that reaches it is stamped with engine
//! time or takes effect at the frame at which it is found, and it tells [`Report`]s of both, from which a session can be played again to the bit.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;

use ringbuf::traits::{Consumer, Observer, Producer, Split};
use ringbuf::{HeapCons, HeapProd, HeapRb};

use super::board::Board;
use super::called_off::CalledOff;
use super::gate::{Gate, Order};
use super::lever::Obeyed;
use super::relief::Relieved;
use super::steps::Steps;
use super::torque::Torque;
use crate::engine::Duty;
use crate::engine::event::{Event, Source};
use crate::engine::exchange::Stagehand;
use crate::engine::knob::followed::Followed;
use crate::engine::turnover::Turn;
use crate::engine::watch::Crossing;
use crate::knob::local_model::profile::Profile;
use crate::performer::outlet::FOR_PROGRAM;
use crate::schedule::Instant;

/// Sources of events, in the order in which they go at the same instant.
pub const SOURCES: [Source; 3] = [Source::Stop, Source::Pattern, Source::Program];

/// The rank of the meters, and seconds that they may take for a frame.
const METERS: u8 = u8::MAX;
const METERED: f64 = 1e-6;

/// The place of those of patterns.
const PATTERNS: usize = 1;

/// Events of a source that may be under way to the callback.
pub const UNDER_WAY: usize = 1 << 13;

/// Reports that may wait to be fetched, and of their room what is for [rare deeds](Deed::is_rare) alone.
const REPORTS: usize = 1 << 15;
const FOR_RARE: usize = 1 << 8;

/// An event on its way to the engine.
#[derive(Debug, Clone, Copy)]
pub struct Cue {
    /// How many plans had followed the first when it was made: voices, places and controls have the numbers of that plan.
    pub plan: u64,
    /// When it is due.
    pub at: Instant,
    /// What is.
    pub event: Event,
    /// The number of the signal that asked for it, or for its pattern; 0 for none.
    pub cause: u64,
}

/// What the callback tells of: that it did something, and before which frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Frames given out before.
    pub frame: u64,
    /// What it did.
    pub deed: Deed,
}

/// What a callback does besides computing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deed {
    /// It gave an event to the engine.
    Event {
        /// When it takes effect: when it was due, or with the next sample if that is past.
        at: Instant,
        /// When it was due.
        due: Instant,
        /// Where it came from.
        source: Source,
        /// What it is.
        event: Event,
        /// The number of the signal that asked for it, or for its pattern; 0 for none.
        cause: u64,
    },
    /// A signal of the engine set off a voice, by itself: nobody gave the engine an event.
    Crossing(Crossing),
    /// Something became of a voice without an event of its own.
    Turn(Turn),
    /// The knob took a world that a slow thread has sent.
    Followed(Followed),
    /// It told the gate something, for the signal of that number; 0 for none.
    Order(Order, u64),
    /// The device takes samples in other steps than before.
    Steps(Steps),
    /// It let a new plan take over.
    Swap,
}

impl Deed {
    /// Whether it is one of a few on which all others depend: no flood of those keeps it from being told.
    fn is_rare(&self) -> bool {
        matches!(self, Self::Order(..) | Self::Steps(_) | Self::Swap)
    }
}

/// The threads' ends of the rings.
pub struct Rings {
    /// By source, as [`SOURCES`] has them.
    pub cues: Vec<HeapProd<Cue>>,
    /// What the callback did.
    pub reports: HeapCons<Report>,
}

/// The audio thread's part of a session.
pub struct Callback {
    stagehand: Stagehand,
    cues: Vec<HeapCons<Cue>>,
    obeyed: Obeyed,
    reports: HeapProd<Report>,
    gate: Gate,
    board: Arc<Board>,
    record: Option<Record>,
    record_input: Option<Record>,
    channels: usize,
    /// Plans that have followed the first.
    plan: u64,
    /// Events that came too late for their plan.
    outdated: u64,
    /// Patterns of which events are on their way that are not to begin.
    called_off: CalledOff,
    /// Frames given out.
    frames: u64,
    /// Tasks above this rank rest.
    shed: u8,
    meters: Arc<Duty>,
    timing: Option<fn() -> u64>,
    /// Whether the device keeps to the time of a knob that is there.
    kept: bool,
    steps: Steps,
}

/// A recording.
struct Record {
    ring: HeapProd<f32>,
    /// Samples that found no room. They are silence in it as soon as there is, so that those behind them stay in their places.
    owed: usize,
}

impl Record {
    /// Keeps samples, and silence to make them `length`. Gives how many of those it had to leave out.
    fn keep(&mut self, samples: &[f32], length: usize) -> usize {
        let silence = self.owed.min(self.ring.vacant_len());
        self.owed -= self.ring.push_iter(std::iter::repeat_n(0.0, silence));
        if self.owed > 0 || self.ring.vacant_len() < length {
            self.owed += length;
            return length;
        }
        let kept = self.ring.push_slice(samples);
        self.ring.push_iter(std::iter::repeat_n(0.0, length - kept));
        0
    }
}

impl Callback {
    /// For an engine that has not played yet, behind a gate that is closed.
    pub fn new(mut stagehand: Stagehand, gate: Gate, board: Arc<Board>) -> (Self, Rings) {
        let channels = stagehand.engine().channels();
        let gate = gate.before(channels, stagehand.engine().stage());
        let (senders, cues) = SOURCES.iter().map(|_| HeapRb::new(UNDER_WAY).split()).unzip();
        let (reports, told) = HeapRb::new(REPORTS).split();
        let callback = Self {
            stagehand,
            cues,
            obeyed: Obeyed::default(),
            reports,
            gate,
            board,
            record: None,
            record_input: None,
            channels,
            plan: 0,
            outdated: 0,
            called_off: CalledOff::default(),
            frames: 0,
            shed: METERS,
            meters: Arc::new(Duty::new("meters", METERED, METERS)),
            timing: None,
            kept: true,
            steps: Steps::FLOAT,
        };
        (callback, Rings { cues: senders, reports: told })
    }

    /// Everything that goes out, goes into `ring` as well. Callbacks for which there is no room are silence there, and counted.
    pub fn record(&mut self, ring: HeapProd<f32>) {
        self.record = Some(Record { ring, owed: 0 });
    }

    /// What the engine hears goes into `ring` as well, frames of [`Callback::input_channels`], in the same way.
    pub fn record_input(&mut self, ring: HeapProd<f32>) {
        self.record_input = Some(Record { ring, owed: 0 });
    }

    /// Channels of an output frame.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Channels of an input frame.
    pub fn input_channels(&mut self) -> usize {
        self.stagehand.engine().input_channels()
    }

    /// Frames given out so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Fills `output`, interleaved frames, from `input`, what came in during the same frames. Neither allocates nor frees, locks,
    /// blocks or asks the system for anything.
    pub fn process(&mut self, input: &[f32], output: &mut [f32]) {
        self.obey();
        // What was meant for the plan that goes is with it before it goes, and is taken over with what waits there.
        self.take_cues();
        if self.stagehand.take_over() {
            self.gate.stands_before(self.stagehand.engine().stage());
            self.plan += 1;
            self.tell(Deed::Swap);
            self.take_cues();
        }
        self.stagehand.compute(input, output);
        self.tell_turnover();
        self.tell_crossings();
        if let Some(record) = &mut self.record_input {
            let channels = self.stagehand.engine().input_channels().max(1);
            let frames = output.len() / self.channels.max(1);
            // Where nothing came in, there was silence.
            let lost = record.keep(&input[..input.len().min(frames * channels)], frames * channels);
            self.board.input.unrecorded.add((lost / channels) as u64);
        }
        self.gate.pass(output, self.channels);
        self.frames += (output.len() / self.channels.max(1)) as u64;
        self.show(output);
        if let Some(record) = &mut self.record {
            let lost = record.keep(output, output.len());
            self.board.unrecorded.add((lost / self.channels.max(1)) as u64);
        }
    }

    /// Tells the gate what others want of it.
    fn obey(&mut self) {
        let mut obeyed = self.obeyed;
        for (order, cause) in self.board.lever.orders(&mut obeyed) {
            self.order_by(order, cause);
        }
        self.obeyed = obeyed;
    }

    /// Tells the gate something, before the next frame. One that has closed for good does not open again because a device is back.
    pub fn order(&mut self, order: Order) {
        self.order_by(order, 0);
    }

    fn order_by(&mut self, order: Order, cause: u64) {
        if order == Order::Return && self.obeyed.closes() {
            return;
        }
        self.gate.order(order);
        self.stagehand.engine().hold_motors(self.gate.holds());
        self.tell(Deed::Order(order, cause));
    }

    /// From the next frame on, what goes out is rounded to the steps of its device.
    pub fn round_to(&mut self, steps: Steps) {
        if std::mem::replace(&mut self.steps, steps) != steps {
            self.gate.round_to(steps);
            self.tell(Deed::Steps(steps));
        }
    }

    /// Times periodic work from now on, by a clock that gives nanoseconds. What is played does not depend on it.
    pub fn time(&mut self, clock: fn() -> u64) {
        self.timing = Some(clock);
        self.stagehand.engine().time_tasks(clock);
    }

    /// What is known of the periodic work that belongs to every session: motors, a knob's servo, and meters, which are the first to rest.
    pub fn duties(&mut self) -> [Arc<Duty>; 3] {
        let [motors, knob] = self.stagehand.engine().duties();
        [motors, knob, Arc::clone(&self.meters)]
    }

    /// Lets more of the engine's tasks rest, or fewer, from the next sample on; where there is nothing left to do, nothing happens.
    pub fn relieve(&mut self, how: Relieved) {
        let engine = self.stagehand.engine();
        // Those above `shed` rest.
        let shed = match how {
            // The meters are the first.
            Relieved::More if self.shed == METERS => Some(METERS - 1),
            Relieved::More => engine.rank_below(u16::from(self.shed) + 1).map(|rank| rank - 1),
            Relieved::Fewer if self.shed == METERS => None,
            Relieved::Fewer => {
                let mut above = |rank| engine.rank_above(rank).unwrap_or(METERS);
                let rank = above(self.shed);
                Some(if rank == METERS { METERS } else { above(rank) - 1 })
            }
        };
        let Some(shed) = shed.filter(|shed| *shed != self.shed) else { return };
        let at = Instant { sample: engine.clock(), fraction: 0 };
        let (source, event) = (Source::Program, Event::Shed(shed));
        if engine.schedule(at, source, event) {
            self.shed = shed;
            self.meters.rest(shed < METERS);
            self.board.shed.set(u64::from(u8::MAX - shed));
            self.tell(Deed::Event { at, due: at, source, event, cause: 0 });
        }
    }

    /// Input channels (from 0) that a knob's sensor is heard by.
    pub fn sensor(&mut self) -> Vec<usize> {
        let knob = self.stagehand.engine().knob();
        knob.and_then(|knob| knob.sensor()).map_or(Vec::new(), |sensor| sensor.channels.to_vec())
    }

    /// The torque that a knob which is there is to give now and near where it is, as far as the gate is open, and whether somebody wants it.
    pub fn torque(&mut self) -> (Profile, bool) {
        let opening = f64::from(self.gate.opening());
        let Some(knob) = self.stagehand.engine().knob().filter(|knob| knob.is_attached()) else {
            return (Profile::flat(0.0), false);
        };
        let wanted = opening > 0.0 && Torque::of(Some(knob)).is_wanted();
        (knob.servo().profile().scaled(opening), wanted)
    }

    /// Seconds that the device may take from the angle of a knob that is there to its torque, if one is read.
    pub fn allowance(&mut self) -> Option<f64> {
        let knob = self.stagehand.engine().knob()?;
        knob.is_attached().then(|| knob.allowance())
    }

    /// Tells the engine, from the next sample on, whether the device keeps to [`Callback::allowance`].
    pub fn deadline(&mut self, kept: bool) {
        if self.kept == kept {
            return;
        }
        let engine = self.stagehand.engine();
        let at = Instant { sample: engine.clock(), fraction: 0 };
        let (source, event) = (Source::Program, Event::Deadline(kept));
        if engine.schedule(at, source, event) {
            self.kept = kept;
            self.tell(Deed::Event { at, due: at, source, event, cause: 0 });
        }
    }

    /// Gives the engine what has come for its plan, as long as it has room, of which patterns leave some; the rest waits in its ring.
    fn take_cues(&mut self) {
        for (number, source) in SOURCES.into_iter().enumerate() {
            let left = if source == Source::Pattern { FOR_PROGRAM } else { 0 };
            while self.stagehand.engine().room() > left {
                let Some(&Cue { plan, at: due, event, cause }) = self.cues[number].try_peek() else { break };
                if plan > self.plan {
                    break;
                }
                self.cues[number].try_pop();
                match (source, event) {
                    (Source::Pattern, event) if self.called_off.take(due, &event) => continue,
                    // Those of its pattern that wait here were sent before it.
                    (_, Event::Cancel(id, bits)) => {
                        self.called_off.call((id, bits), due, self.cues[PATTERNS].occupied_len());
                    }
                    _ => {}
                }
                if plan < self.plan && !event.lets_go() {
                    // It found no room before its plan went; what its numbers name now is something else.
                    self.outdated += 1;
                    continue;
                }
                let clock = self.stagehand.engine().clock();
                let at = if due.ceiling() < clock { Instant::first_of(clock) } else { due };
                self.stagehand.engine().schedule(at, source, event);
                self.board.late.add(u64::from(at != due));
                self.tell(Deed::Event { at, due, source, event, cause });
            }
        }
    }

    /// Tells what signals have set off in the frames that were just computed, and which worlds the knob took.
    fn tell_crossings(&mut self) {
        let mut untold = 0;
        for crossing in self.stagehand.engine().crossings() {
            let report = Report { frame: self.frames, deed: Deed::Crossing(crossing) };
            untold += u64::from(!told(&mut self.reports, report));
        }
        let (reports, frame) = (&mut self.reports, self.frames);
        self.stagehand.engine().followed(|followed| {
            untold += u64::from(!told(reports, Report { frame, deed: Deed::Followed(followed) }));
        });
        untold += self.stagehand.engine().take_unkept();
        self.board.untold.add(untold);
    }

    /// Tells what became of voices. A replay does not need it, and a flood of it takes no room from what one does.
    fn tell_turnover(&mut self) {
        for turn in self.stagehand.engine().turnover() {
            if self.reports.vacant_len() > REPORTS / 2 {
                told(&mut self.reports, Report { frame: self.frames, deed: Deed::Turn(turn) });
            }
        }
    }

    fn tell(&mut self, deed: Deed) {
        let told = told(&mut self.reports, Report { frame: self.frames, deed });
        self.board.untold.add(u64::from(!told));
    }

    /// Lets the other threads see how things stand.
    fn show(&mut self, output: &[f32]) {
        let frames = (output.len() / self.channels.max(1)) as u64;
        match self.shed < METERS {
            true => self.meters.skip(frames),
            false => {
                let (board, channels) = (&self.board, self.channels);
                self.meters.timed(frames, self.timing, || board.meter(output, channels));
            }
        }
        let engine = self.stagehand.engine();
        self.board.voices.set(engine.sounding() as u64);
        self.board.clock.set(engine.clock());
        let (counters, counts) = (engine.counters(), engine.stage().counts());
        self.board.started.set(counters.started);
        self.board.stolen.set(counters.stolen);
        let unordered = engine.stage().drives().dropped();
        self.board.dropped.set(counters.dropped + self.outdated + unordered);
        self.board.masked.set(counters.masked + counts.masked);
        self.board.clamped.set(counts.clamped);
        self.board.limited.set(counts.limited);
        let stage = engine.stage();
        self.board.held_back.set(stage.protections().changed() + stage.drives().changed());
        self.board.knob.set(Torque::of(engine.knob()).figure());
        if let Some(knob) = engine.knob() {
            let given = knob.last();
            let [angle, speed, torque] = [given.angle, given.velocity, given.torque].map(f64::to_bits);
            let shown = [knob.servo().ticks(), angle, speed, torque];
            self.board.turned.iter().zip(shown).for_each(|(figure, value)| figure.set(value));
            let tally = knob.tally().numbers();
            self.board.tally.iter().zip(tally).for_each(|(figure, value)| figure.set(value));
        }
        self.board.frames.set(self.frames);
        self.board.shut.set(u64::from(self.gate.is_shut()));
    }
}

/// Tells something where there is room for it. Says whether there was.
fn told(reports: &mut HeapProd<Report>, report: Report) -> bool {
    let kept = if report.deed.is_rare() { 0 } else { FOR_RARE };
    reports.vacant_len() > kept && reports.try_push(report).is_ok()
}

#[cfg(test)]
mod tests;
