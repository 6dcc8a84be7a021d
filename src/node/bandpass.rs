//! Band-pass filter.

use super::second_order::{self, Part};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "bandpass",
    family: Family::Filter,
    summary: "A band-pass filter, gain 1 at its centre.",
    detail: "(s/qω) / (1 + s/qω + s²/ω²). \
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
    example: r#"band = { type = "bandpass", input = "hiss", frequency = 250, q = 4 }"#,
};

/// The part of the state-variable filter that this is.
#[derive(Debug, Clone)]
pub enum Band {}

impl Part for Band {
    #[inline(always)]
    fn of(_input: f64, _low: f64, band: f64) -> f64 {
        band
    }
}

/// Eight filters.
pub type Lanes<R> = second_order::Lanes<R, Band>;
/// The definition.
pub type Exact = second_order::Exact<Band>;

#[cfg(test)]
mod tests {
    use crate::node::second_order::tests::check;

    #[test]
    fn it_is_its_definition_however_it_moves() {
        check("bandpass", "frequency", 3000.0);
    }
}
