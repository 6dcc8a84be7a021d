//! Audio from outside.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::Real;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "input",
    family: Family::Input,
    summary: "A channel of the audio input.",
    detail: "What the device hears, brought down to the engine's rate: 0 to 1 kHz pass, and what would fold there does not. It comes \
             later by the delay of that filter. Where there is no input it is 0.",
    params: &[Param {
        name: "channel",
        kind: Kind::Constant(Numeric::or(1.0, 1.0, 4096.0)),
        unit: "",
        doc: "Channel of the input, from 1.",
    }],
    example: r#"voice = { type = "input", channel = 1 }"#,
};

/// No state: the engine brings the signal.
#[derive(Debug, Clone)]
pub struct Lanes<R>(std::marker::PhantomData<R>);

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(_setup: &Setup) -> Self {
        Self(std::marker::PhantomData)
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        // The graph wires the signal of the channel to an input of its own.
        let Some(signal) = io.inputs.first() else { return };
        for (frame, out) in io.output.iter_mut().enumerate() {
            *out = signal.at(frame);
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact;

impl Exact {
    /// For one voice.
    pub fn new(_setup: &Setup, _onset: &Onset) -> Self {
        Self
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        inputs.first().copied().unwrap_or(0.0)
    }
}
