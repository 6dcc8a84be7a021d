//! Product of signals.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "multiply",
    family: Family::Arithmetic,
    summary: "The product of its inputs.",
    detail: "One input more than another is a gain; two oscillators give the sums and differences of their frequencies.",
    params: &[Param { name: "inputs", kind: Kind::Signals, unit: "", doc: "What is multiplied." }],
    example: r#"out = { type = "multiply", inputs = ["tone", "hit"] }"#,
};

/// No state.
#[derive(Debug, Clone)]
pub struct Lanes<R>(std::marker::PhantomData<R>);

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(_setup: &Setup) -> Self {
        Self(std::marker::PhantomData)
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let inputs = io.inputs;
        let output = io.pointwise();
        if let [first, second] = inputs {
            for (frame, out) in output.iter_mut().enumerate() {
                let (a, b) = (first.at(frame), second.at(frame));
                for l in 0..LANES {
                    out[l] = a[l] * b[l];
                }
            }
            return;
        }
        let Some((first, others)) = inputs.split_first() else { return };
        for (frame, out) in output.iter_mut().enumerate() {
            *out = first.at(frame);
        }
        for input in others {
            for (frame, out) in output.iter_mut().enumerate() {
                let row = input.at(frame);
                for l in 0..LANES {
                    out[l] *= row[l];
                }
            }
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
        inputs.iter().product()
    }
}
