//! A knob with all that it may have: shaft, winding and current loop, a hand's grasp, torque over its angle, stops, friction.
//!
//! Between events what is linear is the exponential of its matrix. Friction, stops and the supply's limits are linear in parts, and
//! change at their instants, found on the motion's power series. Torque over the angle goes by that series too: 18 terms a
//! piece, pieces short enough that what is left out is below rounding (`series`).

mod events;
mod guards;
mod inputs;

use super::network::{ANGLE, Linear, Mode, Network, SPEED, State, rates};
use super::parts::{Build, Drive, Hand};
use super::rotor::Counts;
use crate::actuator::exponential::MOST;
use crate::actuator::fault::{Fault, Limit, within};

/// Pieces of a step, at most: those that events are looked for in, and those of a power series.
pub const MOST_PIECES: usize = 1024;
/// Radians of the fastest a piece that is looked at by its ends alone.
const PIECE: f64 = 0.5;
/// Shares of a supply, and of the speed that stiction gives in a step, that are no difference.
const SAME: f64 = 1e-13;

/// The share of its resistance by which a winding must be warmer for it to be another: a sixteenth of a kelvin in copper.
const WARMER: f64 = 2.5e-4;
/// Every mode, by its index.
const MODES: [Mode; 8] = {
    let mut all = [Mode { stuck: false, touching: false, saturated: false }; 8];
    let mut n = 0;
    while n < all.len() {
        all[n] = Mode { stuck: n & 1 != 0, touching: n & 2 != 0, saturated: n & 4 != 0 };
        n += 1;
    }
    all
};

/// About the fastest rate of each mode, with the steepest torque over the angle; and how many pieces of a step they ask for.
fn pieces(network: &Network, waved: bool, period: f64) -> ([f64; 8], f64) {
    let p = &network.build.parameters;
    let switches = p.stiction > 0.0 || p.stops.is_some() || network.integral.is_some();
    let steep = (network.build.cogging.bounds().0 / p.inertia).sqrt();
    let fastest = MODES.map(|mode| network.fastest(mode) + steep);
    let most = fastest.iter().fold(0.0, |a: f64, b| a.max(*b));
    (fastest, if switches || waved { (most * period / PIECE).ceil().max(1.0) } else { 1.0 })
}

/// A knob of any [`Build`], step by step.
#[derive(Debug, Clone)]
pub struct Chain {
    network: Network,
    modes: [Linear; 8],
    /// About the fastest rate of each mode, with the steepest torque over the angle.
    fastest: [f64; 8],
    /// Which of them are those of a colder winding.
    stale: [bool; 8],
    pieces: usize,
    period: f64,
    waved: bool,
    /// Angles in it count from `origin`: from a stop as soon as that was met, so that a depth behind it keeps its digits.
    x: State,
    origin: f64,
    force: State,
    torque: f64,
    command: f64,
    hand: Hand,
    grip: Grip,
    contact: Contact,
    /// 1 and −1 at the supply's limits, 0 between them.
    limit: f64,
    counts: Counts,
}

/// 0 where friction holds, else the sense of turning.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Grip {
    None,
    Sticks,
    Slips(f64),
}

/// With the side: 1 the upper stop, −1 the lower one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Contact {
    Away,
    Touching(f64),
    Leaving(f64),
}

impl Chain {
    /// At rest at 0 rad, for `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first field, or the rate, beyond its limits; a rate so low that what switches would need more than [`MOST_PIECES`]
    /// pieces a step.
    pub fn new(build: &Build, rate: f64) -> Result<Self, Fault> {
        build.check()?;
        within("rate", rate, (1.0, 1e8), "steps a second")?;
        let (network, period) = (Network::new(build), 1.0 / rate);
        let waved = !(build.cogging.is_flat() && build.ripple.is_flat());
        let (fastest, pieces) = pieces(&network, waved, period);
        if pieces > MOST_PIECES as f64 {
            let most = fastest.iter().fold(0.0, |a: f64, b| a.max(*b));
            let least = most / (PIECE * MOST_PIECES as f64);
            return Err(Fault::because(
                "rate",
                rate,
                Limit::Least(least),
                "the fastest part of the knob is too fast for it",
            ));
        }
        let modes = MODES.map(|mode| network.linear(mode, period / pieces));
        let p = &build.parameters;
        let mut chain = Self {
            network,
            modes,
            fastest,
            stale: [false; 8],
            pieces: pieces as usize,
            period,
            waved,
            x: [0.0; MOST],
            origin: 0.0,
            force: [0.0; MOST],
            torque: 0.0,
            command: 0.0,
            hand: Hand::default(),
            grip: if p.stiction > 0.0 { Grip::Sticks } else { Grip::None },
            contact: Contact::Away,
            limit: 0.0,
            counts: Counts::default(),
        };
        chain.place(0.0, 0.0)?;
        Ok(chain)
    }

    /// Angle of the motor and its encoder, rad.
    pub fn angle(&self) -> f64 {
        self.origin + self.x[ANGLE]
    }

    /// Speed of the motor, rad/s.
    pub fn speed(&self) -> f64 {
        self.x[SPEED]
    }

    /// Angle of what the hand holds, rad: with a shaft another than the motor's.
    pub fn knob_angle(&self) -> f64 {
        self.origin + self.x[self.network.knob]
    }

    /// Speed of what the hand holds, rad/s.
    pub fn knob_speed(&self) -> f64 {
        self.x[self.network.knob + 1]
    }

    /// Current in the winding, A; 0 where there is none.
    pub fn current(&self) -> f64 {
        self.network.current.map_or(0.0, |i| self.x[i])
    }

    /// Voltage at the winding, V; 0 where there is none.
    pub fn voltage(&self) -> f64 {
        match self.network.build.drive {
            Drive::Torque => 0.0,
            Drive::Voltage(_) => self.command,
            Drive::Current { winding, .. } => self.asks().clamp(-winding.supply, winding.supply),
        }
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Seconds a step.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Kinetic energy and that of shaft, pressed stop and cogging, J; without those of winding and grasp.
    pub fn energy(&self) -> f64 {
        let (x, build) = (&self.x, &self.network.build);
        let mut twice = build.parameters.inertia * x[SPEED] * x[SPEED];
        if let Some(shaft) = &build.shaft {
            let bent = x[self.network.knob] - x[ANGLE];
            twice += shaft.inertia * self.knob_speed() * self.knob_speed() + shaft.stiffness * bent * bent;
        }
        if let (Contact::Touching(side), Some(stops)) = (self.contact, build.parameters.stops) {
            twice += stops.stiffness * self.depth(side) * self.depth(side);
        }
        0.5 * twice + build.cogging.energy(self.angle())
    }

    /// Its winding has another resistance (ohms) from here on, as it has when it is warm: up to ten times that of its build. What
    /// the current loop was set for stays. A difference of less than a sixteenth of a kelvin in copper waits until it is more.
    pub fn warm(&mut self, resistance: f64) {
        let Some(winding) = self.network.build.winding() else { return };
        let most = 10.0 * winding.resistance;
        let step = WARMER * self.network.resistance;
        if !(resistance > 0.0 && resistance <= most && (resistance - self.network.resistance).abs() >= step) {
            return;
        }
        self.network.resistance = resistance;
        let (fastest, pieces) = pieces(&self.network, self.waved, self.period);
        let pieces = pieces.min(MOST_PIECES as f64) as usize;
        self.stale = MODES.map(|mode| self.network.comes_into(mode));
        let all = pieces != self.pieces;
        (self.fastest, self.pieces) = (fastest, pieces);
        while all && self.renew() {}
    }

    /// Renews a mode that was made for a colder winding: one a step, so that no step waits for all. Returns whether there was one.
    fn renew(&mut self) -> bool {
        let Some(n) = self.stale.iter().position(|stale| *stale) else { return false };
        self.stale[n] = false;
        self.modes[n] = self.network.linear(MODES[n], self.period / self.pieces as f64);
        true
    }

    /// Puts all of it at an angle (within ±1e9 rad) with a speed (within ±1e9 rad/s), without current.
    ///
    /// # Errors
    /// Which of the two is beyond its limits; nothing changes then.
    pub fn place(&mut self, angle: f64, speed: f64) -> Result<(), Fault> {
        within("angle", angle, (-1e9, 1e9), "rad")?;
        within("speed", speed, (-1e9, 1e9), "rad/s")?;
        (self.x, self.origin) = ([0.0; MOST], 0.0);
        (self.x[ANGLE], self.x[SPEED]) = (angle, speed);
        (self.x[self.network.knob], self.x[self.network.knob + 1]) = (angle, speed);
        self.settle();
        Ok(())
    }

    fn settle(&mut self) {
        if self.grip != Grip::None {
            let speed = self.x[SPEED];
            self.grip = if speed == 0.0 { Grip::Sticks } else { Grip::Slips(1.0f64.copysign(speed)) };
        }
        self.contact = Contact::Away;
        if self.network.build.parameters.stops.is_some() {
            for side in [1.0, -1.0] {
                if self.depth(side) > 0.0 {
                    self.contact =
                        if self.push(side) > 0.0 { Contact::Touching(side) } else { Contact::Leaving(side) };
                }
            }
        }
    }

    /// How far it is behind a stop.
    fn depth(&self, side: f64) -> f64 {
        side * (self.x[self.network.knob] - self.stop(side))
    }

    /// Where a stop is, counted from the origin.
    fn stop(&self, side: f64) -> f64 {
        self.stop_angle(side) - self.origin
    }

    fn stop_angle(&self, side: f64) -> f64 {
        let none = f64::INFINITY * side;
        self.network.build.parameters.stops.map_or(none, |s| if side > 0.0 { s.high } else { s.low })
    }

    fn push(&self, side: f64) -> f64 {
        let stops = self.network.build.parameters.stops;
        stops.map_or(0.0, |s| s.stiffness * self.depth(side) + s.damping * side * self.knob_speed())
    }

    /// What the current loop asks of the supply, V.
    fn asks(&self) -> f64 {
        let (proportional, integral) = self.network.loop_gains();
        match (self.network.current, self.network.integral) {
            (Some(i), Some(q)) => proportional * (self.command - self.x[i]) + integral * self.x[q],
            _ => 0.0,
        }
    }

    fn mode(&self) -> Mode {
        Mode {
            stuck: self.grip == Grip::Sticks,
            touching: matches!(self.contact, Contact::Touching(_)),
            saturated: self.limit != 0.0,
        }
    }

    /// A piece of a step in which nothing switches, if this is one.
    fn glide(&mut self, piece: f64) -> bool {
        let (size, linear) = (self.network.size, &self.modes[self.mode().index()]);
        let before = rates(&linear.matrix, &self.x, &self.force, size);
        let moved = rates(&linear.passes, &before, &self.x, size);
        let guards = self.guards();
        if guards.used > 0 {
            let after = rates(&linear.matrix, &moved, &self.force, size);
            let dot = |row: &State, x: &State| (0..size).map(|n| row[n] * x[n]).sum::<f64>();
            for guard in &guards.all[..guards.used] {
                let (begins, ends) = (dot(&guard.row, &before), dot(&guard.row, &after));
                let (from, to) =
                    (dot(&guard.row, &self.x) + guard.offset, dot(&guard.row, &moved) + guard.offset);
                let reach = piece * begins.abs().max(ends.abs());
                if to < 0.0 || (begins < 0.0 && ends > 0.0 && from.min(to) <= reach) {
                    return false;
                }
            }
        }
        self.x = moved;
        true
    }
}

#[cfg(test)]
mod tests;
