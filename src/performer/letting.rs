//! What lets go of voices. Where the outlet has no room for it, it waits, and goes out before anything else: to lose one would leave
//! something sounding.

use super::{Happening, Outlet, Performer, When, Whence};
use crate::engine::event::{Event, Source};
use crate::midi::Channel;

impl Performer {
    /// Releases what was played under an id.
    pub fn release(&mut self, at: When, id: u64, outlet: &mut dyn Outlet) {
        // A reference hears of it as the end of what was played.
        let held = self.record.iter_mut().flatten().rev().find(|(_, play)| play.id == id);
        if let Some((start, play)) = held.filter(|(_, play)| play.duration == f64::INFINITY) {
            play.duration = (at.seconds - *start).max(0.0);
        }
        self.let_go(at, Event::Release(id), outlet);
    }

    /// Releases every voice that sounds then, held and always-on ones too, which [`Performer::wake`] brings back. The patterns go on, so
    /// what they play later sounds.
    pub fn release_all(&mut self, at: When, outlet: &mut dyn Outlet) {
        let always = self.plan.instruments.iter().filter(|instrument| instrument.always);
        self.asleep.extend(always.map(|instrument| instrument.name.to_string()));
        self.let_go(at, Event::ReleaseAll, outlet);
    }

    /// Lets the knob's torque rise, after a fault as well, or lets it go. Says whether there was room; to let go waits for it.
    pub fn torque(&mut self, at: When, rises: bool, outlet: &mut dyn Outlet) -> bool {
        if rises {
            return outlet.send(at.instant, Source::Program, Event::Arm(true));
        }
        self.let_go(at, Event::Arm(false), outlet);
        true
    }

    /// Lets all that a port of MIDI has started, or one of its channels, fall silent at once.
    pub(super) fn silence(
        &mut self,
        at: When,
        port: usize,
        channel: Option<Channel>,
        outlet: &mut dyn Outlet,
    ) {
        self.stop_of(port, channel);
        for (id, bits) in Whence::all(port, channel) {
            // A reference hears of it as the end of what was played.
            for (start, play) in self.record.iter_mut().flatten().filter(|(_, play)| play.is_of(id, bits)) {
                play.duration = play.duration.min((at.seconds - *start).max(0.0));
            }
            self.let_go(at, Event::Silence(id, bits), outlet);
        }
    }

    /// Sends what lets go, behind what waits.
    pub(super) fn let_go(&mut self, at: When, event: Event, outlet: &mut dyn Outlet) {
        self.pay(at, outlet);
        if !self.owed.is_empty() || !self.say(at, event, outlet) {
            // Once is enough, but it must come behind what was said last.
            self.owed.retain(|known| *known != event);
            self.owed.push_back(event);
        }
    }

    /// Sends what lets go and found no room, as far as there is some now. It takes effect `at` that time.
    pub fn pay(&mut self, at: When, outlet: &mut dyn Outlet) {
        while let Some(event) = self.owed.front().copied()
            && self.say(at, event, outlet)
        {
            self.owed.pop_front();
        }
    }

    fn say(&mut self, at: When, event: Event, outlet: &mut dyn Outlet) -> bool {
        match event {
            Event::Release(id) => self.order(at, event, Some(id), Happening::Release, outlet),
            Event::Silence(id, bits) => self.order(at, event, Some(id), Happening::Silence(bits), outlet),
            Event::ReleaseAll => self.order(at, event, None, Happening::ReleaseAll, outlet),
            Event::Cancel(id, bits) => {
                let sent = outlet.send(at.instant, Source::Stop, event);
                if sent {
                    self.tell(at, None, Some(id), Happening::Cancel(bits));
                }
                sent
            }
            _ => outlet.send(at.instant, Source::Program, event),
        }
    }
}
