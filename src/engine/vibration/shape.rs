//! What shapes eight channels before the limiter: the high-pass that keeps steady voltages off, and a section of the equaliser.

use super::Row;
use super::loops::SILENCE;
use crate::dsp::biquad::Biquad;
use crate::dsp::blocker::Blocker;
use crate::dsp::lanes::LANES;

/// One lane of rows changes places with that of others.
pub(super) fn swap_lane<'a>(
    one: impl IntoIterator<Item = &'a mut Row>,
    other: impl IntoIterator<Item = &'a mut Row>,
    lane: usize,
) {
    one.into_iter().zip(other).for_each(|(one, other)| std::mem::swap(&mut one[lane], &mut other[lane]));
}

/// One lane of rows becomes that of others.
pub(super) fn copy_lane<'a>(
    one: impl IntoIterator<Item = &'a mut Row>,
    other: impl IntoIterator<Item = &'a Row>,
    lane: usize,
) {
    one.into_iter().zip(other).for_each(|(one, other)| one[lane] = other[lane]);
}

/// An equaliser's section on eight lanes.
#[derive(Debug)]
pub(super) struct Bell {
    b: [Row; 3],
    a: [Row; 2],
    state: [Row; 2],
}

impl Bell {
    /// Of each lane's section.
    pub fn new(section: impl Fn(usize) -> Biquad) -> Self {
        Self {
            b: std::array::from_fn(|k| std::array::from_fn(|l| section(l).b[k] as f32)),
            a: std::array::from_fn(|k| std::array::from_fn(|l| section(l).a[k] as f32)),
            state: [SILENCE; 2],
        }
    }

    #[inline(always)]
    pub fn run(&mut self, rows: &mut [Row]) {
        let [mut first, mut second] = self.state;
        for row in rows {
            for l in 0..LANES {
                let x = row[l];
                let y = self.b[0][l] * x + first[l];
                first[l] = self.b[1][l] * x - self.a[0][l] * y + second[l];
                second[l] = self.b[2][l] * x - self.a[1][l] * y;
                row[l] = y;
            }
        }
        self.state = [first, second];
    }

    /// Whether nothing of a lane is left that is as large as `least`.
    pub fn is_dead(&self, lane: usize, least: f32) -> bool {
        self.state.iter().all(|row| row[lane].abs() < least)
    }

    pub fn rest(&mut self, lane: usize) {
        self.state.iter_mut().for_each(|row| row[lane] = 0.0);
    }

    /// What a lane holds changes places with what it holds in another.
    pub fn swap(&mut self, other: &mut Self, lane: usize) {
        swap_lane(&mut self.state, &mut other.state, lane);
    }
}

/// The high-pass on eight lanes. The mean is kept in 64 bits: it moves by 1/1300 of what is left of a step at each sample, which single
/// precision rounds away 90 dB below it.
#[derive(Debug)]
pub(super) struct Block {
    keep: [f64; LANES],
    pull: [f64; LANES],
    mean: [f64; LANES],
}

impl Block {
    /// For the lanes of which it is said; `None` where there is none.
    pub fn new(blocker: Blocker, on: impl Fn(usize) -> bool) -> Option<Self> {
        let of = |lane, value, none| if on(lane) { value } else { none };
        (0..LANES).any(&on).then(|| Self {
            keep: std::array::from_fn(|l| of(l, blocker.keep, 1.0)),
            pull: std::array::from_fn(|l| of(l, blocker.pull, 0.0)),
            mean: [0.0; LANES],
        })
    }

    #[inline(always)]
    pub fn run(&mut self, rows: &mut [Row]) {
        let mut mean = self.mean;
        for row in rows {
            for l in 0..LANES {
                let apart = f64::from(row[l]) - mean[l];
                mean[l] += self.pull[l] * apart;
                row[l] = (self.keep[l] * apart) as f32;
            }
        }
        self.mean = mean;
    }

    /// Whether nothing of a lane is left that is as large as `least`.
    pub fn is_dead(&self, lane: usize, least: f32) -> bool {
        self.mean[lane].abs() < f64::from(least)
    }

    pub fn rest(&mut self, lane: usize) {
        self.mean[lane] = 0.0;
    }

    /// What a lane holds changes places with what it holds in another.
    pub fn swap(&mut self, other: &mut Self, lane: usize) {
        std::mem::swap(&mut self.mean[lane], &mut other.mean[lane]);
    }

    /// The mean of a lane is taken to be what it is in another, where both have one.
    pub fn follow(&mut self, other: &Self, lane: usize) {
        if self.pull[lane] != 0.0 && other.pull[lane] != 0.0 {
            self.mean[lane] = other.mean[lane];
        }
    }
}
