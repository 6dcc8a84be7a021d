//! Many samples at once, of a point that mostly stays in one piece of an array.

use std::ops::Range;

use super::super::array::tile::{Form, Formed, Rectangle, STRETCH, Segment, Tile, Triangle};
use super::super::law::Law;
use super::super::path::Path;
use super::super::point::Point;

use super::way::stays;
use super::{Mover, SEEN, Steps};

/// Samples before and after each that are looked at.
const AROUND: usize = SEEN as usize;

/// In place of a stretch that is not there.
const NOWHERE: [f64; STRETCH] = [0.0; STRETCH];

/// Tactors farther apart than this, m, see no corner in what rounding makes of a straight way.
const COARSE_ENOUGH: f64 = 1e-4;

/// How old a point is at an engine sample: whole samples, and a share of one.
#[derive(Debug, Clone, Copy)]
pub struct Age {
    /// Whole ones, up to 2^52.
    pub samples: i64,
    /// What is taken off them, as it was.
    pub less: [f64; 2],
}

impl Age {
    /// So many samples later.
    #[inline(always)]
    pub fn after(self, samples: i32) -> f64 {
        // Whole numbers of that size add up exactly, so that this is the age at that sample, to the bit.
        self.samples as f64 + f64::from(samples) - self.less[0] - self.less[1]
    }
}

/// Coordinates by axis (m) of the samples, of what is before the first, and of what is after the last.
pub(super) type Course = [[f64; STRETCH + 2 * AROUND]; 3];

/// Where a point is over some samples, and shortly before and after each of them.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub(super) course: Course,
    /// Whether it goes so straight on that there is no corner in it.
    pub(super) straight: bool,
    /// The gains at the corners of the piece.
    gains: [[f64; STRETCH]; 4],
}

impl Default for Stretch {
    fn default() -> Self {
        Self { course: [[0.0; STRETCH + 2 * AROUND]; 3], straight: false, gains: [[0.0; STRETCH]; 4] }
    }
}

impl Stretch {
    /// Where it is at a sample, so many of them later; the first is `AROUND` before the first of the stretch.
    #[inline(always)]
    fn point(&self, instant: usize) -> Point {
        let [x, y, z] = &self.course;
        [x[instant], y[instant], z[instant]]
    }

    /// A bit for each sample that a piece holds, with some before it and after, and that does not rest.
    #[inline(always)]
    fn held<F: Formed>(&self, tile: &Tile, spacing: f64) -> u32 {
        if self.straight && spacing > COARSE_ENOUGH {
            return self.held_straight::<F>(tile);
        }
        let mut held = [0_u32; STRETCH];
        for k in 0..STRETCH {
            let here = self.point(k + AROUND);
            let ends = [self.point(k), self.point(k + 2 * AROUND)];
            let rests = (ends[0] == here) & (ends[1] == here);
            held[k] = u32::from(stays::<F>(tile, ends, here, spacing) & !rests) << k;
        }
        held.iter().fold(0, |all, bit| all | bit)
    }
}

impl Stretch {
    /// The same where there is no corner: each instant is looked at once.
    #[inline(always)]
    fn held_straight<F: Formed>(&self, tile: &Tile) -> u32 {
        let [x, y, z] = &self.course;
        let (mut inside, mut moves) = ([0_u64; STRETCH + 2 * AROUND], [0_u64; STRETCH + AROUND]);
        for k in 0..inside.len() {
            inside[k] = u64::from(tile.holds::<F>([x[k], y[k], z[k]])) << k;
        }
        for k in 0..moves.len() {
            let after = k + AROUND;
            moves[k] = u64::from((x[k] != x[after]) | (y[k] != y[after]) | (z[k] != z[after])) << k;
        }
        let [inside, moves] = [&inside[..], &moves].map(|bits| bits.iter().fold(0, |all, bit| all | bit));
        (inside & (inside >> AROUND) & (inside >> (2 * AROUND)) & (moves | (moves >> AROUND))) as u32
    }
}

/// When a stretch, and what is around it, is on a path.
#[inline(always)]
fn instants(age: Age, pace: f64) -> [f64; STRETCH + 2 * AROUND] {
    std::array::from_fn(|k| age.after(k as i32 - SEEN as i32) * pace)
}

impl Mover {
    /// Samples that a stretch holds.
    pub const STRETCH: usize = STRETCH;

    /// Takes a stretch of a point that goes along a path: at its first sample `age` samples old, each of which is `pace` seconds of the path, found
    /// on a piece of it shortly before. The same as where [`Path::follow`] has it, to the bit. For the audio thread.
    #[inline(always)]
    pub fn take(&mut self, path: &Path, age: Age, pace: f64, piece: &mut usize) {
        self.stretch.straight = path.trace(&instants(age, pace), piece, &mut self.stretch.course);
    }

    /// Takes a stretch of a point that is told its positions, beside a point that rests, or beside one on a path as [`Mover::take`] has it. For the audio thread.
    #[inline(always)]
    pub fn follow(&mut self, steps: &Steps, beside: (Point, Option<(&Path, Age, f64)>), piece: &mut usize) {
        let (still, route) = beside;
        let spacing = self.spread.array().spacing();
        let Stretch { course, straight, .. } = &mut *self.stretch;
        *straight = true;
        match route {
            Some((path, age, pace)) => *straight = path.trace(&instants(age, pace), piece, course),
            None => *course = still.map(|x| [x; STRETCH + 2 * AROUND]),
        }
        for (to, told) in course.iter_mut().zip(steps.told()) {
            to.iter_mut().zip(told).for_each(|(to, told)| *to += told);
        }
        // Over twice four steps a way turns by sixteen times as much at most; a ten thousandth of the spacing is no corner.
        *straight &= steps.bends_less(0.5e-8 / 256.0 * spacing * spacing);
    }

    /// Whether the point rests at one place through the first samples of a stretch.
    #[inline]
    pub fn rests(&self, samples: usize) -> bool {
        let count = samples + 2 * AROUND;
        self.stretch.course.iter().all(|axis| axis.iter().take(count).all(|x| *x == axis[0]))
    }

    /// A bit for each sample of a stretch, the lowest for its first, of which [`Mover::glide`] can tell the gains: all those well within the piece of the array
    /// in which the point was found last.
    #[inline(always)]
    pub fn held(&self, law: Law, piece: u32) -> u32 {
        let Some(tile) = self.tile(0.0, law, piece) else { return 0 };
        let spacing = self.spread.array().spacing();
        match tile.form {
            Form::Segment => self.stretch.held::<Segment>(tile, spacing),
            Form::Triangle => self.stretch.held::<Triangle>(tile, spacing),
            Form::Rectangle => self.stretch.held::<Rectangle>(tile, spacing),
        }
    }

    /// Each channel that sounds in a range of samples of a stretch, all of which that piece holds: the channel, what hangs there, and its shares by sample.
    /// They are those of [`Mover::gains`], to the bit. For the audio thread.
    #[inline(always)]
    pub fn glide(
        &mut self,
        range: Range<usize>,
        law: Law,
        piece: u32,
    ) -> impl Iterator<Item = (u32, f64, &[f64])> {
        let tile = self.tile(0.0, law, piece).copied();
        let Self { stretch, spread, .. } = self;
        let Stretch { course, gains, .. } = &mut **stretch;
        let here = [0, 1, 2].map(|axis| course[axis][AROUND..].first_chunk().unwrap_or(&NOWHERE));
        if let Some(tile) = &tile {
            match tile.form {
                Form::Segment => tile.fill::<Segment>(here, range.clone(), law, gains),
                Form::Triangle => tile.fill::<Triangle>(here, range.clone(), law, gains),
                Form::Rectangle => tile.fill::<Rectangle>(here, range.clone(), law, gains),
            }
        }
        let (corners, count) = tile.map_or(([0; 4], 0), |tile| (tile.corners, tile.corners().len()));
        let channels = spread.channels();
        corners.into_iter().take(count).zip(gains.iter()).filter_map(move |(tactor, gains)| {
            let (channel, hangs) = *channels.get(tactor as usize)?;
            Some((channel, hangs, gains.get(range.clone())?))
        })
    }
}
