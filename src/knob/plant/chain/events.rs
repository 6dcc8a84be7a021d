//! What happens within a step, at its instant, on the motion's power series.

use super::guards::Event;
use super::{Chain, Contact, Grip, MOST_PIECES};
use crate::knob::plant::crossing::dips;
use crate::knob::plant::network::{ANGLE, SPEED};
use crate::knob::plant::rotor::MOST_EVENTS;
use crate::knob::plant::series::{REACH, Series, value};

impl Chain {
    /// A time with what happens in it.
    #[cold]
    #[inline(never)]
    pub(super) fn careful(&mut self, time: f64) {
        let (mut left, mut events, size) = (time, 0, self.network.size);
        let (cogging, ripple) = (self.network.build.cogging.bounds(), self.network.build.ripple.bounds());
        let periods = cogging.1.max(ripple.1);
        for _ in 0..MOST_PIECES + MOST_EVENTS {
            let (mode, stuck) = (self.mode(), self.grip == Grip::Sticks);
            let linear = &self.modes[mode.index()];
            let series = Series::new(
                &self.network,
                &linear.matrix,
                &self.force,
                &self.x,
                [self.torque, self.origin],
                stuck,
            );
            let fastest =
                self.fastest[mode.index()] + if stuck { 0.0 } else { periods * self.x[SPEED].abs() };
            let mut piece = if fastest * left > REACH { REACH / fastest } else { left };
            if self.waved && !stuck {
                piece = piece.min(series.holds(periods));
            }
            let guards = self.guards();
            let mut first: Option<(f64, Event)> = None;
            for guard in &guards.all[..guards.used] {
                let terms = series.sum(&guard.row, guard.offset, size);
                let until = first.map_or(piece, |(t, _)| t);
                let middle = 0.5 * until;
                let found = dips(0.0, middle, |t| value(&terms, t))
                    .or_else(|| dips(middle, until, |t| value(&terms, t)));
                first = found.map(|t| (t, guard.event)).or(first);
            }
            let t = first.map_or(piece, |(t, _)| t);
            self.x = series.at(t, size);
            left -= t;
            if let Some((_, event)) = first {
                events += 1;
                self.counts.events += 1;
                self.happen(event);
                if events >= MOST_EVENTS && left > 0.0 {
                    break;
                }
            }
            if left <= 0.0 {
                return;
            }
        }
        self.counts.crowded += 1;
        (self.x[SPEED], self.x[self.network.knob + 1]) = (0.0, 0.0);
        self.settle();
    }

    fn happen(&mut self, event: Event) {
        let knob = self.network.knob;
        match (event, self.contact) {
            (Event::Stop, _) => {
                self.x[SPEED] = 0.0;
                self.grip = Grip::Sticks;
                let net = self.net();
                if net.abs() > self.network.build.parameters.stiction {
                    self.grip = Grip::Slips(1.0f64.copysign(net));
                }
            }
            (Event::Break(sense), _) => self.grip = Grip::Slips(sense),
            (Event::Touch(side), _) => {
                let moved = self.stop(side);
                self.origin = self.stop_angle(side);
                self.x[ANGLE] -= moved;
                if let Some(target) = self.network.target {
                    self.x[target] -= moved;
                }
                self.x[knob] = 0.0;
                self.contact = Contact::Touching(side);
            }
            (Event::Release, Contact::Touching(side)) if self.depth(side) > 0.0 && self.damped() => {
                self.contact = Contact::Leaving(side);
            }
            (Event::Again, Contact::Leaving(side)) => self.contact = Contact::Touching(side),
            (Event::Release | Event::Clear, Contact::Touching(side) | Contact::Leaving(side)) => {
                self.x[knob] = self.stop(side);
                self.contact = Contact::Away;
            }
            (Event::Limit(limit), _) => self.limit = limit,
            _ => {}
        }
        self.drives();
    }

    fn damped(&self) -> bool {
        self.network.build.parameters.stops.is_some_and(|stops| stops.damping > 0.0)
    }
}
