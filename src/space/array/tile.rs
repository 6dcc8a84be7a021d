//! One piece of an array by itself: between two tactors of a line, a rectangle or a triangle between neighbours.

use super::super::law::Law;
use super::super::point::Point;
use super::super::row::NOTHING;
use super::cell::{ON_THE_EDGE, WELL_WITHIN};
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

impl Form {
    #[inline(always)]
    fn depth(self, at: [f64; 2]) -> f64 {
        match self {
            Self::Segment => Segment::depth(at),
            Self::Triangle => Triangle::depth(at),
            Self::Rectangle => Rectangle::depth(at),
        }
    }

    #[inline(always)]
    fn weights(self, at: [f64; 2]) -> [f64; 4] {
        match self {
            Self::Segment => Segment::weights(at),
            Self::Triangle => Triangle::weights(at),
            Self::Rectangle => Rectangle::weights(at),
        }
    }
}

/// A straight way in the coordinates of a tile.
#[derive(Debug, Clone, Copy)]
pub(in crate::space) struct Along {
    form: Form,
    from: [f64; 2],
    goes: [f64; 2],
}

impl Along {
    /// The share of the way after which it leaves the tile, at most 1; below that of a point where it is in it, if it is not.
    #[inline(always)]
    pub(in crate::space) fn leaves(&self) -> f64 {
        let ([u, v], [along_u, along_v]) = (self.from, self.goes);
        let out = |left: f64, goes: f64| if goes < 0.0 { left / -goes } else { f64::INFINITY };
        let both = match self.form {
            Form::Segment => out(u, along_u).min(out(1.0 - u, -along_u)),
            Form::Triangle => out(u, along_u).min(out(v, along_v)).min(out(1.0 - u - v, -along_u - along_v)),
            Form::Rectangle => {
                let [u, v] =
                    [(u, along_u), (v, along_v)].map(|(u, goes)| out(u, goes).min(out(1.0 - u, -goes)));
                u.min(v)
            }
        };
        both.min(1.0)
    }

    /// How deep within the tile it is at a share of the way; below 0 outside.
    #[inline(always)]
    pub(in crate::space) fn depth(&self, share: f64) -> f64 {
        self.form.depth(self.at(share))
    }

    #[inline(always)]
    fn at(&self, share: f64) -> [f64; 2] {
        [self.from[0] + share * self.goes[0], self.from[1] + share * self.goes[1]]
    }

    /// The mean gains of the corners between two shares of the way, in the tile.
    #[inline(always)]
    pub(in crate::space) fn means(&self, [from, to]: [f64; 2], law: Law) -> [f64; 4] {
        let (near, far) = (self.form.weights(self.at(from)), self.form.weights(self.at(to)));
        let (part, [u, v]) = (to - from, self.goes);
        let mut bend = if self.form == Form::Rectangle { u * v * part * part } else { 0.0 };
        let mut means = [0.0; 4];
        for (k, mean) in means.iter_mut().enumerate() {
            *mean = law.mean(borne(near[k]), borne(far[k]), bend);
            bend = -bend;
        }
        means
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

    /// Whether a point lies so far within that nothing else holds it.
    #[inline(always)]
    pub(in crate::space) fn holds_well(&self, p: Point) -> bool {
        self.form.depth(self.at(p)) > WELL_WITHIN
    }

    /// A straight way from one point to another, by what it has of the tile.
    #[inline(always)]
    pub(in crate::space) fn along(&self, from: Point, to: Point) -> Along {
        let ([a, b], [c, d]) = (self.at(from), self.at(to));
        Along { form: self.form, from: [a, b], goes: [c - a, d - b] }
    }

    /// Whether a point lies within or on the edge.
    #[inline(always)]
    pub(in crate::space) fn holds<F: Formed>(&self, p: Point) -> bool {
        F::depth(self.at(p)) >= ON_THE_EDGE
    }

    /// The gains of its corners of a point within.
    #[inline(always)]
    pub(in crate::space) fn gains(&self, p: Point, law: Law) -> [f64; 4] {
        self.form.weights(self.at(p)).map(|weight| law.gain(borne(weight)))
    }

    /// The same for many points, by coordinate.
    #[inline(always)]
    pub(in crate::space) fn fill<F: Formed>(
        &self,
        [x, y, z]: [&[f64; STRETCH]; 3],
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
