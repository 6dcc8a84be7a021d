//! Weighted sum of signals.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "mix",
    family: Family::Arithmetic,
    summary: "The sum of its inputs, made softer the more there are.",
    detail: "gain × the sum of n inputs, times 1/n (`average`: as loud as the loudest at most), 1/√n (`power`: unrelated inputs keep their power) or 1 \
             (`sum`). With no input it is 0.",
    params: &[
        Param {
            name: "law",
            kind: Kind::Choice(&["average", "power", "sum"], 0),
            unit: "",
            doc: "How the number of inputs counts.",
        },
        Param {
            name: "gain",
            kind: Kind::Signal(Numeric::or(1.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Factor of the whole.",
        },
        Param { name: "inputs", kind: Kind::Signals, unit: "", doc: "What is mixed." },
    ],
    example: r#"out = { type = "mix", law = "power", inputs = ["low", "mid", "high"] }"#,
};

/// What was chosen.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    choice: usize,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { choice: setup.choices.first().copied().unwrap_or(0), _real: std::marker::PhantomData }
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let Some((gain, inputs)) = io.inputs.split_first() else { return };
        let count = inputs.len().max(1) as f64;
        let weight = R::of(match self.choice {
            0 => 1.0 / count,
            1 => 1.0 / count.sqrt(),
            _ => 1.0,
        });
        for (frame, out) in io.pointwise().iter_mut().enumerate() {
            let mut sum = [R::ZERO; LANES];
            for input in inputs {
                let row = input.at(frame);
                for l in 0..LANES {
                    sum[l] += row[l];
                }
            }
            let gain = gain.at(frame);
            for l in 0..LANES {
                out[l] = sum[l] * weight * gain[l];
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    choice: usize,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self { choice: setup.choices.first().copied().unwrap_or(0) }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let sum: f64 = inputs[1..].iter().sum();
        let count = (inputs.len() - 1).max(1) as f64;
        inputs[0] * sum * count.powf([-1.0, -0.5, 0.0][self.choice.min(2)])
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn every_law_follows_its_twin() {
        for law in 0..3 {
            let bench = Bench::new("mix", 8000.0)
                .choice("law", law)
                .moving("gain", 1.0, |t| t.sin())
                .signal(1.0, |t| (900.0 * t).sin())
                .signal(0.0, |t| (700.0 * t).cos());
            bench.check_contract();
            assert!(bench.error_db::<f32>(80_000) < -130.0);
        }
    }

    #[test]
    fn an_average_of_the_same_is_the_same() {
        let bench = Bench::new("mix", 8000.0).signal(0.25, |_| 0.5).signal(0.25, |_| 0.5);
        assert!(bench.kernel::<f64>(10, &[3]).iter().all(|v| *v == 0.75));
    }
}
