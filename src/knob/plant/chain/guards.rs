//! What the motion must keep to until something switches.

use super::{Chain, Contact, Grip, SAME};
use crate::actuator::exponential::MOST;
use crate::knob::plant::network::{ANGLE, Mode, SPEED, State};
use crate::knob::plant::parts::Drive;

/// Conditions at a time.
const MOST_GUARDS: usize = 8;

/// What happens where one of them does not hold any more. With the sense of turning, or the side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    Stop,
    Break(f64),
    Touch(f64),
    Release,
    Again,
    Clear,
    Limit(f64),
}

/// What must stay at or above 0: a weighted sum of the state and an offset.
#[derive(Debug, Clone, Copy)]
pub(super) struct Guard {
    pub row: State,
    pub offset: f64,
    pub event: Event,
}

/// The guards of now.
pub(super) struct Guards {
    pub all: [Guard; MOST_GUARDS],
    pub used: usize,
}

impl Guards {
    fn add(&mut self, terms: &[(usize, f64)], offset: f64, event: Event) {
        if let Some(guard) = self.all.get_mut(self.used) {
            *guard = Guard { row: [0.0; MOST], offset, event };
            for &(at, weight) in terms {
                guard.row[at] += weight;
            }
            self.used += 1;
        }
    }
}

impl Chain {
    /// The torque on the motor that friction has to hold, as a weighted sum of the state and an offset.
    pub(super) fn holds(&self) -> (State, f64) {
        let (network, p) = (&self.network, &self.network.build.parameters);
        let mut row = self.modes[Mode { stuck: false, ..self.mode() }.index()].matrix[SPEED];
        row.iter_mut().for_each(|e| *e *= p.inertia);
        let share = 1.0 + network.build.ripple.at(self.angle());
        if let Some(i) = network.current {
            row[i] *= share;
        }
        let mut offset = self.torque * share + network.build.cogging.at(self.angle());
        if network.knob == ANGLE {
            offset += self.hand.torque;
            if let Some(grasp) = &network.build.grasp {
                offset += grasp.damping * self.hand.target_speed;
            }
            if let (Contact::Touching(side), Some(stops)) = (self.contact, p.stops) {
                offset += stops.stiffness * self.stop(side);
            }
        }
        (row, offset)
    }

    pub(super) fn net(&self) -> f64 {
        let (row, offset) = self.holds();
        row.iter().zip(&self.x).map(|(e, x)| e * x).sum::<f64>() + offset
    }

    pub(super) fn guards(&self) -> Guards {
        let (network, p) = (&self.network, &self.network.build.parameters);
        let empty = Guard { row: [0.0; MOST], offset: 0.0, event: Event::Stop };
        let mut guards = Guards { all: [empty; MOST_GUARDS], used: 0 };
        match self.grip {
            Grip::None => {}
            Grip::Slips(sense) => {
                let same = SAME * p.stiction / p.inertia * self.period;
                guards.add(&[(SPEED, sense)], same, Event::Stop);
            }
            Grip::Sticks => {
                let (row, offset) = self.holds();
                for sense in [1.0, -1.0] {
                    guards.add(&[], p.stiction - sense * offset, Event::Break(sense));
                    let last = &mut guards.all[guards.used - 1].row;
                    (0..network.size).for_each(|n| last[n] = -sense * row[n]);
                }
            }
        }
        if let Some(stops) = p.stops {
            let (angle, speed) = (network.knob, network.knob + 1);
            let push = |side: f64| [(angle, side * stops.stiffness), (speed, side * stops.damping)];
            let offset = |side: f64| -side * stops.stiffness * self.stop(side);
            match self.contact {
                Contact::Away => {
                    for side in [1.0, -1.0].into_iter().filter(|side| self.stop(*side).is_finite()) {
                        guards.add(&[(angle, -side)], side * self.stop(side), Event::Touch(side));
                    }
                }
                Contact::Touching(side) => guards.add(&push(side), offset(side), Event::Release),
                Contact::Leaving(side) => {
                    guards.add(&push(-side), -offset(side), Event::Again);
                    guards.add(&[(angle, side)], -side * self.stop(side), Event::Clear);
                }
            }
        }
        if let (Drive::Current { winding, .. }, Some(i), Some(q)) =
            (network.build.drive, network.current, network.integral)
        {
            let (proportional, integral) = network.loop_gains();
            let asks = |sign: f64| [(i, -sign * proportional), (q, sign * integral)];
            let held = proportional * self.command;
            let same = SAME * winding.supply;
            if self.limit == 0.0 {
                for side in [1.0, -1.0] {
                    guards.add(&asks(-side), winding.supply - side * held + same, Event::Limit(side));
                }
            } else {
                let offset = self.limit * held - winding.supply + same;
                guards.add(&asks(self.limit), offset, Event::Limit(0.0));
            }
        }
        guards
    }
}
