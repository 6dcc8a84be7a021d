//! Attack, hold, decay: an envelope that ends by itself.

use super::course::Course;
use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::legs::{CURVIEST, LONGEST, Leg, LegScript, Legs, within};
use super::segment::Track;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::Real;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "burst",
    family: Family::Envelope,
    summary: "Attack, hold, decay: runs once from the onset, however long the event lasts.",
    detail: "From 0 to 1 in `attack`, held there for `hold`, to 0 in `decay`. The release is ignored. Times of 0, instants, curves \
             and values outside a range are as in `envelope`.",
    params: &[
        Param { name: "attack", kind: Kind::Start(Numeric::or(0.001, 0.0, LONGEST)), unit: "s", doc: "Time to reach 1." },
        Param { name: "hold", kind: Kind::Start(Numeric::or(0.0, 0.0, LONGEST)), unit: "s", doc: "Time at 1." },
        Param { name: "decay", kind: Kind::Start(Numeric::or(0.05, 0.0, LONGEST)), unit: "s", doc: "Time from there to 0." },
        Param { name: "attack_curve", kind: Kind::Start(Numeric::or(0.0, -CURVIEST, CURVIEST)), unit: "", doc: "Curve of the attack." },
        Param { name: "decay_curve", kind: Kind::Start(Numeric::or(0.0, -CURVIEST, CURVIEST)), unit: "", doc: "Curve of the decay." },
    ],
    example: r#"tap = { type = "burst", attack = 0.001, decay = 0.03, decay_curve = -4 }"#,
};

/// The legs of eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    script: LegScript,
    track: Track<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { script: LegScript::new(setup.rate), track: Track::new() }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let [attack, hold, decay] = [0, 1, 2].map(|i| within(onset.start[i], 0.0, LONGEST));
        let [up, down] = [3, 4].map(|i| within(onset.start[i], -CURVIEST, CURVIEST));
        let legs = Legs {
            first: [
                Leg { to: 1.0, seconds: attack, curve: up },
                Leg { to: 1.0, seconds: hold, curve: 0.0 },
                Leg { to: 0.0, seconds: decay, curve: down },
            ],
            release: None,
        };
        self.script.start(lane, legs);
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
        let number = |i: usize| if onset.start[i].is_nan() { 0.0 } else { onset.start[i] };
        let time = |i: usize| number(i).clamp(0.0, LONGEST);
        let curve = |i: usize| number(i).clamp(-CURVIEST, CURVIEST);
        let mut course = Course::new();
        course.ramp(1.0, time(0), curve(3));
        course.hold(time(1));
        course.ramp(0.0, time(2), curve(4));
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
    use crate::node::harness::Bench;

    fn bench(attack: f64, hold: f64, decay: f64, curve: f64) -> Bench {
        let bench = Bench::new("burst", 7350.0).steady("attack", attack).steady("hold", hold);
        bench.steady("decay", decay).steady("decay_curve", curve).steady("attack_curve", -curve)
    }

    #[test]
    fn it_is_exact_within_the_band_whatever_the_release() {
        for (attack, hold, decay, curve, limit) in [
            (0.001, 0.0, 0.05, 0.0, -120.0),
            (0.002, 0.01, 0.03, -4.0, -105.0),
            (0.0, 0.001, 0.0, 0.0, -100.0),
            (0.0005, 0.0, 0.0005, 3.0, -80.0),
        ] {
            for age in [-1.0, -1.3, -1.99] {
                let bench = bench(attack, hold, decay, curve).age(age);
                let error = bench.band_error_db::<f32>(900, 64);
                assert!(error < limit, "{attack} {hold} {decay} {curve} {age}: {error}");
                let released = bench.clone().released(0.0004).kernel::<f32>(900, &[64]);
                assert_eq!(released, bench.kernel::<f32>(900, &[64]));
            }
        }
    }

    #[test]
    fn it_ends_by_itself() {
        let bench = bench(0.01, 0.01, 0.01, -4.0);
        let end = bench.ends::<f32>(900).unwrap_or(0);
        assert!((end as f64 - 0.03 * 7350.0 - 12.1).abs() < 0.6, "{end}");
        assert!(bench.kernel::<f32>(900, &[64])[end..].iter().all(|v| v.to_bits() == 0));
    }

    #[test]
    fn blocks_lanes_and_neighbours_do_not_matter() {
        bench(0.001, 0.004, 0.05, -4.0).check_contract();
        bench(0.0, 0.0, 0.0, 0.0).check_contract();
    }
}
