//! A knob at work: its servo on the engine's clock, what nodes read of it, and what it sets off.
//!
//! The servo runs ahead of the graph by the stretch of samples that is computed next, so that nodes read its angle without delay and what it
//! sets off begins at its tick. What the patch sends the other way is [`CELL`] engine samples late, whatever the stretches are.

pub mod followed;
mod orders;
pub mod tally;

use super::event::{Event, Source};
use super::watch::{Crossing, SetOff, Watcher};
use super::workspace::{BLOCK, Workspace};
use crate::actuator::thermal::Thermal;
use crate::dsp::lanes::{LANES, Real};
use crate::graph::knob;
use crate::graph::knob::{CELL, Feed, Start};
use crate::graph::plan::{Plan, Shared};
use crate::knob::angle::decoder::Sensor;
use crate::knob::effect::events::What;
use crate::knob::local_model::link::{Fast, Seen};
use crate::knob::plant::parts::Hand;
use crate::knob::servo::setup::Unfit;
use crate::knob::servo::simulated::Simulated;
use crate::knob::servo::tick::{Given, Servo};
use crate::patch::Happening;
use crate::patch::knob::Reading;
use crate::schedule::{Instant, Queue};
use followed::{Followed, Worlds};
pub(super) use orders::Order;
use orders::Orders;
use tally::{Moment, Tally};

const CELLS: usize = CELL as usize;

/// Readings on their way to their ticks.
#[derive(Debug)]
struct Readings {
    ring: Vec<Option<f64>>,
    first: usize,
    count: usize,
}

impl Readings {
    /// For so many ticks an engine sample. An engine sample is computed when its first frame is heard: the first ticks have no reading yet.
    fn new(ticks: usize) -> Self {
        Self { ring: vec![None; (BLOCK + 2) * ticks], first: 0, count: ticks - 1 }
    }

    fn put(&mut self, reading: Option<f64>) {
        // Never more than a block and what of the next is heard already.
        if self.count < self.ring.len() {
            let at = (self.first + self.count) % self.ring.len();
            self.ring[at] = reading;
            self.count += 1;
        }
    }

    fn take(&mut self) -> Option<f64> {
        let reading = self.ring[self.first];
        if self.count == 0 {
            return None;
        }
        self.first = (self.first + 1) % self.ring.len();
        self.count -= 1;
        reading
    }
}

/// A knob at work.
#[derive(Debug)]
pub struct Knob {
    plan: knob::Knob,
    servo: Servo,
    simulated: Option<Simulated>,
    /// The sample before which it has run.
    ran: u64,
    rate: f64,
    ratio: usize,
    /// What nodes read, by reading and by sample of a cell.
    read: [[f64; CELLS]; Reading::ALL.len()],
    /// Torques of the ticks of a cell, as samples of the device.
    torques: Vec<f32>,
    /// What leaves, of the samples of a block.
    leaving: Vec<f32>,
    most: f32,
    /// What scales effects: where it comes from, and its values a cell ago.
    feeds: Vec<Feed>,
    past: Vec<[f64; CELLS]>,
    /// By effect: where its gain, its shift and its signal are among the feeds.
    wires: Vec<[usize; 3]>,
    /// Where the hand is among the feeds, and where it was at the last sample.
    hand: Option<usize>,
    held_at: f64,
    /// Torque of a hand that pushes, N m.
    push: f64,
    /// What it was told in this cell.
    orders: Orders,
    /// What was read of a knob that is there, for the ticks to come.
    readings: Readings,
    /// Whether torque is to rise with the next reading, and whether a card brings and takes in time.
    asked: bool,
    in_time: bool,
    /// What was set off so far, by what did so.
    numbers: Vec<u64>,
    first_watch: usize,
    /// Engine samples from what sets off a pattern to its beginning.
    answer: u64,
    dropped: u64,
    worlds: Worlds,
    tally: Tally,
}

impl Knob {
    /// That of a plan, if it has one.
    ///
    /// # Errors
    /// What of it cannot be.
    pub fn new(plan: &Plan) -> Result<Option<Self>, Unfit> {
        let Some(of) = &plan.knob else { return Ok(None) };
        let mut servo = Servo::new(&of.setup)?;
        let mut simulated =
            of.model.as_ref().map(|model| Simulated::new(model, of.setup.period())).transpose()?;
        let (mut feeds, mut past, mut wires) = (Vec::new(), Vec::new(), Vec::new());
        let mut feed = |from: Feed, first: f64| {
            let found = feeds.iter().position(|other| *other == from);
            found.unwrap_or_else(|| {
                feeds.push(from);
                past.push([if let Feed::Constant(x) = from { x } else { first }; CELLS]);
                feeds.len() - 1
            })
        };
        for scales in &of.scales {
            wires.push([feed(scales.gain, 0.0), feed(scales.shift, 0.0), feed(scales.signal, 0.0)]);
        }
        let control = of.hand.and_then(|signal| match plan.shared.get(signal as usize)? {
            Shared::Control(control) => plan.controls.get(*control as usize),
            _ => None,
        });
        let held_at = control.map_or(0.0, |control| control.default);
        let hand = of.hand.filter(|_| simulated.is_some()).map(|signal| feed(Feed::Signal(signal), held_at));
        if let Some(simulated) = &mut simulated {
            simulated.place(held_at)?;
        }
        if of.armed && simulated.is_some() {
            servo.arm();
        }
        let ticks = of.ticks.max(1) as usize;
        let level = of.channel.and_then(|channel| plan.max_levels().get(channel as usize).copied());
        Ok(Some(Self {
            servo,
            simulated,
            ran: 0,
            rate: plan.engine_rate(),
            ratio: plan.ratio,
            read: [[0.0; CELLS]; Reading::ALL.len()],
            torques: vec![0.0; CELLS * ticks],
            leaving: vec![0.0; BLOCK * plan.ratio],
            most: level.map_or(1.0, super::vibration::single),
            feeds,
            past,
            wires,
            hand,
            held_at,
            push: 0.0,
            orders: Orders::default(),
            readings: Readings::new(ticks),
            asked: of.armed && of.sensor.is_some(),
            in_time: true,
            numbers: vec![0; of.starts.len()],
            first_watch: plan.watches.len(),
            answer: plan.answer,
            dropped: 0,
            worlds: Worlds::default(),
            tally: Tally::default(),
            plan: of.clone(),
        }))
    }

    /// The servo.
    pub fn servo(&self) -> &Servo {
        &self.servo
    }

    /// The knob that is not there.
    pub fn simulated(&self) -> Option<&Simulated> {
        self.simulated.as_ref()
    }

    /// What it did so far.
    pub fn tally(&self) -> Tally {
        let (chain, mut tally) = (self.servo.chain(), self.tally);
        (tally.stages, tally.trip) = (*chain.counts(), chain.trip());
        tally
    }

    /// The effects' names.
    pub fn names(&self) -> &[std::sync::Arc<str>] {
        &self.plan.names
    }

    /// What the last tick gave.
    pub fn last(&self) -> &Given {
        self.servo.last()
    }

    /// A slow thread sends worlds from here on, and sees the knob.
    pub(super) fn listen(&mut self, link: Fast) {
        self.worlds.listen(link);
    }

    /// Takes a world once more that was taken in a run that is repeated.
    pub(super) fn follow_again(&mut self, followed: Followed) {
        self.worlds.follow_again(followed);
    }

    /// Worlds that were taken since this was asked last.
    pub(super) fn followed(&mut self) -> std::vec::Drain<'_, Followed> {
        self.worlds.taken()
    }

    /// How many worlds that were taken since this was asked last were not kept.
    pub(super) fn take_unkept(&mut self) -> u64 {
        self.worlds.take_unkept()
    }

    /// The angle of a knob that is there, for the next tick that has none yet.
    pub(super) fn read(&mut self, angle: Option<f64>) {
        self.readings.put(angle);
    }

    /// What reads a knob that is there.
    pub fn sensor(&self) -> Option<&Sensor> {
        self.plan.sensor.as_ref()
    }

    /// Whether a knob that is there is read.
    pub fn is_attached(&self) -> bool {
        self.plan.sensor.is_some()
    }

    /// Whether torque rises with the next reading.
    pub fn is_asked(&self) -> bool {
        self.asked
    }

    /// Seconds that a card may take from the angle to its torque.
    pub fn allowance(&self) -> f64 {
        self.plan.allowance
    }

    /// Tells it something at `clock`, before the sample that is computed next. It holds from there on at the beginning of a cell, and from the next
    /// cell on in the middle of one.
    pub(super) fn tell(&mut self, clock: u64, order: Order) {
        if clock == self.ran && clock.is_multiple_of(CELL) {
            self.obey_due(clock);
            self.obey(order);
        } else {
            self.orders.add(Self::until(clock), order);
        }
    }

    /// Does what it was told that holds from this sample on.
    fn obey_due(&mut self, sample: u64) {
        for order in self.orders.take(sample).into_iter().flatten() {
            self.obey(order);
        }
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Push(torque) => self.push = if torque.is_finite() { torque } else { 0.0 },
            Order::Deadline(kept) => self.in_time = kept,
            Order::Rise => {
                self.servo.acknowledge();
                self.rise();
            }
            Order::Fall => {
                self.asked = false;
                self.servo.disarm();
            }
            Order::Open if self.plan.armed && !self.servo.chain().armed() => self.rise(),
            Order::Open => {}
        }
    }

    fn rise(&mut self) {
        self.asked = self.is_attached();
        if !self.asked {
            self.servo.arm();
        }
    }

    /// Goes on where the knob of another plan is: a simulated one stays where it is turned to, and the same effects go on.
    pub(super) fn adopt(&mut self, old: &mut Self) {
        self.ran = old.ran;
        (self.push, self.orders) = (old.push, old.orders);
        std::mem::swap(&mut self.readings, &mut old.readings);
        (self.asked, self.in_time) = (old.asked, old.in_time);
        self.worlds.adopt(&mut old.worlds);
        self.held_at = old.held_at;
        self.read = old.read;
        self.tally = old.tally;
        // So that no id comes again.
        let number = old.numbers.iter().copied().max().unwrap_or(0);
        self.numbers.fill(number);
        // Before anything changes places.
        let hand = old.hand.and_then(|from| old.past.get(from)).copied();
        if self.plan.model == old.plan.model {
            std::mem::swap(&mut self.simulated, &mut old.simulated);
        }
        if self.plan.setup == old.plan.setup {
            std::mem::swap(&mut self.servo, &mut old.servo);
            std::mem::swap(&mut self.torques, &mut old.torques);
            if self.feeds.len() == old.feeds.len() {
                std::mem::swap(&mut self.past, &mut old.past);
            }
        } else {
            self.servo.continue_from(&old.servo);
            if !old.servo.chain().armed() {
                self.servo.disarm();
            }
        }
        if let (Some(at), Some(values)) = (self.hand, hand)
            && let Some(past) = self.past.get_mut(at)
        {
            *past = values;
        }
    }

    /// The last sample before which it may run, from `clock` on.
    pub(super) fn until(clock: u64) -> u64 {
        (clock / CELL + 1) * CELL
    }

    /// How many samples it has to run up to sample `until`: none where it was there before, and what was computed broke off at an event.
    pub(super) fn ahead(&self, until: u64) -> u64 {
        until.saturating_sub(self.ran)
    }

    /// Runs up to sample `until`, and puts what it sets off into a queue.
    pub(super) fn run(&mut self, until: u64, queue: &mut Queue<Event>, watcher: &mut Watcher) {
        while self.ran < until {
            let sample = self.ran;
            self.obey_due(sample);
            self.ran += 1;
            self.sample(sample, queue, watcher);
        }
    }

    fn sample(&mut self, sample: u64, queue: &mut Queue<Event>, watcher: &mut Watcher) {
        let at = (sample % CELL) as usize;
        let value = |past: &[[f64; CELLS]], feed: usize| past.get(feed).map_or(0.0, |values| values[at]);
        for (control, wires) in self.servo.controls().zip(&self.wires) {
            control.gain = value(&self.past, wires[0]);
            control.shift = value(&self.past, wires[1]);
            control.fed = value(&self.past, wires[2]);
        }
        if let Some(message) = self.worlds.take(sample) {
            self.servo.follow(&message);
        }
        let target = self.hand.map_or(self.held_at, |hand| value(&self.past, hand));
        let speed = (target - self.held_at) * self.rate;
        let ticks = self.plan.ticks.max(1);
        let (mut passed, mut hit, mut given) = (0.0, 0.0_f64, 0.0);
        for tick in 0..ticks {
            let share = f64::from(tick) / f64::from(ticks);
            let hand = Hand {
                torque: self.push,
                target: self.held_at + (target - self.held_at) * share,
                target_speed: speed,
            };
            let torque = match &mut self.simulated {
                Some(knob) => knob.tick(&mut self.servo, &hand),
                None => self.felt(),
            };
            given = torque;
            for event in self.servo.events().list() {
                match event.what {
                    What::Detent { passed: notches, .. } => passed += notches as f64,
                    What::Wall { speed, .. } => hit = hit.max(speed),
                }
            }
            if !self.servo.events().list().is_empty() {
                let fraction = (u64::from(tick) << 32) / u64::from(ticks);
                self.happened(Instant { sample, fraction: fraction as u32 }, queue, watcher);
            }
            let torque = self.plan.per_newton_metre.map_or(0.0, |per| torque * per);
            if let Some(slot) = self.torques.get_mut(at * ticks as usize + tick as usize) {
                *slot = (torque as f32).clamp(-self.most, self.most);
            }
        }
        self.held_at = target;
        let (Given { angle, velocity, .. }, torque) = (*self.servo.last(), given);
        let turns = self.simulated.as_ref().map(|knob| (knob.plant(), knob.thermal()));
        let (held, speed) =
            turns.map_or((angle, velocity), |(plant, _)| (plant.knob_angle(), plant.knob_speed()));
        let warm = turns.and_then(|(_, thermal)| thermal).map(Thermal::winding);
        let absorbed = self.servo.energy().absorbed();
        self.tally.add(&Moment { angle: held, speed, estimated: velocity, torque, absorbed, warm });
        self.worlds.put(&Seen { tick: self.servo.ticks(), angle, velocity, torque });
        for (read, value) in self.read.iter_mut().zip([angle, velocity, torque, passed, hit]) {
            read[at] = if value.is_finite() { value } else { 0.0 };
        }
    }

    /// A tick of a knob that is there.
    fn felt(&mut self) -> f64 {
        let angle = self.readings.take();
        let torque = self.servo.tick(angle, self.in_time);
        if self.asked && angle.is_some() && self.in_time {
            self.asked = false;
            self.servo.arm();
        }
        torque
    }

    /// Sets off what waits for what happened in the last tick.
    #[cold]
    fn happened(&mut self, at: Instant, queue: &mut Queue<Event>, watcher: &mut Watcher) {
        let Given { angle, velocity, .. } = *self.servo.last();
        for event in self.servo.events().list() {
            let (what, values) = match event.what {
                What::Detent { index, passed } => {
                    let way = if passed < 0 { -1.0 } else { 1.0 };
                    (Happening::Detent, [angle, velocity.abs(), way, index as f64])
                }
                What::Wall { speed, side } => (Happening::Wall, [angle, speed, f64::from(side), 0.0]),
            };
            let waits = |start: &Start| {
                start.what == what && start.effect.is_none_or(|effect| effect as usize == event.effect)
            };
            for (place, start) in self.plan.starts.iter().enumerate().filter(|(_, start)| waits(start)) {
                let Some(number) = self.numbers.get_mut(place) else { continue };
                let watch = (self.first_watch + place) as u32;
                let crossing = Crossing::new(at, (watch, *number), &start.answer(&values), self.answer);
                *number += 1;
                let fits = match crossing.what {
                    SetOff::Voice(play) => queue.push(at, Source::Knob as u16, Event::Play(play)).is_ok(),
                    SetOff::Pattern(_) => true,
                };
                match fits {
                    true => watcher.keep(crossing),
                    false => self.dropped += 1,
                }
            }
        }
    }

    /// Voices that found no room, since this was asked last.
    pub(super) fn take_dropped(&mut self) -> u64 {
        std::mem::take(&mut self.dropped)
    }

    /// The value of a reading at a sample that it has run.
    pub(super) fn reading(&self, reading: Reading, sample: u64) -> f64 {
        self.read[reading as usize][(sample % CELL) as usize]
    }

    /// Notes what the patch sends, of `frames` samples from `clock` on that lie from `offset` on in the block; and what leaves meanwhile.
    pub(super) fn note<R: Real>(
        &mut self,
        work: &mut Workspace<R>,
        frames: usize,
        offset: usize,
        clock: u64,
    ) {
        for (feed, past) in self.feeds.iter().zip(&mut self.past) {
            match *feed {
                Feed::Constant(_) => {}
                Feed::Signal(signal) => {
                    let Some(signal) = work.shared.get(signal as usize) else { continue };
                    for frame in 0..frames {
                        past[((clock + frame as u64) % CELL) as usize] = signal.at(frame)[0].wide();
                    }
                }
                Feed::Voices => {
                    let Some(channel) = self.plan.channel else { continue };
                    let (group, lane) = (channel as usize / LANES, channel as usize % LANES);
                    let fed = work.fed.get(group) == Some(&true);
                    let first = group * work.stride + offset;
                    for frame in 0..frames {
                        let row = work.mix.get(first + frame).filter(|_| fed);
                        past[((clock + frame as u64) % CELL) as usize] =
                            row.map_or(0.0, |row| row[lane].wide());
                    }
                }
            }
        }
        if let Some(channel) = self.plan.channel {
            // What is played there is for the effects, and vibrates nothing.
            let (group, lane) = (channel as usize / LANES, channel as usize % LANES);
            let first = group * work.stride + offset;
            if work.fed.get(group) == Some(&true) {
                work.mix.iter_mut().skip(first).take(frames).for_each(|row| row[lane] = R::ZERO);
            }
        }
        if self.plan.per_newton_metre.is_none() {
            return;
        }
        let ticks = self.plan.ticks.max(1) as usize;
        for frame in 0..frames {
            let at = ((clock + frame as u64) % CELL) as usize * ticks;
            let leaving = self.leaving.iter_mut().skip((offset + frame) * self.ratio).take(self.ratio);
            for (n, slot) in leaving.enumerate() {
                *slot = self.torques.get(at + n * ticks / self.ratio).copied().unwrap_or(0.0);
            }
        }
    }

    /// Writes the frames of the `samples` samples of the block; those of the last one lie in `rest` where `frames` has no room.
    pub(super) fn write(&self, samples: usize, channels: usize, frames: &mut [f32], rest: &mut [f32]) {
        let (Some(channel), Some(_)) = (self.plan.channel, self.plan.per_newton_metre) else { return };
        let whole = frames.len() / (self.ratio * channels).max(1) * self.ratio;
        let before = frames.chunks_exact_mut(channels.max(1)).take(whole);
        let frames = before.chain(rest.chunks_exact_mut(channels.max(1)));
        for (frame, torque) in frames.zip(&self.leaving[..(samples * self.ratio).min(self.leaving.len())]) {
            if let Some(slot) = frame.get_mut(channel as usize) {
                *slot = *torque;
            }
        }
    }
}
