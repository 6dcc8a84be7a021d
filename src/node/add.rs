//! Sum of signals.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "add",
    family: Family::Arithmetic,
    summary: "The sum of its inputs.",
    detail: "Added in the order in which they are listed. With no input it is 0.",
    params: &[
        Param { name: "inputs", kind: Kind::Signals, unit: "", doc: "What is added." },
    ],
    example: r#"out = { type = "add", inputs = ["tone", "hum"] }"#,
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
                    out[l] = R::ZERO + a[l] + b[l];
                }
            }
            return;
        }
        for (frame, out) in output.iter_mut().enumerate() {
            let mut sum = [R::ZERO; LANES];
            for input in inputs {
                let row = input.at(frame);
                for l in 0..LANES {
                    sum[l] += row[l];
                }
            }
            *out = sum;
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
        inputs.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn the_sum_follows_its_twin() {
        let bench = Bench::new("add", 8000.0)
            .signal(1.0, |t| (900.0 * t).sin())
            .signal(-0.3, |_| 0.0)
            .signal(0.0, |t| (700.0 * t).cos());
        bench.check_contract();
        assert!(bench.error_db::<f32>(80_000) < -130.0);
    }

    #[test]
    fn nothing_added_is_silence() {
        assert!(Bench::new("add", 8000.0).kernel::<f32>(10, &[3]).iter().all(|v| *v == 0.0));
    }
}
