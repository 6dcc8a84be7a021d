//! Band-pass filter.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::svf::{Filters, Single};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "bandpass",
    family: Family::Filter,
    summary: "A band-pass filter, gain 1 at its centre.",
    detail: "(s/qω) / (1 + s/qω + s²/ω²). \
             It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its frequency. The frequency is limited to 1 Hz to \
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
            name: "q",
            kind: Kind::Signal(Numeric::or(1.0, 0.1, 1000.0)),
            unit: "",
            doc: "Frequency over bandwidth at −3 dB.",
        },
    ],
    example: r#"band = { type = "bandpass", input = "hiss", frequency = 250, q = 4 }"#,
};

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
        self.filters.start(lane, onset.start[1], onset.start[2]);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, frequency, q] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let steady = frequency.is_steady() && q.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            if !steady {
                self.filters.tune(&frequency.at(frame).map(R::wide), &q.at(frame).map(R::wide));
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
        let turn = self.filters.turn();
        turn.step(inputs[0], inputs[1], inputs[2], self.rate).1
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    #[test]
    fn steady_and_moving() {
        let tone = |t: f64| (TAU * 60.0 * t).sin() + 0.5 * (TAU * 311.0 * t).cos();
        for (frequency, q) in [(5.0, 0.7), (250.0, 30.0), (3000.0, 0.7)] {
            let steady = Bench::new("bandpass", 8000.0).moving("input", 0.0, tone).steady("frequency", frequency).steady("q", q);
            let error = steady.error_db::<f32>(80_000);
            assert!(error < -110.0, "{frequency} Hz: {error}");
        }
        let moving = Bench::new("bandpass", 7350.0)
            .moving("input", 0.0, tone)
            .moving("frequency", 300.0, |t| 250.0 * (TAU * 13.0 * t).sin())
            .moving("q", 5.0, |t| 4.0 * (TAU * 3.0 * t).cos());
        moving.check_contract();
        assert!(moving.error_db::<f32>(73_500) < -110.0);
        assert!(moving.error_db::<f64>(73_500) < -180.0);
    }

    #[test]
    fn the_same_filter_at_sixteen_times_the_rate() {
        let bench = Bench::new("bandpass", 8000.0)
            .moving("input", 0.0, |t| (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) * (TAU * 240.0 * t).sin())
            .moving("frequency", 300.0, |t| 100.0 * (TAU * 5.0 * t).sin())
            .steady("q", 3.0);
        let error = bench.band_error_db::<f32>(4000, 16);
        assert!(error < -80.0, "{error}");
    }

    #[test]
    fn hostile_input_stays_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 4000.0, 0.0] {
            let bench = Bench::new("bandpass", 8000.0)
                .moving("input", 0.0, move |t| if t < 0.01 { bad } else { 0.0 })
                .moving("frequency", 100.0, move |t| if t < 0.02 { bad } else { 0.0 })
                .moving("q", 1.0, move |t| if t < 0.03 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() < 1e7), "{bad}");
        }
    }
}
