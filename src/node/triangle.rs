//! Band-limited triangle oscillator.

use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use super::wave::{self, Shape};
use crate::dsp::wavetable::Wave;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "triangle",
    family: Family::Oscillator,
    summary: "A triangle, band-limited.",
    detail: "amplitude × the triangle that is 0 at phase 0, 1 at ¼ and −1 at ¾. \
             Phase and frequency are those of `sine`. Harmonic k of frequency f fades out as k f goes through the octave below 0.4375 of the \
             engine's rate (the fundamental from there to half the rate), so what would fold back is never made; below 7 Hz there are 256 harmonics.",
    params: &[
        Param {
            name: "frequency",
            kind: Kind::Frequency(Numeric::required(-4000.0, 4000.0)),
            unit: "Hz",
            doc: "Frequency; moving it is frequency modulation.",
        },
        Param {
            name: "phase",
            kind: Kind::Signal(Numeric::or(0.0, -1e6, 1e6)),
            unit: "turns",
            doc: "Added to the phase; moving it is phase modulation.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Peak value; moving it is amplitude modulation.",
        },
    ],
    example: r#"tone = { type = "triangle", frequency = 80 }"#,
};

/// The wave of this node.
#[derive(Debug, Clone)]
pub enum Tri {}

impl Shape for Tri {
    const WAVE: Wave = Wave::Triangle;
}

/// Eight lanes.
pub type Lanes<R> = wave::Lanes<R, Tri>;
/// The definition.
pub type Exact = wave::Exact<Tri>;

#[cfg(test)]
mod tests {
    #[test]
    fn it_is_its_definition_and_stays_in_the_band() {
        crate::node::wave::tests::check("triangle");
    }
}
