//! The most that may leave eight channels, where that is less than full scale.
//!
//! A channel is lifted by as much before the limiter as it is lowered by behind the band limit, so the limiter limits at full scale as
//! ever, which then is that level. What it does to a channel at a level of a half is what it does at full scale to a signal twice as large.
//!
//! A level that comes down over what is louder would meet the limiter unprepared, crest by crest. What was played lately is known, so the
//! limiter is told beforehand what it will need on the way: see [`Ceiling::foresee`].

use super::Row;
use super::loops::SILENCE;
use crate::dsp::lanes::LANES;

/// Engine samples in which a level glides to where it is told while something sounds: 100 ms, about.
const GLIDE: u32 = 800;

/// Nothing is lowered.
const FULL: Row = [1.0; LANES];

/// The levels of eight channels.
#[derive(Debug)]
pub(super) struct Ceiling {
    level: Row,
    /// One over the level, and where it goes to.
    lift: Row,
    target: Row,
    /// Factor of each sample on the way, and how many are left.
    pace: Row,
    left: u32,
    /// Nothing goes beyond this.
    most: Row,
    /// The largest magnitudes that were played lately where a level comes down, else 0; and what the limiter needed, times the level.
    lately: Row,
    needed: Row,
}

/// The largest number in single precision that is no larger than a level, so that what keeps to the one keeps to the other.
pub(in crate::engine) fn single(level: f64) -> f32 {
    let near = level as f32;
    if f64::from(near) > level { near.next_down() } else { near }
}

impl Ceiling {
    /// At these levels, each above 0; `None` where all are full scale.
    pub fn new(level: Row) -> Option<Self> {
        let lift = level.map(|level| 1.0 / level);
        (level != FULL).then_some(Self {
            level,
            lift,
            target: level,
            pace: FULL,
            left: 0,
            most: level,
            lately: SILENCE,
            needed: SILENCE,
        })
    }

    /// Goes to other levels: at once, or gliding where something sounds.
    pub fn go(this: &mut Option<Self>, target: Row, sounds: bool) {
        let (level, goal) = this.as_ref().map_or((FULL, FULL), |ceiling| (ceiling.level, ceiling.target));
        if goal == target {
            return;
        }
        if !sounds {
            *this = Self::new(target);
            return;
        }
        *this = Some(Self::gliding(level, level, target));
    }

    /// From levels, below a most, to others.
    fn gliding(level: Row, most: Row, target: Row) -> Self {
        let pace =
            |l: usize| (f64::from(target[l]) / f64::from(level[l])).powf(1.0 / f64::from(GLIDE)) as f32;
        Self {
            level,
            lift: FULL,
            target,
            pace: std::array::from_fn(pace),
            left: GLIDE,
            most: std::array::from_fn(|l| most[l].max(target[l])),
            lately: SILENCE,
            needed: SILENCE,
        }
    }

    /// At the beginning of a glide: the largest magnitudes that were played lately, and what the limiter needs.
    pub fn prepare(this: &mut Option<Self>, lately: &Row, need: &Row) {
        let Some(this) = this.as_mut().filter(|ceiling| ceiling.left > 0) else { return };
        for l in 0..LANES {
            let falls = this.target[l] < this.level[l];
            this.lately[l] = if falls { lately[l] } else { 0.0 };
            this.needed[l] = if falls { need[l] * this.level[l] } else { 0.0 };
        }
    }

    /// What the limiter needs at the samples to come for what was played lately, if that goes on, where a constant input of 1 needs `unit`:
    /// as many of `needs`; none where no level comes down.
    #[inline(always)]
    pub fn foresee<'a>(&self, unit: f32, needs: &'a mut [Row]) -> &'a [Row] {
        if self.left == 0 || (self.lately == SILENCE && self.needed == SILENCE) {
            return &[];
        }
        let mut level = self.level;
        for row in &mut *needs {
            for l in 0..LANES {
                level[l] *= self.pace[l];
                row[l] = (self.lately[l] * unit).max(self.needed[l]) / level[l];
            }
        }
        needs
    }

    /// Goes to its own levels from those of another, in the lanes that are kept of that; the others are at theirs.
    pub fn follow(this: &mut Option<Self>, old: &Option<Self>, kept: impl Fn(usize) -> bool) {
        let target = this.as_ref().map_or(FULL, |ceiling| ceiling.target);
        let (from, most) = old.as_ref().map_or((FULL, FULL), |ceiling| (ceiling.level, ceiling.most));
        let of = |row: Row| std::array::from_fn(|l| if kept(l) { row[l] } else { target[l] });
        let (level, most): (Row, Row) = (of(from), of(most));
        *this = if level == target { Self::new(target) } else { Some(Self::gliding(level, most, target)) };
    }

    /// Ends a glide.
    pub fn settle(this: &mut Option<Self>) {
        if let Some(target) = this.as_ref().map(|ceiling| ceiling.target) {
            *this = Self::new(target);
        }
    }

    /// Samples after which to [`Ceiling::settle`]; none where it does not glide.
    pub fn glides(&self) -> Option<u32> {
        (self.left > 0).then_some(self.left)
    }

    /// Nothing goes beyond this: the levels, and on the way to others the higher of both.
    pub fn most(&self) -> &Row {
        &self.most
    }

    /// In front of the limiter.
    #[inline(always)]
    pub fn lift(&self, rows: &mut [Row]) {
        if self.left == 0 {
            for row in rows {
                for l in 0..LANES {
                    row[l] *= self.lift[l];
                }
            }
            return;
        }
        let mut level = self.level;
        for row in rows {
            for l in 0..LANES {
                level[l] *= self.pace[l];
                row[l] /= level[l];
            }
        }
    }

    /// Behind the band limit, the same rows; no more of them than it glides for.
    #[inline(always)]
    pub fn lower(&mut self, rows: &mut [Row]) {
        let mut level = self.level;
        self.left = self.left.saturating_sub(rows.len() as u32);
        for row in rows {
            for l in 0..LANES {
                level[l] *= self.pace[l];
                row[l] *= level[l];
            }
        }
        self.level = level;
    }
}

#[cfg(test)]
mod tests {
    use super::{Ceiling, FULL, GLIDE, single};

    #[test]
    fn a_level_is_rounded_downwards() {
        for level in [1.0, 0.5, 0.3, 0.1, 1.0 / 3.0, 0.7, 1e-4] {
            let near = single(level);
            assert!(f64::from(near) <= level && f64::from(near.next_up()) > level, "{level}: {near}");
        }
    }

    #[test]
    fn what_is_lifted_and_lowered_is_what_it_was_and_a_glide_ends_where_it_should() {
        let mut ceiling = None;
        Ceiling::go(&mut ceiling, FULL, true);
        assert!(ceiling.is_none());
        let to = [1.0, 0.5, 0.3, 1e-4, 1.0, 0.7, 0.9, 0.1];
        Ceiling::go(&mut ceiling, to, true);
        let mut done = 0;
        for step in [1, 7, 128, 128, 128, 128, 128, 152] {
            let at = ceiling.as_mut().unwrap();
            assert_eq!(at.glides(), Some(GLIDE - done));
            assert_eq!(*at.most(), FULL, "the higher of both");
            let mut rows = vec![[0.25; 8]; step];
            at.lift(&mut rows);
            at.lower(&mut rows);
            assert!(rows.iter().flatten().all(|x| (x - 0.25).abs() < 1e-7), "{rows:?}");
            done += step as u32;
        }
        let at = ceiling.as_ref().unwrap();
        assert_eq!(at.glides(), None);
        for (level, to) in at.level.iter().zip(to) {
            assert!((level / to - 1.0).abs() < 1e-4, "{level} {to}");
        }
        Ceiling::settle(&mut ceiling);
        assert_eq!(*ceiling.as_ref().unwrap().most(), to);
        // Back at full scale there is nothing to do any more.
        Ceiling::go(&mut ceiling, FULL, false);
        assert!(ceiling.is_none());
    }
}
