//! Envelope follower.

use std::collections::VecDeque;

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
             de/dt = (r − e) / τ, τ = attack where r > e and release elsewhere. The input is heard one sample of the engine (0.125 ms) late: then a polynomial \
             goes through six samples, and is read eight times on the way from the third newest to the second; r is the mean of \
             two readings. So the envelope of 250 Hz comes out within −80 dB, that of 700 Hz within −60 dB. Times are limited to 0 (at once) to 100 s; an input that is not a number counts as 0. Below \
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

/// Readings from sample to sample, and samples that a polynomial goes through.
const READINGS: usize = 8;
const POINTS: usize = 6;

/// Lagrange's weights of the samples, the newest first, for each reading on the way from the one before the last but one to the last
/// but one. On the way to the newest they would amplify what lies above 2 kHz.
const WEIGHTS: [[f64; POINTS]; READINGS] = weights();

const fn weights() -> [[f64; POINTS]; READINGS] {
    let (mut all, mut m) = ([[1.0; POINTS]; READINGS], 0);
    while m < READINGS {
        let back = 2.0 - (m + 1) as f64 / READINGS as f64;
        let mut k = 0;
        while k < POINTS {
            let mut j = 0;
            while j < POINTS {
                if j != k {
                    all[m][k] *= (j as f64 - back) / (j as f64 - k as f64);
                }
                j += 1;
            }
            k += 1;
        }
        m += 1;
    }
    all
}

/// Eight followers, in `f64`, as a long release moves by little at a sample.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    rms: bool,
    rate: f64,
    value: [f64; LANES],
    before: [f64; LANES],
    past: [[f64; LANES]; POINTS - 1],
    up: [f64; LANES],
    down: [f64; LANES],
    _real: std::marker::PhantomData<R>,
}

/// What is left at the next reading.
#[inline(always)]
fn left(seconds: f64, rate: f64) -> f64 {
    let seconds = if seconds < 100.0 { seconds } else { 100.0 };
    if seconds > 0.0 { exp(-1.0 / (seconds * rate * READINGS as f64)) } else { 0.0 }
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        let zero = [0.0; LANES];
        Self {
            rms: setup.choices.first() == Some(&1),
            rate: setup.rate,
            value: zero,
            before: zero,
            past: [zero; POINTS - 1],
            up: zero,
            down: zero,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.value[lane] = 0.0;
        self.before[lane] = 0.0;
        for row in &mut self.past {
            row[lane] = 0.0;
        }
        self.up[lane] = left(onset.start[1], self.rate);
        self.down[lane] = left(onset.start[2], self.rate);
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.up[lane] = left(now[1], self.rate);
        self.down[lane] = left(now[2], self.rate);
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
            let mut row = input.at(frame).map(R::wide);
            for x in &mut row {
                *x = if x.abs() < 1e9 { *x } else { 0.0 };
            }
            let p = self.past;
            for w in &WEIGHTS {
                for l in 0..LANES {
                    let x = (w[0] * row[l] + w[1] * p[0][l]) + (w[2] * p[1][l] + w[3] * p[2][l]) + (w[4] * p[3][l] + w[5] * p[4][l]);
                    let size = if self.rms { x * x } else { x.abs() };
                    let mean = 0.5 * (size + self.before[l]);
                    self.before[l] = size;
                    let stays = if mean > self.value[l] { self.up[l] } else { self.down[l] };
                    self.value[l] = mean + stays * (self.value[l] - mean);
                }
            }
            self.past = [row, p[0], p[1], p[2], p[3]];
            for l in 0..LANES {
                out[l] = R::of(if self.rms { self.value[l].sqrt() } else { self.value[l] });
            }
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
    before: f64,
    /// The last samples, the newest first: six after those by which the twin's rate has to be late.
    past: VecDeque<f64>,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, _onset: &Onset) -> Self {
        let late = (setup.rate / setup.engine_rate).round().max(1.0) as usize - 1;
        let past = VecDeque::from(vec![0.0; late + 6]);
        Self { rms: setup.choices.first() == Some(&1), rate: setup.rate, value: 0.0, before: 0.0, past }
    }
}

impl Twin for Exact {
    fn step(&mut self, _t: f64, inputs: &[f64]) -> f64 {
        self.past.pop_back();
        self.past.push_front(inputs[0]);
        let late = self.past.len() - 6;
        for eighth in 1..=8 {
            // Neville's scheme, at `place` with the newest of six samples at 0 and the one before at −1.
            let place = f64::from(eighth) / 8.0 - 2.0;
            let mut through: [f64; 6] = std::array::from_fn(|k| self.past[late + k]);
            for degree in 1..6 {
                for k in 0..6 - degree {
                    let (here, there) = (-(k as f64), -((k + degree) as f64));
                    through[k] = ((place - there) * through[k] + (here - place) * through[k + 1]) / (here - there);
                }
            }
            let size = if self.rms { through[0].powi(2) } else { through[0].abs() };
            let mean = (size + self.before) / 2.0;
            self.before = size;
            let constant = if mean > self.value { inputs[1] } else { inputs[2] }.clamp(0.0, 100.0);
            if constant == 0.0 {
                self.value = mean;
            } else {
                self.value += (mean - self.value) * -(-0.125 / (constant * self.rate)).exp_m1();
            }
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

    /// The twin at 32 times the rate is, but for its own small steps, the differential equation on the true input.
    #[test]
    fn attack_and_release_that_differ_follow_the_equation() {
        for mode in 0..2 {
            for (hertz, most) in [(61.0, -95.0), (130.0, -85.0), (250.0, -75.0), (711.0, -65.0)] {
                let bench = Bench::new("follow", 8000.0)
                    .choice("mode", mode)
                    .moving("input", 0.0, move |t| (1.0 - (-300.0 * t.max(0.0)).exp()).powi(3) * (TAU * hertz * t).sin())
                    .steady("attack", 0.002)
                    .steady("release", 0.03);
                let error = bench.band_error_db::<f32>(1500, 32);
                println!("mode {mode}, {hertz} Hz: {error}");
                assert!(error < most, "mode {mode}, {hertz} Hz: {error}");
            }
        }
    }

    /// White noise of ±1 has an RMS of 1/√3 and a mean size of ½; nothing on the way from sample to sample may change that much.
    #[test]
    fn noise_reads_as_strong_as_it_is() {
        for (mode, exact) in [(0, 0.5), (1, 1.0 / 3f64.sqrt())] {
            let noise = |t: f64| crate::dsp::random::uniform(5, (t * 8000.0 + 10.5) as u64);
            let bench = Bench::new("follow", 8000.0).choice("mode", mode).moving("input", 0.0, noise);
            let bench = bench.steady("attack", 0.5).steady("release", 0.5);
            let out = bench.kernel::<f32>(80_000, &[64]);
            let mean = out[40_000..].iter().sum::<f64>() / 40_000.0;
            assert!((20.0 * (mean / exact).log10()).abs() < 1.0, "{mode}: {mean} for {exact}");
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
