//! Taking over the voices of an instrument's old bank.

use super::Bank;
use crate::dsp::fade::{CROSS, FADE};
use crate::dsp::lanes::{LANES, Real};
use crate::engine::lane::{Lane, Status};
use crate::engine::lookup::always_id;
use crate::graph::places::Places;
use crate::node::kernel::LEAD;
use crate::schedule::Instant;
use crate::space::spot::Spot;

impl<R: Real> Bank<R> {
    /// Copies ahead what [`Bank::adopt`] would take long to copy of an old bank whose voices may cross, `left` bytes at most.
    pub fn copy_ahead(&mut self, old: &Self, ops: &[Option<usize>], left: &mut usize) {
        self.ops.copy_ahead(&old.ops, ops, &old.live, left);
    }

    /// Takes over, from the instrument of an old number as that of a new one, the voices of an old bank: its lanes, as far as there are as many, and the states of the ops that `ops` names. Ops
    /// without a counterpart begin now, before sample `clock`; voices that were let go of, and of which such an op is to say when they
    /// end, fade. The old bank is left empty, but for the copies of those voices that cross: `crosses` says which do, of those on these channels.
    pub fn adopt(
        &mut self,
        old: &mut Self,
        ops: &[Option<usize>],
        (places, old_places): (&mut Places, &mut Places),
        (from, number): (usize, usize),
        (spot, crosses): (impl Fn(Spot) -> Option<Spot>, Option<impl Fn(&[(u32, f64)]) -> bool>),
        clock: u64,
    ) {
        if crosses.is_none() && self.lanes.len() != old.lanes.len() {
            return;
        }
        self.crossed = clock;
        // A voice of its own that is always on has begun here already; that of the old bank goes on in its place, and as this would.
        let own = self.lanes.iter().find(|lane| lane.status != Status::Free).map(|lane| lane.play);
        (0..self.lanes.len()).for_each(|lane| self.free(lane));
        match &crosses {
            Some(_) => {
                self.ops.copy_states(&old.ops, ops, &old.live);
                self.copy_lanes(old);
            }
            None => {
                self.ops.take_states(&mut old.ops, ops);
                self.swap_lanes(old);
            }
        }
        (self.masked, self.stolen) = (old.masked, old.stolen);
        for lane in 0..self.lanes.len() {
            let mut voice = self.lanes[lane];
            if voice.status == Status::Free {
                continue;
            }
            if let Some(crosses) = &crosses {
                let strength = voice.play.strength();
                let was = crosses(old_places.felt(from, voice.play.place, strength));
                let is = |place| crosses(places.felt(number, place, strength));
                match was || spot(voice.play.place).is_none_or(is) {
                    // One that fades does so where it is.
                    true if matches!(voice.status, Status::Fading(..)) => {
                        self.free(lane);
                        continue;
                    }
                    true => {
                        old.let_fade(lane, Instant { sample: clock, fraction: 0 }, FADE / CROSS);
                        self.crossing[lane / LANES] |= 1 << (lane % LANES);
                    }
                    false => old.free(lane),
                }
            }
            // A place that is no more is silence.
            let mut place = spot(voice.play.place);
            if let Some(own) = own.filter(|_| voice.play.id == always_id(from)) {
                (voice.play, place) = (own, Some(own.place));
                self.lanes[lane].play = own;
            }
            if let Some(id) = self.ids.get_mut(lane) {
                *id = voice.play.id;
            }
            self.ops.set(lane, &voice.play.fields());
            self.ops.retune(lane, &old.ops, ops);
            self.lanes[lane].play.place = place.unwrap_or(Spot::Row(u32::MAX));
            let strength = voice.play.strength();
            let gain = self.place(lane, place.map_or(&[], |place| places.felt(number, place, strength)));
            if let Some(place) = place.filter(|place| self.journeys.take(*place)) {
                self.moving[lane / LANES] |= 1 << (lane % LANES);
                self.journeys.go_on(lane, place, gain);
            }
            let missing = ops.iter().enumerate().filter(|(_, from)| from.is_none());
            let mut anew = false;
            for (op, _) in missing {
                // As if the voice began here, so that what is new comes in gently.
                self.ops.start_late(op, lane, voice.play.id, voice.born.until(clock) - LEAD);
                anew |= self.ops.decides(op);
            }
            if anew && voice.status == Status::Released {
                self.let_fade(lane, Instant { sample: clock, fraction: 0 }, 1.0);
            }
        }
    }

    /// Changes lanes with a bank that has as many.
    fn swap_lanes(&mut self, old: &mut Self) {
        std::mem::swap(&mut self.lanes, &mut old.lanes);
        std::mem::swap(&mut self.live, &mut old.live);
        std::mem::swap(&mut self.taken, &mut old.taken);
        std::mem::swap(&mut self.rising, &mut old.rising);
        std::mem::swap(&mut self.fading, &mut old.fading);
        std::mem::swap(&mut self.ending, &mut old.ending);
        std::mem::swap(&mut self.peaks, &mut old.peaks);
        self.journeys.swap(&mut old.journeys);
        std::mem::swap(&mut self.sounding, &mut old.sounding);
    }

    /// Takes on what another bank has on its lanes; of those that there are only there, nothing.
    fn copy_lanes(&mut self, from: &Self) {
        fn copy<T: Copy>(to: &mut [T], from: &[T]) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        }
        copy(&mut self.lanes, &from.lanes);
        copy(&mut self.live, &from.live);
        copy(&mut self.rising, &from.rising);
        copy(&mut self.fading, &from.fading);
        copy(&mut self.ending, &from.ending);
        copy(&mut self.peaks, &from.peaks);
        self.journeys.copy(&from.journeys);
        self.taken = self.live.iter().map(|live| live.count_ones() as usize).sum();
        let sounds = |lane: &&Lane| matches!(lane.status, Status::Held | Status::Released);
        self.sounding = self.lanes.iter().filter(sounds).count();
    }
}
