//! Brown noise.

use fundsp::filter::Lowpole;
use fundsp::typenum::U1;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, Sampled, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random::{Source, uniform};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "brown",
    family: Family::Noise,
    summary: "Noise that falls by 6 dB an octave: a deep rumble.",
    detail: "White noise, as of `white`, through y[n] = c y[n−1] + (1 − c) x[n] at the engine's rate, c = e^(−2π corner / rate) (the unit \
             `lowpole` of fundsp), times √((1 + c) / (1 − c)): RMS amplitude / √3, as for `white`; peaks may be higher. Below the corner it is \
             flat, so that it does not wander off as the sum of white noise would. It begins at 0 with the voice's first sample, and has its full size \
             after about 1 / (2π corner) seconds; between samples it is band-limited. The corner is limited to its range.",
    params: &[
        Param {
            name: "corner",
            kind: Kind::Start(Numeric::or(10.0, LEAST, MOST)),
            unit: "Hz",
            doc: "Where it begins to fall; read when the voice starts.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"rumble = { type = "brown", corner = 30, amplitude = 0.5 }"#,
};

const LEAST: f64 = 0.1;
const MOST: f64 = 1000.0;

/// Eight streams and their filters.
#[derive(Clone)]
pub struct Lanes<R> {
    source: Source,
    filters: Leaf<Lowpole<f64, U1>>,
    gain: [f64; LANES],
    rate: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self {
            source: Source::default(),
            filters: Leaf::new(setup.rate, || Lowpole::new(10.0)),
            gain: [0.0; LANES],
            rate: setup.rate,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let corner = self.turn(lane, onset.start[0]);
        self.source.start(lane, onset.stream);
        self.filters.start(lane, |filter| filter.set_cutoff(corner));
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        let corner = self.turn(lane, now[0]);
        self.filters.change(lane, |filter| filter.set_cutoff(corner));
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let amplitude = io.inputs[1];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (noise, gain) = (self.source.draw::<f32>(), amplitude.at(frame));
            for l in 0..LANES {
                let low = f64::from(self.filters.draw(l, &[noise[l]].into()));
                out[l] = R::of(low * self.gain[l]) * gain[l];
            }
        }
    }
}

impl<R> Lanes<R> {
    /// Sets the gain of a lane, and gives its corner, Hz.
    fn turn(&mut self, lane: usize, corner: f64) -> f64 {
        let corner = within(corner, LEAST, MOST);
        // (1 + c) / (1 − c) is the hyperbolic cotangent of half the exponent.
        self.gain[lane] = 1.0 / (std::f64::consts::PI * corner / self.rate).tanh().sqrt();
        corner
    }
}

/// The definition.
pub struct Exact {
    noise: Sampled,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let corner = onset.start[0].clamp(LEAST, MOST);
        let c = (-std::f64::consts::TAU * corner / setup.engine_rate).exp();
        let size = ((1.0 + c) / (1.0 - c)).sqrt();
        let (stream, mut y, mut n) = (onset.stream, 0.0, 0);
        let noise = Sampled::new(setup, onset, move || {
            y = c * y + (1.0 - c) * uniform(stream, n);
            n += 1;
            size * y
        });
        Self { noise }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        inputs[1] * self.noise.at(t)
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn the_kernel_follows_its_twin() {
        for (rate, age, corner) in [(8000.0, -1.0, 10.0), (7350.0, -1.99, 0.1), (7350.0, -1.4, 1000.0)] {
            let bench =
                Bench::new("brown", rate).age(age).steady("corner", corner).moving("amplitude", 1.0, |t| 0.5 * t.sin());
            bench.check_contract();
            let error = bench.error_db::<f32>(80_000);
            assert!(error < -110.0, "{corner} Hz: {error}");
        }
    }

    #[test]
    fn between_samples_it_is_band_limited() {
        let bench = Bench::new("brown", 8000.0).moving("amplitude", 0.0, |t| 1.0 - (100.0 * t.max(0.0)).cos());
        let error = bench.band_error_db::<f32>(3000, 16);
        assert!(error < -80.0, "{error}");
    }

    #[test]
    fn its_power_is_that_of_white_noise_and_falls_by_six_decibels_an_octave() {
        for rate in [7350.0, 8000.0] {
            let (mut power, mut octaves) = (0.0, [0.0; 3]);
            for stream in 0..16 {
                let mut bench = Bench::new("brown", rate).steady("corner", 40.0);
                bench.stream = stream;
                let out = bench.kernel::<f32>(80_000, &[64]);
                power += out.iter().map(|v| v * v).sum::<f64>() / 80_000.0 / 16.0;
                // Power at three tones, each over blocks of 0.1 s through a Hann window.
                for (k, octave) in octaves.iter_mut().enumerate() {
                    let turn = std::f64::consts::TAU * 200.0 * f64::from(1 << k) / rate;
                    for block in out.chunks_exact(rate as usize / 10) {
                        let (mut re, mut im) = (0.0, 0.0);
                        for (n, x) in block.iter().enumerate() {
                            let window = 1.0 - (std::f64::consts::TAU * n as f64 / block.len() as f64).cos();
                            re += window * x * (turn * n as f64).cos();
                            im += window * x * (turn * n as f64).sin();
                        }
                        *octave += re * re + im * im;
                    }
                }
            }
            assert!((10.0 * (3.0 * power).log10()).abs() < 0.4, "{rate} Hz: {power}");
            for pair in octaves.windows(2) {
                let fall = 10.0 * (pair[1] / pair[0]).log10();
                assert!((-6.6..-5.2).contains(&fall), "{rate} Hz: {fall} dB");
            }
        }
    }

    #[test]
    fn hostile_corners_are_limited() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 0.0, 1e9] {
            let out = Bench::new("brown", 8000.0).steady("corner", bad).kernel::<f32>(8000, &[64]);
            assert!(out.iter().all(|v| v.abs() < 10.0) && out.iter().any(|v| *v != 0.0), "{bad}");
        }
    }
}
