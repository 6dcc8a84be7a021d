//! The mean gains of a straight way from one piece of an array to the next.

use super::super::point::{Point, minus};
use super::Mover;
use super::way::{Span, Way, turns};

/// Pieces that a box may lead through.
const MOST: usize = 6;
/// By how much of its way a point is followed into the next piece, to tell which that is.
const NEXT: f64 = 1e-6;
/// Shares of a tile, and of a way, that are rounding.
const ROUNDING: f64 = 1e-9;

impl Mover {
    /// Adds the mean gains of a box, cut where its way leaves one piece for the next. False, and nothing is added, where it turns, or leads where pieces are no
    /// tiles.
    pub(super) fn tour<A: Fn(i64, f64) -> Point>(&mut self, way: &Way<A>, span: &Span) -> bool {
        if self.tile(way.width, way.law, self.now.hint).is_none() {
            return false;
        }
        let spacing = self.spread.array().spacing();
        let at = |share: f64| (way.at)(span.base, share);
        let (from, to) = (at(span.from), at(span.to));
        if way.bent && turns([from, to], at(0.5 * (span.from + span.to)), spacing) {
            return false;
        }
        let whole = minus(to, from);
        let mut done = 0.0;
        for piece in 0..MOST {
            let share = if piece == 0 { 0.0 } else { (done + NEXT).min(1.0) };
            let here = plus(from, share, whole);
            let known = |mover: &Self| mover.tile(way.width, way.law, mover.now.hint).copied();
            let tile = known(self).filter(|tile| tile.holds_well(here)).or_else(|| {
                self.find(here, way.law);
                known(self)
            });
            let Some(tile) = tile else { break };
            let along = tile.along(from, to);
            let leaves = along.leaves();
            if along.depth(share) < -ROUNDING {
                break;
            }
            if leaves > done {
                let part = leaves - done;
                let means = along.means([done, leaves], way.law);
                for (tactor, mean) in tile.corners().iter().zip(means) {
                    self.part.add(*tactor, part * mean);
                }
                done = leaves;
            }
            if done >= 1.0 - ROUNDING {
                return true;
            }
        }
        self.part.drain(|_, _| {});
        false
    }
}

#[inline(always)]
fn plus(from: Point, share: f64, whole: Point) -> Point {
    let [x, y, z] = from;
    [x + share * whole[0], y + share * whole[1], z + share * whole[2]]
}
