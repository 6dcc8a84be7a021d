//! Sine and cosine into an angle that goes on over whole turns.
//!
//! The channels of a real pair have offsets, unequal gains, and are not quite a quarter of a turn apart:
//! s = o_s + A_s sin(φ + ε), c = o_c + A_c cos φ. Taken back, sin φ = ((s − o_s)/A_s − sin ε cos φ)/cos ε. Uncorrected, an offset of 1 %
//! makes 0.01 rad once a turn of the pair; gains that differ by 1 %, 0.005 rad twice a turn; ε of 0.01, 0.005 rad twice.

use super::turn::{angle, shortest};
use crate::actuator::elementary::{cosine, sine};
use crate::actuator::fault::{Fault, check, positive, within};
use std::f64::consts::{PI, TAU};

/// The pair is lost where its length leaves these, as shares of what it should be.
pub const LENGTHS: [f64; 2] = [0.5, 2.0];
/// A step beyond this might as well have gone the other way round, rad of the pair: half a turn, and a quarter of that for what noise and
/// a knob that speeds up may add.
pub const MOST_STEP: f64 = 0.75 * PI;

/// What a pair is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// What sine and cosine are at their middles.
    pub offset: [f64; 2],
    /// Amplitudes of sine and cosine.
    pub gain: [f64; 2],
    /// By how much the sine leads a quarter of a turn, ε, rad, within ±1.
    pub phase: f64,
    /// Turns of the pair for each turn of the knob, 1 or more.
    pub turns: u32,
}

impl Pair {
    /// Without an error, of an amplitude.
    pub fn of(amplitude: f64, turns: u32) -> Self {
        Self { offset: [0.0; 2], gain: [amplitude; 2], phase: 0.0, turns }
    }
}

/// Unwraps the angle of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolver {
    offset: [f64; 2],
    /// 1 / A.
    scale: [f64; 2],
    sin_phase: f64,
    per_cos_phase: f64,
    per_turns: f64,
    /// The last angle of the pair, and its whole turns.
    last: Option<f64>,
    whole: i64,
    lost: u64,
}

impl Resolver {
    /// For a pair.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(pair: &Pair) -> Result<Self, Fault> {
        for (offset, gain) in pair.offset.into_iter().zip(pair.gain) {
            positive("gain", gain)?;
            within("offset", offset, (-1e6, 1e6), "")?;
        }
        within("phase", pair.phase, (-1.0, 1.0), "rad")?;
        check("turns", f64::from(pair.turns), crate::actuator::fault::Limit::Least(1.0))?;
        Ok(Self {
            offset: pair.offset,
            scale: pair.gain.map(|gain| 1.0 / gain),
            sin_phase: sine(pair.phase / TAU),
            per_cos_phase: 1.0 / cosine(pair.phase / TAU),
            per_turns: 1.0 / f64::from(pair.turns),
            last: None,
            whole: 0,
            lost: 0,
        })
    }

    /// Sine and cosine of the pair as they should be.
    fn pair(&self, sine: f64, cosine: f64) -> [f64; 2] {
        let x = (cosine - self.offset[1]) * self.scale[1];
        let y = ((sine - self.offset[0]) * self.scale[0] - self.sin_phase * x) * self.per_cos_phase;
        [y, x]
    }

    /// Whether the pair is as long as it should be, within [`LENGTHS`].
    #[inline]
    pub fn is_whole(&self, sine: f64, cosine: f64) -> bool {
        let [y, x] = self.pair(sine, cosine);
        (LENGTHS[0] * LENGTHS[0]..=LENGTHS[1] * LENGTHS[1]).contains(&(x * x + y * y))
    }

    /// Sine and cosine of this frame; the angle of the knob, rad, `None` where it is lost: the pair is too short or too long, or not a number,
    /// or the step is beyond [`MOST_STEP`]. It begins within a half of the pair's turn. After a loss the turn is taken that is nearest
    /// to the last known angle.
    #[inline]
    pub fn push(&mut self, sine: f64, cosine: f64) -> Option<f64> {
        if !self.is_whole(sine, cosine) {
            self.lost += 1;
            return None;
        }
        let [y, x] = self.pair(sine, cosine);
        let now = angle(y, x);
        let last = self.last.unwrap_or(now);
        let step = shortest(now, last);
        let crossed = (last + step - now) / TAU;
        self.whole = self.whole.saturating_add(crossed.round() as i64);
        self.last = Some(now);
        if step.abs() > MOST_STEP {
            self.lost += 1;
            return None;
        }
        Some((now + TAU * self.whole as f64) * self.per_turns)
    }

    /// In how many frames it was lost.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Forgets all whole turns: the next angle is within a half of the pair's turn again.
    pub fn reset(&mut self) {
        (self.last, self.whole) = (None, 0);
    }
}
