//! What the filters of second order share: kernel and twin, by the part of the state-variable filter that each of them gives.

use std::marker::PhantomData;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::svf::{Filters, Single};

/// A part of the filter. Inputs of its node: what is filtered, frequency (Hz), and what gives q.
pub trait Part: Send + Clone + 'static {
    /// From what went in, what is left below the frequency, and what is left around it.
    fn of(input: f64, low: f64, band: f64) -> f64;

    /// q, from the last input; `rate` is the engine's.
    #[inline(always)]
    fn q(_frequency: f64, given: f64, _rate: f64) -> f64 {
        given
    }

    /// The same by definition.
    fn exact_q(_frequency: f64, given: f64, _rate: f64) -> f64 {
        given
    }
}

/// Eight filters.
#[derive(Debug, Clone)]
pub struct Lanes<R, P> {
    filters: Filters,
    rate: f64,
    _of: PhantomData<(R, P)>,
}

impl<R: Real, P: Part> Kernel<R> for Lanes<R, P> {
    fn new(setup: &Setup) -> Self {
        Self { filters: Filters::new(setup.rate), rate: setup.rate, _of: PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let [frequency, given] = [onset.start[1], onset.start[2]];
        self.filters.start(lane, frequency, P::q(frequency, given, self.rate));
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.filters.retune(lane, now[1], P::q(now[1], now[2], self.rate));
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, frequency, given] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let mut tune = !(frequency.is_steady() && given.is_steady());
        // What does not move in this block is tuned once.
        let still = frequency.step == 0 && given.step == 0;
        for (frame, out) in io.output.iter_mut().enumerate() {
            if tune {
                let (hertz, mut q) = (frequency.at(frame).map(R::wide), given.at(frame).map(R::wide));
                for l in 0..LANES {
                    q[l] = P::q(hertz[l], q[l], self.rate);
                }
                self.filters.tune(&hertz, &q);
                tune = !still;
            }
            let now = self.filters.step(&input.at(frame));
            for l in 0..LANES {
                out[l] = R::of(P::of(now.input[l], now.low[l], now.band[l]));
            }
        }
    }

    fn settle(&mut self) {
        self.filters.settle();
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact<P> {
    filters: Interleaved<Single>,
    rate: f64,
    _of: PhantomData<P>,
}

impl<P: Part> Exact<P> {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let filters = Interleaved::new(Single::default(), setup.rate, setup.engine_rate);
        Self { filters, rate: setup.engine_rate, _of: PhantomData }
    }
}

impl<P: Part> Twin for Exact<P> {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let q = P::exact_q(inputs[1], inputs[2], self.rate);
        let (low, band) = self.filters.turn().step(inputs[0], inputs[1], q, self.rate);
        P::of(inputs[0], low, band)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    /// What holds for the filter of that name, whose frequency is called `frequency`; steady ones are measured up to `highest` Hz.
    pub fn check(name: &str, frequency: &str, highest: f64) {
        let steady = [(5.0, 0.7), (250.0, 30.0), (highest, 0.7)];
        follows_its_twin(name, [frequency, "q"], steady, (5.0, 4.0));
        is_the_same_at_sixteen_times_the_rate(name, [frequency, "q"], 3.0);
        hostile_input_stays_bounded(name, [frequency, "q"]);
    }

    /// Steady at each pair of values; then moving, the second by so much around a middle.
    pub fn follows_its_twin(
        name: &str,
        [frequency, second]: [&str; 2],
        steady: [(f64, f64); 3],
        moving: (f64, f64),
    ) {
        let tone = |t: f64| (TAU * 60.0 * t).sin() + 0.5 * (TAU * 311.0 * t).cos();
        for (hertz, given) in steady {
            let bench = Bench::new(name, 8000.0)
                .moving("input", 0.0, tone)
                .steady(frequency, hertz)
                .steady(second, given);
            let error = bench.error_db::<f32>(80_000);
            assert!(error < -110.0, "{hertz} Hz: {error}");
        }
        let (middle, swing) = moving;
        let moving = Bench::new(name, 7350.0)
            .moving("input", 0.0, tone)
            .moving(frequency, 300.0, |t| 250.0 * (TAU * 13.0 * t).sin())
            .moving(second, middle, move |t| swing * (TAU * 3.0 * t).cos());
        moving.check_contract();
        assert!(moving.error_db::<f32>(73_500) < -110.0);
        assert!(moving.error_db::<f64>(73_500) < -180.0);
    }

    pub fn is_the_same_at_sixteen_times_the_rate(name: &str, [frequency, second]: [&str; 2], given: f64) {
        let bench = Bench::new(name, 8000.0)
            .moving("input", 0.0, |t| (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) * (TAU * 240.0 * t).sin())
            .moving(frequency, 300.0, |t| 100.0 * (TAU * 5.0 * t).sin())
            .steady(second, given);
        let error = bench.band_error_db::<f32>(4000, 16);
        assert!(error < -80.0, "{error}");
    }

    pub fn hostile_input_stays_bounded(name: &str, [frequency, second]: [&str; 2]) {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 4000.0, 0.0] {
            let bench = Bench::new(name, 8000.0)
                .moving("input", 0.0, move |t| if t < 0.01 { bad } else { 0.0 })
                .moving(frequency, 100.0, move |t| if t < 0.02 { bad } else { 0.0 })
                .moving(second, 1.0, move |t| if t < 0.03 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() < 1e7), "{bad}");
        }
    }
}
