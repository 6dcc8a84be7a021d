//! What the hand does that holds the voice.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::motion::Motion;
use super::segment::{Script, Segment, Track};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// Seconds that it takes to a new value where nothing is said.
pub const SMOOTHING: f64 = 0.01;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "touch",
    family: Family::Input,
    summary: "How the voice is bent or pressed while it sounds.",
    detail: "Pitch bend, pressure and timbre of the note that plays the voice (MIDI, MPE), or what a program or OSC says of this one voice. \
             `detune` is the share by which the frequency is moved: 0 at rest, 0.0595 a semitone up, 1 an octave. `pressure` goes from 0, at \
             rest, to 1, `timbre` from 0 to 1 with 64/127 in its middle. What is known at the onset it has from the beginning; each new value is \
             reached in `smoothing` seconds, in a straight line from wherever it stands. Lines begin and end at their exact instants, \
             between samples too, band-limited. In an expression, `touch.pressure` and `touch.timbre` are short for this node, and \
             `touch.bend` for 1 + `detune`: frequency = \"event.frequency * touch.bend\".",
    params: &[
        Param { name: "of", kind: Kind::Choice(Motion::WORDS, 0), unit: "", doc: "What of it." },
        Param {
            name: "smoothing",
            kind: Kind::Constant(Numeric::or(SMOOTHING, 0.0, 10.0)),
            unit: "s",
            doc: "How long it takes to each new value.",
        },
    ],
    example: r#"push = { type = "touch", of = "pressure", smoothing = 0.03 }"#,
};

/// What a setup says: which motion, and the seconds it takes.
fn read(setup: &Setup) -> (Motion, f64) {
    let motion = setup.choices.first().and_then(|i| Motion::ALL.get(*i)).copied().unwrap_or(Motion::Detune);
    (motion, setup.constants.first().copied().unwrap_or(SMOOTHING))
}

/// Where eight lanes are on their way to.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    motion: Motion,
    script: Ways,
    track: Track<R>,
}

/// The ways of eight lanes, as a script.
#[derive(Debug, Clone)]
struct Ways {
    rate: f64,
    smoothing: f64,
    to: [f64; LANES],
    /// Whether a lane is to set out for a new value, or to stay.
    sets_out: [bool; LANES],
    /// Whether it has been asked where it begins.
    begun: [bool; LANES],
}

impl Script for Ways {
    fn next(&mut self, lane: usize, value: f64) -> Segment {
        self.begun[lane] = true;
        if std::mem::take(&mut self.sets_out[lane]) {
            Segment::ramp(value, self.to[lane], self.smoothing, 0.0, self.rate)
        } else {
            Segment::hold(self.to[lane], f64::INFINITY)
        }
    }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let (motion, smoothing) = read(setup);
        let script = Ways {
            rate: setup.rate,
            smoothing,
            to: [0.0; LANES],
            sets_out: [false; LANES],
            begun: [true; LANES],
        };
        Self { motion, script, track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.script.to[lane] = self.motion.rest();
        (self.script.sets_out[lane], self.script.begun[lane]) = (false, false);
        self.track.start(lane, onset.age);
        self.track.since_ever(lane, self.motion.rest());
    }

    fn touch(&mut self, lane: usize, motion: Motion, value: f64, at: f64) {
        let Some(value) = self.motion.within(value).filter(|_| motion == self.motion) else { return };
        if value == self.script.to[lane] {
            return;
        }
        if at <= 0.0 && !self.script.begun[lane] {
            self.script.to[lane] = value;
            self.track.since_ever(lane, value);
            return;
        }
        self.track.reach(lane, at, &mut self.script);
        (self.script.to[lane], self.script.sets_out[lane]) = (value, true);
        self.track.cut(lane, at, &mut self.script);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        self.track.run(io, &mut self.script);
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    motion: Motion,
    smoothing: f64,
    /// What it was at the onset and before, and where it is on its way to.
    first: f64,
    to: f64,
    /// What was added since.
    course: Course,
    width: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let (motion, smoothing) = read(setup);
        let (first, mut course) = (motion.rest(), Course::new());
        course.hold(f64::INFINITY);
        Self { motion, smoothing, first, to: first, course, width: 1.0 / setup.rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, _inputs: &[f64]) -> f64 {
        self.course.forget(t - 2.0 * self.width);
        self.first + self.course.sample(t, self.width)
    }

    fn touch(&mut self, t: f64, motion: Motion, value: f64) {
        let Some(value) = self.motion.within(value).filter(|_| motion == self.motion) else { return };
        if t <= 0.0 {
            (self.first, self.to) = (value, value);
        } else if value != self.to {
            self.to = value;
            self.course.cut(t);
            self.course.ramp(value - self.first, self.smoothing, 0.0);
            self.course.hold(f64::INFINITY);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Motion;
    use crate::node::harness::Bench;

    /// A hand that presses: known at the onset, and moved again and again, also while it is still on its way, and twice within a sample.
    fn pressed(first: f64, smoothing: f64) -> Bench {
        let bench = Bench::new("touch", 8000.0).choice("of", 1).constant("smoothing", smoothing);
        let bench = bench.touched(0.0, Motion::Pressure, first).touched(0.0, Motion::Timbre, 0.9);
        let ways = [(0.01003, 1.0), (0.0149, 0.2), (0.014951, 0.6), (0.01502, 0.55), (0.05, 0.0), (0.0701, 0.7)];
        ways.into_iter().fold(bench, |bench, (t, value)| bench.touched(t, Motion::Pressure, value))
    }

    #[test]
    fn it_goes_in_straight_lines_between_exact_instants() {
        for (smoothing, limit) in [(0.01, -100.0), (0.002, -95.0), (0.0003, -80.0), (0.0, -80.0)] {
            for age in [-1.0, -1.37, -1.99] {
                let error = pressed(0.0, smoothing).age(age).band_error_db::<f32>(1200, 64);
                assert!(error < limit, "{smoothing} {age}: {error}");
            }
        }
    }

    #[test]
    fn it_arrives_and_stays_exactly() {
        for blocks in [&[64][..], &[1], &[7, 3]] {
            let samples = pressed(0.25, 0.01).kernel::<f64>(1200, blocks);
            assert!(samples[..75].iter().all(|v| *v == 0.25), "{:?}", &samples[..80]);
            assert!(samples[500..550].iter().all(|v| v.to_bits() == 0), "{:?}", &samples[490..560]);
            assert!(samples[660..].iter().all(|v| *v == 0.7));
        }
    }

    #[test]
    fn of_a_hand_at_rest_it_is_what_rest_is() {
        for (number, motion) in Motion::ALL.into_iter().enumerate() {
            let bench = Bench::new("touch", 8000.0).choice("of", number);
            let samples = bench.kernel::<f64>(300, &[64]);
            assert!(samples.iter().all(|v| *v == motion.rest()), "{motion:?}");
            assert_eq!(bench.ends::<f32>(300), None);
        }
    }

    #[test]
    fn hostile_values_stay_within_what_a_hand_can_do() {
        let odd = [f64::NAN, f64::INFINITY, -1e308, f64::NAN, 1e308, f64::NEG_INFINITY, -0.0];
        for (number, motion) in Motion::ALL.into_iter().enumerate() {
            let mut bench = Bench::new("touch", 8000.0).choice("of", number).constant("smoothing", 0.0001);
            for (i, value) in odd.into_iter().enumerate() {
                bench = bench.touched(0.01 * i as f64, motion, value);
            }
            let (least, most) = if motion == Motion::Detune { (-1.0, 1023.0) } else { (0.0, 1.0) };
            let overshoot = 0.2 * (most - least);
            let samples = bench.kernel::<f32>(1000, &[64]);
            assert!(samples.iter().all(|v| (least - overshoot..most + overshoot).contains(v)), "{motion:?}");
            bench.check_contract();
        }
    }

    #[test]
    fn blocks_lanes_and_neighbours_do_not_matter() {
        pressed(0.25, 0.01).check_contract();
        pressed(0.5, 0.0).check_contract();
    }
}
