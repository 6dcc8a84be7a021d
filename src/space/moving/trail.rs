//! Where a point was that is given its positions one by one.

use super::super::array::tile::STRETCH;
use super::super::point::{Point, dot, minus};
use super::SEEN;

/// Engine samples by which a trail is later than its positions: as many as a low pass looks ahead, and one more, so that every instant lies between known
/// positions, the same whichever sample looks at it.
pub const LATE: i64 = SEEN + 1;
/// Positions kept before those of a stretch: as far back as a low pass reaches from the first, and one more.
const KEPT: usize = (LATE + SEEN + 1) as usize;
/// In engine samples of 8 kHz this is some 100 m/s: what goes further at once has jumped.
const JUMP: f64 = 0.0125;

/// The last positions of a point that is given one with every engine sample, by axis, the newest last.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trail {
    last: [[f64; KEPT]; 3],
    begun: bool,
}

/// The positions of a stretch, and those before them, by axis.
#[derive(Debug, Clone, Copy)]
pub struct Steps {
    axes: [[f64; KEPT + STRETCH]; 3],
    samples: usize,
}

impl Trail {
    /// Takes as many positions as `samples`, which is at most a stretch: `fill` writes those of an axis (m). For the audio thread.
    #[inline(always)]
    pub fn take(&mut self, samples: usize, mut fill: impl FnMut(usize, &mut [f64])) -> Steps {
        let samples = samples.min(STRETCH);
        let mut axes = [[0.0; KEPT + STRETCH]; 3];
        for (axis, points) in axes.iter_mut().enumerate() {
            let (before, told) = points.split_at_mut(KEPT);
            fill(axis, &mut told[..samples]);
            let last = &mut self.last[axis];
            if !self.begun {
                *last = [told[0]; KEPT];
            }
            before.copy_from_slice(last);
            last.copy_from_slice(&points[samples..samples + KEPT]);
        }
        self.begun = true;
        Steps { axes, samples }
    }
}

impl Steps {
    /// Where the point is so many whole samples and a share of one from one sample of the stretch, within ±[`SEEN`]; that is where it was told to be
    /// [`LATE`] samples earlier. On the cubic through the two positions before and the two after where it goes smoothly, straight between its neighbours where it does
    /// not, and at the nearer one where it jumps.
    #[inline(always)]
    pub fn at(&self, sample: usize, whole: i64, share: f64) -> Point {
        let index = ((KEPT + sample) as i64 + whole - LATE).max(1) as usize;
        let [x, y, z] = &self.axes;
        if share == 0.0 {
            return match (x.get(index), y.get(index), z.get(index)) {
                (Some(x), Some(y), Some(z)) => [*x, *y, *z],
                _ => [0.0; 3],
            };
        }
        let along = |axis: &[f64; KEPT + STRETCH]| match axis.get(index - 1..) {
            Some([a, b, c, d, ..]) => [*a, *b, *c, *d],
            _ => [0.0; 4],
        };
        let ([a, b, c, d], [e, f, g, h], [i, j, k, l]) = (along(x), along(y), along(z));
        between([[a, e, i], [b, f, j], [c, g, k], [d, h, l]], share)
    }

    /// Where it is by axis, from [`SEEN`] samples before the first of the stretch to as many after its last.
    #[inline(always)]
    pub(super) fn told(&self) -> [&[f64]; 3] {
        let from = |axis: usize| &self.axes[axis][KEPT - (LATE + SEEN) as usize..];
        [from(0), from(1), from(2)]
    }

    /// Whether each step differs by less than that from the one before, in squares.
    #[inline(always)]
    pub(super) fn bends_less(&self, most: f64) -> bool {
        let mut all = true;
        let [x, y, z] = self.told();
        for k in 1..self.samples + 2 * SEEN as usize - 1 {
            let change = |axis: &[f64]| axis[k + 1] - 2.0 * axis[k] + axis[k - 1];
            all &= square([change(x), change(y), change(z)]) <= most;
        }
        all
    }
}

/// Between the middle two of four positions.
#[inline(always)]
fn between([first, near, far, last]: [Point; 4], share: f64) -> Point {
    let steps = [minus(near, first), minus(far, near), minus(last, far)];
    let gone = steps.map(square);
    if gone[1] > JUMP * JUMP {
        return if share < 0.5 { near } else { far };
    }
    let changes = [minus(steps[1], steps[0]), minus(steps[2], steps[1])];
    let third = minus(changes[1], changes[0]);
    // Newton's form: through the middle two, the first, and the last.
    let bend = 0.5 * share * (share - 1.0);
    let twist = if square(third) <= 0.0025 * gone[0].max(gone[1]).max(gone[2]) {
        [bend, bend * (share + 1.0) / 3.0]
    } else {
        [0.0; 2]
    };
    let at = |k: usize| near[k] + share * steps[1][k] + twist[0] * changes[0][k] + twist[1] * third[k];
    [at(0), at(1), at(2)]
}

fn square(way: Point) -> f64 {
    dot(way, way)
}
