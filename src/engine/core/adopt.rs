//! Taking over from the engine of another plan.

use super::Core;
use crate::dsp::lanes::Real;
use crate::engine::event::Event;
use crate::engine::handover::Inheritance;
use crate::schedule::Instant;

/// Of the engine-wide signals, which all lanes have alike.
const FIRST_LANE: &[u8] = &[1];

impl<R: Real> Core<R> {
    /// Copies ahead, `left` bytes at most, what [`Core::adopt`] would take long to copy; nothing is left where that is not all yet.
    pub fn copy_ahead(&mut self, old: &Self, inheritance: &Inheritance, left: &mut usize) {
        if let (Some(new), Some(old)) = (&mut self.shared, &old.shared) {
            new.copy_ahead(old, &inheritance.shared, FIRST_LANE, left);
        }
        for (number, (bank, from)) in self.banks.iter_mut().zip(&inheritance.instruments).enumerate() {
            if let Some((from, ops)) = from
                && inheritance.may_cross(number)
                && let Some(old) = old.banks.get(*from)
            {
                bank.copy_ahead(old, ops, left);
            }
        }
    }

    /// Takes the place of `old`: what `inheritance` names goes on here, and the rest fades out there.
    pub fn adopt(&mut self, old: &mut Self, inheritance: &Inheritance) {
        self.clock = old.clock;
        self.counters = old.counters;
        self.commander.forget();
        match self.stage.is_succeeding() {
            true => self.stage.take_over(&mut old.stage, self.clock),
            false => {
                std::mem::swap(&mut self.stage, &mut old.stage);
                if inheritance.swells {
                    self.stage.trade_swells(&mut old.stage);
                }
            }
        }
        if let Some(levels) = &inheritance.levels {
            self.stage.limit_to(levels);
        }
        std::mem::swap(&mut self.tasks, &mut old.tasks);
        std::mem::swap(&mut self.standing, &mut old.standing);
        for (ramp, from) in self.controls.iter_mut().zip(&inheritance.controls) {
            if let Some(from) = from.and_then(|i| old.controls.get(i)) {
                ramp.follow(from);
            }
        }
        if let (Some(new), Some(old)) = (&mut self.knob, &mut old.knob) {
            new.adopt(old);
        }
        if let (Some(new), Some(old)) = (&mut self.shared, &mut old.shared) {
            new.copy_states(old, &inheritance.shared, FIRST_LANE);
            new.retune(0, old, &inheritance.shared);
        }
        let now = Instant { sample: self.clock, fraction: 0 };
        for (number, ((bank, first), from)) in
            self.banks.iter_mut().zip(&self.first).zip(&inheritance.instruments).enumerate()
        {
            let from = from
                .as_ref()
                .and_then(|(from, ops)| Some((*from, old.banks.get_mut(*from)?, ops, old.first.get(*from)?)));
            match from {
                Some((from, bank_of_old, ops, first_of_old)) => {
                    let spot = |old| inheritance.spot(old);
                    let changed = inheritance.is_changed(number);
                    let jumps = |channel: &(u32, f64)| {
                        inheritance.jumps.get(channel.0 as usize).copied().unwrap_or(true)
                    };
                    let crosses = |place: &[(u32, f64)]| changed || place.iter().any(jumps);
                    let places = (&mut self.places, &mut old.places);
                    let crosses = inheritance.may_cross(number).then_some(crosses);
                    bank.adopt(bank_of_old, ops, places, (from, number), (spot, crosses), self.clock);
                    for lane in 0..bank.lanes().min(bank_of_old.lanes()) {
                        if let Some((at, serial)) = old.ends.get(first_of_old + lane) {
                            self.ends.set(first + lane, at, serial);
                        }
                    }
                }
                None => bank.begin_at(now),
            }
        }
        let begins = |number| inheritance.instruments.get(number as usize).is_some_and(Option::is_none);
        self.turnover.begin_at(now, begins);
        (self.outlasted, self.settled) = (old.outlasted, old.settled);
        let (from, same) = (&inheritance.watches, inheritance.same_signals);
        self.counters.dropped += self.watcher.adopt(&mut old.watcher, from, same, self.clock);
        std::mem::swap(&mut self.queue, &mut old.queue);
        let instrument = |old: u32| {
            let of_old = |i: &Option<(usize, _)>| i.as_ref().is_some_and(|(from, _)| *from == old as usize);
            inheritance.instruments.iter().position(of_old).map(|new| new as u32)
        };
        let control =
            |old: u32| inheritance.controls.iter().position(|c| *c == Some(old as usize)).map(|c| c as u32);
        let counters = &mut self.counters;
        self.queue.edit(|event| {
            let kept = match event {
                Event::Play(play) => instrument(play.instrument)
                    .zip(inheritance.spot(play.place))
                    .map(|(instrument, place)| (play.instrument, play.place) = (instrument, place)),
                Event::Control(of, _) | Event::Glide(of, ..) => control(*of).map(|c| *of = c),
                Event::Release(_)
                | Event::ReleaseAll
                | Event::Silence(..)
                | Event::Cancel(..)
                | Event::Touch(..)
                | Event::Marker(..)
                | Event::Push(_)
                | Event::Arm(_)
                | Event::Deadline(_)
                | Event::Shed(_) => Some(()),
            };
            counters.dropped += u64::from(kept.is_none() && matches!(event, Event::Play(_)));
            kept.is_some()
        });
        old.banks.iter_mut().for_each(|bank| bank.fade_all(now));
    }
}
