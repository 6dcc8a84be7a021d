//! Tactors anywhere: inverse distance, held local.

use super::super::point::{Point, dot};
use super::super::row::Row;

/// The reach is taken from the distance to the tactor that comes fourth by distance.
const NEIGHBOURS: usize = 4;
/// The reach, in shares of that distance.
const REACH: f64 = 1.5;
/// An ellipsoid is no flatter than this share of the array's extent.
const FLATTEST: f64 = 1e-3;

/// What is around the sites: an ellipsoid in their own axes, about their middle.
#[derive(Debug, Clone)]
pub(super) struct Cloud {
    /// One over the squares of its half axes.
    squeeze: Point,
}

impl Cloud {
    /// The ellipsoid of the shape of the sites' spread that holds them all.
    pub(super) fn of(places: &[Point]) -> Self {
        let share = 1.0 / places.len().max(1) as f64;
        let spread = [0, 1, 2].map(|k| {
            let square = places.iter().map(|p| p[k] * p[k] * share).sum::<f64>();
            1.0 / square.max(FLATTEST * FLATTEST)
        });
        let most = places.iter().map(|p| weighted(*p, spread)).fold(f64::MIN_POSITIVE, f64::max);
        Self { squeeze: spread.map(|s| s / most) }
    }

    /// A point outside the ellipsoid is drawn to it, towards the middle.
    #[inline(always)]
    pub(super) fn held(&self, p: Point) -> Point {
        let out = weighted(p, self.squeeze);
        if out > 1.0 {
            let share = 1.0 / out.sqrt();
            p.map(|x| x * share)
        } else {
            p
        }
    }

    /// Shares a point within the ellipsoid: w ∝ ((R − r)₊ / (R r))², with the reach R from the neighbours' distance.
    ///
    /// Franke & Nielson's local form of Shepard's inverse distance ("Smooth interpolation of large sets of scattered data", 1980), with a
    /// reach that follows the point: R is a continuous function of it, and so are the weights.
    pub(super) fn share(&self, [x, y, z]: [&[f64]; 3], p: Point, row: &mut Row) {
        let n = x.len().min(y.len()).min(z.len()).min(row.dense.len());
        // The squares of the least distances, rising.
        let mut least = [f64::INFINITY; NEIGHBOURS];
        for k in 0..n {
            let d = [x[k] - p[0], y[k] - p[1], z[k] - p[2]];
            let square = dot(d, d);
            row.dense[k] = square;
            if square < least[NEIGHBOURS - 1] {
                least[NEIGHBOURS - 1] = square;
                for place in (1..NEIGHBOURS).rev() {
                    if least[place] < least[place - 1] {
                        least.swap(place, place - 1);
                    }
                }
            }
        }
        let far = least[NEIGHBOURS.min(n).saturating_sub(1)];
        let reach = REACH * far.sqrt();
        let nearest = least[0].sqrt();
        for k in 0..n {
            if row.dense[k] < reach * reach {
                let r = row.dense[k].sqrt();
                // Times the nearest's distance, which may be 0.
                let w = if r > nearest { nearest / r } else { 1.0 } - nearest / reach;
                row.push(k as u32, w * w);
            }
        }
        row.level();
    }
}

/// Σ p² s
#[inline(always)]
fn weighted(p: Point, s: Point) -> f64 {
    p[0] * p[0] * s[0] + p[1] * p[1] * s[1] + p[2] * p[2] * s[2]
}
