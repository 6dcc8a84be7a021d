//! An envelope through points.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Point, Setup, Twin};
use super::legs::{CURVIEST, LONGEST, within};
use super::segment::{Script, Segment, Track};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "breakpoints",
    family: Family::Envelope,
    summary: "An envelope through any number of points.",
    detail: "From 0 at the onset to each point's value at its time, along its shape (as a curve of `envelope`), then 0: at once, so that \
             a last value other than 0 ends in a jump. Points at the same instant are a jump. With `sustain`, the value holds \
             at that point until the event ends; then, or if the event ends before, it goes on from where it is to the next \
             point, in the time between those two. Without, the release is ignored. Times that go back are taken as the time \
             of the point before. Instants are exact and may fall between samples; jumps and corners are band-limited.",
    params: &[
        Param {
            name: "points",
            kind: Kind::Points,
            unit: "",
            doc: "Points in order: `at` in seconds after the onset, `value` from −1e6 to 1e6, and `shape` of the way there: linear, slow, fast, exponential or from −20 to 20.",
        },
        Param {
            name: "sustain",
            kind: Kind::Constant(Numeric::or(0.0, 0.0, 1e6)),
            unit: "",
            doc: "Which point holds until the release, counted from 1; 0 for none.",
        },
    ],
    example: r#"swell = { type = "breakpoints", points = [{ at = 0.1, value = 1, shape = "slow" }, { at = 0.5, value = 0 }] }"#,
};

const LARGEST: f64 = 1e6;

/// Where eight lanes are among the points.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    script: Points,
    track: Track<R>,
}

#[derive(Debug, Clone)]
struct Points {
    rate: f64,
    /// Value, seconds from the point before, curve.
    points: Vec<Leg>,
    /// Points up to the one that holds; `usize::MAX` for none.
    sustain: usize,
    at: [usize; LANES],
    released: [bool; LANES],
}

#[derive(Debug, Clone)]
struct Leg {
    to: f64,
    seconds: f64,
    curve: f64,
}

impl Script for Points {
    fn next(&mut self, lane: usize, value: f64) -> Segment {
        let at = self.at[lane];
        if at == self.sustain && !self.released[lane] {
            return Segment::hold(at.checked_sub(1).map_or(0.0, |before| self.points[before].to), f64::INFINITY);
        }
        self.at[lane] = at.saturating_add(1);
        match self.points.get(at) {
            Some(leg) => Segment::ramp(value, leg.to, leg.seconds, leg.curve, self.rate),
            None => Segment::end(),
        }
    }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn copy(&mut self, from: &Self, _live: u8) {
        let Points { rate, points, sustain, at, released } = &from.script;
        // Of the same settings there are as many.
        if self.script.points.len() != points.len() {
            return;
        }
        self.track.clone_from(&from.track);
        self.script.points.iter_mut().zip(points).for_each(|(to, from)| to.clone_from(from));
        (self.script.rate, self.script.sustain) = (*rate, *sustain);
        (self.script.at, self.script.released) = (*at, *released);
    }

    fn heap(setup: &Setup) -> usize {
        setup.points.len() * size_of::<Leg>()
    }

    fn new(setup: &Setup) -> Self {
        let mut time = 0.0;
        let points: Vec<Leg> = setup
            .points
            .iter()
            .map(|point| {
                let before = time;
                time = within(point.at, before, LONGEST).max(before);
                Leg {
                    to: within(point.value, -LARGEST, LARGEST),
                    seconds: time - before,
                    curve: within(point.curve, -CURVIEST, CURVIEST),
                }
            })
            .collect();
        let sustain = match setup.constants.first() {
            Some(k) if *k >= 1.0 && (*k as usize) <= points.len() => *k as usize,
            _ => usize::MAX,
        };
        let script =
            Points { rate: setup.rate, points, sustain, at: [usize::MAX; LANES], released: [false; LANES] };
        Self { script, track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.script.at[lane] = 0;
        self.script.released[lane] = false;
        self.track.start(lane, onset.age);
    }

    fn release(&mut self, lane: usize, at: f64) {
        let script = &mut self.script;
        self.track.reach(lane, at, script);
        if script.sustain <= script.points.len() && !script.released[lane] {
            script.released[lane] = true;
            script.at[lane] = script.sustain;
            self.track.cut(lane, at, script);
        }
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        self.track.run(io, &mut self.script);
    }

    fn sounding(&self, lane: usize) -> Option<bool> {
        Some(self.track.sounding(lane))
    }

    fn value(&self, lane: usize) -> Option<f64> {
        Some(self.track.value(lane))
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    course: Course,
    width: f64,
    t: f64,
    /// The points after the one that holds, where there is one: value, seconds, curve.
    after: Option<Vec<(f64, f64, f64)>>,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let number = |v: f64, limit: f64| if v.is_nan() { 0.0 } else { v.clamp(-limit, limit) };
        let mut legs = Vec::new();
        let mut last = 0.0;
        for Point { at, value, curve } in &setup.points {
            let at = number(*at, LONGEST).max(last);
            legs.push((number(*value, LARGEST), at - last, number(*curve, CURVIEST)));
            last = at;
        }
        let sustain = setup.constants[0] as usize;
        let after = (sustain > 0 && sustain <= legs.len()).then(|| legs.split_off(sustain));
        let mut course = Course::new();
        for (value, seconds, curve) in legs {
            course.ramp(value, seconds, curve);
        }
        if after.is_some() {
            course.hold(f64::INFINITY);
        }
        Self { course, width: 1.0 / setup.rate, t: f64::NEG_INFINITY, after }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, _inputs: &[f64]) -> f64 {
        self.t = t;
        self.course.sample(t, self.width)
    }

    fn release(&mut self, t: f64) {
        if let Some(legs) = self.after.take() {
            self.course.cut(t);
            for (value, seconds, curve) in legs {
                self.course.ramp(value, seconds, curve);
            }
        }
    }

    fn sounding(&self) -> Option<bool> {
        Some(!self.course.is_over(self.t))
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::{Bench, error_db};
    use crate::node::kernel::Point;

    fn bench(points: &[(f64, f64, f64)]) -> Bench {
        let points: Vec<Point> = points.iter().map(|&(at, value, curve)| Point { at, value, curve }).collect();
        Bench::new("breakpoints", 8000.0).points(&points)
    }

    const HILLS: [(f64, f64, f64); 6] = [
        (0.0, 0.5, 0.0),
        (0.01, 1.0, 3.0),
        (0.0253, -0.7, 0.0),
        (0.0253, 0.2, 0.0),
        (0.0331, 0.9, -5.0),
        (0.0502, 0.0, -3.0),
    ];

    #[test]
    fn every_point_is_exact_within_the_band() {
        for age in [-1.0, -1.3, -1.6, -1.99] {
            for bench in [bench(&HILLS), bench(&HILLS).constant("sustain", 5.0).released(0.1)] {
                let bench = bench.age(age);
                let error = bench.band_error_db::<f32>(1200, 64);
                assert!(error < -110.0, "{age}: {error}");
            }
        }
    }

    #[test]
    fn a_release_before_the_holding_point_goes_on_from_there() {
        for released in [0.0, 0.004, 0.0253, 0.03] {
            let bench = bench(&HILLS).constant("sustain", 5.0).released(released);
            let error = bench.band_error_db::<f32>(1200, 64);
            assert!(error < -100.0, "{released}: {error}");
            let end = bench.ends::<f32>(1200).unwrap_or(0);
            assert!((end as f64 - 8000.0 * (released + 0.0171) - 12.1).abs() < 0.6, "{released}: {end}");
        }
    }

    #[test]
    fn between_the_points_it_is_the_definition() {
        let bench = bench(&[(3.0, 1.0, 2.0), (6.0, 0.2, 0.0), (9.0, 0.0, -4.0)]);
        let (kernel, twin) = (bench.kernel::<f32>(80_000, &[64]), bench.twin(80_000, 1));
        assert!(error_db(&kernel, &twin) < -110.0);
        for second in [0, 3, 6] {
            let span = second * 8000 + 20..(second + 3) * 8000 - 20;
            assert!(error_db(&kernel[span.clone()], &twin[span]) < -140.0, "{second}");
        }
    }

    #[test]
    fn blocks_lanes_and_neighbours_do_not_matter() {
        bench(&HILLS).check_contract();
        bench(&HILLS).constant("sustain", 3.0).released(0.05).check_contract();
    }

    #[test]
    fn odd_points_neither_stall_nor_break_it() {
        let crowd: Vec<(f64, f64, f64)> = (0..5000).map(|k| (1e-7 * f64::from(k), f64::from(k % 2), 9.0)).collect();
        let hostile = [(f64::NAN, f64::NAN, f64::NAN), (-1.0, 1e300, f64::INFINITY), (f64::INFINITY, -1.0, 1.0)];
        for points in [&crowd[..], &hostile, &[], &[(0.01, 1.0, 0.0)]] {
            let bench = bench(points);
            assert!(bench.kernel::<f32>(300, &[64]).iter().all(|v| v.is_finite() && v.abs() < 2e6));
            bench.check_contract();
        }
        assert_eq!(bench(&crowd).ends::<f32>(300), Some(16));
        assert_eq!(bench(&[]).ends::<f32>(300), Some(12));
        assert_eq!(bench(&HILLS).constant("sustain", 5.0).ends::<f32>(3000), None);
    }
}
