//! Low-frequency oscillator: moves other parameters.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::legs::within;
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};
use crate::dsp::phase;

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "lfo",
    family: Family::Envelope,
    summary: "A slow oscillator between two values, to move other parameters.",
    detail: "low + (high − low) v, where v runs from 0 to 1 with the phase p = ∫ rate dt + phase (in turns, 0 at the onset): \
             sine ½ + ½ sin 2πp; triangle likewise in straight lines; square 1 in the first half of a turn, else 0; saw from 0 \
             to 1 over a turn (for one that falls, let `low` be above `high`). The edges of square and saw take the time `ease` \
             from their instant on, at most half a turn, along u³(10 − 15u + 6u²): so they hold nothing above some 4/`ease` Hz \
             that would fold into the band. With an `ease` of 0 they are jumps of the sampled signal. A rate that is moved by a \
             signal may be negative. For a sound rather than a movement take an oscillator.",
    params: &[
        Param { name: "wave", kind: Kind::Choice(WAVES, 0), unit: "", doc: "Shape." },
        Param {
            name: "rate",
            kind: Kind::Frequency(Numeric::or(1.0, -1000.0, 1000.0)),
            unit: "Hz",
            doc: "Turns a second.",
        },
        Param {
            name: "phase",
            kind: Kind::Start(Numeric::or(0.0, -1e6, 1e6)),
            unit: "turns",
            doc: "Phase at the onset.",
        },
        Param {
            name: "low",
            kind: Kind::Signal(Numeric::or(0.0, -1e6, 1e6)),
            unit: "",
            doc: "Value where v is 0.",
        },
        Param {
            name: "high",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Value where v is 1.",
        },
        Param {
            name: "ease",
            kind: Kind::Start(Numeric::or(0.005, 0.0, 1000.0)),
            unit: "s",
            doc: "Length of the edges of square and saw.",
        },
    ],
    example: r#"breath = { type = "lfo", rate = 0.2, low = 0.3 }"#,
};

const WAVES: &[&str] = &["sine", "triangle", "square", "saw"];

/// The narrowest edge, in turns: keeps u finite.
const NARROWEST: f64 = 1e-9;

/// Phase and step of eight lanes.
#[derive(Debug, Clone)]
pub struct Lanes<R> {
    wave: usize,
    phase: [u64; LANES],
    step: [u64; LANES],
    ease: [f64; LANES],
    turns_a_hertz: f64,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn new(setup: &Setup) -> Self {
        Self {
            wave: setup.choices.first().copied().unwrap_or(0),
            phase: [0; LANES],
            step: [0; LANES],
            ease: [0.0; LANES],
            turns_a_hertz: 1.0 / setup.rate,
            _real: std::marker::PhantomData,
        }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let turns = onset.start[0] * self.turns_a_hertz;
        self.step[lane] = phase::turns(turns);
        self.phase[lane] = phase::turns(turns * onset.age).wrapping_add(phase::turns(onset.start[1]));
        self.ease[lane] = within(onset.start[4], 0.0, 1000.0);
    }

    fn retune(&mut self, lane: usize, was: &[f64], now: &[f64]) {
        self.step[lane] = phase::turns(now[0] * self.turns_a_hertz);
        self.phase[lane] =
            self.phase[lane].wrapping_add(phase::turns(now[1])).wrapping_sub(phase::turns(was[1]));
        self.ease[lane] = within(now[4], 0.0, 1000.0);
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        match self.wave {
            0 => self.fill(io, |angle, _| R::of(0.5) + R::of(0.5) * R::sine(angle)),
            1 => self.fill(io, |angle, _| {
                R::of(1.0 - (2.0 * turn(angle.wrapping_add(1 << 62)) - 1.0).abs())
            }),
            2 => self.fill(io, |angle, width| {
                // Both halves are the same edge, one of them upside down.
                let edge = eased(0.5 * turn(angle << 1) / width);
                R::of(if angle >> 63 == 0 { edge } else { 1.0 - edge })
            }),
            _ => self.fill(io, |angle, width| {
                let p = turn(angle);
                let fall = 1.0 - eased(p / width);
                let rise = (p - width) / (1.0 - width);
                R::of(if p < width { fall } else { rise })
            }),
        }
    }
}

impl<R: Real> Lanes<R> {
    /// `shape` of the phase and the width of an edge in turns.
    #[inline(always)]
    fn fill(&mut self, io: &mut Io<R>, shape: impl Fn(u64, f64) -> R) {
        // `low` and `high` follow `rate` and `phase`.
        let [rate, low, high] = [io.inputs[0], io.inputs[2], io.inputs[3]];
        let (mut angle, step) = (self.phase, self.step);
        let mut width: [f64; LANES] = std::array::from_fn(|l| width_of(rate.base[l], self.ease[l]));
        for (frame, out) in io.output.iter_mut().enumerate() {
            let (from, to) = (low.at(frame), high.at(frame));
            if !rate.is_steady() {
                let bend = rate.at(frame);
                for l in 0..LANES {
                    width[l] = width_of(rate.base[l] + bend[l].wide(), self.ease[l]);
                }
            }
            for l in 0..LANES {
                out[l] = from[l] + (to[l] - from[l]) * shape(angle[l], width[l]);
                angle[l] = angle[l].wrapping_add(step[l]);
            }
            if !rate.is_steady() {
                let bend = rate.at(frame);
                for l in 0..LANES {
                    let turns = bend[l].wide() * self.turns_a_hertz;
                    angle[l] = angle[l].wrapping_add(phase::deviation(turns - (turns + 0.5).floor()));
                }
            }
        }
        self.phase = angle;
    }
}

#[inline(always)]
fn width_of(rate: f64, ease: f64) -> f64 {
    let width = rate.abs() * ease;
    // In this order, what is not a number is as wide as can be.
    if width < 0.5 { if width > NARROWEST { width } else { NARROWEST } } else { 0.5 }
}

/// A phase in turns, from 0 to just below 1.
#[inline(always)]
fn turn(phase: u64) -> f64 {
    f64::from_bits(0x3FF0_0000_0000_0000 | phase >> 12) - 1.0
}

/// 0 to 1 for u from 0 to 1, with two derivatives of 0 at both ends.
#[inline(always)]
fn eased(u: f64) -> f64 {
    let u = if u < 1.0 { u } else { 1.0 };
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

/// The definition.
#[derive(Debug)]
pub struct Exact {
    wave: usize,
    turns: f64,
    start: (f64, f64),
    ease: f64,
    previous: Option<(f64, f64)>,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let ease = if onset.start[4] > 0.0 { onset.start[4].min(1000.0) } else { 0.0 };
        let start = (finite(onset.start[0]), finite(onset.start[1]));
        Self { wave: setup.choices[0], turns: 0.0, start, ease, previous: None }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        let (rate, low, high) = (inputs[0], inputs[2], inputs[3]);
        match self.previous {
            // The rate holds for a sample, as in any sampled oscillator.
            Some((before, rate)) => self.turns += rate * (t - before),
            None => self.turns = self.start.0 * t,
        }
        self.previous = Some((t, rate));
        self.turns -= self.turns.floor();
        let p = (self.turns + self.start.1).rem_euclid(1.0);
        let width = (self.ease * rate.abs()).clamp(1e-9, 0.5);
        let edge = |turns: f64| {
            let u = (turns / width).min(1.0);
            10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5)
        };
        let v = match WAVES[self.wave] {
            "sine" => 0.5 + 0.5 * (std::f64::consts::TAU * p).sin(),
            "triangle" if p < 0.25 => 0.5 + 2.0 * p,
            "triangle" if p < 0.75 => 1.5 - 2.0 * p,
            "triangle" => 2.0 * p - 1.5,
            "square" if p < 0.5 => edge(p),
            "square" => 1.0 - edge(p - 0.5),
            _ if p < width => 1.0 - edge(p),
            _ => (p - width) / (1.0 - width),
        };
        low + (high - low) * v
    }
}

#[cfg(test)]
mod tests {
    use super::WAVES;
    use crate::node::harness::{Bench, error_db, low_pass};

    /// A phase that is another now is one from now on; the rate goes on from there.
    #[test]
    fn another_phase_is_taken_at_once() {
        use super::{Io, Kernel, LANES, Lanes, Onset};
        use crate::node::kernel::Input;
        let bench = bench(0, 3.0);
        let known = |rate: f64, phase: f64| [rate, phase, 0.0, 1.0, 0.005];
        let run = |lanes: &mut Lanes<f64>, rate: f64| {
            let (zeros, ones, base) = ([[0.0; LANES]], [[1.0; LANES]], [rate; LANES]);
            let input = |rows| Input { rows, step: 0, steady: true, base: &base };
            let mut output = [[0.0; LANES]; 300];
            let inputs = [input(&zeros), input(&zeros), input(&zeros), input(&ones)];
            lanes.run(&mut Io { inputs: &inputs, output: &mut output, still: false });
            output.map(|row| row[0])
        };
        let mut changed: Lanes<f64> = Lanes::new(&bench.setup);
        let mut other: Lanes<f64> = Lanes::new(&bench.setup);
        changed.start(0, &Onset { age: -1.5, stream: 0, start: &known(3.0, 0.1) });
        other.start(0, &Onset { age: -1.5, stream: 0, start: &known(3.0, 0.45) });
        assert_ne!(run(&mut changed, 3.0), run(&mut other, 3.0));
        changed.retune(0, &known(3.0, 0.1), &known(7.0, 0.45));
        other.retune(0, &known(3.0, 0.45), &known(7.0, 0.45));
        let (changed, other) = (run(&mut changed, 7.0), run(&mut other, 7.0));
        let most = changed.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(most < 1e-12, "{most}");
    }

    fn bench(wave: usize, rate: f64) -> Bench {
        Bench::new("lfo", 8000.0).choice("wave", wave).steady("rate", rate).steady("phase", 0.137)
    }

    #[test]
    fn every_wave_follows_its_definition() {
        for (wave, name) in WAVES.iter().enumerate() {
            for rate in [0.2, 7.3, -3.1, 150.0, 0.0] {
                let bench = bench(wave, rate).age(-1.37).moving("low", -0.5, |t| (3.0 * t).sin()).steady("high", 2.0);
                let (single, double) = (bench.error_db::<f32>(80_000), bench.error_db::<f64>(80_000));
                assert!(single < -130.0 && double < -170.0, "{name} at {rate}: {single} {double}");
            }
            let moved = bench(wave, 4.0).moving("rate", 4.0, |t| 6.0 * (2.0 * t.max(0.0)).sin());
            assert!(moved.error_db::<f32>(80_000) < -110.0, "{name}: {}", moved.error_db::<f32>(80_000));
            moved.check_contract();
            bench(wave, 31.0).check_contract();
        }
    }

    #[test]
    fn eased_edges_hold_within_the_band_what_faster_sampling_gives() {
        for wave in [2, 3] {
            let bench = bench(wave, 5.3);
            let kernel = low_pass(&bench.kernel::<f64>(8000, &[64]), 1);
            let twin = low_pass(&bench.twin(8000 * 16, 16), 16);
            // It begins in the middle of things, not in silence.
            let error = error_db(&kernel[80..7900], &twin[80..7900]);
            assert!(error < -95.0, "{}: {error}", WAVES[wave]);
        }
    }

    #[test]
    fn it_stays_between_low_and_high_whatever_it_is_fed() {
        for wave in 0..WAVES.len() {
            for value in [f64::NAN, f64::INFINITY, -1.0, 1e300, 0.0, 999.0] {
                for bench in [bench(wave, value), bench(wave, 3.0).steady("ease", value).steady("phase", value)] {
                    let moved = bench.clone().moving("rate", 2.0, move |_| value);
                    for bench in [bench, moved] {
                        let samples = bench.kernel::<f32>(500, &[64]);
                        assert!(samples.iter().all(|v| (-1e-6..=1.0 + 1e-6).contains(v)), "{wave} {value}");
                    }
                }
            }
        }
    }
}
