//! How a point moves about now, and whether it stays in a piece of an array.

use super::super::array::tile::{Form, Formed, Rectangle, Segment, Tile, Triangle};
use super::super::law::Law;
use super::super::point::{Point, dot, minus};

/// How a point moves about now.
pub(super) struct Way<A> {
    /// Where it is so many whole engine samples and a share of one from now.
    pub(super) at: A,
    /// Whether there may be a corner in it.
    pub(super) bent: bool,
    pub(super) width: f64,
    pub(super) law: Law,
    /// Whether it goes through a cloud.
    pub(super) cloud: bool,
    /// Whether it is slow: then its boxes are as long as a sample.
    pub(super) slow: bool,
}

/// A piece of time, by shares of a sample from some whole samples from now on.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub(super) base: i64,
    pub(super) from: f64,
    pub(super) to: f64,
}

/// Whether a point that moves stays within a piece, and goes through no corner of its way.
#[inline(always)]
pub(super) fn stays<F: Formed>(tile: &Tile, ends: [Point; 2], here: Point, spacing: f64) -> bool {
    tile.holds::<F>(here) & tile.holds::<F>(ends[0]) & tile.holds::<F>(ends[1]) & !turns(ends, here, spacing)
}

/// The same, whatever the form of the piece.
#[inline]
pub(super) fn stays_in(tile: &Tile, ends: [Point; 2], here: Point, spacing: f64) -> bool {
    match tile.form {
        Form::Segment => stays::<Segment>(tile, ends, here, spacing),
        Form::Triangle => stays::<Triangle>(tile, ends, here, spacing),
        Form::Rectangle => stays::<Rectangle>(tile, ends, here, spacing),
    }
}

/// Whether the way from one end over where a point is now to the other has a corner, that is to be seen in an array of that spacing.
#[inline(always)]
pub(super) fn turns([before, after]: [Point; 2], now: Point, spacing: f64) -> bool {
    let (come, go) = (minus(now, before), minus(after, now));
    let off = minus(go, come);
    let off = dot(off, off);
    // In squares: a ten thousandth of the spacing, a hundredth of the way.
    (off > 1e-8 * spacing * spacing) & (off > 1e-4 * (dot(come, come) + dot(go, go)))
}
