//! On while the event lasts.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::legs::{LONGEST, Leg, LegScript, Legs, within};
use super::segment::Track;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::Real;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "gate",
    family: Family::Envelope,
    summary: "1 while the event lasts, else 0.",
    detail: "From 0 to 1 in `rise`, and from the end of the event to 0 in `fall`, in straight lines. A time of 0 is a jump. Both \
             instants are exact and may fall between samples; jumps and corners are band-limited. Values of an event that are \
             outside a range are limited to it, and what is not a number is 0.",
    params: &[
        Param { name: "rise", kind: Kind::Start(Numeric::or(0.0, 0.0, LONGEST)), unit: "s", doc: "Time from 0 to 1." },
        Param { name: "fall", kind: Kind::Start(Numeric::or(0.0, 0.0, LONGEST)), unit: "s", doc: "Time from 1 to 0." },
    ],
    example: r#"on = { type = "gate", rise = 0.002, fall = 0.002 }"#,
};

/// The legs of eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    script: LegScript,
    track: Track<R>,
}

/// The legs, as inputs have them.
fn legs(start: &[f64]) -> Legs {
    let [rise, fall] = [0, 1].map(|i| within(start[i], 0.0, LONGEST));
    let on = Leg { to: 1.0, ..Leg::default() };
    Legs {
        first: [Leg { seconds: rise, ..on }, on, on],
        release: Some(Leg { to: 0.0, seconds: fall, curve: 0.0 }),
    }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { script: LegScript::new(setup.rate), track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.script.start(lane, legs(onset.start));
        self.track.start(lane, onset.age);
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.script.retune(lane, &legs(now));
    }

    fn release(&mut self, lane: usize, at: f64) {
        self.track.reach(lane, at, &mut self.script);
        if self.script.release(lane) {
            self.track.cut(lane, at, &mut self.script);
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
    fall: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let time = |i: usize| if onset.start[i] > 0.0 { onset.start[i].min(LONGEST) } else { 0.0 };
        let mut course = Course::new();
        course.ramp(1.0, time(0), 0.0);
        course.hold(f64::INFINITY);
        Self { course, width: 1.0 / setup.rate, t: f64::NEG_INFINITY, fall: time(1) }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, _inputs: &[f64]) -> f64 {
        self.t = t;
        self.course.sample(t, self.width)
    }

    fn release(&mut self, t: f64) {
        self.course.cut(t);
        self.course.ramp(0.0, self.fall, 0.0);
    }

    fn sounding(&self) -> Option<bool> {
        Some(!self.course.is_over(self.t))
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    fn bench(rise: f64, fall: f64, held: f64) -> Bench {
        Bench::new("gate", 8000.0).steady("rise", rise).steady("fall", fall).released(held)
    }

    #[test]
    fn both_instants_are_exact_within_the_band() {
        for (rise, fall, held, limit) in
            [(0.0, 0.0, 0.1, -115.0), (0.0, 0.0, 0.001, -105.0), (0.002, 0.001, 0.05, -115.0), (0.01, 0.0, 0.004, -100.0)]
        {
            for age in [-1.0, -1.3, -1.99] {
                let error = bench(rise, fall, held).age(age).band_error_db::<f32>(1200, 64);
                assert!(error < limit, "{rise} {fall} {held} {age}: {error}");
            }
        }
    }

    #[test]
    fn it_is_one_in_between_and_zero_after() {
        let bench = bench(0.0, 0.0, 0.1);
        let samples = bench.kernel::<f32>(900, &[64]);
        assert!(samples[12..800].iter().all(|v| *v == 1.0));
        let end = bench.ends::<f32>(900).unwrap_or(0);
        assert!(samples[end..].iter().all(|v| v.to_bits() == 0) && (810..816).contains(&end), "{end}");
    }

    #[test]
    fn blocks_lanes_and_neighbours_do_not_matter() {
        bench(0.0, 0.0, 0.1).check_contract();
        bench(0.003, 0.002, 0.0101).check_contract();
    }
}
