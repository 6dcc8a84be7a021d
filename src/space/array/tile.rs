//! One piece of an array by itself: between two tactors of a line, a rectangle or a triangle between neighbours.

use super::super::law::Law;
use super::super::point::Point;
use super::super::row::NOTHING;
use super::cell::ON_THE_EDGE;
use std::ops::Range;

/// Samples of a point that are shared at once, at most.
pub(in crate::space) const STRETCH: usize = 32;

/// How weights come of its coordinates u and v.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::space) enum Form {
    Segment,
    Triangle,
    Rectangle,
}

/// The same where it is known beforehand, so that it need not be asked for at every point.
pub(in crate::space) trait Formed {
    /// How far within it a point lies, in shares of the tile; below 0 outside.
    fn depth(at: [f64; 2]) -> f64;
    /// The weights of its corners; nothing where it is none.
    fn weights(at: [f64; 2]) -> [f64; 4];
}

/// 1 − u, u.
pub(in crate::space) struct Segment;
/// 1 − u − v, u, v.
pub(in crate::space) struct Triangle;
/// (1 − u)(1 − v), u (1 − v), u v, (1 − u) v.
pub(in crate::space) struct Rectangle;

#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

impl Formed for Segment {
    #[inline(always)]
    fn depth([u, _]: [f64; 2]) -> f64 {
        least(u, 1.0 - u)
    }

    #[inline(always)]
    fn weights([u, _]: [f64; 2]) -> [f64; 4] {
        [1.0 - u, u, 0.0, 0.0]
    }
}

impl Formed for Triangle {
    #[inline(always)]
    fn depth([u, v]: [f64; 2]) -> f64 {
        least(least(u, v), 1.0 - u - v)
    }

    #[inline(always)]
    fn weights([u, v]: [f64; 2]) -> [f64; 4] {
        [1.0 - u - v, u, v, 0.0]
    }
}

impl Formed for Rectangle {
    #[inline(always)]
    fn depth([u, v]: [f64; 2]) -> f64 {
        least(least(u, v), least(1.0 - u, 1.0 - v))
    }

    #[inline(always)]
    fn weights([u, v]: [f64; 2]) -> [f64; 4] {
        [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]
    }
}

/// A piece of an array.
#[derive(Debug, Clone, Copy)]
pub(in crate::space) struct Tile {
    pub(in crate::space) form: Form,
    /// Where its first corner is, m, and what a metre adds to u and to v.
    pub(super) origin: Point,
    pub(super) u: Point,
    pub(super) v: Point,
    pub(in crate::space) corners: [u32; 4],
}

impl Tile {
    /// Tactors at its corners.
    #[inline]
    pub(in crate::space) fn corners(&self) -> &[u32] {
        match self.form {
            Form::Segment => &self.corners[..2],
            Form::Triangle => &self.corners[..3],
            Form::Rectangle => &self.corners,
        }
    }

    /// The coordinates of a point.
    #[inline(always)]
    fn at(&self, p: Point) -> [f64; 2] {
        let d = [p[0] - self.origin[0], p[1] - self.origin[1], p[2] - self.origin[2]];
        let dot = |a: Point| a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
        [dot(self.u), dot(self.v)]
    }

    /// Whether a point lies within or on the edge.
    #[inline(always)]
    pub(in crate::space) fn holds<F: Formed>(&self, p: Point) -> bool {
        F::depth(self.at(p)) >= ON_THE_EDGE
    }

    /// The gains of its corners of a point within.
    #[inline(always)]
    pub(in crate::space) fn gains(&self, p: Point, law: Law) -> [f64; 4] {
        let at = self.at(p);
        let weights = match self.form {
            Form::Segment => Segment::weights(at),
            Form::Triangle => Triangle::weights(at),
            Form::Rectangle => Rectangle::weights(at),
        };
        weights.map(|weight| law.gain(borne(weight)))
    }

    /// The same for many points, by coordinate.
    #[inline(always)]
    pub(in crate::space) fn fill<F: Formed>(
        &self,
        [x, y, z]: &[[f64; STRETCH]; 3],
        range: Range<usize>,
        law: Law,
        gains: &mut [[f64; STRETCH]; 4],
    ) {
        let [a, b, c, d] = gains;
        let range = range.start..range.end.min(STRETCH);
        for k in range.clone() {
            [a[k], b[k], c[k], d[k]] = F::weights(self.at([x[k], y[k], z[k]]));
        }
        for gains in gains.iter_mut().take(self.corners().len()) {
            let gains = gains.get_mut(range.clone()).unwrap_or_default();
            // The law is asked for once, so that many gains are worked out side by side.
            match law {
                Law::Energy => gains.iter_mut().for_each(|gain| *gain = Law::Energy.gain(borne(*gain))),
                Law::Nearest | Law::Linear => {
                    gains.iter_mut().for_each(|gain| *gain = Law::Linear.gain(borne(*gain)));
                }
                Law::Logarithmic => {
                    gains.iter_mut().for_each(|gain| *gain = Law::Logarithmic.gain(borne(*gain)));
                }
            }
        }
    }
}

/// A weight, if it is one.
#[inline(always)]
fn borne(weight: f64) -> f64 {
    if weight > NOTHING { weight } else { 0.0 }
}
