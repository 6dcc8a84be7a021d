//! Snap: a spring to the nearest of equal places, which changes over late.
//!
//! Up to the snap point the spring pulls back; past it the next place pulls on. A change of place can only take energy: the spring to the next
//! place is stretched less than the one to the last.

use super::events::{Events, What};
use super::{Bound, Effect, Modulation, Reading, nearest};
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::knob::order::{larger, smaller};

/// Places with hysteresis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snap {
    /// From place to place, radians.
    pub width: f64,
    /// K of the spring, N m/rad.
    pub stiffness: f64,
    /// The largest torque of the spring, N m.
    pub most: f64,
    /// How many widths from its place the knob snaps to the next: 0.5 (no hysteresis) to 1.
    pub point: f64,
    /// One of the places, radians.
    pub centre: f64,
}

/// The place that holds the knob.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    place: Option<f64>,
}

impl Effect for Snap {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        positive("width", self.width)?;
        not_negative("stiffness", self.stiffness)?;
        positive("most", self.most)?;
        check("point", self.point, Limit::Within(0.5, 1.0, "widths"))?;
        check("centre", self.centre, Limit::Least(f64::MIN))
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.stiffness, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
        let at = (r.angle - self.centre) / self.width;
        let mut place = state.place.unwrap_or(nearest(at));
        if (at - place).abs() > self.point {
            let next = nearest(at);
            if next != place {
                events.push(What::Detent { index: next as i64, passed: (next - place) as i64 });
            }
            place = next;
        }
        state.place = Some(place);
        let pull = -m.stiffness * self.stiffness * (at - place) * self.width;
        m.gain * smaller(self.most, larger(-self.most, pull))
    }
}
