//! A point that moves: a way of straight pieces, and a time law.

use super::array::FARTHEST;
use super::fault::Fault;
use super::point::{Point, between, distance};

/// How a path is gone through in time.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Timing {
    /// At one speed.
    #[default]
    Linear,
    /// From rest to rest: of the time x it has gone 3x² − 2x³ of the way, Hermite's cubic, whose speed is 0 at both ends and 1.5 times the
    /// mean in the middle. It follows a raised cosine within 1 % of the way.
    Smooth,
    /// At each point at a time of its own, in seconds from the beginning, at one speed between them. Before the first and after the last it
    /// stays; two points at one place are a rest.
    At(Vec<f64>),
}

/// A path of straight pieces, by its length.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    points: Vec<Point>,
    /// By point: the way to it.
    along: Vec<f64>,
    /// By point: when it is there; only for times of their own.
    times: Vec<f64>,
    smooth: bool,
    seconds: f64,
}

impl Path {
    /// A path through points that takes some seconds by a law without times.
    ///
    /// # Errors
    /// Fewer than two points; a point that is not finite or beyond [`FARTHEST`]; all points at one place; no time. For [`Timing::At`],
    /// also a number of times that is not that of the points, and times that do not rise; its last time is what the path takes, and
    /// `seconds` does not count.
    pub fn new(points: &[Point], seconds: f64, timing: Timing) -> Result<Self, Fault> {
        if points.len() < 2 {
            return Err(Fault::FewPoints(points.len()));
        }
        if let Some(bad) = points.iter().position(|p| !p.iter().all(|x| x.abs() <= FARTHEST)) {
            return Err(Fault::PathPoint(bad, points[bad]));
        }
        let mut along = vec![0.0];
        for pair in points.windows(2) {
            along.push(along[along.len() - 1] + distance(pair[0], pair[1]));
        }
        if along[along.len() - 1] < f64::MIN_POSITIVE {
            return Err(Fault::NoLength(points[0]));
        }
        let smooth = timing == Timing::Smooth;
        let (times, seconds) = match timing {
            Timing::Linear | Timing::Smooth => (Vec::new(), seconds),
            Timing::At(times) => {
                rising(&times, points.len())?;
                let last = times[times.len() - 1];
                (times, last)
            }
        };
        if !(seconds.is_finite() && seconds >= f64::MIN_POSITIVE) {
            return Err(Fault::NoTime(seconds));
        }
        Ok(Self { points: points.to_vec(), along, times, smooth, seconds })
    }

    /// Its length in metres, above 0.
    pub fn length(&self) -> f64 {
        self.along.last().copied().unwrap_or_default()
    }

    /// What it takes, in seconds, above 0.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// When it is at each of its points, where that was said.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Whether it goes from rest to rest.
    pub fn is_smooth(&self) -> bool {
        self.smooth
    }

    /// Its points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Where it is after some seconds; before 0 at its beginning, as for what is not a number, and at its end after it is over. For the audio
    /// thread.
    pub fn at(&self, seconds: f64) -> Point {
        self.follow(seconds, &mut 0)
    }

    /// The same, where it was found on a piece shortly before; the piece only tells where to look first. For the audio thread.
    #[inline(always)]
    pub fn follow(&self, seconds: f64, piece: &mut usize) -> Point {
        let share = if self.times.is_empty() {
            let x = if seconds > 0.0 { (seconds / self.seconds).min(1.0) } else { 0.0 };
            place(&self.along, self.length() * if self.smooth { eased(x) } else { x }, piece)
        } else {
            place(&self.times, seconds, piece)
        };
        match self.points.get(*piece..) {
            Some([from, to, ..]) => between(*from, *to, share),
            _ => [0.0; 3],
        }
    }

    /// The same for many instants, rising, coordinate by coordinate: those of [`Path::follow`], to the bit. Whether they go straight on, at one speed.
    /// For the audio thread.
    #[inline(always)]
    pub(super) fn trace<const N: usize>(
        &self,
        seconds: &[f64; N],
        piece: &mut usize,
        to: &mut [[f64; N]; 3],
    ) -> bool {
        let mut values = *seconds;
        let marks = if self.times.is_empty() { &self.along } else { &self.times };
        if self.times.is_empty() {
            let length = self.length();
            for value in &mut values {
                let x = if *value > 0.0 { (*value / self.seconds).min(1.0) } else { 0.0 };
                *value = length * if self.smooth { eased(x) } else { x };
            }
        }
        let _ = place(marks, values[0], piece);
        if let (Some([begin, end, ..]), Some([from, next, ..])) =
            (marks.get(*piece..), self.points.get(*piece..))
            && values.iter().fold(true, |all, value| all & (*begin <= *value) & (*value < *end))
        {
            let [x, y, z] = to;
            for k in 0..N {
                let share = (values[k] - begin) / (end - begin);
                [x[k], y[k], z[k]] = between(*from, *next, held(share));
            }
            // Before its beginning it rests.
            return !self.smooth && seconds[0] >= 0.0;
        }
        for (k, seconds) in seconds.iter().enumerate() {
            let point = self.follow(*seconds, piece);
            (0..3).for_each(|axis| to[axis][k] = point[axis]);
        }
        false
    }

    /// The point a way along it, in metres; before 0 its beginning, beyond its length its end. For the audio thread.
    pub fn point(&self, along: f64) -> Point {
        let mut piece = 0;
        let share = place(&self.along, along, &mut piece);
        between(self.points[piece], self.points[piece + 1], share)
    }

    /// When it first has gone so many metres, in seconds.
    pub fn when(&self, along: f64) -> f64 {
        if self.times.is_empty() {
            let y = (along / self.length()).clamp(0.0, 1.0);
            return self.seconds * if self.smooth { uneased(y) } else { y };
        }
        // The first piece that reaches it.
        let after = self.along.partition_point(|way| *way < along).clamp(1, self.along.len() - 1);
        let (from, to) = (self.along[after - 1], self.along[after]);
        let share = if to > from { ((along - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        (1.0 - share) * self.times[after - 1] + share * self.times[after]
    }
}

/// A path that a voice goes along.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// The path.
    pub path: Path,
    /// Whether it is gone through in the time of the event that names it, whatever that is; else in its own.
    pub stretched: bool,
}

impl Route {
    /// Seconds of the path for each of a voice whose event lasts so long. One that is held takes the path's own time.
    pub fn pace(&self, event: f64) -> f64 {
        let within = self.stretched && event.is_finite() && event > 0.0;
        if within { self.path.seconds / event } else { 1.0 }
    }

    /// Where a voice is some seconds after its onset, whose event lasts so long. For the audio thread.
    pub fn at(&self, seconds: f64, event: f64) -> Point {
        self.path.at(seconds * self.pace(event))
    }
}

/// Refuses times that are not as many as the points, or do not rise.
fn rising(times: &[f64], points: usize) -> Result<(), Fault> {
    if times.len() != points {
        return Err(Fault::Times(times.len(), points));
    }
    let mut least = 0.0;
    for (index, time) in times.iter().copied().enumerate() {
        if !time.is_finite() || time < least || (index > 0 && time == least) {
            return Err(Fault::TimeOrder(index, time, least));
        }
        least = time;
    }
    Ok(())
}

/// The share of the piece of rising marks that holds a value, held within their ends; it is looked for about `piece`, which then is it.
#[inline(always)]
fn place(marks: &[f64], value: f64, piece: &mut usize) -> f64 {
    let last = marks.len().saturating_sub(2);
    let is_it = match marks.get(*piece..) {
        Some([from, to, ..]) => *from <= value && value < *to,
        _ => false,
    };
    if !is_it {
        *piece = marks.partition_point(|mark| *mark <= value).saturating_sub(1).min(last);
    }
    let Some([from, to, ..]) = marks.get(*piece..) else { return 0.0 };
    held((value - from) / (to - from))
}

/// A share from 0 to 1; 0 for what is not a number, as for a piece of no length.
#[inline(always)]
fn held(share: f64) -> f64 {
    if share >= 1.0 {
        1.0
    } else if share > 0.0 {
        share
    } else {
        0.0
    }
}

/// Hermite's cubic from 0 to 1, symmetric to the bit about the middle but for rounding.
fn eased(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}

/// Its inverse, by halving: additions and multiplications alone are the same on every machine.
fn uneased(y: f64) -> f64 {
    if y <= 0.0 || y >= 1.0 {
        return y;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if eased(middle) < y {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::{Path, Timing};
    use crate::space::fault::Fault;
    use crate::space::point::{Point, distance};

    const BENT: [Point; 3] = [[0.0; 3], [0.3, 0.0, 0.0], [0.3, 0.1, 0.0]];

    #[test]
    fn at_one_speed_it_goes_by_its_length() {
        let path = Path::new(&BENT, 2.0, Timing::Linear).unwrap();
        assert!((path.length() - 0.4).abs() < 1e-15 && path.seconds() == 2.0);
        for n in 0..=200 {
            let t = f64::from(n) * 0.01;
            let way = 0.2 * t;
            let wanted = if way < 0.3 { [way, 0.0, 0.0] } else { [0.3, way - 0.3, 0.0] };
            assert!(distance(path.at(t), wanted) < 1e-15, "{t}");
            assert!((path.when(way) - t).abs() < 1e-14);
        }
        assert_eq!(
            [path.at(-1.0), path.at(f64::NAN), path.at(1e9), path.at(f64::INFINITY)],
            [BENT[0], BENT[0], BENT[2], BENT[2]]
        );
    }

    #[test]
    fn smooth_rests_at_both_ends_and_follows_a_raised_cosine() {
        let path = Path::new(&BENT, 2.0, Timing::Smooth).unwrap();
        let gone = |t: f64| distance(path.at(t), path.at(0.0));
        assert!(gone(1e-4) < 0.4 * 3.0 * 0.25e-8 * 1.01, "no speed in the beginning");
        assert!(distance(path.at(2.0 - 1e-4), BENT[2]) < 0.4 * 3.0 * 0.25e-8 * 1.01, "nor at the end");
        for n in 0..=1000 {
            let t = f64::from(n) * 0.002;
            let cosine = 0.2 * (1.0 - (t * std::f64::consts::FRAC_PI_2).cos());
            assert!(distance(path.at(t), path.point(cosine)) < 0.0101 * 0.4, "{t}");
            let way = 0.4 * f64::from(n) / 1000.0;
            assert!(distance(path.at(path.when(way)), path.point(way)) < 1e-12, "{way}");
            // As far from the end as from the beginning, in the mirror of time.
            assert!((path.when(way) + path.when(0.4 - way) - 2.0).abs() < 1e-7);
        }
        // The greatest speed is 1.5 times the mean, which a raised cosine's is not (1.571).
        let speed = distance(path.at(1.0005), path.at(0.9995)) / 0.001;
        assert!((speed / 0.2 - 1.5).abs() < 1e-5, "{speed}");
    }

    #[test]
    fn with_times_of_their_own_points_are_reached_then() {
        let points = [BENT[0], BENT[1], BENT[1], BENT[2]];
        let path = Path::new(&points, f64::NAN, Timing::At(vec![0.5, 1.0, 3.0, 3.5])).unwrap();
        assert_eq!(path.seconds(), 3.5);
        assert_eq!(
            [0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 9.0].map(|t| path.at(t)[0..2].to_vec()),
            [
                vec![0.0, 0.0],
                vec![0.0, 0.0],
                vec![0.3, 0.0],
                vec![0.3, 0.0],
                vec![0.3, 0.0],
                vec![0.3, 0.1],
                vec![0.3, 0.1]
            ]
        );
        assert!(distance(path.at(0.75), [0.15, 0.0, 0.0]) < 1e-15);
        assert!((path.when(0.0) - 0.5).abs() < 1e-15 && (path.when(0.3) - 1.0).abs() < 1e-15);
        assert!((path.when(0.35) - 3.25).abs() < 1e-14 && path.when(9.0) == 3.5);
    }

    #[test]
    fn what_is_no_path_is_refused() {
        let new = |points: &[Point], seconds| Path::new(points, seconds, Timing::Linear).unwrap_err();
        assert_eq!(new(&[], 1.0), Fault::FewPoints(0));
        assert_eq!(new(&BENT[..1], 1.0), Fault::FewPoints(1));
        assert_eq!(new(&[BENT[1]; 3], 1.0), Fault::NoLength(BENT[1]));
        for bad in [f64::NAN, f64::INFINITY, 1e7] {
            assert!(matches!(new(&[BENT[0], [0.0, bad, 0.0]], 1.0), Fault::PathPoint(1, _)));
        }
        for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(new(&BENT, seconds), Fault::NoTime(_)), "{seconds}");
        }
        let at = |times: &[f64]| Path::new(&BENT, 1.0, Timing::At(times.to_vec())).unwrap_err();
        assert_eq!(at(&[0.0, 1.0]), Fault::Times(2, 3));
        assert_eq!(at(&[0.0, 1.0, 1.0]), Fault::TimeOrder(2, 1.0, 1.0));
        assert_eq!(at(&[-0.1, 1.0, 2.0]), Fault::TimeOrder(0, -0.1, 0.0));
        assert!(matches!(at(&[0.0, f64::NAN, 2.0]), Fault::TimeOrder(1, ..)));
    }

    #[test]
    fn a_path_may_be_of_any_size() {
        let tiny = Path::new(&[[0.0; 3], [1e-300, 0.0, 0.0]], 1e-300, Timing::Smooth);
        // Its length, squared on the way, is nothing to a number.
        assert!(matches!(tiny, Err(Fault::NoLength(_))));
        let vast = Path::new(&[[-1e6, 0.0, 0.0], [1e6, 0.0, 0.0]], 1e-3, Timing::Linear).unwrap();
        assert!(vast.at(0.5e-3)[0].abs() < 1e-9);
    }
}
