//! Band noise.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use super::white::Sequence;
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random::Source;
use crate::dsp::svf::{Filters, Single};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "band_noise",
    family: Family::Noise,
    summary: "Noise between two frequencies.",
    detail: "White noise through a high-pass filter at `low` and a low-pass filter at `high` (both of second order with q = 1/√2, as `highpass` and \
             `lowpass`), times √(rate / 2 (high − low)), so that its RMS is about amplitude / √3 for bands of an octave or more; filters of second order get no narrower \
             than about 0.28 of their frequency, so narrower bands are louder: by 6 dB at 240 to 260 Hz. Peaks are about four times as high. Both edges are limited as the filters do, and may stand in either order; a band below 1 Hz is scaled as one of 1 Hz.",
    params: &[
        Param {
            name: "low",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Lower edge (−3 dB where the other is an octave away or more).",
        },
        Param {
            name: "high",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Upper edge (−3 dB where the other is an octave away or more).",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"grit = { type = "band_noise", low = 80, high = 250 }"#,
};

const Q: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Eight streams and their filters.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    source: Source,
    above: Filters,
    below: Filters,
    scale: [f64; LANES],
    rate: f64,
    _real: std::marker::PhantomData<R>,
}

/// Power of white noise over that of a band of it.
#[inline(always)]
fn ratio(low: f64, high: f64, rate: f64) -> f64 {
    let width = if high > low { high - low } else { low - high };
    let width = if width > 1.0 { width } else { 1.0 };
    rate / (width + width)
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let [above, below] = [0, 1].map(|_| Filters::new(setup.rate));
        let scale = [0.0; LANES];
        Self { source: Source::default(), above, below, scale, rate: setup.rate, _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.source.start(lane, onset.stream);
        let [a, b] = [onset.start[0], onset.start[1]];
        self.above.start(lane, if b < a { b } else { a }, Q);
        self.below.start(lane, if b < a { a } else { b }, Q);
        self.scale[lane] = ratio(a, b, self.rate).sqrt();
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        let [a, b] = [now[0], now[1]];
        self.above.retune(lane, if b < a { b } else { a }, Q);
        self.below.retune(lane, if b < a { a } else { b }, Q);
        self.scale[lane] = ratio(a, b, self.rate).sqrt();
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [low, high, amplitude] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let steady = low.is_steady() && high.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            if !steady {
                let (mut low, mut high) = (low.at(frame).map(R::wide), high.at(frame).map(R::wide));
                for l in 0..LANES {
                    let (a, b) = (low[l], high[l]);
                    low[l] = if b < a { b } else { a };
                    high[l] = if b < a { a } else { b };
                }
                self.above.tune(&low, &[Q; LANES]);
                self.below.tune(&high, &[Q; LANES]);
                for l in 0..LANES {
                    self.scale[l] = ratio(low[l], high[l], self.rate).sqrt();
                }
            }
            let (noise, gain) = (self.source.draw::<f64>(), amplitude.at(frame));
            let now = self.above.step(&noise);
            let mut high = [0.0; LANES];
            for l in 0..LANES {
                high[l] = now.input[l] - now.band[l] - now.low[l];
            }
            let band = self.below.step(&high).low;
            for l in 0..LANES {
                out[l] = R::of(band[l] * self.scale[l]) * gain[l];
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    white: Sequence,
    filters: Interleaved<[Single; 2]>,
    rate: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let filters = Interleaved::new([Single::default(), Single::default()], setup.rate, setup.engine_rate);
        Self { white: Sequence::new(setup, onset), filters, rate: setup.engine_rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let x = self.white.at(t);
        let [above, below] = self.filters.turn();
        let (lower, upper) = (inputs[0].min(inputs[1]), inputs[0].max(inputs[1]));
        let (low, band) = above.step(x, lower, Q, self.rate);
        let (y, _) = below.step(x - low - band, upper, Q, self.rate);
        inputs[2] * y * (self.rate / 2.0 / (upper - lower).max(1.0)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn steady_and_moving() {
        let steady = Bench::new("band_noise", 8000.0).steady("low", 60.0).steady("high", 300.0);
        assert!(steady.error_db::<f32>(80_000) < -120.0);
        let moving = Bench::new("band_noise", 8000.0)
            .moving("low", 60.0, |t| 50.0 * t.sin())
            .moving("high", 300.0, |t| 50.0 * (3.0 * t).sin());
        moving.check_contract();
        assert!(moving.error_db::<f32>(80_000) < -110.0);
        let error = moving.moving("amplitude", 0.0, |t| 1.0 - (100.0 * t.max(0.0)).cos()).band_error_db::<f32>(2000, 16);
        assert!(error < -80.0, "{error}");
    }

    #[test]
    fn its_edges_stand_in_any_order() {
        let of = |low: f64, high: f64| {
            Bench::new("band_noise", 8000.0).steady("low", low).steady("high", high).kernel::<f32>(4000, &[64])
        };
        assert_eq!(of(300.0, 200.0), of(200.0, 300.0));
        let crossing = Bench::new("band_noise", 8000.0)
            .moving("low", 200.0, |t| 150.0 * (9.0 * t).sin())
            .moving("high", 250.0, |t| -150.0 * (9.0 * t).sin());
        assert!(crossing.error_db::<f32>(20_000) < -110.0);
    }

    #[test]
    fn its_power_hardly_depends_on_the_band() {
        for (low, high) in [(10.0, 1000.0), (100.0, 200.0), (20.0, 60.0)] {
            let bench = Bench::new("band_noise", 8000.0).steady("low", low).steady("high", high);
            let power = bench.kernel::<f32>(80_000, &[64]).iter().map(|v| v * v).sum::<f64>() / 80_000.0;
            assert!((10.0 * (3.0 * power).log10()).abs() < 3.0, "{low} to {high} Hz: {power}");
        }
    }
}
