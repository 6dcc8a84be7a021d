//! The envelope of a few legs: some on the way to a level, one after the release.

use super::segment::{Script, Segment};
use crate::dsp::lanes::LANES;

/// The longest time of an envelope, s.
pub const LONGEST: f64 = 1e6;

/// The largest curve.
pub const CURVIEST: f64 = 20.0;

/// One leg: to a value, in a time.
#[derive(Debug, Clone, Copy, Default)]
pub struct Leg {
    /// Value at its end.
    pub to: f64,
    /// Length.
    pub seconds: f64,
    /// See [`Segment::ramp`].
    pub curve: f64,
}

/// Up to three legs from 0 on; then, where there is a release, the last value holds until it comes.
#[derive(Debug, Clone, Copy, Default)]
pub struct Legs {
    /// From the onset on. Where the third ends at 0, so does the envelope: nothing could follow.
    pub first: [Leg; 3],
    /// From wherever the value is at the release. Without one, the envelope ends after the third leg.
    pub release: Option<Leg>,
}

/// The legs of a group of lanes, as a script for a [`super::segment::Track`].
#[derive(Debug, Clone)]
pub struct LegScript {
    rate: f64,
    legs: [Legs; LANES],
    at: [usize; LANES],
}

/// Places in the course of the legs: 0 to 2 the first ones, then these.
const HOLD: usize = 3;
const RELEASE: usize = 4;
const END: usize = 5;

impl LegScript {
    /// For samples at `rate`.
    pub fn new(rate: f64) -> Self {
        Self { rate, legs: [Legs::default(); LANES], at: [END; LANES] }
    }
    /// A voice begins.
    pub fn start(&mut self, lane: usize, legs: Legs) {
        self.legs[lane] = legs;
        self.at[lane] = 0;
    }
    /// A voice that was not released yet will end as these do; the way until then stays as it is.
    pub fn retune(&mut self, lane: usize, legs: &Legs) {
        if self.at[lane] <= RELEASE {
            self.legs[lane].release = legs.release;
        }
    }
    /// Makes the release what comes next; `false` where there is none or it has been.
    pub fn release(&mut self, lane: usize) -> bool {
        let can = self.legs[lane].release.is_some() && self.at[lane] <= RELEASE;
        if can {
            self.at[lane] = RELEASE;
        }
        can
    }
    fn ramp(&self, from: f64, leg: Leg) -> Segment {
        Segment::ramp(from, leg.to, leg.seconds, leg.curve, self.rate)
    }
}

impl Script for LegScript {
    fn next(&mut self, lane: usize, value: f64) -> Segment {
        let (legs, at) = (self.legs[lane], self.at[lane]);
        self.at[lane] = (at + 1).min(END);
        match at {
            0..HOLD => {
                // The value a segment ends at is rounded; the leg's own is not.
                let from = if at == 0 { value } else { legs.first[at - 1].to };
                self.ramp(from, legs.first[at])
            }
            HOLD if legs.release.is_some() && legs.first[HOLD - 1].to != 0.0 => {
                Segment::hold(legs.first[HOLD - 1].to, f64::INFINITY)
            }
            RELEASE => match legs.release {
                Some(leg) => self.ramp(value, leg),
                None => Segment::end(),
            },
            _ => {
                self.at[lane] = END;
                Segment::end()
            }
        }
    }
}

/// `value` within a range; the nearest to 0 in it where it is not a number.
pub fn within(value: f64, least: f64, most: f64) -> f64 {
    if value.is_nan() { 0.0_f64.clamp(least, most) } else { value.clamp(least, most) }
}
