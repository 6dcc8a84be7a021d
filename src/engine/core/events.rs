//! Events, ends of voices and what signals set off, in order of time.

use super::Core;
use crate::dsp::lanes::Real;
use crate::engine::bank::Stolen;
use crate::engine::event::{Event, Play, is_of};
use crate::engine::knob::Order;
use crate::engine::turnover::Turned;
use crate::engine::watch::SetOff;
use crate::schedule::Instant;

impl<R: Real> Core<R> {
    /// Events, ends of voices and what signals set off that are due before the next sample, in order of time; where they fall together,
    /// ends come first and what signals set off last.
    pub(super) fn run_events(&mut self) {
        loop {
            let (event, start) = (self.queue.first(), self.watcher.next());
            let end = self.ends.next().filter(|end| end.ceiling() <= self.clock);
            if let Some(end) = end
                && event.is_none_or(|event| end <= event)
                && start.is_none_or(|start| end <= start)
            {
                self.end_next();
            } else if let Some(start) = start
                && start.ceiling() <= self.clock
                && event.is_none_or(|event| start < event)
            {
                self.cross();
            } else if let Some(entry) = self.queue.pop_due(self.clock) {
                self.handle(entry.at, entry.what);
            } else {
                return;
            }
        }
    }

    /// Starts the voice that a signal has set off next; a pattern is told of.
    fn cross(&mut self) {
        match self.watcher.begin(self.clock) {
            Some((at, Some(SetOff::Voice(play)))) => self.play(&play, at),
            Some((_, Some(SetOff::Pattern(_)))) => {}
            Some((_, None)) => self.counters.dropped += 1,
            None => {}
        }
    }

    /// Releases the voice that has sounded its time next, if it is still there.
    fn end_next(&mut self) {
        let Some((slot, at, serial)) = self.ends.pop() else { return };
        let number = self.first.partition_point(|first| *first <= slot).saturating_sub(1);
        if let (Some(bank), Some(first)) = (self.banks.get_mut(number), self.first.get(number)) {
            bank.end(slot - first, serial, at);
            self.commander.release(number, serial, at, &mut self.stage);
        }
    }

    fn handle(&mut self, at: Instant, event: Event) {
        match event {
            Event::Play(play) => self.play(&play, at),
            Event::Release(id) => self.release(|voice| voice == id, at),
            Event::ReleaseAll => self.release(|_| true, at),
            Event::Silence(id, bits) => self.silence(id, bits, at),
            Event::Touch(to) => self.banks.iter_mut().for_each(|bank| bank.touch(to, at)),
            Event::Glide(index, value, seconds) => {
                if let Some(ramp) = self.controls.get_mut(index as usize) {
                    ramp.glide(value, seconds * self.rate, at);
                }
            }
            Event::Control(index, value) => {
                if let Some(ramp) = self.controls.get_mut(index as usize) {
                    ramp.send(value, at);
                }
            }
            Event::Cancel(id, bits) => self.cancel(id, bits, at),
            Event::Marker(name, _) => self.stage.mark(name, at),
            Event::Shed(above) => self.tasks.shed(above),
            Event::Push(torque) => self.tell_knob(Order::Push(torque)),
            Event::Deadline(kept) => self.tell_knob(Order::Deadline(kept)),
            Event::Arm(arms) => self.tell_knob(if arms { Order::Rise } else { Order::Fall }),
        }
    }

    fn tell_knob(&mut self, order: Order) {
        self.knob.iter_mut().for_each(|knob| knob.tell(self.clock, order));
    }

    pub(super) fn play(&mut self, play: &Play, at: Instant) {
        let place = self.places.felt(play.instrument as usize, play.place, play.strength());
        let Some(bank) = self.banks.get_mut(play.instrument as usize) else { return };
        self.stage.open(self.clock);
        self.knob.iter_mut().for_each(|knob| knob.tell(self.clock, Order::Open));
        self.counters.started += 1;
        let serial = self.counters.started;
        let (lane, stolen) = bank.start(play, at, self.clock, place, serial);
        let Some(first) = self.first.get(play.instrument as usize) else { return };
        if let Some(Stolen { lane, serial, id }) = stolen {
            self.ends.clear(first + lane);
            self.commander.release(play.instrument as usize, serial, at, &mut self.stage);
            self.turnover.note(at, Turned::Stolen(id, play.id));
        }
        if self.commander.gives(play.instrument) {
            self.commander.begin(play, serial, place, at, &mut self.stage);
        }
        // Who was here before has died away, but its time is not over.
        if let Some((end, _)) = self.ends.clear(first + lane) {
            self.outlasted = self.outlasted.max(Some(end));
        }
        if play.duration.is_finite() {
            self.ends.set(first + lane, at + play.duration.max(0.0) * self.rate, serial);
        }
    }

    fn release(&mut self, which: impl Fn(u64) -> bool, at: Instant) {
        let Self { banks, first, ends, commander, stage, .. } = self;
        for (number, (bank, first)) in banks.iter_mut().zip(first).enumerate() {
            bank.release(&which, at, |lane, serial| {
                ends.clear(*first + lane);
                commander.release(number, serial, at, stage);
            });
        }
    }

    /// What waits lies at this instant or behind it.
    fn cancel(&mut self, id: u64, bits: u8, at: Instant) {
        self.queue.edit(|event| !event.begins_of(id, bits));
        self.release(|voice| is_of(voice, id, bits), at);
    }

    fn silence(&mut self, id: u64, bits: u8, at: Instant) {
        let Self { banks, first, ends, commander, stage, .. } = self;
        for (number, (bank, first)) in banks.iter_mut().zip(first).enumerate() {
            bank.silence(
                |play| play.is_of(id, bits),
                at,
                |lane, serial| {
                    ends.clear(*first + lane);
                    commander.release(number, serial, at, stage);
                },
            );
        }
        // What an old engine still sounds of it; where it is told of several at once, of all.
        self.silenced = Some(self.silenced.map_or((id, bits, at), |(.., since)| (0, 64, since)));
        self.queue.edit(|event| !matches!(event, Event::Play(play) if play.is_of(id, bits)));
        if self.banks.iter().all(|bank| bank.only_sounds(|play| play.is_of(id, bits))) {
            self.stage.shut(self.clock);
            self.tell_knob(Order::Fall);
        }
    }
}
