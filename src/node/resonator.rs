//! Resonator.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::svf::{Filters, Single};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "resonator",
    family: Family::Filter,
    summary: "Rings at a frequency for a time.",
    detail: "(s/qω) / (1 + s/qω + s²/ω²) with q = π frequency decay / ln 1000: gain 1 at its frequency, and after a knock it falls by 60 dB in `decay` seconds. \
             It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its frequency; the decay grows \
             longer towards the edge of the band, by 2πf/rate over its sine: 3 % at 500 Hz, 7 % at 800 Hz. The frequency is limited to 1 Hz to \
             0.45 of that rate, q to 0.1 to 1000, at every sample, however they move; an input that is not a number counts as 0. A tail \
             below −140 dB ends in silence.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "What is filtered.",
        },
        Param {
            name: "frequency",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Where it acts.",
        },
        Param {
            name: "decay",
            kind: Kind::Signal(Numeric::or(0.1, 0.0, 100.0)),
            unit: "s",
            doc: "Time to fall by 60 dB.",
        },
    ],
    example: r#"ring = { type = "resonator", input = "click", frequency = 180, decay = 0.2 }"#,
};

/// q for each turn that fits into the decay: π / ln 1000.
const Q_A_TURN: f64 = 0.454_792_117_947_280_47;

/// Eight filters.
#[derive(Debug)]
pub struct Lanes<R> {
    filters: Filters,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { filters: Filters::new(setup.rate), _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.filters.start(lane, onset.start[1], Q_A_TURN * onset.start[1] * onset.start[2]);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, frequency, decay] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let steady = frequency.is_steady() && decay.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            if !steady {
                let (hertz, seconds) = (frequency.at(frame), decay.at(frame));
                let (mut center, mut q) = ([0.0; LANES], [0.0; LANES]);
                for l in 0..LANES {
                    center[l] = hertz[l].wide();
                    q[l] = Q_A_TURN * center[l] * seconds[l].wide();
                }
                self.filters.tune(&center, &q);
            }
            let now = self.filters.step(&input.at(frame));
            for l in 0..LANES {
                out[l] = R::of(now.band[l]);
            }
        }
    }

    fn settle(&mut self) {
        self.filters.settle();
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    filters: Interleaved<Single>,
    rate: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self { filters: Interleaved::new(Single::default(), setup.rate, setup.engine_rate), rate: setup.engine_rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let q = std::f64::consts::PI * inputs[1] * inputs[2] / 1000f64.ln();
        self.filters.turn().step(inputs[0], inputs[1], q, self.rate).1
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    #[test]
    fn steady_and_moving() {
        let tone = |t: f64| (TAU * 60.0 * t).sin() + 0.5 * (TAU * 311.0 * t).cos();
        for (frequency, q) in [(5.0, 0.7), (250.0, 0.3), (800.0, 0.01)] {
            let steady = Bench::new("resonator", 8000.0).moving("input", 0.0, tone).steady("frequency", frequency).steady("decay", q);
            let error = steady.error_db::<f32>(80_000);
            assert!(error < -110.0, "{frequency} Hz: {error}");
        }
        let moving = Bench::new("resonator", 7350.0)
            .moving("input", 0.0, tone)
            .moving("frequency", 300.0, |t| 250.0 * (TAU * 13.0 * t).sin())
            .moving("decay", 0.05, |t| 0.04 * (TAU * 3.0 * t).cos());
        moving.check_contract();
        assert!(moving.error_db::<f32>(73_500) < -110.0);
        assert!(moving.error_db::<f64>(73_500) < -180.0);
    }

    #[test]
    fn a_knock_decays_by_60_db_in_the_time_given() {
        assert!((super::Q_A_TURN - std::f64::consts::PI / 1000f64.ln()).abs() < 1e-15);
        let bench = Bench::new("resonator", 8000.0)
            .age(-1.0)
            .moving("input", 0.0, |t| if t == 0.0 { 1.0 } else { 0.0 })
            .steady("frequency", 200.0)
            .steady("decay", 0.25);
        let out = bench.kernel::<f64>(4000, &[64]);
        let peak = |from: usize| out[from..from + 80].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let fall = 20.0 * (peak(2400) / peak(400)).log10();
        assert!((fall + 60.0).abs() < 0.3, "{fall}");
    }

    #[test]
    fn the_same_filter_at_sixteen_times_the_rate() {
        let bench = Bench::new("resonator", 8000.0)
            .moving("input", 0.0, |t| (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) * (TAU * 240.0 * t).sin())
            .moving("frequency", 300.0, |t| 100.0 * (TAU * 5.0 * t).sin())
            .steady("decay", 0.03);
        let error = bench.band_error_db::<f32>(4000, 16);
        assert!(error < -80.0, "{error}");
    }

    #[test]
    fn hostile_input_stays_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 4000.0, 0.0] {
            let bench = Bench::new("resonator", 8000.0)
                .moving("input", 0.0, move |t| if t < 0.01 { bad } else { 0.0 })
                .moving("frequency", 100.0, move |t| if t < 0.02 { bad } else { 0.0 })
                .moving("decay", 1.0, move |t| if t < 0.03 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() < 1e7), "{bad}");
        }
    }
}
