//! Where a point was, and where it is about to be.

use super::super::point::{Point, dot, minus};

/// Samples that are kept: as far back as a low pass reaches.
const KEPT: usize = 5;
/// In engine samples of 8 kHz this is some 100 m/s: what goes further at once has jumped.
const JUMP: f64 = 0.0125;

/// The last positions of a point that is given one with every engine sample.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trail {
    /// The newest first.
    points: [Point; KEPT],
    /// How the next differs: the last step, and how it changed. None of it after a jump.
    step: Point,
    change: Point,
    third: Point,
    begun: bool,
    smooth: bool,
}

impl Trail {
    /// The next position, m.
    pub fn push(&mut self, point: Point) {
        if !std::mem::replace(&mut self.begun, true) {
            self.points = [point; KEPT];
        }
        self.points.rotate_right(1);
        self.points[0] = point;
        let [now, before, earlier, first, ..] = self.points;
        let (step, last) = (minus(now, before), minus(before, earlier));
        let (change, past) = (minus(step, last), minus(last, minus(earlier, first)));
        let third = minus(change, past);
        let gone = square(step);
        let moves = gone <= JUMP * JUMP;
        // What turns more than that has a corner, and is no arc.
        let bends = moves && square(change) <= 0.0625 * gone;
        self.smooth = bends && square(third) <= 0.0025 * gone;
        self.step = if moves { step } else { [0.0; 3] };
        self.change = if bends { change } else { [0.0; 3] };
        self.third = if self.smooth { third } else { [0.0; 3] };
    }

    /// Where it is so many engine samples from now, within ±4: on the cubic through its last four positions where it goes smoothly. Where it does not, straight between
    /// them, and ahead as it went last; after a jump it stays.
    #[inline(always)]
    pub fn at(&self, samples: f64) -> Point {
        if self.smooth || samples >= 0.0 {
            let bend = 0.5 * samples * (samples + 1.0);
            let twist = bend * (samples + 2.0) / 3.0;
            let gone = |k: usize| samples * self.step[k] + bend * self.change[k] + twist * self.third[k];
            return [0, 1, 2].map(|k| self.points[0][k] + gone(k));
        }
        let back = (-samples).min((KEPT - 1) as f64);
        let whole = (back as usize).min(KEPT - 2);
        let share = back - whole as f64;
        let (near, far) = (self.points[whole], self.points[whole + 1]);
        [0, 1, 2].map(|k| near[k] + share * (far[k] - near[k]))
    }
}

fn square(way: Point) -> f64 {
    dot(way, way)
}
