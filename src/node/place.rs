//! Where a voice is, as its nodes say.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

const METRES: Numeric = Numeric::or(0.0, -1000.0, 1000.0);

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "place",
    family: Family::Place,
    summary: "Where the voice is felt.",
    detail: "It moves the voice that has it: x, y and z are added to the position of its event, or along the path of it; where an event has none, \
             they are the position. The tactors about it share it at every engine sample by the voice's law, whatever reads this node; as a signal it is \
             silence. A voice has one at most, and plays at no tactor by name then. It is there five engine samples (0.6 ms) after \
             its nodes say so, since what crosses from tactor to tactor has to be known from both sides; what moves smoothly then is as exact as a path. What jumps \
             farther than 12 mm from one engine sample to the next is there at once.",
    params: &[
        Param { name: "x", kind: Kind::Signal(METRES), unit: "m", doc: "Along x: of a body, to the wearer's right." },
        Param { name: "y", kind: Kind::Signal(METRES), unit: "m", doc: "Along y: up." },
        Param { name: "z", kind: Kind::Signal(METRES), unit: "m", doc: "Along z: ahead." },
        Param {
            name: "width",
            kind: Kind::Signal(METRES),
            unit: "m",
            doc: "Added to the voice's width; both together are never below 0.",
        },
    ],
    example: r#"here = { type = "place", x = "0.1 * sway", y = 0.05 }"#,
};

/// Eight lanes of silence: the engine reads what it is given.
#[derive(Debug, Clone)]
pub struct Lanes<R>(R);

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(_setup: &Setup) -> Self {
        Self(R::ZERO)
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        io.pointwise().fill([self.0; LANES]);
    }
}

/// The definition: nothing.
#[derive(Debug)]
pub struct Exact;

impl Exact {
    /// For one voice.
    pub fn new(_setup: &Setup, _onset: &Onset) -> Self {
        Self
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, _inputs: &[f64]) -> f64 {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn as_a_signal_it_is_silence() {
        let bench = Bench::new("place", 8000.0);
        bench.check_contract();
        assert!(bench.kernel::<f32>(100, &[64]).iter().all(|x| *x == 0.0));
        assert!(bench.twin(100, 1).iter().all(|x| *x == 0.0));
    }
}
