//! Many samples at once, of a point that mostly stays in one piece of an array.

use std::ops::Range;

use super::super::array::tile::{Form, Formed, Rectangle, STRETCH, Segment, Tile, Triangle};
use super::super::law::Law;
use super::super::path::Path;
use super::super::point::Point;

use super::way::stays;
use super::{Mover, SEEN};

/// Samples before and after each that are looked at.
const AROUND: usize = SEEN as usize;

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

/// Coordinates by axis and sample, m.
type Points = [[f64; STRETCH]; 3];
/// The same with what is before the first and after the last.
pub(super) type Course = [[f64; STRETCH + 2 * AROUND]; 3];

/// Where a point is over some samples, and shortly before and after each of them.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub(super) before: Points,
    pub(super) here: Points,
    pub(super) after: Points,
    /// All of them in a row, where they go straight on at one speed; then there is no corner in them.
    course: Course,
    pub(super) straight: bool,
    /// The gains at the corners of the piece.
    gains: [[f64; STRETCH]; 4],
}

impl Default for Stretch {
    fn default() -> Self {
        let nothing = [[0.0; STRETCH]; 3];
        let course = [[0.0; STRETCH + 2 * AROUND]; 3];
        let gains = [[0.0; STRETCH]; 4];
        Self { before: nothing, here: nothing, after: nothing, course, straight: false, gains }
    }
}

impl Stretch {
    #[inline(always)]
    fn point(of: &Points, sample: usize) -> Point {
        [of[0][sample], of[1][sample], of[2][sample]]
    }

    /// A bit for each sample that a piece holds, with some before it and after, and that does not rest.
    #[inline(always)]
    fn held<F: Formed>(&self, tile: &Tile, spacing: f64) -> u32 {
        if self.straight && spacing > COARSE_ENOUGH {
            return self.held_straight::<F>(tile);
        }
        let mut held = [0_u32; STRETCH];
        for k in 0..STRETCH {
            let here = Self::point(&self.here, k);
            let ends = [Self::point(&self.before, k), Self::point(&self.after, k)];
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

impl Mover {
    /// Samples that a stretch holds.
    pub const STRETCH: usize = STRETCH;

    /// Takes a stretch of a point that goes along a path: at its first sample `age` samples old, each of which is `pace` seconds of the path, found
    /// on a piece of it shortly before. The same as where [`Path::follow`] has it, to the bit. For the audio thread.
    #[inline(always)]
    pub fn take(&mut self, path: &Path, age: Age, pace: f64, piece: &mut usize) {
        let mut seconds = [0.0; STRETCH + 2 * AROUND];
        for (k, seconds) in seconds.iter_mut().enumerate() {
            *seconds = age.after(k as i32 - SEEN as i32) * pace;
        }
        let mut course = [[0.0; STRETCH + 2 * AROUND]; 3];
        let straight = path.trace(&seconds, piece, &mut course);
        self.fill(&course, straight);
    }

    /// Takes a stretch, and what is around it, by coordinate; whether it goes straight on at one speed.
    #[inline(always)]
    pub(super) fn fill(&mut self, course: &Course, straight: bool) {
        let stretch = &mut *self.stretch;
        for (axis, way) in course.iter().enumerate() {
            stretch.before[axis].copy_from_slice(&way[..STRETCH]);
            stretch.here[axis].copy_from_slice(&way[AROUND..][..STRETCH]);
            stretch.after[axis].copy_from_slice(&way[2 * AROUND..]);
        }
        stretch.straight = straight;
        if straight {
            stretch.course = *course;
        }
    }

    /// Takes one sample of a stretch: where the point is [`SEEN`] samples before it, then, and as many after it. For the audio thread.
    #[inline(always)]
    pub fn set(&mut self, sample: usize, [before, here, after]: [Point; 3]) {
        if sample < STRETCH {
            let stretch = &mut *self.stretch;
            stretch.straight = false;
            for axis in 0..3 {
                stretch.before[axis][sample] = before[axis];
                stretch.here[axis][sample] = here[axis];
                stretch.after[axis][sample] = after[axis];
            }
        }
    }

    /// Whether the point rests at one place through the first samples of a stretch.
    #[inline]
    pub fn rests(&self, samples: usize) -> bool {
        let Stretch { before, here, after, .. } = &*self.stretch;
        [before, here, after].into_iter().all(|points| {
            points.iter().zip(here).all(|(axis, here)| axis.iter().take(samples).all(|x| *x == here[0]))
        })
    }

    /// A bit for each sample of a stretch, the lowest for its first, of which [`Mover::glide`] can tell the gains: all those well within the piece of the array
    /// in which the point was found last.
    #[inline(always)]
    pub fn held(&self, law: Law, piece: u32) -> u32 {
        let Some(tile) = self.tile(0.0, law, piece) else { return 0 };
        let spacing = self.spread.array().spacing();
        match tile.form {
            Form::Segment => self.stretch.held::<Segment>(&tile, spacing),
            Form::Triangle => self.stretch.held::<Triangle>(&tile, spacing),
            Form::Rectangle => self.stretch.held::<Rectangle>(&tile, spacing),
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
        let tile = self.tile(0.0, law, piece);
        let Self { stretch, spread, .. } = self;
        let Stretch { here, gains, .. } = &mut **stretch;
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
