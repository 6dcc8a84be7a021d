//! White noise.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::random::{Source, uniform};
use crate::dsp::sinc::weights;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "white",
    family: Family::Noise,
    summary: "White noise.",
    detail: "One number a sample of the engine, uniform in ±amplitude (RMS amplitude / √3), from the stream of the node in the voice: the same seed \
             gives the same noise. The sequence begins with the voice's first sample, one to two samples ahead of the onset; between samples it is band-limited.",
    params: &[
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"hiss = { type = "white", amplitude = 0.5 }"#,
};

/// Eight streams.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    source: Source,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(_setup: &Setup) -> Self {
        Self { source: Source::default(), _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.source.start(lane, onset.stream);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let amplitude = io.inputs[0];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (noise, gain) = (self.source.draw::<R>(), amplitude.at(frame));
            for l in 0..LANES {
                out[l] = noise[l] * gain[l];
            }
        }
    }
}

/// White noise as a function of time, for the twins: the engine's sequence through a sinc in the window cosh 12√(1 − x²) / cosh 12, of 64 samples on each side.
///
/// Numbers before the voice's first are 0, as they are for the filters of the engine, whose memory is empty then. So noise that
/// begins has its band's own rise, which begins [`REACH`] samples before the first number; a twin that filters it must have
/// been asked for all of that.
#[derive(Debug)]
pub struct Sequence {
    stream: u64,
    age: f64,
    rate: f64,
}

/// Samples of the engine by which the noise begins before its first number, and ends after its last.
pub const REACH: i64 = 64;

impl Sequence {
    /// For one voice; `onset.age` tells where the engine's samples lie.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        Self { stream: onset.stream, age: onset.age, rate: setup.engine_rate }
    }

    /// Its value at voice time `t` (seconds).
    pub fn at(&self, t: f64) -> f64 {
        let place = t * self.rate - self.age;
        let near = place.round();
        if (place - near).abs() < 1e-6 {
            return if near < 0.0 { 0.0 } else { uniform(self.stream, near as u64) };
        }
        let begun = weights(place, REACH as f64).filter(|(k, _)| *k >= 0);
        begun.map(|(k, weight)| uniform(self.stream, k as u64) * weight).sum()
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    sequence: Sequence,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        Self { sequence: Sequence::new(setup, onset) }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        inputs[0] * self.sequence.at(t)
    }
}

#[cfg(test)]
mod tests {
    use crate::dsp::random::uniform;
    use crate::node::harness::Bench;

    #[test]
    fn the_sequence_is_the_stream() {
        let bench = Bench::new("white", 8000.0).moving("amplitude", 1.0, |t| 0.5 * t.sin());
        bench.check_contract();
        assert!(bench.error_db::<f32>(80_000) < -130.0);
        let plain = Bench::new("white", 8000.0);
        for (n, value) in plain.kernel::<f64>(1000, &[64]).iter().enumerate() {
            assert_eq!(*value, uniform(plain.stream, n as u64));
        }
    }

    #[test]
    fn between_samples_it_is_band_limited() {
        let plain = Bench::new("white", 8000.0).moving("amplitude", 0.0, |t| 1.0 - (100.0 * t.max(0.0)).cos());
        let error = plain.band_error_db::<f32>(3000, 16);
        assert!(error < -80.0, "{error}");
    }
}
