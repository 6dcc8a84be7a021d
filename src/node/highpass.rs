//! High-pass filter.

use super::second_order::{self, Part};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "highpass",
    family: Family::Filter,
    summary: "A high-pass filter, 12 dB an octave.",
    detail: "(s/ω)² / (1 + s/qω + s²/ω²). \
             It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its cutoff. The cutoff is limited to 1 Hz to \
             0.45 of that rate, q to 0.1 to 1000, at every sample, however they move; an input that is not a number counts as 0. A tail \
             below −140 dB ends in silence.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "What is filtered.",
        },
        Param {
            name: "cutoff",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Where it acts.",
        },
        Param {
            name: "q",
            kind: Kind::Signal(Numeric::or(std::f64::consts::FRAC_1_SQRT_2, 0.1, 1000.0)),
            unit: "",
            doc: "Resonance: gain at the cutoff.",
        },
    ],
    example: r#"thin = { type = "highpass", input = "hiss", cutoff = 60 }"#,
};

/// The part of the state-variable filter that this is.
#[derive(Debug, Clone)]
pub enum High {}

impl Part for High {
    #[inline(always)]
    fn of(input: f64, low: f64, band: f64) -> f64 {
        input - band - low
    }
}

/// Eight filters.
pub type Lanes<R> = second_order::Lanes<R, High>;
/// The definition.
pub type Exact = second_order::Exact<High>;

#[cfg(test)]
mod tests {
    use crate::node::second_order::tests::check;

    #[test]
    fn it_is_its_definition_however_it_moves() {
        check("highpass", "cutoff", 800.0);
    }
}
