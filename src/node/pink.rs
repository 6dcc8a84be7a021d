//! Pink noise.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use super::white::Sequence;
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random::Source;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "pink",
    family: Family::Noise,
    summary: "Noise with the same power in every octave.",
    detail: "White noise through five first-order sections at the engine's rate, whose poles lie at 2.8 Hz × 5.25^n and zeros at 2.29 times that: \
             −3 dB an octave within 0.1 dB from 10 Hz to 1 kHz. RMS amplitude / √3, as for `white`; peaks may be higher.",
    params: &[
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"rumble = { type = "pink", amplitude = 0.5 }"#,
};

const SECTIONS: usize = 5;

/// Poles and zeros at `rate`, and the gain that gives the power of white noise.
fn design(rate: f64) -> ([f64; SECTIONS], [f64; SECTIONS], f64) {
    let image = |hertz: f64| (-std::f64::consts::TAU * hertz / rate).exp();
    let (mut poles, mut zeros) = ([0.0; SECTIONS], [0.0; SECTIONS]);
    for n in 0..SECTIONS {
        let hertz = 2.796 * 5.2542_f64.powi(n as i32);
        poles[n] = image(hertz);
        zeros[n] = image(2.2923 * hertz);
    }
    // Power by partial fractions: H = c + Σ r / (1 − p / z).
    let mut constant = 1.0;
    let mut residues = [1.0; SECTIONS];
    for k in 0..SECTIONS {
        constant *= zeros[k] / poles[k];
        for j in 0..SECTIONS {
            residues[k] *= 1.0 - zeros[j] / poles[k];
            if j != k {
                residues[k] /= 1.0 - poles[j] / poles[k];
            }
        }
    }
    let mut power = constant * constant;
    for k in 0..SECTIONS {
        power += 2.0 * constant * residues[k];
        for j in 0..SECTIONS {
            power += residues[j] * residues[k] / (1.0 - poles[j] * poles[k]);
        }
    }
    (poles, zeros, 1.0 / power.sqrt())
}

/// Eight streams and their filters. In `f64`, as the lowest pole is close to 1.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    source: Source,
    poles: [f64; SECTIONS],
    zeros: [f64; SECTIONS],
    gain: f64,
    states: [[f64; LANES]; SECTIONS],
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let (poles, zeros, gain) = design(setup.rate);
        let states = [[0.0; LANES]; SECTIONS];
        Self { source: Source::default(), poles, zeros, gain, states, _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.source.start(lane, onset.stream);
        for state in &mut self.states {
            state[lane] = 0.0;
        }
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let amplitude = io.inputs[0];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (mut noise, gain) = (self.source.draw::<f64>(), amplitude.at(frame));
            for (n, state) in self.states.iter_mut().enumerate() {
                for l in 0..LANES {
                    let inner = noise[l] + self.poles[n] * state[l];
                    noise[l] = inner - self.zeros[n] * state[l];
                    state[l] = inner;
                }
            }
            for l in 0..LANES {
                out[l] = R::of(noise[l] * self.gain) * gain[l];
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    white: Sequence,
    filters: Interleaved<[(f64, f64); SECTIONS]>,
    rate: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let filters = Interleaved::new([(0.0, 0.0); SECTIONS], setup.rate, setup.engine_rate);
        Self { white: Sequence::new(setup, onset), filters, rate: setup.engine_rate }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let (poles, zeros, gain) = design(self.rate);
        let mut x = self.white.at(t);
        // Section by section y[n] = x[n] − zero x[n−1] + pole y[n−1].
        for (n, (before, after)) in self.filters.turn().iter_mut().enumerate() {
            let y = x - zeros[n] * *before + poles[n] * *after;
            (*before, *after) = (x, y);
            x = y;
        }
        inputs[0] * gain * x
    }
}

#[cfg(test)]
mod tests {
    use super::design;
    use crate::node::harness::Bench;

    #[test]
    fn the_kernel_follows_its_twin() {
        let bench = Bench::new("pink", 8000.0).moving("amplitude", 1.0, |t| 0.5 * t.sin());
        bench.check_contract();
        assert!(bench.error_db::<f32>(80_000) < -110.0);
    }

    #[test]
    fn three_decibels_an_octave() {
        for rate in [7350.0, 8000.0] {
            let (poles, zeros, gain) = design(rate);
            let level = |hertz: f64| {
                let (s, c) = (std::f64::consts::TAU * hertz / rate).sin_cos();
                let size = |p: &f64| (1.0 - p * c).hypot(p * s);
                let ratio = zeros.iter().map(size).product::<f64>() / poles.iter().map(size).product::<f64>();
                20.0 * ratio.log10() + 10.0 * hertz.log10()
            };
            let all: Vec<f64> = (0..=200).map(|k| level(10.0 * 100f64.powf(f64::from(k) / 200.0))).collect();
            let (least, most) = all.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
            assert!(most - least < 0.2, "{rate} Hz: {least} to {most} dB");
            assert!(gain.is_finite() && gain > 0.0);
        }
    }

    #[test]
    fn its_power_is_that_of_white_noise() {
        let mut power = 0.0;
        for stream in 0..8 {
            let mut bench = Bench::new("pink", 8000.0);
            bench.stream = stream;
            power += bench.kernel::<f32>(80_000, &[64]).iter().map(|v| v * v).sum::<f64>() / 80_000.0 / 8.0;
        }
        assert!((10.0 * (3.0 * power).log10()).abs() < 0.3, "{power}");
    }
}
