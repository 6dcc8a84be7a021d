//! Attack, decay, sustain, release.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::legs::{CURVIEST, LONGEST, Leg, LegScript, Legs, within};
use super::segment::Track;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::Real;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "envelope",
    family: Family::Envelope,
    summary: "Attack, decay, sustain, release: follows the event for as long as it lasts.",
    detail: "From 0 to 1 in `attack`, to `sustain` in `decay`, held there until the event ends, then from whatever the value \
             is to 0 in `release`. A time of 0 is a jump. All instants are exact and may fall between samples; jumps and \
             corners are band-limited. A stretch from a to b is a + (b − a)(e^(cu) − 1)/(e^c − 1) at the share u of its time, \
             c its curve: 0 is a straight line, below 0 fast at first, above 0 slow at first. |c| is limited to 16,000 a second \
             of its time, as steeper curves differ above 1 kHz only. With a sustain of 0 it ends with the decay. Values of an \
             event that are outside a range are limited to it, and what is not a number is 0.",
    params: &[
        Param { name: "attack", kind: Kind::Start(Numeric::or(0.005, 0.0, LONGEST)), unit: "s", doc: "Time to reach 1." },
        Param { name: "decay", kind: Kind::Start(Numeric::or(0.0, 0.0, LONGEST)), unit: "s", doc: "Time from there to `sustain`." },
        Param { name: "sustain", kind: Kind::Start(Numeric::or(1.0, 0.0, 1.0)), unit: "", doc: "Value held until the release." },
        Param { name: "release", kind: Kind::Start(Numeric::or(0.005, 0.0, LONGEST)), unit: "s", doc: "Time from the release to 0." },
        Param { name: "attack_curve", kind: Kind::Start(Numeric::or(0.0, -CURVIEST, CURVIEST)), unit: "", doc: "Curve of the attack." },
        Param { name: "decay_curve", kind: Kind::Start(Numeric::or(0.0, -CURVIEST, CURVIEST)), unit: "", doc: "Curve of the decay." },
        Param { name: "release_curve", kind: Kind::Start(Numeric::or(0.0, -CURVIEST, CURVIEST)), unit: "", doc: "Curve of the release." },
    ],
    example: r#"hit = { type = "envelope", attack = 0.004, decay = 0.08, sustain = 0.3, release = 0.02 }"#,
};

/// The legs of eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    script: LegScript,
    track: Track<R>,
}

/// The legs, as inputs have them.
fn legs(start: &[f64]) -> Legs {
    let [attack, decay, release] = [0, 1, 3].map(|i| within(start[i], 0.0, LONGEST));
    let sustain = within(start[2], 0.0, 1.0);
    let [up, down, off] = [4, 5, 6].map(|i| within(start[i], -CURVIEST, CURVIEST));
    Legs {
        first: [
            Leg { to: 1.0, seconds: attack, curve: up },
            Leg { to: sustain, seconds: decay, curve: down },
            Leg { to: sustain, seconds: 0.0, curve: 0.0 },
        ],
        release: Some(Leg { to: 0.0, seconds: release, curve: off }),
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
    release: (f64, f64),
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let number = |i: usize| if onset.start[i].is_nan() { 0.0 } else { onset.start[i] };
        let time = |i: usize| number(i).clamp(0.0, LONGEST);
        let curve = |i: usize| number(i).clamp(-CURVIEST, CURVIEST);
        let mut course = Course::new();
        course.ramp(1.0, time(0), curve(4));
        course.ramp(number(2).clamp(0.0, 1.0), time(1), curve(5));
        if number(2) > 0.0 {
            course.hold(f64::INFINITY);
        }
        Self { course, width: 1.0 / setup.rate, t: f64::NEG_INFINITY, release: (time(3), curve(6)) }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, _inputs: &[f64]) -> f64 {
        self.t = t;
        self.course.sample(t, self.width)
    }

    fn release(&mut self, t: f64) {
        self.course.cut(t);
        self.course.ramp(0.0, self.release.0, self.release.1);
    }

    fn sounding(&self) -> Option<bool> {
        Some(!self.course.is_over(self.t))
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::{Bench, error_db};

    fn bench(times: [f64; 4], curves: [f64; 3], sustain: f64) -> Bench {
        Bench::new("envelope", 8000.0)
            .steady("attack", times[0])
            .steady("decay", times[1])
            .steady("sustain", sustain)
            .steady("release", times[2])
            .steady("attack_curve", curves[0])
            .steady("decay_curve", curves[1])
            .steady("release_curve", curves[2])
            .released(times[3])
    }

    const LINEAR: [f64; 3] = [0.0; 3];

    /// Within 0 to 1 kHz, jumps and corners are those of the continuous envelope.
    #[test]
    fn all_instants_are_exact_within_the_band() {
        for (times, curves, sustain, limit) in [
            ([0.004, 0.08, 0.02, 0.1], LINEAR, 0.3, -120.0),
            ([0.001, 0.001, 0.001, 0.1], LINEAR, 0.3, -120.0),
            ([0.0, 0.0, 0.0, 0.1], LINEAR, 1.0, -115.0),
            ([0.0, 0.0, 0.0, 0.0002], LINEAR, 1.0, -90.0),
            ([0.001, 0.001, 0.001, 0.1], [5.0, -10.0, 5.0], 0.3, -105.0),
            ([0.001, 0.001, 0.001, 0.1], [16.0, -16.0, 20.0], 0.3, -90.0),
            ([0.01, 0.02, 0.03, 0.005], [-4.0, 0.0, -4.0], 0.3, -110.0),
        ] {
            for age in [-1.0, -1.3, -1.6, -1.99] {
                let bench = bench(times, curves, sustain).age(age);
                let (double, single) = (bench.band_error_db::<f64>(1500, 64), bench.band_error_db::<f32>(1500, 64));
                assert!(double < limit && single < limit, "{times:?} {curves:?} {age}: {double} {single}");
            }
        }
    }

    /// Away from them, it is the definition, sample by sample.
    #[test]
    fn segments_are_exact_between_the_corners() {
        let bench = bench([2.0, 3.0, 2.0, 7.0], [0.0, -3.0, 4.0], 0.4).age(-1.37);
        let twin = bench.twin(80_000, 1);
        for (kernel, limit) in [(bench.kernel::<f32>(80_000, &[64]), -140.0), (bench.kernel::<f64>(80_000, &[64]), -200.0)] {
            assert!(error_db(&kernel, &twin) < -110.0);
            // Corners at 0, 2, 5, 7 and 9 s.
            for (from, to) in [(20, 15_990), (16_020, 39_990), (40_020, 55_990), (56_020, 71_990), (72_020, 80_000)] {
                let error = error_db(&kernel[from..to], &twin[from..to]);
                assert!(error < limit, "{from}: {error}");
            }
        }
    }

    /// Level and swing of a hardly curved segment are huge and cancel, so a run must not go on for long.
    #[test]
    fn a_hardly_curved_segment_is_as_exact() {
        let bench = bench([10.0, 0.0, 0.0, 20.0], [2e-6, 0.0, 0.0], 1.0);
        let error = error_db(&bench.kernel::<f64>(79_000, &[64])[20..], &bench.twin(79_000, 1)[20..]);
        assert!(error < -130.0, "{error}");
    }

    #[test]
    fn blocks_lanes_and_neighbours_do_not_matter() {
        bench([0.004, 0.08, 0.02, 0.1], LINEAR, 0.3).check_contract();
        bench([0.004, 0.05, 0.02, 0.07], [-3.0, 0.0, 5.0], 0.3).age(-1.0).check_contract();
        bench([0.0, 0.0, 0.0, 0.0], LINEAR, 0.5).check_contract();
        bench([1e-6, 0.0, 1e-5, 0.01], LINEAR, 0.5).check_contract();
    }

    #[test]
    fn it_is_exactly_zero_once_it_says_so() {
        for (times, sustain) in [
            ([0.004, 0.08, 0.02, 0.1], 0.3),
            ([0.0, 0.0, 0.0, 0.01], 1.0),
            ([0.1, 0.0, 0.01, 0.02], 1.0),
            ([0.01, 0.02, 0.01, 0.09], 0.0),
            ([0.001, 0.01, 0.02, 0.0], 0.5),
            ([0.0, 0.01, 0.02, 0.0], 0.5),
        ] {
            let bench = bench(times, [0.0, -4.0, -4.0], sustain);
            let samples = bench.kernel::<f32>(2000, &[64]);
            let end = bench.ends::<f32>(2000).unwrap_or(usize::MAX);
            let held = if sustain == 0.0 { times[0] + times[1] } else { times[3] + times[2] };
            assert!((end as f64 - held * 8000.0 - 12.1).abs() < 0.6, "{times:?}: {end}");
            assert!(samples[end..].iter().all(|v| v.to_bits() == 0), "{times:?}");
        }
        assert_eq!(Bench::new("envelope", 8000.0).ends::<f32>(4000), None);
    }

    #[test]
    fn a_release_at_the_onset_of_a_jump_leaves_nothing() {
        let samples = bench([0.0, 0.0, 0.0, 0.0], LINEAR, 1.0).kernel::<f32>(100, &[64]);
        assert!(samples.iter().all(|v| *v == 0.0), "{samples:?}");
    }

    #[test]
    fn hostile_numbers_are_limited() {
        let hostile = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 1e300, 1e-300, 5e-324, 0.0, 3e-5];
        for a in hostile {
            for b in hostile {
                let bench = bench([a, b, a, 0.01], [b, a, b], b);
                let (kernel, twin) = (bench.kernel::<f32>(300, &[64]), bench.twin(300, 1));
                assert!(kernel.iter().all(|v| v.abs() < 1.2), "{a} {b}: {kernel:?}");
                // What the two settle on is the same.
                assert!((kernel[70] - twin[70]).abs() < 1e-6, "{a} {b}: {} {}", kernel[70], twin[70]);
                assert!((kernel[299] - twin[299]).abs() < 1e-6, "{a} {b}: {} {}", kernel[299], twin[299]);
            }
        }
    }

    #[test]
    fn a_voice_that_starts_over_sounds_like_a_new_one() {
        use crate::dsp::lanes::LANES;
        use crate::node::States;
        use crate::node::kernel::{Io, Onset};
        let bench = bench([0.004, 0.08, 0.02, 0.1], [0.0, -4.0, 0.0], 0.3);
        let start = [0.004, 0.08, 0.3, 0.02, 0.0, -4.0, 0.0];
        let mut states = States::<f32>::new(bench.kind, &bench.setup, 1);
        let mut block = vec![[0.0; LANES]; 33];
        let onset = |age: f64| Onset { age, stream: 0, start: &start };
        let mut last = Vec::new();
        for age in [-1.9, -1.2, -1.6] {
            states.start(0, 3, &onset(age));
            last.clear();
            for _ in 0..3 {
                states.run(crate::dsp::isa::Isa::detect(), 0, &mut Io { inputs: &[], output: &mut block, still: false });
                last.extend(block.iter().map(|row| f64::from(row[3])));
            }
        }
        assert_eq!(last, bench.kernel::<f32>(99, &[64]));
    }
}
