//! A place in metres.

use crate::dsp::elementary::finite;

/// Three coordinates in metres: of the body x to the wearer's right, y up, z ahead.
pub type Point = [f64; 3];

/// From `b` to `a`.
#[inline(always)]
pub(super) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a · b
#[inline(always)]
pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `share` of the way from `a` to `b`; 0 and 1 give them exactly.
#[inline(always)]
pub(super) fn between(a: Point, b: Point, share: f64) -> Point {
    let at = |k: usize| (1.0 - share) * a[k] + share * b[k];
    [at(0), at(1), at(2)]
}

/// The distance of two points.
#[inline(always)]
pub(crate) fn distance(a: Point, b: Point) -> f64 {
    let d = minus(a, b);
    dot(d, d).sqrt()
}

/// Every coordinate within ±1e30; what is not a number becomes 0.
#[inline(always)]
pub(super) fn tamed(point: Point) -> Point {
    let [x, y, z] = point;
    [finite(x), finite(y), finite(z)]
}

/// A place in the plane of an array.
pub(super) type Flat = [f64; 2];

/// From `b` to `a`, in the plane.
#[inline(always)]
pub(super) fn less(a: Flat, b: Flat) -> Flat {
    [a[0] - b[0], a[1] - b[1]]
}

/// a · b in the plane.
#[inline(always)]
pub(super) fn inner(a: Flat, b: Flat) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a × b in the plane: above 0 where b lies to the left of a.
#[inline(always)]
pub(super) fn cross(a: Flat, b: Flat) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Its length.
#[inline(always)]
pub(super) fn size(a: Flat) -> f64 {
    inner(a, a).sqrt()
}
