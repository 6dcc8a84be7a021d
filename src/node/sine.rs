//! Sine oscillator.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::quadrature::{Clockwork, Turns, bend};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "sine",
    family: Family::Oscillator,
    summary: "A sine.",
    detail: "amplitude × sin 2π(∫ frequency dt + phase). The integral is 0 at the onset, which may fall between samples; what a \
             signal adds to the frequency is integrated by the six-point Adams–Moulton rule, at the engine's rate. \
             A moved frequency may be negative; what moves beyond half the engine's rate folds, as any sampled sine does. \
             The frequency that is known at the onset does not: from 0.4 of that rate on it fades, and from half of it on there is nothing. \
             A phase beyond ±2048 turns counts as 0.",
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
    example: r#"tone = { type = "sine", frequency = 250 }"#,
};

/// Share of the engine's rate from which a frequency fades, and where nothing is left of it.
const EDGE: (f64, f64) = (0.4, 0.5);

/// What is left of a sine of that frequency.
fn left(frequency: f64, rate: f64) -> f64 {
    // Not-a-number is no frequency, and stands still.
    let share = if frequency.is_nan() { 0.0 } else { (frequency / rate).abs() };
    ((EDGE.1 - share) / (EDGE.1 - EDGE.0)).clamp(0.0, 1.0)
}

/// Phases of eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    clock: Clockwork,
    rate: f64,
    /// What is left of each lane, where that is not all.
    left: Option<[R; LANES]>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self { clock: Clockwork::new(setup.rate).of_what_begins(setup.begins), rate: setup.rate, left: None }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        self.leave(lane, onset.start[0]);
        self.clock.start(lane, onset.start[0], onset.age);
    }

    fn retune(&mut self, lane: usize, _was: &[f64], now: &[f64]) {
        self.leave(lane, now[0]);
        self.clock.retune(lane, now[0]);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let [frequency, phase, amplitude] = [io.inputs[0], io.inputs[1], io.inputs[2]];
        if frequency.is_steady() && phase.is_steady() {
            let (hands, &step) = self.clock.hands();
            let (mut angle, mut shift) = ([0; LANES], [0; LANES]);
            for l in 0..LANES {
                shift[l] = bend(phase.base[l]);
                angle[l] = hands[l].wrapping_add(shift[l]);
            }
            for (frame, out) in io.output.iter_mut().enumerate() {
                let gain = amplitude.at(frame);
                for l in 0..LANES {
                    angle[l] = angle[l].wrapping_add(step[l]);
                    out[l] = R::sine(angle[l]) * gain[l];
                }
            }
            for l in 0..LANES {
                hands[l] = angle[l].wrapping_sub(shift[l]);
            }
        } else {
            for (frame, out) in io.output.iter_mut().enumerate() {
                let (turns, gain) = (phase.at(frame), amplitude.at(frame));
                let angle = self.clock.advance_by(&frequency.at(frame));
                for l in 0..LANES {
                    out[l] = R::sine(angle[l].wrapping_add(bend(turns[l].wide()))) * gain[l];
                }
            }
        }
        if let Some(left) = self.left {
            for out in &mut *io.output {
                for l in 0..LANES {
                    out[l] *= left[l];
                }
            }
        }
    }
}

impl<R: Real> Lanes<R> {
    /// What is left of a lane of that frequency.
    fn leave(&mut self, lane: usize, frequency: f64) {
        let left = R::of(left(frequency, self.rate));
        if left != R::ONE || self.left.is_some() {
            self.left.get_or_insert([R::ONE; LANES])[lane] = left;
            self.left = self.left.filter(|all| *all != [R::ONE; LANES]);
        }
    }
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    turns: Turns,
    left: f64,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let left = match onset.start[0].abs() / setup.engine_rate {
            share if share > 0.4 => (5.0 - 10.0 * share).max(0.0),
            _ => 1.0,
        };
        Self { turns: Turns::new(onset.start[0], setup.begins), left }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let turns = self.turns.step(t, inputs[0]) + inputs[1];
        self.left * inputs[2] * (std::f64::consts::TAU * turns).sin()
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;
    use std::f64::consts::TAU;

    #[test]
    fn steady_and_moving() {
        let steady = Bench::new("sine", 8000.0).steady("frequency", 250.1).steady("phase", -0.3);
        steady.check_contract();
        assert!(steady.error_db::<f32>(80_000) < -120.0);
        let moving = Bench::new("sine", 7350.0)
            .age(-1.01)
            .moving("frequency", 200.0, |t| 200.0 * (TAU * 50.0 * t).sin())
            .moving("phase", 0.0, |t| (TAU * 31.0 * t).cos())
            .moving("amplitude", 1.0, |t| (TAU * 7.0 * t).sin());
        moving.check_contract();
        assert!(moving.error_db::<f32>(73_500) < -110.0);
        assert!(moving.error_db::<f64>(73_500) < -160.0);
    }

    /// The index of 10 that hostile scenes use, in ten seconds.
    #[test]
    fn deep_modulation_follows_its_twin() {
        for (rate, hertz, index) in [(7350.0, 250.0, 10.0), (7350.0, 50.0, 10.0), (8000.0, 250.0, 5.0)] {
            let fm = Bench::new("sine", rate)
                .age(-1.7)
                .moving("frequency", 250.0, move |t| index * hertz * (TAU * hertz * t).sin());
            let (single, double) = (fm.error_db::<f32>(73_500), fm.error_db::<f64>(73_500));
            assert!(single < -110.0 && double < -110.0, "{rate} Hz, {hertz} Hz × {index}: {single}, {double}");
        }
    }

    #[test]
    fn frequency_modulation_is_that_of_the_integral() {
        for (modulator, index, most) in [(50.0, 10.0, -95.0), (250.0, 2.0, -85.0)] {
            let depth = index * modulator;
            let fm = Bench::new("sine", 8000.0)
                .age(-1.7)
                .moving("frequency", 250.0, move |t| depth * (TAU * modulator * t).sin());
            let kernel = fm.kernel::<f32>(8000, &[64]);
            // Closed form: ∫ sin = (1 − cos) / 2πf.
            let exact = |n: usize| {
                let t = (-1.7 + n as f64) / 8000.0;
                (TAU * 250.0 * t + index * (1.0 - (TAU * modulator * t).cos())).sin()
            };
            let (mut error, mut energy) = (0.0, 0.0);
            for (n, value) in kernel.iter().enumerate().skip(2) {
                error += (value - exact(n)).powi(2);
                energy += exact(n).powi(2);
            }
            let db = 10.0 * (error / energy).log10();
            assert!(db < most, "{modulator} Hz: {db}");
        }
    }

    /// 40 Hz that begin at once and fall with 20 ms: their integral is 0.8 (1 − e^(−t / 20 ms)) turns. The engine's samples of the
    /// jump are band-limited, the twin's are means; both must give the integral once the jump is over.
    #[test]
    fn a_jump_of_frequency_is_integrated_from_its_instant() {
        let turns = |t: f64| 200.0 * t + 0.8 * -(-t / 0.02).exp_m1();
        let struck = |age: f64| Bench::new("decay", 8000.0).steady("attack", 0.0).steady("time", 0.02).age(age);
        for age in [-1.0, -1.3, -1.8, -1.999] {
            for (factor, samples) in [(1, struck(age).kernel::<f64>(400, &[64])), (16, struck(age).twin(6400, 16))] {
                let rate = 8000.0 * f64::from(factor);
                let place = move |t: f64| samples[(t * rate - age * f64::from(factor)).round().max(0.0) as usize];
                let tone = Bench::new("sine", 8000.0).age(age).moving("frequency", 200.0, move |t| 40.0 * place(t)).begins();
                let out = if factor == 1 { tone.kernel::<f64>(400, &[64]) } else { tone.twin(6400, 16) };
                for (n, value) in out.iter().enumerate().skip(16 * factor as usize) {
                    let t = (age + n as f64 / f64::from(factor)) / 8000.0;
                    let exact = (TAU * turns(t)).sin();
                    assert!((value - exact).abs() < 3e-6, "{factor} {age} {n}: {value} {exact}");
                }
            }
        }
    }

    #[test]
    fn what_begins_follows_its_twin() {
        let bench = Bench::new("sine", 7350.0)
            .age(-1.7)
            .moving("frequency", 200.0, |t| 300.0 * (TAU * 47.3 * t.max(0.0)).sin())
            .begins();
        bench.check_contract();
        assert!(bench.error_db::<f32>(73_500) < -110.0);
        assert!(bench.error_db::<f64>(73_500) < -160.0);
    }

    /// A slip of a digit must not come back as another tone.
    #[test]
    fn what_lies_beyond_half_the_rate_is_not_folded_back() {
        for hertz in [4000.0, 7900.0, -7900.0, 12_000.0, 1e9] {
            let bench = Bench::new("sine", 8000.0).steady("frequency", hertz).steady("phase", 0.1);
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| *v == 0.0), "{hertz}");
        }
        let near = Bench::new("sine", 8000.0).steady("frequency", 3600.0);
        near.check_contract();
        assert!(near.error_db::<f32>(8000) < -110.0);
        let peak = near.kernel::<f32>(8000, &[64]).into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        assert!((peak - 0.5).abs() < 0.01, "{peak}");
    }

    #[test]
    fn hostile_modulation_stays_within_the_amplitude() {
        for bad in [f64::NAN, f64::INFINITY, -1e300, 1e9] {
            let bench = Bench::new("sine", 8000.0)
                .moving("frequency", 100.0, move |t| if t > 0.01 { bad } else { 0.0 })
                .moving("phase", 0.0, move |t| if t > 0.02 { bad } else { 0.0 });
            assert!(bench.kernel::<f32>(800, &[64]).iter().all(|v| v.abs() <= 1.000_001), "{bad}");
        }
    }
}
