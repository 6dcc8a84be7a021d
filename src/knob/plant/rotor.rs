//! One inertia with friction and end stops, exact for a torque that is held over a step.

mod events;

use super::law::{Law, Over};
use super::parameters::{MOST_TORQUE, Parameters};
use super::stops::Stops;
use crate::actuator::fault::{Fault, within};

/// Events in a step, at most. What moves after those is stopped where it is until the step ends: no energy is made, and the step is
/// counted in [`Counts::crowded`].
pub const MOST_EVENTS: usize = 8;

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Inputs that were no number, or beyond what a knob can be given, and counted as 0.
    pub masked: u64,
    /// Reversals, stops, starts, contacts made and lost, limits reached and left.
    pub events: u64,
    /// Steps that had more than [`MOST_EVENTS`].
    pub crowded: u64,
}

/// What dry friction does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grip {
    /// There is none.
    None,
    /// It holds.
    Sticks,
    /// It turns, forward or backward.
    Slips,
}

/// Where a knob is with respect to its stops. The depth p behind one is kept for itself: it keeps its digits wherever the stop is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Contact {
    /// Between them.
    Away,
    /// Behind one, which pushes.
    Touching(Side, f64),
    /// Behind one that is slower than the knob and does not push.
    Leaving(Side, f64),
}

/// 1 for the upper stop, −1 for the lower one, and where that is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    sign: f64,
    place: f64,
}

/// A knob of one inertia, step by step. Without `WALLED` it has no stops, and pays nothing for them.
#[derive(Debug, Clone)]
pub struct Rotor<const WALLED: bool> {
    angle: f64,
    speed: f64,
    /// What a whole step does, and torque into acceleration.
    step: Over,
    lightness: f64,
    grip: Grip,
    /// Friction that acts now: T_c times the sense of turning.
    rubs: f64,
    sense: f64,
    contact: Contact,
    pressed: Over,
    /// Whether a step behind a stop is so short that each thing can happen but once in it.
    short: bool,
    period: f64,
    counts: Counts,
    free: Law,
    against: Law,
    walls: Stops,
    parameters: Parameters,
}

impl<const WALLED: bool> Rotor<WALLED> {
    /// At rest at 0 rad, for `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first parameter, or the rate, that is beyond its limits.
    pub fn new(parameters: &Parameters, rate: f64) -> Result<Self, Fault> {
        parameters.check()?;
        within("rate", rate, (1.0, 1e8), "steps a second")?;
        let period = 1.0 / rate;
        let Parameters { inertia, viscous, stiction, .. } = *parameters;
        let none = Stops { low: f64::NEG_INFINITY, high: f64::INFINITY, stiffness: 1.0, damping: 0.0 };
        let walls = parameters.stops.filter(|_| WALLED).unwrap_or(none);
        let free = Law::new(inertia, viscous, 0.0);
        let against = Law::new(inertia, viscous + walls.damping, walls.stiffness);
        let mut rotor = Self {
            angle: 0.0,
            speed: 0.0,
            step: free.over(period),
            lightness: 1.0 / inertia,
            grip: if stiction > 0.0 { Grip::Sticks } else { Grip::None },
            rubs: 0.0,
            sense: 0.0,
            contact: Contact::Away,
            pressed: against.over(period),
            short: against.half_period().is_none_or(|half| period < 0.9 * half),
            period,
            counts: Counts::default(),
            free,
            against,
            walls,
            parameters: *parameters,
        };
        rotor.settle();
        Ok(rotor)
    }

    /// Angle, rad.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Speed, rad/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Seconds a step.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Puts it at an angle (within ±1e9 rad) with a speed (within ±1e9 rad/s).
    ///
    /// # Errors
    /// Which of the two is beyond its limits; nothing changes then.
    pub fn place(&mut self, angle: f64, speed: f64) -> Result<(), Fault> {
        within("angle", angle, (-1e9, 1e9), "rad")?;
        within("speed", speed, (-1e9, 1e9), "rad/s")?;
        (self.angle, self.speed) = (angle, speed);
        self.settle();
        Ok(())
    }

    /// Kinetic energy and that of a pressed stop, J.
    pub fn energy(&self) -> f64 {
        let depth = match self.contact {
            Contact::Touching(_, depth) => depth,
            _ => 0.0,
        };
        0.5 * (self.parameters.inertia * self.speed * self.speed + self.walls.stiffness * depth * depth)
    }

    /// The torque with which a stop pushes, N m: against turning forward where it is above 0.
    pub fn pushes(&self) -> f64 {
        match self.contact {
            Contact::Touching(side, depth) => side.sign * self.push(side, depth, self.speed),
            _ => 0.0,
        }
    }

    /// Grip and contact from angle and speed alone.
    fn settle(&mut self) {
        let Stops { low, high, .. } = self.walls;
        let (above, below) = (self.angle - high, low - self.angle);
        self.contact = if WALLED && (above > 0.0 || below > 0.0) {
            let side = self.side(above > 0.0);
            let depth = above.max(below);
            if self.push(side, depth, self.speed) > 0.0 {
                Contact::Touching(side, depth)
            } else {
                Contact::Leaving(side, depth)
            }
        } else {
            Contact::Away
        };
        if self.grip != Grip::None {
            if self.speed == 0.0 {
                self.hold();
            } else {
                self.slip(self.speed);
            }
        }
    }

    fn side(&self, upper: bool) -> Side {
        if upper {
            Side { sign: 1.0, place: self.walls.high }
        } else {
            Side { sign: -1.0, place: self.walls.low }
        }
    }

    fn push(&self, side: Side, depth: f64, speed: f64) -> f64 {
        self.walls.stiffness * depth + self.walls.damping * side.sign * speed
    }

    fn slip(&mut self, towards: f64) {
        self.sense = 1.0f64.copysign(towards);
        (self.grip, self.rubs) = (Grip::Slips, self.sense * self.parameters.coulomb);
    }

    fn hold(&mut self) {
        (self.speed, self.grip, self.sense, self.rubs) = (0.0, Grip::Sticks, 0.0, 0.0);
    }

    /// Passes one step with a torque (N m) held over it, that of motor and hand together. What is no number, or beyond
    /// [`MOST_TORQUE`], counts as no torque and is counted.
    #[inline]
    pub fn step(&mut self, torque: f64) {
        // So that what is not a number fails too.
        let torque = if torque.abs() <= MOST_TORQUE { torque } else { self.mask() };
        if !WALLED || self.contact == Contact::Away {
            if self.grip == Grip::Sticks {
                if torque.abs() <= self.parameters.stiction {
                    return;
                }
            } else {
                let acceleration =
                    (torque - self.rubs - self.parameters.viscous * self.speed) * self.lightness;
                let speed = self.speed + acceleration * self.step.gains;
                let angle = self.angle + self.speed * self.period + acceleration * self.step.bends;
                let rubs_on = self.grip == Grip::None || speed * self.sense > 0.0;
                let clear = !WALLED || self.stays_clear(angle, speed);
                if rubs_on && clear {
                    (self.angle, self.speed) = (angle, speed);
                    return;
                }
            }
        } else if self.presses_on(torque) {
            return;
        }
        self.careful(torque);
    }

    /// Whether no stop is met on the way to an angle and a speed: speed only rises or only falls on it.
    #[inline]
    fn stays_clear(&self, angle: f64, speed: f64) -> bool {
        let Stops { low, high, .. } = self.walls;
        let reach = self.period * speed.abs().max(self.speed.abs());
        (angle < high && angle > low)
            && (speed * self.speed > 0.0 || (self.angle + reach < high && self.angle - reach > low))
    }

    /// A step behind a stop in which nothing else happens, if this is one.
    fn presses_on(&mut self, torque: f64) -> bool {
        let Contact::Touching(side, depth) = self.contact else { return false };
        if self.grip == Grip::Sticks {
            return (torque - side.sign * self.walls.stiffness * depth).abs() <= self.parameters.stiction;
        }
        if !self.short {
            return false;
        }
        let before = self.acceleration(torque);
        let (v, over) = (self.speed, &self.pressed);
        let speed = v * over.keeps + before * over.gains;
        let moved = side.sign * (v * over.goes + before * over.bends);
        let push = self.push(side, depth + moved, speed);
        let after = before * over.keeps + self.against.jerk(v, before) * over.gains;
        let Stops { stiffness, damping, .. } = self.walls;
        let slope = |v: f64, a: f64| side.sign * (stiffness * v + damping * a);
        // Within half a period the slope is not much beyond what it is at the ends.
        let (begins, ends) = (slope(v, before), slope(speed, after));
        let reach = self.period * ends.abs().max(begins.abs());
        let dips = begins < 0.0 && ends > 0.0 && push.min(self.push(side, depth, v)) <= reach;
        if push <= 0.0 || dips || (self.grip == Grip::Slips && speed * self.sense <= 0.0) {
            return false;
        }
        self.speed = speed;
        self.contact = Contact::Touching(side, depth + moved);
        self.angle = side.place + side.sign * (depth + moved);
        true
    }

    #[cold]
    fn mask(&mut self) -> f64 {
        self.counts.masked += 1;
        0.0
    }

    /// Of a knob that turns, with all that acts now.
    fn acceleration(&self, torque: f64) -> f64 {
        let push = match self.contact {
            Contact::Touching(side, depth) => side.sign * self.push(side, depth, self.speed),
            _ => 0.0,
        };
        (torque - self.rubs - self.parameters.viscous * self.speed - push) * self.lightness
    }

    fn law(&self) -> &Law {
        if matches!(self.contact, Contact::Touching(..)) { &self.against } else { &self.free }
    }
}

#[cfg(test)]
mod tests;
