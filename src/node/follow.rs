//! Envelope follower.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::elementary::exp;
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "follow",
    family: Family::Filter,
    summary: "How strong a signal is at the moment.",
    detail: "With e the envelope and r the size of the input (its absolute value, or its square for `rms`, of whose e the root comes out): \
             de/dt = (r − e) / τ, τ = attack where r > e and release elsewhere. From sample to sample r counts as the mean of both, \
             which is right to the second order. Times are limited to 0 (at once) to 100 s; an input that is not a number counts as 0. Below \
             −140 dB it is 0.",
    params: &[
        Param {
            name: "mode",
            kind: Kind::Choice(&["absolute", "rms"], 0),
            unit: "",
            doc: "What is followed; a sine of amplitude 1 has a mean of 0.637 and an RMS of 0.707.",
        },
        Param {
            name: "input",
            kind: Kind::Signal(Numeric::required(-1e6, 1e6)),
            unit: "",
            doc: "What is followed.",
        },
        Param {
            name: "attack",
            kind: Kind::Signal(Numeric::or(0.005, 0.0, 100.0)),
            unit: "s",
            doc: "Time constant on the way up.",
        },
        Param {
            name: "release",
            kind: Kind::Signal(Numeric::or(0.05, 0.0, 100.0)),
            unit: "s",
            doc: "Time constant on the way down.",
        },
    ],
    example: r#"loud = { type = "follow", input = "mic", attack = 0.002, release = 0.1 }"#,
};

/// Eight followers, in `f64`, as a long release moves by little at a sample.
#[derive(Debug)]
pub struct Lanes<R> {
    rms: bool,
    rate: f64,
    value: [f64; LANES],
    before: [f64; LANES],
    fresh: [bool; LANES],
    up: [f64; LANES],
    down: [f64; LANES],
    _real: std::marker::PhantomData<R>,
}

/// What is left after a sample.
#[inline(always)]
fn left(seconds: f64, rate: f64) -> f64 {
    let seconds = if seconds < 100.0 { seconds } else { 100.0 };
    if seconds > 0.0 { exp(-1.0 / (seconds * rate)) } else { 0.0 }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let zero = [0.0; LANES];
        Self {
            rms: setup.choices.first() == Some(&1),
            rate: setup.rate,
            value: zero,
            before: zero,
            fresh: [false; LANES],
            up: zero,
            down: zero,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.value[lane] = 0.0;
        self.fresh[lane] = true;
        self.up[lane] = left(onset.start[1], self.rate);
        self.down[lane] = left(onset.start[2], self.rate);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [input, attack, release] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        let steady = attack.is_steady() && release.is_steady();
        for (frame, out) in io.output.iter_mut().enumerate() {
            if !steady {
                let (attack, release) = (attack.at(frame), release.at(frame));
                for l in 0..LANES {
                    self.up[l] = left(attack[l].wide(), self.rate);
                    self.down[l] = left(release[l].wide(), self.rate);
                }
            }
            let row = input.at(frame);
            for l in 0..LANES {
                let size = row[l].wide().abs();
                let size = if size < 1e9 { size } else { 0.0 };
                let size = if self.rms { size * size } else { size };
                let before = if self.fresh[l] { size } else { self.before[l] };
                self.before[l] = size;
                let mean = 0.5 * (size + before);
                let stays = if mean > self.value[l] { self.up[l] } else { self.down[l] };
                let value = mean + stays * (self.value[l] - mean);
                self.value[l] = value;
                out[l] = R::of(if self.rms { value.sqrt() } else { value });
            }
            self.fresh = [false; LANES];
        }
    }

    fn settle(&mut self) {
        let nothing = if self.rms { 1e-14 } else { 1e-7 };
        for value in &mut self.value {
            if *value < nothing {
                *value = 0.0;
            }
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    rms: bool,
    rate: f64,
    value: f64,
    before: Option<f64>,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        Self { rms: setup.choices.first() == Some(&1), rate: setup.rate, value: 0.0, before: None }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        let size = if self.rms { inputs[0].powi(2) } else { inputs[0].abs() };
        let mean = (size + self.before.unwrap_or(size)) / 2.0;
        self.before = Some(size);
        let constant = if mean > self.value { inputs[1] } else { inputs[2] }.clamp(0.0, 100.0);
        if constant == 0.0 {
            self.value = mean;
        } else {
            self.value += (mean - self.value) * -(-1.0 / (constant * self.rate)).exp_m1();
        }
        if self.rms { self.value.sqrt() } else { self.value }
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    #[test]
    fn both_modes_follow_their_twin() {
        for mode in 0..2 {
            let bench = Bench::new("follow", 8000.0)
                .choice("mode", mode)
                .moving("input", 0.0, |t| (TAU * 100.0 * t).sin() * t.sin())
                .moving("attack", 0.01, |t| 0.01 * t.sin())
                .steady("release", 10.0);
            bench.check_contract();
            let error = bench.error_db::<f32>(80_000);
            assert!(error < -110.0, "{error}");
        }
    }

    #[test]
    fn a_steady_sine_reads_its_mean_and_its_rms() {
        for (mode, exact) in [(0, 2.0 / std::f64::consts::PI), (1, 0.5_f64.sqrt())] {
            let bench = Bench::new("follow", 8000.0)
                .choice("mode", mode)
                .moving("input", 0.0, |t| (TAU * 173.0 * t).sin())
                .steady("attack", 0.5)
                .steady("release", 0.5);
            let out = bench.kernel::<f32>(80_000, &[64]);
            assert!((out[79_999] / exact - 1.0).abs() < 2e-3, "{}", out[79_999]);
        }
    }

    #[test]
    fn hostile_input_leaves_again() {
        for bad in [f64::NAN, f64::INFINITY, 1e30] {
            let bench = Bench::new("follow", 8000.0)
                .moving("input", 0.0, move |t| if t < 0.01 { bad } else { 0.0 })
                .moving("attack", 0.0, move |t| if t < 0.02 { bad } else { 0.0 })
                .steady("release", 0.001);
            let out = bench.kernel::<f32>(1000, &[64]);
            assert!(out.iter().all(|v| v.is_finite()) && out[999] == 0.0, "{bad}");
        }
    }
}
