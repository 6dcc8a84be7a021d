//! Band-limited sawtooth oscillator.

use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use super::wave::{self, Shape};
use crate::dsp::wavetable::Wave;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "sawtooth",
    family: Family::Oscillator,
    summary: "A rising sawtooth, band-limited.",
    detail: "amplitude × the sawtooth that rises from 0 at phase 0 to 1 at ½, jumps to −1 and rises on; mean 0. \
             Phase and frequency are those of `sine`. Harmonic k of frequency f fades out as k f goes through the octave below 0.4375 of the \
             engine's rate (the fundamental from there to half the rate), so what would fold back is never made; below 1.7 Hz there are 1024 harmonics.",
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
    example: r#"tone = { type = "sawtooth", frequency = 80 }"#,
};

/// The wave of this node.
#[derive(Debug, Clone)]
pub enum Saw {}

impl Shape for Saw {
    const WAVE: Wave = Wave::Sawtooth;
}

/// Eight lanes.
pub type Lanes<R> = wave::Lanes<R, Saw>;
/// The definition.
pub type Exact = wave::Exact<Saw>;

#[cfg(test)]
mod tests {
    #[test]
    fn it_is_its_definition_and_stays_in_the_band() {
        crate::node::wave::tests::check("sawtooth");
    }
}
