//! What happens within a step of a rotor, at its instant: reversals, stops and starts; a stop met, let go, met again.

use super::{Contact, Grip, MOST_EVENTS, Rotor, Side};
use crate::knob::plant::crossing::{Point, falls};
use crate::knob::plant::stops::Stops;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    Stop,
    Touch(bool),
    Release,
    Again,
    Clear,
}

impl<const WALLED: bool> Rotor<WALLED> {
    /// A step with what happens in it.
    #[cold]
    #[inline(never)]
    pub(super) fn careful(&mut self, torque: f64) {
        let mut left = self.period;
        for _ in 0..MOST_EVENTS {
            if self.grip == Grip::Sticks && !self.breaks(torque) {
                return;
            }
            let (t, event) = self.first(torque, left).map_or((left, None), |(t, event)| (t, Some(event)));
            self.advance(torque, t);
            let Some(event) = event else { return };
            self.counts.events += 1;
            self.happen(event);
            left -= t;
            if left <= 0.0 {
                return;
            }
        }
        self.counts.crowded += 1;
        self.speed = 0.0;
        self.settle();
    }

    /// Whether it leaves rest under a torque, and does.
    fn breaks(&mut self, torque: f64) -> bool {
        let torque = match self.contact {
            Contact::Touching(side, depth) => torque - side.sign * self.walls.stiffness * depth,
            _ => torque,
        };
        if torque.abs() <= self.parameters.stiction {
            return false;
        }
        self.counts.events += 1;
        self.slip(torque);
        true
    }

    fn advance(&mut self, torque: f64, t: f64) {
        let a = self.acceleration(torque);
        let over = if t == self.period {
            if matches!(self.contact, Contact::Touching(..)) { self.pressed } else { self.step }
        } else {
            self.law().over(t)
        };
        let moved = self.speed * over.goes + a * over.bends;
        self.speed = self.speed * over.keeps + a * over.gains;
        match &mut self.contact {
            Contact::Away => self.angle += moved,
            Contact::Touching(side, depth) | Contact::Leaving(side, depth) => {
                *depth += side.sign * moved;
                self.angle = side.place + side.sign * *depth;
            }
        }
    }

    fn happen(&mut self, event: Event) {
        match (event, self.contact) {
            (Event::Stop, Contact::Leaving(side, depth)) => {
                self.contact = Contact::Touching(side, depth);
                self.hold();
            }
            (Event::Stop, _) => self.hold(),
            (Event::Touch(upper), _) => {
                let side = self.side(upper);
                self.angle = side.place;
                self.contact = Contact::Touching(side, 0.0);
            }
            (Event::Release, Contact::Touching(side, depth)) if depth > 0.0 && self.walls.damping > 0.0 => {
                self.contact = Contact::Leaving(side, depth);
            }
            (Event::Again, Contact::Leaving(side, depth)) => self.contact = Contact::Touching(side, depth),
            (Event::Release | Event::Clear, Contact::Touching(side, _) | Contact::Leaving(side, _)) => {
                self.angle = side.place;
                self.contact = Contact::Away;
            }
            _ => {}
        }
    }

    /// The first event within a time, and when.
    fn first(&self, torque: f64, left: f64) -> Option<(f64, Event)> {
        let (v, a, law) = (self.speed, self.acceleration(torque), self.law());
        let turns = law.zero(v, a);
        let mut first: Option<(f64, Event)> = None;
        let mut meet = |at: Option<f64>, event: Event| {
            if let Some(t) = at.filter(|t| *t <= left)
                && first.is_none_or(|(earliest, _)| t < earliest)
            {
                first = Some((t, event));
            }
        };
        if self.grip == Grip::Slips {
            meet(turns, Event::Stop);
        }
        if !WALLED {
            return first;
        }
        let moved = |t: f64| {
            let over = law.over(t);
            (v * over.goes + a * over.bends, v * over.keeps + a * over.gains)
        };
        match self.contact {
            Contact::Away => {
                for upper in [true, false] {
                    let side = self.side(upper);
                    if side.place.is_finite() {
                        let gap = side.sign * (side.place - self.angle);
                        let of = |t: f64| {
                            let (moved, speed) = moved(t);
                            (gap - side.sign * moved, -side.sign * speed)
                        };
                        meet(in_parts([turns, None], left, of), Event::Touch(upper));
                    }
                }
            }
            Contact::Touching(side, depth) => {
                meet(self.release(side, depth, [v, a], left), Event::Release);
            }
            Contact::Leaving(side, depth) => {
                let of = |t: f64| {
                    let (moved, speed) = moved(t);
                    (depth + side.sign * moved, side.sign * speed)
                };
                meet(in_parts([turns, None], left, of), Event::Clear);
                let Stops { stiffness, damping, .. } = self.walls;
                let slope = |v: f64, a: f64| side.sign * (stiffness * v + damping * a);
                let (s, r) = (slope(v, a), slope(a, law.jerk(v, a)));
                // At its own release the push is 0 but for rounding, of either sign.
                let push = self.push(side, depth, v).min(0.0);
                let of = |t: f64| {
                    let over = law.over(t);
                    (-push - s * over.goes - r * over.bends, -s * over.keeps - r * over.gains)
                };
                meet(in_parts([law.zero(s, r), None], left, of), Event::Again);
            }
        }
        first
    }

    /// When the push of a stop is no longer above 0. It swings about its end with what swing the contact has, so after its first
    /// minimum it is not lower again.
    fn release(&self, side: Side, depth: f64, [v, a]: [f64; 2], left: f64) -> Option<f64> {
        let Stops { stiffness, damping, .. } = self.walls;
        let law = &self.against;
        let slope = |v: f64, a: f64| side.sign * (stiffness * v + damping * a);
        let (s, r) = (slope(v, a), slope(a, law.jerk(v, a)));
        let push = self.push(side, depth, v).max(0.0);
        let of = |t: f64| {
            let over = law.over(t);
            (push + s * over.goes + r * over.bends, s * over.keeps + r * over.gains)
        };
        let turns = law.zero(s, r);
        let next = turns.zip(law.half_period()).map(|(t, half)| t + half);
        in_parts([turns, next], left, of)
    }
}

/// The first time at which something is below 0, whose extremes are at given times: between them it only rises or only falls.
fn in_parts(extremes: [Option<f64>; 2], left: f64, of: impl Fn(f64) -> Point) -> Option<f64> {
    let mut from = 0.0;
    for extreme in extremes.into_iter().flatten().chain([f64::INFINITY]) {
        let to = extreme.min(left);
        if of(to).0 < 0.0 {
            return Some(falls(from, to, of));
        }
        if to >= left {
            return None;
        }
        from = to;
    }
    None
}
