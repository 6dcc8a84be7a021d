//! What switches in a motor: stops and starts, and a current source at its limit. All of it at its instant.

use super::drive::Drive;
use super::flow::{Motion, Push, Way};
use super::kernels::of_number;
use super::model::{Grip, Motor, NOTHING, Regime};
use super::piece::{Guard, Piece};
use super::swift::{Method, State, begins, parabola};
use crate::actuator::elementary::{ln, wrapped};

/// Events in a step, at most.
pub const MOST_EVENTS: usize = 8;
/// Parts of a step that are searched for events one by one, at most.
const MOST_PARTS: f64 = 16.0;

/// What can end a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// The rotor stops.
    Stop,
    /// It breaks away, forward or backward.
    Start(bool),
    /// The source of a current comes to its limit, upper or lower.
    Limit(bool),
    /// It is back where it should be.
    Return,
}

impl<const BOOKED: bool> Motor<BOOKED> {
    /// A drive of another kind, or one that a current must follow.
    #[cold]
    pub(super) fn switch(&mut self, drive: Drive) {
        let x = self.state.motion();
        match drive {
            Drive::Voltage(volts) => self.apply(volts),
            Drive::Open => {
                self.energy.opened += self.magnetic();
                self.state.current = 0.0;
                (self.regime, self.volts) = (Regime::Held, 0.0);
            }
            Drive::Current { amperes, limit } => {
                let needs = self.rotor.resistance * amperes + self.rotor.gain * x.speed;
                if needs.abs() <= limit {
                    self.impress(amperes);
                } else {
                    // What flows beyond the wish is taken back at once.
                    if (amperes - x.current) * needs < 0.0 {
                        self.impress(amperes);
                    }
                    self.apply(limit.copysign(needs));
                }
            }
        }
        self.drive = drive;
        if self.grip == Grip::Sticks {
            let torque = self.rotor.gain * self.state.current + self.gravity(self.state.phase);
            if torque.abs() > self.parameters.stiction {
                self.slip(torque);
            }
        }
        self.bound();
    }

    fn apply(&mut self, volts: f64) {
        (self.regime, self.volts) = (Regime::Coil, volts);
        let state = &mut self.state;
        state.current = self.flows[0].dictated(state.speed, volts).unwrap_or(state.current);
    }

    fn impress(&mut self, amperes: f64) {
        let before = self.magnetic();
        self.state.current = amperes;
        (self.regime, self.volts) = (Regime::Held, 0.0);
        self.energy.supplied += self.magnetic() - before;
    }

    pub(super) fn slip(&mut self, towards: f64) {
        self.grip = Grip::Slips;
        self.sense = 1.0_f64.copysign(towards);
    }

    pub(super) fn hold(&mut self) {
        (self.grip, self.sense) = (Grip::Sticks, 0.0);
        self.state.speed = 0.0;
    }

    /// A time with what happens in it.
    #[cold]
    #[inline(never)]
    pub(super) fn careful(&mut self, span: f64) {
        let mut left = span;
        for _ in 0..MOST_EVENTS {
            let event =
                if self.grip == Grip::Sticks { self.rest(left, true) } else { self.slide(left, true) };
            let Some((t, event)) = event else { return };
            self.counts.events += 1;
            self.happen(event);
            self.bound();
            left -= t;
            if left <= 0.0 {
                return;
            }
        }
        self.counts.crowded += 1;
        if self.grip != Grip::None && self.state.speed == 0.0 {
            self.hold();
            self.rest(left, false);
        } else {
            self.slide(left, false);
        }
        self.bound();
    }

    /// At rest until something happens, or for all of the time.
    fn rest(&mut self, left: f64, events: bool) -> Option<(f64, Event)> {
        let (from, pull) = (self.state.current, self.gravity(self.state.phase));
        let (gain, stiction) = (self.rotor.gain, self.parameters.stiction);
        self.state.pull = pull;
        let torque = |current: f64| gain * current + pull;
        let over = |current: f64| torque(current).abs() > stiction;
        let (to, at_last) = self.relaxed(from, left);
        let mut first: Option<(f64, f64, Event)> = None;
        let mut meet = |target: f64, event: Event, at_once: bool| {
            let t = if at_once { 0.0 } else { self.reaches(from, target, at_last).min(left) };
            if first.is_none_or(|(earliest, ..)| t < earliest) {
                first = Some((t, if at_once { from } else { target }, event));
            }
        };
        if events {
            if over(from) {
                meet(from, Event::Start(torque(from) > 0.0), true);
            } else if over(to) {
                let forward = torque(to) > 0.0;
                let edge = if forward { stiction } else { -stiction };
                meet((edge - pull) / gain, Event::Start(forward), false);
            }
            if let (Drive::Current { amperes, .. }, Regime::Coil) = (self.drive, self.regime) {
                let short_of = |current: f64| (amperes - current) * self.volts > 0.0;
                if !short_of(from) || !short_of(to) {
                    meet(amperes, Event::Return, !short_of(from));
                }
            }
        }
        let (t, current) = first.map_or((left, to), |(t, current, _)| (t, current));
        if BOOKED {
            self.energy.relaxing(&self.rotor, self.terminal(), from, at_last, t);
        }
        self.state.current = if current.abs() < NOTHING { 0.0 } else { current };
        if let Some(mount) = &mut self.mount {
            mount.advance(t, self.state.phase, 0.0);
        }
        first.map(|(t, _, event)| (t, event))
    }

    /// The current after a time at rest, and where it goes.
    fn relaxed(&self, from: f64, t: f64) -> (f64, f64) {
        if self.regime == Regime::Held {
            return (from, from);
        }
        let (r, l) = (self.rotor.resistance, self.rotor.inductance);
        let at_last = self.volts / r;
        if l > 0.0 {
            (from + t * of_number(-r / l * t)[0] * ((self.volts - r * from) / l), at_last)
        } else {
            (at_last, at_last)
        }
    }

    /// When a current that relaxes passes a value on its way.
    fn reaches(&self, from: f64, target: f64, at_last: f64) -> f64 {
        let time = self.rotor.inductance / self.rotor.resistance * ln((from - at_last) / (target - at_last));
        time.max(0.0)
    }

    /// What acts over a time whose way is known, and the torque of gravity to go on with.
    fn piece(&self, span: f64, way: &Way) -> (Push, f64) {
        let (flow, state) = (&self.flows[self.regime as usize], &self.state);
        let (x, friction) = (state.motion(), self.swift.friction);
        let others = Push { volts: self.volts, torque: friction, slope: 0.0, curve: 0.0 };
        let pulled_by = |push: &Push, way: &Way| {
            let angle = way.change(flow.rates(x, push), x.speed, push).angle;
            self.gravity(state.phase + angle / std::f64::consts::TAU)
        };
        match self.method {
            Method::None => (others, 0.0),
            Method::Midpoint => {
                let pulled = Push { torque: friction + state.pull, ..others };
                let pull = pulled_by(&pulled, &flow.over(0.5 * span));
                (Push { torque: friction + pull, ..others }, pull)
            }
            Method::Parabola => {
                let free = flow.rates(x, &others).speed;
                let begins = begins(self.weight, free, self.rotor.inertia, x.speed, state.phase, &others);
                let (middle, end) = (pulled_by(&begins, &flow.over(0.5 * span)), pulled_by(&begins, way));
                (parabola(begins, friction, [middle, end], span), end)
            }
        }
    }

    /// What the motion must keep to, and what happens where it does not.
    fn guards(&self) -> [Option<(Guard, Event)>; 3] {
        let stop = (self.grip == Grip::Slips)
            .then_some((Guard { current: 0.0, speed: self.sense, offset: 0.0 }, Event::Stop));
        let Drive::Current { amperes, limit } = self.drive else { return [stop, None, None] };
        if self.regime == Regime::Coil {
            let sign = 1.0_f64.copysign(self.volts);
            let back = Guard { current: -sign, speed: 0.0, offset: sign * amperes };
            return [stop, Some((back, Event::Return)), None];
        }
        if limit == f64::INFINITY {
            return [stop, None, None];
        }
        let (k, needs) = (self.rotor.gain, self.rotor.resistance * amperes);
        let below = Guard { current: 0.0, speed: -k, offset: limit - needs };
        let above = Guard { current: 0.0, speed: k, offset: limit + needs };
        [stop, Some((below, Event::Limit(true))), Some((above, Event::Limit(false)))]
    }

    /// Turning until something happens, or for all of the time.
    fn slide(&mut self, left: f64, events: bool) -> Option<(f64, Event)> {
        let flow = self.flows[self.regime as usize];
        let way = flow.over(left);
        let (push, pull) = self.piece(left, &way);
        let piece = Piece::new(&flow, self.state.motion(), push);
        let guards = if events { self.guards() } else { [None; 3] };
        let parts = (left * self.swings() / std::f64::consts::FRAC_PI_2).ceil().clamp(1.0, MOST_PARTS);
        let mut from = (0.0, piece.from);
        let mut part = 1.0;
        loop {
            let t = if part == parts { left } else { left * (part / parts) };
            let (motion, angle) = if part == parts { piece.by(&way) } else { piece.at(t) };
            let mut first: Option<(f64, Event)> = None;
            for (guard, event) in guards.iter().flatten() {
                let met = piece.meets(guard, from, (t, motion));
                if let Some(met) = met.filter(|met| first.is_none_or(|(t, _)| *met < t)) {
                    first = Some((met, *event));
                }
            }
            if let Some((t, event)) = first {
                let (motion, angle) = piece.at(t);
                self.land(&piece, t, motion, angle, pull);
                return Some((t, event));
            }
            if part == parts {
                self.land(&piece, left, motion, angle, pull);
                return None;
            }
            from = (t, motion);
            part += 1.0;
        }
    }

    /// Takes the end of a piece.
    fn land(&mut self, piece: &Piece, t: f64, motion: Motion, angle: f64, pull: f64) {
        if BOOKED {
            self.energy.piece(piece.flow, piece.from, &piece.push, self.parameters.coulomb, t);
        }
        let snapped = |x: f64| if x.abs() < NOTHING { 0.0 } else { x };
        let (phase, whole) = wrapped(self.state.phase + angle / std::f64::consts::TAU);
        let (current, speed) = (snapped(motion.current), snapped(motion.speed));
        self.state = State { current, phase, speed, turns: self.state.turns + whole, pull };
        if let Some(mount) = &mut self.mount {
            mount.advance(t, phase, speed);
        }
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Stop => {
                self.state.pull = self.gravity(self.state.phase);
                let torque = self.rotor.gain * self.state.current + self.state.pull;
                self.hold();
                if torque.abs() > self.parameters.stiction {
                    self.slip(torque);
                }
            }
            Event::Start(forward) => self.slip(if forward { 1.0 } else { -1.0 }),
            Event::Limit(upper) => {
                if let Drive::Current { limit, .. } = self.drive {
                    self.apply(if upper { limit } else { -limit });
                }
            }
            Event::Return => {
                if let Drive::Current { amperes, .. } = self.drive {
                    self.impress(amperes);
                }
            }
        }
    }
}
