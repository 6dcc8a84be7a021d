//! Exponential decay.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::legs::{LONGEST, within};
use super::segment::{STEEPEST, Script, Segment, Track};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "decay",
    family: Family::Envelope,
    summary: "Exponential decay, as of something struck: runs once from the onset, however long the event lasts.",
    detail: "From 0 to 1 in `attack`, in a straight line, then e^(−t/time). At −120 dB (1e-6, after 13.8 × `time`) it steps to \
             0 and ends. The release is ignored. Instants are exact and may fall between samples; jumps and corners are \
             band-limited. A `time` below 62.5 µs is taken as that: shorter ones differ above 1 kHz only. Values of an event \
             that are outside a range are limited to it, and what is not a number is 0.",
    params: &[
        Param {
            name: "attack",
            kind: Kind::Start(Numeric::or(0.0, 0.0, LONGEST)),
            unit: "s",
            doc: "Time to reach 1.",
        },
        Param {
            name: "time",
            kind: Kind::Start(Numeric::or(0.05, 0.0, LONGEST)),
            unit: "s",
            doc: "Time constant: time in which it falls to 1/e, or by 8.7 dB.",
        },
    ],
    example: r#"ring = { type = "decay", time = 0.04 }"#,
};

/// Time constants until the end: ln 1e6.
const SPAN: f64 = 13.815_510_557_964_274;

/// The times of eight lanes, and what comes next.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    script: Times,
    track: Track<R>,
}

#[derive(Debug, Clone)]
struct Times {
    rate: f64,
    attack: [f64; LANES],
    time: [f64; LANES],
    at: [usize; LANES],
}

impl Script for Times {
    fn next(&mut self, lane: usize, value: f64) -> Segment {
        self.at[lane] += 1;
        match self.at[lane] {
            1 => Segment::ramp(value, 1.0, self.attack[lane], 0.0, self.rate),
            2 => Segment::decay(1.0, self.time[lane], SPAN * self.time[lane], self.rate),
            _ => Segment::end(),
        }
    }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let script = Times { rate: setup.rate, attack: [0.0; LANES], time: [1.0; LANES], at: [0; LANES] };
        Self { script, track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.script.attack[lane] = within(onset.start[0], 0.0, LONGEST);
        self.script.time[lane] = within(onset.start[1], 1.0 / STEEPEST, LONGEST);
        self.script.at[lane] = 0;
        self.track.start(lane, onset.age);
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
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let number = |i: usize| if onset.start[i] > 0.0 { onset.start[i].min(LONGEST) } else { 0.0 };
        let mut course = Course::new();
        course.ramp(1.0, number(0), 0.0);
        course.fall(1e-6, number(1).max(62.5e-6));
        Self { course, width: 1.0 / setup.rate, t: f64::NEG_INFINITY }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, _inputs: &[f64]) -> f64 {
        self.t = t;
        self.course.sample(t, self.width)
    }

    fn sounding(&self) -> Option<bool> {
        Some(!self.course.is_over(self.t))
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::{Bench, error_db};

    fn bench(attack: f64, time: f64) -> Bench {
        Bench::new("decay", 8000.0).steady("attack", attack).steady("time", time)
    }

    #[test]
    fn its_onset_is_exact_within_the_band() {
        for (attack, time, limit) in
            [(0.0, 0.05, -115.0), (0.002, 0.02, -115.0), (0.0, 0.002, -105.0), (0.0, 0.0005, -100.0), (0.0, 0.0, -60.0)]
        {
            for age in [-1.0, -1.4, -1.99] {
                let error = bench(attack, time).age(age).band_error_db::<f32>(1000, 64);
                assert!(error < limit, "{attack} {time} {age}: {error}");
            }
        }
    }

    #[test]
    fn it_falls_by_an_e_in_its_time() {
        let bench = bench(0.0, 0.5).age(-1.25);
        let (single, double) = (bench.kernel::<f32>(80_000, &[64]), bench.kernel::<f64>(80_000, &[64]));
        let exact: Vec<f64> = (0..80_000).map(|n| (-(n as f64 - 1.25) / 4000.0).exp()).collect();
        assert!(error_db(&single[20..55_000], &exact[20..55_000]) < -140.0);
        assert!(error_db(&double[20..55_000], &exact[20..55_000]) < -200.0);
        // The definition too, the step at its end included.
        let twin = bench.twin(80_000, 1);
        assert!(error_db(&single[20..], &twin[20..]) < -140.0);
        assert!(bench.ends::<f32>(80_000) == Some((0.5 * 8000.0 * 1e6_f64.ln() + 11.25).ceil() as usize));
    }

    #[test]
    fn blocks_lanes_and_neighbours_do_not_matter() {
        bench(0.001, 0.01).released(0.005).check_contract();
    }

    #[test]
    fn hostile_numbers_are_limited() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 1e300, 1e-300] {
            for bench in [bench(value, 0.01), bench(0.0, value), bench(value, value)] {
                assert!(bench.kernel::<f32>(300, &[64]).iter().all(|v| v.abs() < 1.2), "{value}");
            }
        }
    }
}
