//! Where a controller has been of late: whether somebody moves it.

use std::collections::VecDeque;

/// Seconds within which a movement happens,
const WINDOW: f64 = 2.0;
/// and within which a button is pressed twice.
const PRESSES: f64 = 5.0;
/// So often its position is another than before, at least;
const CHANGES: usize = 4;
/// one of 7 bits is, and the lower half of a pair of 14, which comes by itself, is not;
const CHANGE: f64 = 0.0078;
/// and so far apart they lie, as a share of all it can do. A worn potentiometer that lies on the table wanders by less.
pub const SPAN: f64 = 0.1;
/// Of a way that is so large,
const LARGE: f64 = 0.25;
/// so many steps are enough,
const STEPS: usize = 3;
/// where each is so large.
const STEP: f64 = 0.05;
/// What comes back sooner than this is a spike of a bad contact, seconds.
const SPIKE: f64 = 0.05;
/// Whoever holds a button for so long, seconds, means it; or it stays down, and was pressed twice.
const HELD: f64 = 0.5;
/// Positions that are kept.
const MOST: usize = 256;

/// Positions of one controller over time: whether somebody moves it.
#[derive(Debug, Clone, Default)]
pub struct Travel {
    points: VecDeque<(f64, f64)>,
}

impl Travel {
    /// It stands at `position`, 0 to 1, at so many seconds.
    pub fn comes(&mut self, seconds: f64, position: f64) {
        if !position.is_finite() {
            return;
        }
        let ends = is_end(position) && self.points.iter().all(|(_, position)| is_end(*position));
        let window = if ends { PRESSES } else { WINDOW };
        while self.points.front().is_some_and(|(at, _)| seconds - at > window) || self.points.len() >= MOST {
            self.points.pop_front();
        }
        if self.last() != Some(position) {
            self.points.push_back((seconds, position));
        }
    }

    /// Where it stands.
    pub fn last(&self) -> Option<f64> {
        self.points.back().map(|(_, position)| *position)
    }

    /// How far it went; and how far without the one position that lies furthest off, which may be a spike.
    fn spans(&self) -> (f64, f64) {
        let mut all: Vec<f64> = self.points.iter().map(|(_, position)| *position).collect();
        all.sort_by(f64::total_cmp);
        match all[..] {
            [first, second, .., last_but_one, last] => {
                (last - first, (last - second).min(last_but_one - first))
            }
            [first, .., last] => (last - first, 0.0),
            _ => (0.0, 0.0),
        }
    }

    /// Where it has been, each so far from the one before.
    fn steps(&self, by: f64) -> Vec<(f64, f64)> {
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for point in &self.points {
            if steps.last().is_none_or(|(_, last)| (point.1 - last).abs() >= by) {
                steps.push(*point);
            }
        }
        steps
    }

    /// Whether it has been moved through several positions, that far.
    pub fn is_moved(&self, span: f64) -> bool {
        let (all, without) = self.spans();
        all >= span && without >= 0.5 * span && self.steps(CHANGE).len() >= CHANGES
    }

    /// Whether it has been moved through few positions, and far: one way, or there and back, and no faster than a hand does.
    pub fn is_moved_coarsely(&self) -> bool {
        let steps = self.steps(STEP);
        let Some([a, b, c]) = steps.last_chunk::<STEPS>() else { return false };
        let since = if (b.1 - a.1) * (c.1 - b.1) > 0.0 { a.0 } else { b.0 };
        self.spans().0 >= LARGE && c.0 - since >= SPIKE
    }

    /// Whether it has gone to its upper end and come back to the lower one, no sooner than a button that is pressed by mistake.
    pub fn is_latched(&self) -> bool {
        let mut last = self.points.iter().rev();
        let (Some((to, b)), Some((from, a))) = (last.next(), last.next()) else { return false };
        *a >= 1.0 && *b <= 0.0 && to - from >= HELD
    }

    /// Whether it has been moved far of late, in however many steps.
    pub fn is_far(&self, seconds: f64) -> bool {
        self.points.back().is_some_and(|(at, _)| seconds - at <= WINDOW) && self.spans().0 >= SPAN
    }

    /// Whether it has been at two positions and no others, as a button is.
    pub fn is_switch(&self) -> bool {
        let mut all: Vec<f64> = self.points.iter().map(|(_, position)| *position).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all.len() == 2
    }
}

/// Whether it is as far as it goes.
fn is_end(position: f64) -> bool {
    position <= 0.0 || position >= 1.0
}
