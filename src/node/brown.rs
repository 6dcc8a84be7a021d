//! Brown noise.

use fundsp::filter::Lowpole;
use fundsp::typenum::U1;

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use super::white::Sequence;
use crate::dsp::interleaved::Interleaved;
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random::Source;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "brown",
    family: Family::Noise,
    summary: "Noise that falls by 6 dB an octave: a deep rumble.",
    detail: "White noise, as of `white`, through y[n] = c y[n−1] + (1 − c) x[n] at the engine's rate, c = e^(−2π corner / rate) (the unit \
             `lowpole` of fundsp), times √((1 + c) / (1 − c)): RMS amplitude / √3, as for `white`; peaks may be higher. Below the corner it is \
             flat, so that it does not wander off as the sum of white noise would. It begins at 0 with the voice's first sample, and has its full size \
             after about 1 / (2π corner) seconds. The corner is limited to its range.",
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
        let corner = within(onset.start[0], LEAST, MOST);
        // (1 + c) / (1 − c) is the hyperbolic cotangent of half the exponent.
        self.gain[lane] = 1.0 / (std::f64::consts::PI * corner / self.rate).tanh().sqrt();
        self.source.start(lane, onset.stream);
        self.filters.start(lane, |filter| filter.set_cutoff(corner));
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

/// The definition.
pub struct Exact {
    white: Sequence,
    filters: Interleaved<f64>,
    stays: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let corner = onset.start[0].clamp(LEAST, MOST);
        Self {
            white: Sequence::new(setup, onset),
            filters: Interleaved::new(0.0, setup.rate, setup.engine_rate),
            stays: (-std::f64::consts::TAU * corner / setup.engine_rate).exp(),
        }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let (c, x) = (self.stays, self.white.at(t));
        let y = self.filters.turn();
        *y = c * *y + (1.0 - c) * x;
        inputs[1] * ((1.0 + c) / (1.0 - c)).sqrt() * *y
    }
}
