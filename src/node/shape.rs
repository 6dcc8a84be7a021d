//! Soft shaper.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "shape",
    family: Family::Arithmetic,
    summary: "Bends a signal softly towards ±1.",
    detail: "With u = drive × input limited to ±1: (35 u − 35 u³ + 21 u⁵ − 5 u⁷) / 16, whose slope 35/16 (1 − u²)³ vanishes to the second order where it \
             ends. Up to |u| = 1 a polynomial of degree 7 makes no harmonic beyond the seventh, so nothing of an input within 1 kHz folds \
             into the band at 8 kHz. Beyond that, of a sine of 250 Hz: −85 dB with a drive of 2, −60 dB with 4.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "What is shaped.",
        },
        Param {
            name: "drive",
            kind: Kind::Signal(Numeric::or(1.0, -1000000.0, 1000000.0)),
            unit: "",
            doc: "Gain before the curve.",
        },
    ],
    example: r#"warm = { type = "shape", input = "tone", drive = 1.5 }"#,
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
        let [input, drive] = [io.inputs[0], io.inputs[1]];
        let [a, b, c] = [R::of(35.0 / 16.0), R::of(21.0 / 16.0), R::of(5.0 / 16.0)];
        for (frame, out) in io.pointwise().iter_mut().enumerate() {
            let (x, drive) = (input.at(frame), drive.at(frame));
            for l in 0..LANES {
                let driven = x[l] * drive[l];
                let size = if driven.abs() < R::ONE { driven.abs() } else { R::ONE };
                let z = size * size;
                let y = size * (a - z * (a - z * (b - z * c)));
                // What is not a number becomes 0.
                out[l] = if driven > R::ZERO {
                    y
                } else if driven < R::ZERO {
                    -y
                } else {
                    R::ZERO
                };
            }
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
        let u = (inputs[0] * inputs[1]).clamp(-1.0, 1.0);
        (35.0 * u - 35.0 * u.powi(3) + 21.0 * u.powi(5) - 5.0 * u.powi(7)) / 16.0
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn the_kernel_follows_its_twin() {
        let bench = Bench::new("shape", 8000.0)
            .moving("input", 0.2, |t| (900.0 * t).sin())
            .moving("drive", 1.5, |t| 0.7 * t.sin());
        bench.check_contract();
        assert!(bench.error_db::<f32>(80_000) < -120.0);
    }

    #[test]
    fn little_folds_into_the_band() {
        for (hertz, drive, most) in [(250.0, 1.0, -100.0), (900.0, 1.0, -100.0), (250.0, 2.0, -80.0)] {
            let bench = Bench::new("shape", 8000.0)
                .age(-1.0)
                .moving("input", 0.0, move |t| {
                    (1.0 - (std::f64::consts::TAU * t.max(0.0) / 0.25).cos()) / 2.0 * (std::f64::consts::TAU * hertz * t).sin()
                })
                .steady("drive", drive);
            let error = bench.band_error_db::<f32>(2080, 16);
            assert!(error < most, "{hertz} Hz, drive {drive}: {error}");
        }
    }

    #[test]
    fn hostile_input_stays_within_one() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30] {
            for drive in [0.0, 1.0, -1e6] {
                let bench = Bench::new("shape", 8000.0).moving("input", 0.0, move |_| bad).steady("drive", drive);
                assert!(bench.kernel::<f32>(10, &[64]).iter().all(|v| v.abs() <= 1.0), "{bad}");
            }
        }
    }
}
