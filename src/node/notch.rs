//! Notch filter.

use super::second_order::{self, Part};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "notch",
    family: Family::Filter,
    summary: "Takes out one frequency.",
    detail: "(1 + s²/ω²) / (1 + s/qω + s²/ω²). \
             It is the bilinear (trapezoidal) state-variable filter at the engine's rate, exact at its frequency. The frequency is limited to 1 Hz to \
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
            name: "frequency",
            kind: Kind::Signal(Numeric::required(0.0, 4000.0)),
            unit: "Hz",
            doc: "Where it acts.",
        },
        Param {
            name: "q",
            kind: Kind::Signal(Numeric::or(1.0, 0.1, 1000.0)),
            unit: "",
            doc: "Frequency over bandwidth at −3 dB.",
        },
    ],
    example: r#"clean = { type = "notch", input = "mic", frequency = 50, q = 10 }"#,
};

/// The part of the state-variable filter that this is.
#[derive(Debug, Clone)]
pub enum Rest {}

impl Part for Rest {
    #[inline(always)]
    fn of(input: f64, _low: f64, band: f64) -> f64 {
        input - band
    }
}

/// Eight filters.
pub type Lanes<R> = second_order::Lanes<R, Rest>;
/// The definition.
pub type Exact = second_order::Exact<Rest>;

#[cfg(test)]
mod tests {
    use crate::node::second_order::tests::check;

    #[test]
    fn it_is_its_definition_however_it_moves() {
        check("notch", "frequency", 3000.0);
    }
}
