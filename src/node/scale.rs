//! Gain and offset.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "scale",
    family: Family::Arithmetic,
    summary: "Its input times a gain, plus an offset.",
    detail: "gain × input + offset.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "What is scaled.",
        },
        Param {
            name: "gain",
            kind: Kind::Signal(Numeric::or(1.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Factor.",
        },
        Param {
            name: "offset",
            kind: Kind::Signal(Numeric::or(0.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Added after that.",
        },
    ],
    example: r#"bend = { type = "scale", input = "lfo", gain = 20, offset = 200 }"#,
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
        let [input, gain, offset] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        for (frame, out) in io.pointwise().iter_mut().enumerate() {
            let (x, g, o) = (input.at(frame), gain.at(frame), offset.at(frame));
            for l in 0..LANES {
                out[l] = g[l] * x[l] + o[l];
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
        inputs[0] * inputs[1] + inputs[2]
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn the_kernel_follows_its_twin() {
        let bench = Bench::new("scale", 8000.0)
            .moving("input", 0.2, |t| (900.0 * t).sin())
            .moving("gain", 1.0, |t| t.sin())
            .steady("offset", -0.5);
        bench.check_contract();
        assert!(bench.error_db::<f32>(80_000) < -130.0);
    }
}
