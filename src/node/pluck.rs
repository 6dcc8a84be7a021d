//! Plucked string.

use fundsp::Frame;
use fundsp::audionode::AudioNode;
use fundsp::funutd::Rnd;
use fundsp::typenum::{U0, U1};

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use super::leaf::{Leaf, Sampled, within};
use super::spec::{Family, Kind, NodeSpec, Numeric, Param};
use crate::dsp::lanes::{LANES, Real};

/// What the node says about itself.
pub static SPEC: NodeSpec = NodeSpec {
    name: "pluck",
    family: Family::Oscillator,
    summary: "A plucked string.",
    detail: "The string of Karplus and Strong (Computer Music Journal 7(2), 1983), tuned after Jaffe and Smith (same issue), at the engine's \
             rate, as the unit `pluck` of fundsp. With P samples a period, N = ⌊P − 1.2⌋, g = 10^(−3 / ring), b = damping / 4, \
             e = (2 + N − P) / (P − N): s[n] = y[n−1] + e (y[n] − s[n−1]), y[n] = b (u[n] + u[n−2]) + (1 − 2b) u[n−1], u[n] = g s[n−N]. \
             The first N values of the string are random, uniform in ±1, less their mean, from the stream of the node in the voice: no two voices \
             are quite the same, and the same seed gives the same string. The sequence begins with the voice's first sample, one to two samples ahead of \
             the onset; between samples it is band-limited. Peaks lie within about ± amplitude. When it has been below \
             −140 dB for a second, it is silent. The frequency is limited to its range.",
    params: &[
        Param {
            name: "frequency",
            kind: Kind::Start(Numeric::required(LEAST, MOST)),
            unit: "Hz",
            doc: "Pitch; read when the voice starts.",
        },
        Param {
            name: "ring",
            kind: Kind::Constant(Numeric::or(150.0, 1.0, 1e5)),
            unit: "periods",
            doc: "Periods until the lowest tone has fallen by 60 dB; so high strings fall sooner, as strings do.",
        },
        Param {
            name: "damping",
            kind: Kind::Constant(Numeric::or(0.5, 0.0, 1.0)),
            unit: "",
            doc: "How much sooner high tones fall: 0 not at all, 1 most, as on gut.",
        },
        Param {
            name: "amplitude",
            kind: Kind::Signal(Numeric::or(1.0, -1e6, 1e6)),
            unit: "",
            doc: "Factor.",
        },
    ],
    example: r#"string = { type = "pluck", frequency = "event.frequency", ring = 100 }"#,
};

/// Lowest and highest pitch, Hz. The lowest sets how much memory a lane has.
const LEAST: f64 = 10.0;
const MOST: f64 = 1000.0;

/// A string, as a unit that [`Leaf`] runs. That of fundsp is the same, and cannot be copied without memory of its own.
struct Plucked {
    /// As long as the longest; what is behind `length` is not used.
    line: Vec<f32>,
    length: usize,
    place: usize,
    /// What a period leaves, and how much of its neighbours a sample takes.
    gain: f64,
    damping: f64,
    /// The coefficient that tunes it.
    tuning: f64,
    /// The last two samples of the line, the last one behind the damping, and the last that came out.
    line_before: [f64; 2],
    damped_before: f64,
    out_before: f64,
}

impl Plucked {
    fn new(longest: usize, gain: f64, damping: f64) -> Self {
        let (line, length) = (vec![0.0; longest.max(1)], longest.max(1));
        Self {
            line,
            length,
            place: 0,
            gain,
            damping: damping / 4.0,
            tuning: 0.0,
            line_before: [0.0; 2],
            damped_before: 0.0,
            out_before: 0.0,
        }
    }

    /// Plucks it, so that it has this period, in samples.
    fn pluck(&mut self, period: f64, stream: u64) {
        self.length = ((period - 1.2) as usize).clamp(1, self.line.len());
        let length = self.length as f64;
        self.tuning = (2.0 + length - period) / (period - length);
        let mut random = Rnd::from_u64(stream);
        let line = &mut self.line[..self.length];
        line.iter_mut().for_each(|x| *x = random.f32_in(-1.0, 1.0));
        let mean = (line.iter().map(|x| f64::from(*x)).sum::<f64>() / length) as f32;
        line.iter_mut().for_each(|x| *x -= mean);
        (self.place, self.line_before, self.damped_before, self.out_before) = (0, [0.0; 2], 0.0, 0.0);
    }
}

impl Clone for Plucked {
    fn clone(&self) -> Self {
        Self { line: self.line.clone(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        if self.line.len() == from.line.len() {
            self.line[..from.length].copy_from_slice(&from.line[..from.length]);
            *self = Self { line: std::mem::take(&mut self.line), ..*from };
        }
    }
}

impl AudioNode for Plucked {
    const ID: u64 = 0x706c_7563_6b65_6421;
    type Inputs = U0;
    type Outputs = U1;

    #[inline]
    fn tick(&mut self, _input: &Frame<f32, U0>) -> Frame<f32, U1> {
        let x = self.gain * f64::from(self.line[self.place]);
        let [one, two] = self.line_before;
        let damped = self.damping * (x + two) + (1.0 - 2.0 * self.damping) * one;
        let out = self.damped_before + self.tuning * (damped - self.out_before);
        (self.line_before, self.damped_before, self.out_before) = ([x, one], damped, out);
        self.line[self.place] = out as f32;
        self.place = if self.place + 1 < self.length { self.place + 1 } else { 0 };
        [out as f32].into()
    }
}

/// Eight strings.
#[derive(Clone)]
pub struct Lanes<R> {
    strings: Leaf<Plucked>,
    rate: f64,
    _real: std::marker::PhantomData<R>,
}

/// Samples of the longest string.
fn longest(setup: &Setup) -> usize {
    (setup.rate / LEAST) as usize
}

impl<R: Real> Kernel<R> for Lanes<R> {
    fn copy(&mut self, from: &Self, _live: u8) {
        self.strings.copy(&from.strings);
        self.rate = from.rate;
    }

    fn heap(setup: &Setup) -> usize {
        LANES * size_of::<f32>() * longest(setup)
    }

    fn new(setup: &Setup) -> Self {
        let ring = setup.constants.first().copied().unwrap_or(150.0);
        let damping = setup.constants.get(1).copied().unwrap_or(0.5);
        let (gain, damping) = (10f64.powf(-3.0 / within(ring, 1.0, 1e5)), within(damping, 0.0, 1.0));
        let make = || Plucked::new(longest(setup), gain, damping);
        Self { strings: Leaf::new(setup.rate, make), rate: setup.rate, _real: std::marker::PhantomData }
    }

    fn start(&mut self, lane: usize, onset: &Onset) {
        let period = self.rate / within(onset.start[0], LEAST, MOST);
        self.strings.start(lane, |string| string.pluck(period, onset.stream));
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        let amplitude = io.inputs[1];
        for (frame, out) in io.output.iter_mut().enumerate() {
            let gain = amplitude.at(frame);
            for l in 0..LANES {
                out[l] = R::of(self.strings.draw(l, &[].into()).into()) * gain[l];
            }
        }
    }

    fn settle(&mut self) {
        self.strings.settle();
    }
}

/// The definition.
pub struct Exact {
    string: Sampled,
}

impl Exact {
    /// For one voice.
    pub fn new(setup: &Setup, onset: &Onset) -> Self {
        let period = setup.engine_rate / onset.start[0].clamp(LEAST, MOST);
        let length = (period - 1.2).floor();
        let (gain, b) = (10f64.powf(-3.0 / setup.constants[0]), setup.constants[1] / 4.0);
        let e = (2.0 + length - period) / (period - length);
        let mut s = noise(onset.stream, length as usize);
        let (mut u, mut y, mut last) = ([0.0; 3], 0.0, 0.0);
        let string = Sampled::new(setup, onset, move || {
            u = [gain * s[s.len() - length as usize], u[0], u[1]];
            let before = y;
            y = b * (u[0] + u[2]) + (1.0 - 2.0 * b) * u[1];
            last = before + e * (y - last);
            s.push(last);
            last
        });
        Self { string }
    }
}

impl Twin for Exact {
    fn step(&mut self, t: f64, inputs: &[f64]) -> f64 {
        inputs[1] * self.string.at(t)
    }
}

/// `count` numbers in ±1 less their mean, from the generator Krull64 (Perttu) at the start of a stream: a counter in 128 bits
/// that is multiplied and added to, whose upper half is mixed.
fn noise(stream: u64, count: usize) -> Vec<f64> {
    let mut counter = u128::from(!stream);
    let all: Vec<f64> = (0..count)
        .map(|_| {
            counter = counter.wrapping_mul(0x1_DF77_A66A_374E_300D).wrapping_add(u128::from(stream) << 1 | 1);
            let mut x = (counter >> 64) as u64;
            x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            x = (x ^ x >> 31).wrapping_mul(0xD6E8_FEB8_6659_FD93);
            (x ^ x >> 32) as f64 / 2f64.powi(63) - 1.0
        })
        .collect();
    let mean = all.iter().sum::<f64>() / count as f64;
    all.iter().map(|x| x - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::Plucked;
    use crate::node::harness::Bench;
    use fundsp::audionode::AudioNode;

    fn string(rate: f64, frequency: f64, ring: f64, damping: f64) -> Bench {
        Bench::new("pluck", rate).steady("frequency", frequency).constant("ring", ring).constant("damping", damping)
    }

    #[test]
    fn the_kernel_follows_its_twin() {
        for (rate, age, frequency, ring, damping) in [
            (8000.0, -1.0, 100.0, 150.0, 0.5),
            (8000.0, -1.99, 40.3, 30.0, 1.0),
            (7350.0, -1.5, 10.0, 100.0, 0.0),
            (7350.0, -1.01, 1000.0, 800.0, 0.2),
        ] {
            let bench = string(rate, frequency, ring, damping).age(age).moving("amplitude", 1.0, |t| 0.5 * t.sin());
            bench.check_contract();
            for error in [bench.error_db::<f32>(80_000), bench.error_db::<f64>(80_000)] {
                assert!(error < -110.0, "{frequency} Hz: {error}");
            }
        }
    }

    #[test]
    fn it_is_the_string_of_fundsp() {
        for (rate, frequency, ring, damping) in [(8000.0, 100.0, 150.0, 0.5), (7350.0, 333.3, 30.0, 1.0)] {
            let mut theirs = fundsp::oscillator::Pluck::new(1.0, 10f32.powf(-3.0 / ring), damping);
            theirs.set_sample_rate(rate / frequency);
            theirs.set_hash(9);
            let longest = (rate / super::LEAST) as usize;
            let mut ours = Plucked::new(longest, 10f64.powf(-3.0 / f64::from(ring)), damping.into());
            ours.pluck(rate / frequency, 9);
            for n in 0..4000 {
                let (a, b) = (theirs.tick(&[0.0].into())[0], ours.tick(&[].into())[0]);
                assert!((a - b).abs() < 1e-4, "{frequency} Hz, sample {n}: {a} {b}");
            }
        }
    }

    #[test]
    fn between_samples_it_is_band_limited() {
        let bench = string(8000.0, 90.0, 150.0, 0.5).moving("amplitude", 0.0, |t| 1.0 - (100.0 * t.max(0.0)).cos());
        let error = bench.band_error_db::<f32>(3000, 16);
        assert!(error < -80.0, "{error}");
    }

    /// The part of `samples` from `from` on that turns at `hertz`, through a Hann window over `count`.
    fn part(samples: &[f64], from: usize, count: usize, hertz: f64, rate: f64) -> (f64, f64) {
        let (mut re, mut im) = (0.0, 0.0);
        for (n, x) in samples[from..from + count].iter().enumerate() {
            let window = 1.0 - (std::f64::consts::TAU * n as f64 / count as f64).cos();
            let angle = std::f64::consts::TAU * hertz / rate * (from + n) as f64;
            re += window * x * angle.cos();
            im -= window * x * angle.sin();
        }
        (re, im)
    }

    #[test]
    fn it_has_its_pitch_and_falls_by_sixty_decibels_in_its_periods() {
        for (rate, frequency, ring) in [(8000.0, 97.3, 300.0), (7350.0, 251.7, 600.0), (8000.0, 12.5, 40.0)] {
            let out = string(rate, frequency, ring, 0.0).kernel::<f64>((rate * 2.5) as usize, &[64]);
            // Ten periods, and as many some time later.
            let (count, later) = ((10.0 * rate / frequency) as usize, 6.0 * rate / frequency);
            let later = later.round() as usize;
            let (a, b) = (part(&out, count, count, frequency, rate), part(&out, count + later, count, frequency, rate));
            let fall = 20.0 * (b.0.hypot(b.1) / a.0.hypot(a.1)).log10();
            let exact = -60.0 / ring * later as f64 * frequency / rate;
            assert!((fall - exact).abs() < 0.05 * exact.abs(), "{frequency} Hz: {fall} dB, {exact}");
            let turned = (b.1.atan2(b.0) - a.1.atan2(a.0)) / std::f64::consts::TAU;
            let off = (turned - turned.round()) / (later as f64 / rate);
            assert!(off.abs() < 0.002 * frequency, "{frequency} Hz is off by {off} Hz");
        }
    }

    #[test]
    fn damping_takes_the_high_part_first() {
        let high = |damping: f64| {
            let out = string(8000.0, 100.0, 1000.0, damping).kernel::<f64>(4000, &[64]);
            let edge: f64 = out[2000..].windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
            edge / out[2000..].iter().map(|v| v * v).sum::<f64>()
        };
        assert!(high(0.0) > 3.0 * high(0.5) && high(0.5) > 1.3 * high(1.0));
    }

    #[test]
    fn every_voice_has_its_own_string_and_the_same_one_again() {
        let of = |stream: u64| {
            let mut bench = string(8000.0, 100.0, 150.0, 0.5);
            bench.stream = stream;
            bench.kernel::<f64>(2000, &[64])
        };
        assert_eq!(of(3), of(3));
        let (a, b) = (of(3), of(4));
        let cross: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        assert!(cross.abs() < 0.5 * a.iter().map(|v| v * v).sum::<f64>(), "{cross}");
        assert!(a.iter().all(|v| v.abs() < 1.5) && a.iter().sum::<f64>().abs() < 5.0);
    }

    #[test]
    fn what_has_died_away_is_silent() {
        let out = string(8000.0, 500.0, 50.0, 0.5).kernel::<f32>(20_000, &[64]);
        assert!(out[18_000..].iter().all(|v| *v == 0.0));
    }

    #[test]
    fn hostile_pitches_are_limited() {
        for bad in [f64::NAN, f64::INFINITY, -1e30, 0.0, 1e9] {
            let out = string(7350.0, bad, 150.0, 0.5).kernel::<f32>(800, &[64]);
            assert!(out.iter().all(|v| v.abs() < 2.0) && out.iter().any(|v| *v != 0.0), "{bad}");
        }
    }
}
