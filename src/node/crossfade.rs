//! Cross-fade of two signals.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "crossfade",
    family: Family::Arithmetic,
    summary: "From one signal to another by a position.",
    detail: "position is limited to 0 to 1. `linear`: (1 − p) a + p b, right for signals that are alike. `power`: (1 − p) g a + p g b with \
             g = 1 / √((1 − p)² + p²), whose gains have the squares 1 in sum, right for signals that are unlike. A position that is not a number is 0.",
    params: &[
        Param {
            name: "law",
            kind: Kind::Choice(&["linear", "power"], 0),
            unit: "",
            doc: "What stays the same on the way.",
        },
        Param {
            name: "a",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "Heard alone at position 0.",
        },
        Param {
            name: "b",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "Heard alone at position 1.",
        },
        Param {
            name: "position",
            kind: Kind::Signal(Numeric::required(0.0, 1.0)),
            unit: "",
            doc: "0 to 1.",
        },
    ],
    example: r#"out = { type = "crossfade", a = "soft", b = "rough", position = "pressure" }"#,
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
        let [a, b, position] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        for (frame, out) in io.pointwise().iter_mut().enumerate() {
            let (a, b, p) = (a.at(frame), b.at(frame), position.at(frame));
            for l in 0..LANES {
                let to = R::ZERO.max(p[l]).min(R::ONE);
                let from = R::ONE - to;
                let sum = from * a[l] + to * b[l];
                out[l] = if self.choice == 0 { sum } else { sum / (from * from + to * to).sqrt() };
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
        let p = inputs[2].clamp(0.0, 1.0);
        let norm = if self.choice == 0 { 1.0 } else { (1.0 - p).hypot(p) };
        ((1.0 - p) * inputs[0] + p * inputs[1]) / norm
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn both_laws_follow_their_twin() {
        for law in 0..2 {
            let bench = Bench::new("crossfade", 8000.0)
                .choice("law", law)
                .moving("a", 0.2, |t| (900.0 * t).sin())
                .moving("b", -0.1, |t| (700.0 * t).sin())
                .moving("position", 0.5, |t| 0.7 * t.sin());
            bench.check_contract();
            assert!(bench.error_db::<f32>(80_000) < -130.0);
        }
    }

    #[test]
    fn the_power_law_keeps_the_power() {
        for p in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let gains = [("a", "b"), ("b", "a")].map(|(on, off)| {
                let bench = Bench::new("crossfade", 8000.0).choice("law", 1).steady(on, 1.0).steady(off, 0.0);
                bench.steady("position", p).kernel::<f64>(1, &[1])[0]
            });
            assert!((gains[0].hypot(gains[1]) - 1.0).abs() < 1e-12);
        }
    }
}
