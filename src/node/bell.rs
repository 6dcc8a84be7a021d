//! Bell filter.

use fundsp::svf::{BellMode, Svf, SvfParams};

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, signal, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::elementary::exp2;
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::svf::{LEAST_CUTOFF, MOST_CUTOFF, Single};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "bell",
    family: Family::Filter,
    summary: "Lifts or lowers what lies around a frequency, and leaves the rest.",
    detail: "(s²/ω² + sA/qω + 1) / (s²/ω² + s/Aqω + 1), A = 10^(gain / 40): the gain at the frequency, 1 far from it. Two bells of opposite \
             gain cancel each other. It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its frequency; the \
             unit `bell` of fundsp. The frequency is limited to 1 Hz to 0.45 of the rate, q to 0.1 to 100 and the gain to ±60 dB, at every sample; an input that is not a number \
             counts as 0. When nothing has been above −140 dB for a second, it is silent.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1e6, 1e6)),
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
            name: "gain",
            kind: Kind::Signal(Numeric::required(-60.0, 60.0)),
            unit: "dB",
            doc: "How much it lifts, or lowers where it is negative.",
        },
        Param {
            name: "q",
            kind: Kind::Signal(Numeric::or(1.0, 0.1, 100.0)),
            unit: "",
            doc: "How narrow it is.",
        },
    ],
    example: r#"body = { type = "bell", input = "string", frequency = 120, gain = 12, q = 3 }"#,
};

/// log2(10) / 20: a gain in dB as a power of two.
const OCTAVES: f64 = std::f64::consts::LOG2_10 / 20.0;

/// Eight filters.
pub struct Lanes<R> {
    filters: Leaf<Svf<f64, BellMode<f64>>>,
    most: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let params = SvfParams { sample_rate: setup.rate, cutoff: 1000.0, q: 1.0, gain: 1.0 };
        Self {
            filters: Leaf::new(setup.rate, || Svf::new(BellMode::default(), &params)),
            most: MOST_CUTOFF * setup.rate,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.filters.start(lane, |_| {});
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, frequency, gain, q] = [io.inputs[0], io.inputs[1], io.inputs[2], io.inputs[3]];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (input, frequency, gain, q) = (input.at(frame), frequency.at(frame), gain.at(frame), q.at(frame));
            for l in 0..LANES {
                let frequency = within(frequency[l].wide(), LEAST_CUTOFF, self.most) as f32;
                let gain = exp2(within(gain[l].wide(), -60.0, 60.0) * OCTAVES) as f32;
                let q = within(q[l].wide(), 0.1, 100.0) as f32;
                out[l] = R::of(self.filters.pass(l, &[signal(input[l]), frequency, q, gain].into()).into());
            }
        }
    }

    fn settle(&mut self) {
        self.filters.settle();
    }
}

/// The definition: the input and what a band-pass filter of the same denominator takes out of it, in the right share.
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
        let a = 10f64.powf(inputs[2].clamp(-60.0, 60.0) / 40.0);
        let q = inputs[3].clamp(0.1, 100.0);
        let (_, band) = self.filters.turn().step(inputs[0], inputs[1], a * q, self.rate);
        inputs[0] + (a * a - 1.0) * band
    }
}
