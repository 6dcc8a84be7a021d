//! The axes along which an array extends most and least.

use super::super::point::{Point, distance, dot, minus, tamed};

/// Off its main axes' products an array may be by this share of their mean, and still keeps the axes it was given in.
const ALONG: f64 = 1e-12;
/// Turns of Jacobi's method; it converges within some six for three axes.
const TURNS: usize = 32;

/// Coordinates of an array: from its middle, along the axes of its spread, in units of its size.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    /// The mean of the sites.
    pub(super) centre: Point,
    /// Metres of a unit, which is the array's size: twice the distance of the farthest site from the middle.
    pub(super) unit: f64,
    /// Twice the distance of the farthest site from the first axis, in units.
    pub(super) across: f64,
    /// From the lowest to the highest along the last axis, in units.
    pub(super) deep: f64,
    /// Axes from the widest spread to the narrowest, at right angles; each as long as there are units in a metre.
    pub(super) rates: [Point; 3],
}

impl Frame {
    /// Axes are those of the covariance of the sites. One site has the axes of the body and a unit of a metre.
    pub(super) fn of(places: &[Point]) -> Self {
        let share = 1.0 / places.len().max(1) as f64;
        let centre = [0, 1, 2].map(|k| places.iter().map(|p| p[k] * share).sum::<f64>());
        let mut covariance = [[0.0; 3]; 3];
        for place in places {
            let d = minus(*place, centre);
            for i in 0..3 {
                for j in 0..3 {
                    covariance[i][j] += d[i] * d[j] * share;
                }
            }
        }
        let axes = axes(covariance);
        let far = places.iter().map(|place| distance(*place, centre)).fold(0.0, f64::max);
        let unit = if far > 0.0 { 2.0 * far } else { 1.0 };
        let rates = axes.map(|axis| axis.map(|x| x / unit));
        let mut frame = Self { centre, unit, across: 0.0, deep: 0.0, rates };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for place in places {
            let [_, y, z] = frame.local(*place);
            frame.across = frame.across.max(2.0 * y.hypot(z));
            (low, high) = (low.min(z), high.max(z));
        }
        frame.deep = (high - low).max(0.0);
        frame
    }

    /// From the middle to a point, in metres; what is not a number in it counts as 0.
    #[inline(always)]
    pub(super) fn off_centre(&self, point: Point) -> Point {
        minus(tamed(point), self.centre)
    }

    /// One coordinate of what lies so far from the middle.
    #[inline(always)]
    pub(super) fn along(&self, axis: usize, d: Point) -> f64 {
        dot(d, self.rates[axis])
    }

    /// A point in these coordinates.
    #[inline(always)]
    pub(super) fn local(&self, point: Point) -> Point {
        let d = self.off_centre(point);
        [0, 1, 2].map(|axis| self.along(axis, d))
    }
}

/// Eigenvectors of a symmetric matrix by Jacobi's method (Golub & Van Loan, "Matrix Computations", 8.5), by falling eigenvalue.
fn axes(mut a: [[f64; 3]; 3]) -> [Point; 3] {
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let least = ALONG * (a[0][0] + a[1][1] + a[2][2]);
    for _ in 0..TURNS {
        let (p, q) = [(0, 1), (0, 2), (1, 2)].into_iter().fold((0, 1), |best, next| {
            if a[next.0][next.1].abs() > a[best.0][best.1].abs() { next } else { best }
        });
        if a[p][q].abs() <= least {
            break;
        }
        let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        let t = if theta >= 0.0 { 1.0 } else { -1.0 } / (theta.abs() + (theta * theta + 1.0).sqrt());
        let c = 1.0 / (t * t + 1.0).sqrt();
        let s = t * c;
        for k in 0..3 {
            (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
        }
        for k in 0..3 {
            (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
        }
        for axis in &mut v {
            (axis[p], axis[q]) = (c * axis[p] - s * axis[q], s * axis[p] + c * axis[q]);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    // Columns of v.
    order.map(|k| [v[0][k], v[1][k], v[2][k]])
}

#[cfg(test)]
mod tests {
    use super::Frame;
    use crate::space::point::{Point, dot};

    #[test]
    fn axes_are_orthonormal_and_follow_the_spread() {
        // An ellipsoid of half axes 3, 2 and 1, turned.
        let turn = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
        let corners = [[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]];
        let places: Vec<Point> = corners
            .iter()
            .flat_map(|c| [*c, c.map(|x| -x)])
            .map(|c| [0, 1, 2].map(|k| 7.0 + turn[0][k] * c[0] + turn[1][k] * c[1] + turn[2][k] * c[2]))
            .collect();
        let frame = Frame::of(&places);
        for (i, axis) in frame.rates.iter().enumerate() {
            assert!((frame.unit * dot(*axis, turn[i]).abs() - 1.0).abs() < 1e-14, "{i}");
        }
        let sizes = [frame.unit, frame.unit * frame.across, frame.unit * frame.deep];
        assert!(
            sizes.iter().zip([6.0, 4.0, 2.0]).all(|(size, wanted)| (size - wanted).abs() < 1e-13),
            "{sizes:?}"
        );
        let local = frame.local([7.0, 7.0, 7.0].map(|x: f64| x));
        assert!(local.iter().all(|x| x.abs() < 1e-15));
    }

    #[test]
    fn a_square_keeps_the_axes_it_was_given_in() {
        let square: Vec<Point> =
            (0..16).map(|n| [0.06 * f64::from(n % 4) - 0.09, 0.06 * f64::from(n / 4) - 0.09, 0.3]).collect();
        for axis in Frame::of(&square).rates {
            assert_eq!(axis.iter().filter(|x| **x == 0.0).count(), 2, "{axis:?}");
        }
    }
}
