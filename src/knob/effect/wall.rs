//! Walls and end stops.

use super::events::{Events, What};
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, Limit, check, not_negative};

/// A wall: −(K p + B ṗ) for a depth p above 0, and never a pull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Where it stands, radians.
    pub angle: f64,
    /// Whether it stands in the way of smaller angles rather than larger ones.
    pub below: bool,
    /// K, N m/rad.
    pub stiffness: f64,
    /// B, N m s/rad.
    pub damping: f64,
}

/// Whether the knob is in the wall.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    inside: bool,
}

impl Wall {
    fn side(&self) -> f64 {
        if self.below { -1.0 } else { 1.0 }
    }
}

impl Effect for Wall {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        check("angle", self.angle, Limit::Least(f64::MIN))?;
        not_negative("stiffness", self.stiffness)?;
        not_negative("damping", self.damping)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.stiffness, damping: self.damping }
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
        let side = self.side();
        let depth = side * (r.angle - self.angle);
        let inside = depth > 0.0;
        if inside && !state.inside {
            events.push(What::Wall { speed: r.velocity.abs(), side: side as i8 });
        }
        state.inside = inside;
        if !inside {
            return 0.0;
        }
        let push = m.stiffness * self.stiffness * depth + m.damping * self.damping * side * r.velocity;
        if push > 0.0 { -m.gain * side * push } else { 0.0 }
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let depth = (self.side() * (angle - self.angle)).max(0.0);
        Some(0.5 * self.stiffness * depth * depth)
    }
}

/// Two walls that leave a range between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stops {
    /// The smallest free angle, radians.
    pub low: f64,
    /// The largest, radians.
    pub high: f64,
    /// K, N m/rad.
    pub stiffness: f64,
    /// B, N m s/rad.
    pub damping: f64,
}

impl Stops {
    fn walls(&self) -> [Wall; 2] {
        let Self { low, high, stiffness, damping } = *self;
        [
            Wall { angle: low, below: true, stiffness, damping },
            Wall { angle: high, below: false, stiffness, damping },
        ]
    }
}

impl Effect for Stops {
    type State = [State; 2];

    fn check(&self) -> Result<(), Fault> {
        let [low, high] = self.walls();
        low.check()?;
        high.check()?;
        check("high", self.high, Limit::Least(self.low))
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.stiffness, damping: self.damping }
    }

    #[inline(always)]
    fn torque(&self, state: &mut [State; 2], r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
        let [low, high] = self.walls();
        low.torque(&mut state[0], r, m, events) + high.torque(&mut state[1], r, m, events)
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let [low, high] = self.walls();
        Some(low.energy(angle)? + high.energy(angle)?)
    }
}
