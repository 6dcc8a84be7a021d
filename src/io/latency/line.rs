//! The line beneath moments that come late.
//!
//! Callbacks come when they should or later, never earlier. So the line that lies beneath all of their moments, and as near to them
//! as it can, is when they should have come (S. B. Moon, P. Skelly, D. Towsley, "Estimation and removal of clock skew from
//! network delay measurements", INFOCOM 1999): the edge of the lower convex hull above the middle.

/// A line: `at` for `x = middle`, and by how much it rises with x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    middle: f64,
    at: f64,
    slope: f64,
}

impl Line {
    /// Beneath points in ascending order of x. `None` for fewer than two.
    pub fn beneath(points: &[(f64, f64)]) -> Option<Self> {
        let mut hull: Vec<(f64, f64)> = Vec::new();
        for &point in points {
            // Whatever lies above the line from the one before it to this one is no corner.
            while let [.., a, b] = hull[..]
                && (b.1 - a.1) * (point.0 - a.0) >= (point.1 - a.1) * (b.0 - a.0)
            {
                hull.pop();
            }
            hull.push(point);
        }
        let middle = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
        let edge = hull.windows(2).find(|edge| edge[1].0 >= middle)?;
        let slope = (edge[1].1 - edge[0].1) / (edge[1].0 - edge[0].0);
        let at = edge[0].1 + slope * (middle - edge[0].0);
        slope.is_finite().then_some(Self { middle, at, slope })
    }

    /// Beneath points, as near as it can be, for a slope that is known. `None` for no points.
    pub fn rising(points: &[(f64, f64)], slope: f64) -> Option<Self> {
        let middle = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
        let at = points.iter().map(|p| p.1 - slope * (p.0 - middle)).min_by(f64::total_cmp)?;
        slope.is_finite().then_some(Self { middle, at, slope })
    }

    /// Its height at x.
    pub fn at(&self, x: f64) -> f64 {
        self.at + self.slope * (x - self.middle)
    }

    /// Where it is that high.
    pub fn place(&self, y: f64) -> f64 {
        self.middle + (y - self.at) / self.slope
    }

    /// By how much it rises with x.
    pub fn slope(&self) -> f64 {
        self.slope
    }
}

#[cfg(test)]
mod tests {
    use super::Line;

    #[test]
    fn it_is_when_they_should_have_come() {
        let frame = 1.0 / 48_010.0;
        let late = |n: u32| {
            if n.is_multiple_of(7) {
                0.0
            } else {
                1e-4 * f64::from(n * 7919 % 97) + if n % 50 == 3 { 4e-3 } else { 0.0 }
            }
        };
        let points: Vec<_> =
            (0..2000).map(|n| (f64::from(n) * 128.0, 2.0 + f64::from(n) * 128.0 * frame + late(n))).collect();
        let line = Line::beneath(&points).unwrap();
        assert!((line.slope() / frame - 1.0).abs() < 1e-9);
        assert!((line.at(10_000.0) - (2.0 + 10_000.0 * frame)).abs() < 1e-9);
        assert!((line.place(2.0 + 777.0 * frame) - 777.0).abs() < 1e-4);
        assert_eq!((Line::beneath(&[]), Line::beneath(&[(1.0, 1.0)])), (None, None));
        // Of a short part, another's slope makes more.
        let part = Line::rising(&points[100..140], line.slope()).unwrap();
        assert!((part.at(10_000.0) - line.at(10_000.0)).abs() < 1e-9);
        assert_eq!(Line::rising(&[], 1.0), None);
    }
}
