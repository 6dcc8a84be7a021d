//! Band-limited pulse oscillator.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::quadrature::{Turns, bend};
use crate::dsp::wavetable::{Additive, TableLanes, Wave};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "pulse",
    family: Family::Oscillator,
    summary: "A pulse of a width, band-limited.",
    detail: "amplitude × the wave that is 2 − 2 width for the first `width` of each turn and −2 width for the rest: 2 from low to \
             high, mean 0, ±1 at width ½, silent at 0 and 1. It is the difference of two sawtooths, band-limited as they are; the width \
             may move (pulse-width modulation) and is limited to 0 to 1. Phase and frequency are those of `sine`.",
    params: &[
        Param {
            name: "frequency",
            kind: Kind::Frequency(Numeric::required(-4000.0, 4000.0)),
            unit: "Hz",
            doc: "Frequency; moving it is frequency modulation.",
        },
        Param {
            name: "phase",
            kind: Kind::Signal(Numeric::or(0.0, -1e6, 1e6)),
            unit: "turns",
            doc: "Added to the phase; moving it is phase modulation.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Peak value; moving it is amplitude modulation.",
        },
        Param {
            name: "width",
            kind: Kind::Signal(Numeric::or(0.5, 0.0, 1.0)),
            unit: "turns",
            doc: "Share of a turn that is high.",
        },
    ],
    example: r#"tone = { type = "pulse", frequency = 80, width = 0.25 }"#,
};

/// Eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R: Real>(TableLanes<R>);

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self(TableLanes::new(Wave::Sawtooth, setup.rate, setup.begins))
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.0.start(lane, onset.start[0], onset.age);
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.0.retune(lane, now[0]);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [frequency, phase, amplitude, width] = [io.inputs[0], io.inputs[1], io.inputs[2], io.inputs[3]];
        let steady = frequency.is_steady() && phase.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (gain, width) = (amplitude.at(frame), width.at(frame));
            let (angle, tone) = if steady {
                self.0.steady(phase.base)
            } else {
                self.0.moving(&frequency.at(frame), &phase.at(frame))
            };
            for l in 0..LANES {
                let up = angle[l].wrapping_sub(1 << 63);
                let down = up.wrapping_sub(bend(width[l].max(R::ZERO).min(R::ONE).wide()));
                out[l] = (self.0.tables.at(tone[l], down) - self.0.tables.at(tone[l], up)) * gain[l];
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    turns: Turns,
    series: Additive,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let turns = Turns::new(onset.start[0], setup.begins);
        Self { turns, series: Additive::new(Wave::Sawtooth, setup.rate, setup.engine_rate) }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let share = self.series.share(inputs[0], inputs[1]);
        let up = self.turns.step(t, inputs[0]) + inputs[1] - 0.5;
        let down = up - inputs[3].clamp(0.0, 1.0);
        inputs[2] * (self.series.at(down, share) - self.series.at(up, share))
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    #[test]
    fn steady_and_moving() {
        for hertz in [-61.3, 3.0, 80.0, 333.0, 1200.0, 3700.0] {
            let steady = Bench::new("pulse", 8000.0).steady("frequency", hertz).steady("phase", 0.2);
            assert!(steady.error_db::<f32>(8000) < -110.0, "{hertz} Hz: {}", steady.error_db::<f32>(8000));
        }
        let moving = Bench::new("pulse", 7350.0)
            .age(-1.01)
            .moving("frequency", 100.0, |t| 120.0 * (TAU * 11.0 * t).sin())
            .moving("phase", 0.0, |t| 0.3 * (TAU * 31.0 * t).cos())
            .moving("amplitude", 1.0, |t| (TAU * 7.0 * t).sin())
            .moving("width", 0.5, |t| 0.4 * (TAU * 3.0 * t).sin());
        moving.check_contract();
        let error = moving.error_db::<f32>(73_500);
        assert!(error < -110.0, "{error}");
    }

    #[test]
    fn aliases_stay_out_of_the_band() {
        let bench = Bench::new("pulse", 8000.0)
            .age(-1.5)
            .moving("frequency", 217.0, |t| 60.0 * (TAU * 5.0 * t).sin())
            .moving("amplitude", 0.0, |t| (1.0 - (TAU * 5.0 * t.max(0.0)).cos()) / 2.0);
        let error = bench.band_error_db::<f32>(2000, 16);
        assert!(error < -80.0, "{error}");
    }

    #[test]
    fn hostile_modulation_stays_bounded() {
        for bad in [f64::NAN, f64::INFINITY, -1e300, 1e9, 0.0] {
            let bench = Bench::new("pulse", 8000.0)
                .moving("frequency", 0.0, move |t| if t > 0.01 { bad } else { 0.0 })
                .moving("phase", 0.0, move |t| if t > 0.02 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() < 2.6), "{bad}");
        }
    }
}
