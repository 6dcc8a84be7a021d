//! The line beneath moments that come late.
//!
//! Callbacks come when they should or later, never earlier. So the line that lies beneath all of their moments, and as near to them
//! as it can, is when they should have come (S. B. Moon, P. Skelly, D. Towsley, "Estimation and removal of clock skew from
//! network delay measurements", INFOCOM 1999): the edge of the lower convex hull above the middle.

/// Parts of a stretch, each with the moment in it that is nearest to the line.
pub const PARTS: usize = 16;

/// How far a line may be off: standard errors, as the moments nearest to it scatter in [`PARTS`] parts of the stretch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Of its height.
    pub height: f64,
    /// Of its slope, as a share.
    pub slope: f64,
}

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

    /// How far it may be off, for the points that it lies beneath, in ascending order of x. `None` for fewer than three parts with points.
    ///
    /// Whichever two points the line goes through say nothing of that. The nearest point of each part does: by the standard errors of the line of
    /// least squares through those, and by how far that one is from this.
    pub fn errors(&self, points: &[(f64, f64)]) -> Option<Errors> {
        let (first, last) = (points.first()?.0, points.last()?.0);
        let part = |x: f64| (((x - first) / (last - first) * PARTS as f64) as usize).min(PARTS - 1);
        let mut nearest: Vec<(f64, f64)> = Vec::new();
        for group in points.chunk_by(|a, b| part(a.0) == part(b.0)) {
            let over = group.iter().map(|p| (p.0, p.1 - self.at(p.0)));
            nearest.extend(over.min_by(|a, b| a.1.total_cmp(&b.1)));
        }
        if nearest.len() < 3 {
            return None;
        }
        let count = nearest.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| nearest.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        let spread: f64 = nearest.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
        let rise = nearest.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
        let left: f64 = nearest.iter().map(|p| (p.1 - y - rise * (p.0 - x)).powi(2)).sum();
        let deviation = (left / (count - 2.0)).sqrt();
        Some(Errors {
            height: (deviation / count.sqrt()).hypot(y),
            slope: (deviation / spread.sqrt()).hypot(rise) / self.slope.abs(),
        })
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
    use super::{Errors, Line};

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
        // A moment in seven came when it should have.
        let errors = line.errors(&points).unwrap();
        assert!(errors.slope.max(errors.height) < 1e-9, "{errors:?}");
        assert_eq!(line.errors(&points[..2]), None);
    }

    /// Callbacks each late by chance: the line is off by no more than it says, mostly, and it does not say much more.
    #[test]
    fn it_is_off_as_it_says() {
        let mut seed = 7_u64;
        let mut even = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (frame, sets) = (1.0 / 48_000.0, 400);
        // Late by up to a millisecond, mostly little; and by what a timer of 50 us makes of it.
        for (shape, step) in [(1.0, 0.0), (3.0, 0.0), (1.0, 50e-6)] {
            let (mut within, mut says, mut is) = ([0; 2], 0.0, 0.0);
            for _ in 0..sets {
                let late = |even: f64| {
                    let late = 1e-3 * even.powf(shape);
                    if step > 0.0 { (late / step).floor() * step } else { late }
                };
                let points: Vec<_> = (0..800)
                    .map(|n| (256.0 * f64::from(n), 256.0 * frame * f64::from(n) + late(even())))
                    .collect();
                let line = Line::beneath(&points).unwrap();
                let Errors { height, slope } = line.errors(&points).unwrap();
                let off = (line.slope() / frame - 1.0).abs();
                let middle = 256.0 * 400.0;
                within[0] += i32::from(off <= 2.14 * slope + 1e-12);
                within[1] += i32::from((line.at(middle) - frame * middle).abs() <= 2.14 * height + 1e-12);
                (says, is) = (says + slope * slope, is + off * off);
            }
            let share = within.map(|within| f64::from(within) / f64::from(sets));
            assert!(share[0] > 0.93 && share[1] > 0.93, "{shape} {step}: {share:?}");
            let [says, is] = [says, is].map(|sum: f64| (sum / f64::from(sets)).sqrt());
            // A part whose moments were all late makes it more careful than it need be.
            assert!(says < f64::max(5.0 * is, 5e-6), "{shape} {step}: {says} {is}");
        }
    }
}
