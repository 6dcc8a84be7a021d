//! Limits a signal.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "clip",
    family: Family::Arithmetic,
    summary: "Cuts a signal off at a limit, with a rounded corner.",
    detail: "With u = input / limit and a knee k: u up to |u| = 1 − k, the limit from 1 + k on, and between them a curve whose slope falls from \
             1 to 0 by the quintic 1 − 10v³ + 15v⁴ − 6v⁵ (v from 0 to 1 across the knee), so that bends are smooth to the second order. The rounder the \
             knee, the less folds back into the band: for a sine of about 250 Hz at twice the limit, −88 dB with a knee of 0.5, \
             −94 dB with 0.75, −52 dB with 0, which is a plain clip. A limit of 0 or less, or one that is not a number, gives 0.",
    params: &[
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1000000.0, 1000000.0)),
            unit: "",
            doc: "What is clipped.",
        },
        Param {
            name: "limit",
            kind: Kind::Signal(Numeric::or(1.0, 0.0, 1000000.0)),
            unit: "",
            doc: "Most that comes out, on both sides.",
        },
        Param {
            name: "knee",
            kind: Kind::Signal(Numeric::or(0.5, 0.0, 1.0)),
            unit: "",
            doc: "Half the width of the rounded part, as a share of the limit.",
        },
    ],
    example: r#"hard = { type = "clip", input = "tone", limit = 0.5 }"#,
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
        let [input, limit, knee] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        for (frame, out) in io.pointwise().iter_mut().enumerate() {
            let (x, most, knee) = (input.at(frame), limit.at(frame), knee.at(frame));
            for l in 0..LANES {
                let most = R::ZERO.max(most[l]).min(R::of(1e6));
                // A knee this narrow cannot be told from none.
                let knee = R::of(1e-4).max(knee[l]).min(R::ONE) * most;
                let (size, straight) = (x[l].abs(), most - knee);
                let v = R::ZERO.max((size - straight) / (knee + knee)).min(R::ONE);
                let area = v * v * v * v * (R::of(2.5) - v * (R::of(3.0) - v));
                let low = if size < straight { size } else { straight };
                let y = low + (knee + knee) * (v - area);
                let y = if y < most { y } else { most };
                out[l] = if x[l] < R::ZERO { -y } else { y };
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
        let (limit, knee) = (inputs[1], inputs[2].clamp(1e-4, 1.0));
        if limit <= 0.0 {
            return 0.0;
        }
        let u = inputs[0].abs() / limit;
        let y = if u <= 1.0 - knee {
            u
        } else if u >= 1.0 + knee {
            1.0
        } else {
            let v = (u - 1.0 + knee) / (2.0 * knee);
            1.0 - knee + 2.0 * knee * (v - 2.5 * v.powi(4) + 3.0 * v.powi(5) - v.powi(6))
        };
        limit * y.copysign(inputs[0])
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn the_kernel_follows_its_twin() {
        for knee in [0.0, 0.2, 1.0] {
            let bench = Bench::new("clip", 8000.0)
                .moving("input", 0.2, |t| (900.0 * t).sin())
                .moving("limit", 0.5, |t| 0.3 * t.sin())
                .steady("knee", knee);
            bench.check_contract();
            assert!(bench.error_db::<f32>(80_000) < -120.0, "{}", bench.error_db::<f32>(80_000));
        }
    }

    #[test]
    fn little_folds_into_the_band() {
        for (knee, most) in [(0.5, -85.0), (0.75, -92.0), (0.0, -50.0)] {
            let bench = Bench::new("clip", 8000.0)
                .age(-1.0)
                .moving("input", 0.0, |t| {
                    // Fades in and out, as the filters of the comparison ring.
                    (1.0 - (std::f64::consts::TAU * t.max(0.0) / 0.25).cos()) / 2.0 * (std::f64::consts::TAU * 250.0 * t).sin()
                })
                .steady("limit", 0.5)
                .steady("knee", knee);
            let error = bench.band_error_db::<f32>(2080, 16);
            assert!(error < most, "knee {knee}: {error}");
        }
    }

    #[test]
    fn hostile_input_stays_within_the_limit() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30, -1e30] {
            for name in ["input", "limit", "knee"] {
                let mut bench = Bench::new("clip", 8000.0);
                for other in ["input", "limit", "knee"] {
                    bench = bench.moving(other, 0.5, move |_| if other == name { bad } else { 0.0 });
                }
                let most = if name == "limit" { 1e6 } else { 0.5 };
                assert!(bench.kernel::<f32>(10, &[64]).iter().all(|v| v.abs() <= most), "{name} {bad}");
            }
        }
    }
}
