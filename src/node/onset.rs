//! The onset itself.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::segment::{Script, Segment, Track};
use super::spec::{Family, NodeSpec};
use crate::dsp::lanes::Real;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "onset",
    family: Family::Envelope,
    summary: "0 before the onset, 1 from there on.",
    detail: "A jump at its exact instant, which may fall between samples, band-limited. It never ends, and a voice does not wait for it. \
             What comes before the onset is not heard in any case: where a filter or a delay would remember it, this node is put in by itself.",
    params: &[],
    example: r#"from_here = { type = "onset" }"#,
};

/// Eight jumps.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    track: Track<R>,
}

/// 1 for ever.
struct On;

impl Script for On {
    fn next(&mut self, _lane: usize, _value: f64) -> Segment {
        Segment::hold(1.0, f64::INFINITY)
    }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(_setup: &Setup) -> Self {
        Self { track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.track.start(lane, onset.age);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        self.track.run(io, &mut On);
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    course: Course,
    width: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let mut course = Course::new();
        course.ramp(1.0, 0.0, 0.0);
        course.hold(f64::INFINITY);
        Self { course, width: 1.0 / setup.rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, _inputs: &[f64]) -> f64 {
        self.course.sample(t, self.width)
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn it_is_a_jump_at_its_instant() {
        for age in [-1.0, -1.37, -1.99] {
            let bench = Bench::new("onset", 8000.0).age(age);
            bench.check_contract();
            let error = bench.band_error_db::<f32>(600, 64);
            assert!(error < -115.0, "{age}: {error}");
            assert!(bench.kernel::<f32>(600, &[64])[12..].iter().all(|v| *v == 1.0));
            assert_eq!(bench.ends::<f32>(600), None);
        }
    }
}
