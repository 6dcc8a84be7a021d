//! Plucked string.

use fundsp::oscillator::Pluck;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, Sampled, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "pluck",
    family: Family::Oscillator,
    summary: "A plucked string.",
    detail: "The string of Karplus and Strong (Computer Music Journal 7(2), 1983), tuned after Jaffe and Smith (same issue), at the engine's \
             rate; the unit `pluck` of fundsp. With P samples a period, N = ⌊P − 1.2⌋, g = 10^(−3 / ring), b = damping / 4, \
             e = (2 + N − P) / (P − N): s[n] = y[n−1] + e (y[n] − s[n−1]), y[n] = b (u[n] + u[n−2]) + (1 − 2b) u[n−1], u[n] = g s[n−N]. \
             The first N values of the string are random, uniform in ±1, less their mean, from the stream of the node in the voice: no two voices \
             are quite the same, and the same seed gives the same string. The sequence begins with the voice's first sample, one to two samples ahead of \
             the onset; between samples it is band-limited. Peaks lie within about ± amplitude. When it has been below \
             −140 dB for a second, it is silent. The frequency is limited to its range.",
    params: &[
        Param {
            name: "frequency",
            kind: Kind::Start(Numeric::required(LEAST, MOST)),
            unit: "Hz",
            doc: "Pitch; read when the voice starts.",
        },
        Param {
            name: "ring",
            kind: Kind::Constant(Numeric::or(150.0, 1.0, 1e5)),
            unit: "periods",
            doc: "Periods until the lowest tone has fallen by 60 dB; so high strings fall sooner, as strings do.",
        },
        Param {
            name: "damping",
            kind: Kind::Constant(Numeric::or(0.5, 0.0, 1.0)),
            unit: "",
            doc: "How much sooner high tones fall: 0 not at all, 1 most, as on gut.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"string = { type = "pluck", frequency = "event.frequency", ring = 100 }"#,
};

/// Lowest and highest pitch, Hz. The lowest sets how much memory a lane has.
const LEAST: f64 = 10.0;
const MOST: f64 = 1000.0;

/// Eight strings.
pub struct Lanes<R> {
    strings: Leaf<Pluck>,
    rate: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let ring = setup.constants.first().copied().unwrap_or(150.0);
        let damping = setup.constants.get(1).copied().unwrap_or(0.5);
        let (gain, damping) = (10f64.powf(-3.0 / within(ring, 1.0, 1e5)), within(damping, 0.0, 1.0));
        // A unit is tuned when it is made. So its second is a period, and its sample rate, which can be set, the samples of that.
        let make = || Pluck::new(1.0, gain as f32, damping as f32);
        Self { strings: Leaf::new(setup.rate / LEAST, make), rate: setup.rate, _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let period = self.rate / within(onset.start[0], LEAST, MOST);
        self.strings.start(lane, |string| {
            use fundsp::audionode::AudioNode;
            string.set_sample_rate(period);
            string.set_hash(onset.stream);
            // It is as long as the longest from the beginning, so this fills it and no more.
            string.allocate();
        });
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let amplitude = io.inputs[1];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let gain = amplitude.at(frame);
            for l in 0..LANES {
                out[l] = R::of(self.strings.draw(l, &[0.0].into()).into()) * gain[l];
            }
        }
    }

    fn settle(&mut self) {
        self.strings.settle();
    }
}

/// The definition.
pub struct Exact {
    string: Sampled,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let period = setup.engine_rate / onset.start[0].clamp(LEAST, MOST);
        let length = (period - 1.2).floor();
        let (gain, b) = (10f64.powf(-3.0 / setup.constants[0]), setup.constants[1] / 4.0);
        let e = (2.0 + length - period) / (period - length);
        let mut s = noise(onset.stream, length as usize);
        let (mut u, mut y, mut last) = ([0.0; 3], 0.0, 0.0);
        let string = Sampled::new(setup, onset, move || {
            u = [gain * s[s.len() - length as usize], u[0], u[1]];
            let before = y;
            y = b * (u[0] + u[2]) + (1.0 - 2.0 * b) * u[1];
            last = before + e * (y - last);
            s.push(last);
            last
        });
        Self { string }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        inputs[1] * self.string.at(t)
    }
}

/// `count` numbers in ±1 less their mean, from the generator Krull64 (Perttu) at the start of a stream: a counter in 128 bits
/// that is multiplied and added to, whose upper half is mixed.
fn noise(stream: u64, count: usize) -> Vec<f64> {
    let mut counter = u128::from(!stream);
    let all: Vec<f64> = (0..count)
        .map(|_| {
            counter = counter.wrapping_mul(0x1_DF77_A66A_374E_300D).wrapping_add(u128::from(stream) << 1 | 1);
            let mut x = (counter >> 64) as u64;
            x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            x = (x ^ x >> 31).wrapping_mul(0xD6E8_FEB8_6659_FD93);
            (x ^ x >> 32) as f64 / 2f64.powi(63) - 1.0
        })
        .collect();
    let mean = all.iter().sum::<f64>() / count as f64;
    all.iter().map(|x| x - mean).collect()
}
