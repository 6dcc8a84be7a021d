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
#[derive(Debug)]
pub struct Lanes<R> {
    script: LegScript,
    track: Track<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { script: LegScript::new(setup.rate), track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let [rise, fall] = [0, 1].map(|i| within(onset.start[i], 0.0, LONGEST));
        let on = Leg { to: 1.0, ..Leg::default() };
        let legs = Legs {
            first: [Leg { seconds: rise, ..on }, on, on],
            release: Some(Leg { to: 0.0, seconds: fall, curve: 0.0 }),
        };
        self.script.start(lane, legs);
        self.track.start(lane, onset.age);
    }

    fn release(&mut self, lane: usize, at: f64) {
        self.track.reach(lane, at, &mut self.script);
        if self.script.release(lane) {
            self.track.cut(lane, at, &mut self.script);
        }
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        self.track.run(io.output, &mut self.script);
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
