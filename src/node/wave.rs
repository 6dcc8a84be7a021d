//! What the oscillators of one fixed wave share: kernel and twin, by their wave.

use std::marker::PhantomData;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::quadrature::Turns;
use crate::dsp::wavetable::{Additive, TableLanes, Wave};

/// Which wave a node plays.
pub trait Shape: Send + Clone + 'static {
    /// The wave.
    const WAVE: Wave;
}

/// Eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R: Real, S>(TableLanes<R>, PhantomData<S>);

impl<R: Real, S: Shape> Kernel<R> for Lanes<R, S> {
    fn new(setup: &Setup) -> Self {
        Self(TableLanes::new(S::WAVE, setup.rate, setup.begins), PhantomData)
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.0.start(lane, onset.start[0], onset.age);
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.0.retune(lane, now[0]);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [frequency, phase, amplitude] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let steady = frequency.is_steady() && phase.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            let gain = amplitude.at(frame);
            let (angle, tone) = if steady {
                self.0.steady(phase.base)
            } else {
                self.0.moving(&frequency.at(frame), &phase.at(frame))
            };
            for l in 0..LANES {
                out[l] = self.0.tables.at(tone[l], angle[l]) * gain[l];
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact<S> {
    turns: Turns,
    series: Additive,
    _of: PhantomData<S>,
}

impl<S: Shape> Exact<S> {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let turns = Turns::new(onset.start[0], setup.begins);
        Self { turns, series: Additive::new(S::WAVE, setup.rate, setup.engine_rate), _of: PhantomData }
    }
}

impl<S: Shape> Twin for Exact<S> {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let share = self.series.share(inputs[0], inputs[1]);
        inputs[2] * self.series.at(self.turns.step(t, inputs[0]) + inputs[1], share)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    /// What holds for the wave of that name.
    pub fn check(name: &str) {
        steady_and_moving(name);
        aliases_stay_out_of_the_band(name);
        hostile_modulation_stays_bounded(name);
    }

    fn steady_and_moving(name: &str) {
        for hertz in [-61.3, 3.0, 80.0, 333.0, 1200.0, 3700.0] {
            let steady = Bench::new(name, 8000.0).steady("frequency", hertz).steady("phase", 0.2);
            assert!(steady.error_db::<f32>(8000) < -110.0, "{hertz} Hz: {}", steady.error_db::<f32>(8000));
        }
        let moving = Bench::new(name, 7350.0)
            .age(-1.01)
            .moving("frequency", 100.0, |t| 120.0 * (TAU * 11.0 * t).sin())
            .moving("phase", 0.0, |t| 0.3 * (TAU * 31.0 * t).cos())
            .moving("amplitude", 1.0, |t| (TAU * 7.0 * t).sin());
        moving.check_contract();
        let error = moving.error_db::<f32>(73_500);
        assert!(error < -110.0, "{error}");
    }

    fn aliases_stay_out_of_the_band(name: &str) {
        let bench = Bench::new(name, 8000.0)
            .age(-1.5)
            .moving("frequency", 217.0, |t| 60.0 * (TAU * 5.0 * t).sin())
            .moving("amplitude", 0.0, |t| (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) / 2.0);
        let error = bench.band_error_db::<f32>(2000, 16);
        assert!(error < -80.0, "{error}");
    }

    fn hostile_modulation_stays_bounded(name: &str) {
        for bad in [f64::NAN, f64::INFINITY, -1e300, 1e9, 0.0] {
            let bench = Bench::new(name, 8000.0)
                .moving("frequency", 0.0, move |t| if t > 0.01 { bad } else { 0.0 })
                .moving("phase", 0.0, move |t| if t > 0.02 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() < 1.3), "{bad}");
        }
    }
}
