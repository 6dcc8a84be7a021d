//! Band-limited waves from tables with ever more harmonics, cross-faded by the frequency.
//!
//! A wave is its Fourier series Σ b(k) sin 2πkφ. At frequency f, harmonic k has the weight w(k, r), r = B / |f|, where
//! B is 0.4375 of the rate: w(1) = 8r − 7 within 0 and 1, so the fundamental fades out from B to half the rate;
//! w(k) = (r − K) / (K' − K) within 0 and 1, where K is the first of 2, 3, 4, 6, 8, 12, 16, ... not below k, and K' the next: a
//! harmonic fades out over the octave below B. All of K sits at the half-octaves of a binary floating-point number, so its
//! exponent and first bit find the tables and the other bits are the weight.

use super::lanes::{LANES, Real};
use super::quadrature::{Clockwork, bend};
use std::any::{Any, TypeId};
use std::sync::OnceLock;

/// B as a share of the rate.
pub const BAND: f64 = 0.4375;

/// A wave that is kept in tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wave {
    /// Rises from 0 at phase 0 to 1 at ½, where it jumps to −1: b(k) = −2 (−1)^k / πk, to harmonic 1024.
    Sawtooth,
    /// 0 at phase 0, 1 at ¼, −1 at ¾: b(k) = 8 sin(πk/2) / π²k², to harmonic 256.
    Triangle,
}

impl Wave {
    /// The place of the last table: harmonics are kept to 2^(last / 2).
    const fn last(self) -> usize {
        match self {
            Self::Sawtooth => 20,
            Self::Triangle => 16,
        }
    }

    fn coefficient(self, k: usize) -> f64 {
        let n = k as f64;
        match self {
            Self::Sawtooth if k % 2 == 1 => std::f64::consts::FRAC_2_PI / n,
            Self::Sawtooth => -std::f64::consts::FRAC_2_PI / n,
            Self::Triangle if k % 4 == 1 => 8.0 / (std::f64::consts::PI * n).powi(2),
            Self::Triangle if k % 4 == 3 => -8.0 / (std::f64::consts::PI * n).powi(2),
            Self::Triangle => 0.0,
        }
    }

    /// Its tables, made when they are first asked for.
    pub fn tables<R: Real>(self) -> &'static Tables<R> {
        static SINGLE: [OnceLock<Tables<f32>>; 2] = [OnceLock::new(), OnceLock::new()];
        static DOUBLE: [OnceLock<Tables<f64>>; 2] = [OnceLock::new(), OnceLock::new()];
        let place = self as usize;
        let any: &'static dyn Any = if TypeId::of::<R>() == TypeId::of::<f32>() {
            SINGLE[place].get_or_init(|| Tables::new(self))
        } else {
            DOUBLE[place].get_or_init(|| Tables::new(self))
        };
        any.downcast_ref().unwrap_or_else(|| unreachable!("lanes are f32 or f64"))
    }
}

/// All levels of a wave, one after the other.
#[derive(Debug)]
pub struct Tables<R> {
    /// Value and slope of the table with fewer harmonics, then of the one with more.
    points: Vec<[R; 4]>,
    /// Of each level, its first point; the number of its points (without the last, which repeats the first) is 2 to the second.
    levels: Vec<(u32, u32)>,
    most: f64,
}

/// Which level, how much of its richer table, and how much of all.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tone<R> {
    first: u32,
    bits: u32,
    rich: R,
    gain: R,
}

impl<R: Real> Tables<R> {
    fn new(wave: Wave) -> Self {
        let limit =
            |i: usize| -> usize { if i.is_multiple_of(2) { 1 << (i / 2) } else { (3 << (i / 2)) / 2 } };
        let (mut points, mut levels) = (Vec::new(), Vec::new());
        for i in 1..=wave.last() {
            // At least 32 points a cycle of the highest harmonic keep the cubic within −115 dB.
            let count = (32 * limit(i)).next_power_of_two().max(512);
            let first = points.len();
            let [poor, rich] = [limit(i - 1), limit(i)].map(|k| series(wave, k, count));
            let both = poor.iter().zip(&rich);
            points.extend(both.map(|(p, r)| [R::of(p[0]), R::of(p[1]), R::of(r[0]), R::of(r[1])]));
            points.push(points[first]);
            levels.push((first as u32, count.trailing_zeros()));
        }
        let next = wave.last() + 1;
        Self { points, levels, most: (3 << (next / 2)) as f64 / 2.0 * (1.0 - 1e-12) }
    }

    /// The tone at `share`, B / |frequency| (infinite at 0 Hz).
    #[inline(always)]
    pub fn tone(&self, share: f64) -> Tone<R> {
        // Comparisons, as they make 0 of what is not a number.
        let fade = 8.0 * share - 7.0;
        let gain = if fade > 0.0 { if fade < 1.0 { fade } else { 1.0 } } else { 0.0 };
        let share = if share > 1.0 { share } else { 1.0 };
        let share = if share < self.most { share } else { self.most };
        let bits = share.to_bits();
        let place = (bits >> 51) as usize - (1023 << 1);
        let rich = f64::from_bits((bits << 1 & 0x000F_FFFF_FFFF_FFFF) | 1.0_f64.to_bits()) - 1.0;
        let (first, bits) = self.levels[place.saturating_sub(1).min(self.levels.len() - 1)];
        Tone { first, bits, rich: R::of(rich), gain: R::of(gain) }
    }

    /// The wave at a phase.
    #[inline(always)]
    pub fn at(&self, tone: Tone<R>, phase: u64) -> R {
        // A phase of `bits` bits is a place; without a shift by 64, which a tone that was never set would ask for.
        let place = tone.first as usize + (phase >> 1 >> (63 - tone.bits)) as usize;
        let x = R::of(((phase << tone.bits) >> 40) as u32 as i32 as f64 * (1.0 / 16_777_216.0));
        let Some([a, b]) = self.points.get(place..).and_then(|p| p.first_chunk()) else { return R::ZERO };
        let mix = |k: usize| {
            let [left, right] = [a, b].map(|p| p[k] + (p[k + 2] - p[k]) * tone.rich);
            (left, right)
        };
        let ((y, next), (slope, end)) = (mix(0), mix(1));
        let rise = next - y;
        // Hermite's cubic through both values and slopes.
        let third = (slope + end) - (rise + rise);
        let second = rise - slope - third;
        (y + x * (slope + x * (second + x * third))) * tone.gain
    }
}

/// Values and slopes (a step) of the first `harmonics` of a wave, at `count` points.
fn series(wave: Wave, harmonics: usize, count: usize) -> Vec<[f64; 2]> {
    let step = std::f64::consts::TAU / count as f64;
    let mut values = vec![[0.0; 2]; count];
    let mut slopes = vec![[0.0; 2]; count];
    for k in 1..=harmonics {
        let b = wave.coefficient(k);
        values[k][0] = b;
        slopes[k][0] = b * k as f64 * step;
    }
    spread(&mut values);
    spread(&mut slopes);
    values.iter().zip(&slopes).map(|(v, s)| [v[1], s[0]]).collect()
}

/// In place, from c to Σ c(k) exp(2πikn / N): the inverse transform of Cooley and Tukey (1965).
fn spread(values: &mut [[f64; 2]]) {
    let count = values.len();
    let bits = count.trailing_zeros();
    for n in 0..count {
        let mirrored = n.reverse_bits() >> (usize::BITS - bits);
        if n < mirrored {
            values.swap(n, mirrored);
        }
    }
    let turn: Vec<(f64, f64)> =
        (0..count / 2).map(|k| (std::f64::consts::TAU * k as f64 / count as f64).sin_cos()).collect();
    let mut half = 1;
    while half < count {
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let (s, c) = turn[k * (count / 2 / half)];
                let turned = [b[0] * c - b[1] * s, b[0] * s + b[1] * c];
                *b = [a[0] - turned[0], a[1] - turned[1]];
                *a = [a[0] + turned[0], a[1] + turned[1]];
            }
        }
        half *= 2;
    }
}

/// Phase and tone of eight lanes that play tables.
#[derive(Debug, Clone)]
pub struct TableLanes<R: Real> {
    /// The tables.
    pub tables: &'static Tables<R>,
    clock: Clockwork,
    known: [f64; LANES],
    steady: [Tone<R>; LANES],
    turns: [f64; LANES],
    fresh: [bool; LANES],
    band: f64,
    rate: f64,
}

impl<R: Real> TableLanes<R> {
    /// Silent lanes at `rate` samples a second; `begins` as in [`Clockwork::of_what_begins`].
    pub fn new(wave: Wave, rate: f64, begins: bool) -> Self {
        Self {
            tables: wave.tables(),
            clock: Clockwork::new(rate).of_what_begins(begins),
            known: [0.0; LANES],
            steady: [Tone::default(); LANES],
            turns: [0.0; LANES],
            fresh: [false; LANES],
            band: BAND * rate,
            rate,
        }
    }

    /// See [`Clockwork::start`].
    pub fn start(&mut self, lane: usize, frequency: f64, age: f64) {
        self.retune(lane, frequency);
        self.clock.start(lane, self.known[lane], age);
        self.fresh[lane] = true;
    }

    /// See [`Clockwork::retune`].
    pub fn retune(&mut self, lane: usize, frequency: f64) {
        let frequency = if frequency.is_finite() { frequency } else { 0.0 };
        self.clock.retune(lane, frequency);
        self.known[lane] = frequency;
        self.steady[lane] = self.tables.tone(self.band / frequency.abs());
    }

    /// Phases and tones of the next sample of a voice whose frequency and phase stay as they are.
    #[inline(always)]
    pub fn steady(&mut self, turns: &[f64; LANES]) -> ([u64; LANES], [Tone<R>; LANES]) {
        let (hands, step) = self.clock.hands();
        let mut angle = [0; LANES];
        for l in 0..LANES {
            hands[l] = hands[l].wrapping_add(step[l]);
            angle[l] = hands[l].wrapping_add(bend(turns[l]));
        }
        (angle, self.steady)
    }

    /// The same where `hertz` are deviations of the frequency and `turns` shifts of the phase at that sample. What a moving
    /// phase adds to the frequency is its difference from the sample before.
    #[inline(always)]
    pub fn moving(&mut self, hertz: &[R; LANES], turns: &[R; LANES]) -> ([u64; LANES], [Tone<R>; LANES]) {
        let mut angle = self.clock.advance_by(hertz);
        let mut tones = [Tone::default(); LANES];
        let mut share = [0.0; LANES];
        for l in 0..LANES {
            let shift = turns[l].wide();
            let before = if self.fresh[l] { shift } else { self.turns[l] };
            self.turns[l] = shift;
            angle[l] = angle[l].wrapping_add(bend(shift));
            let frequency = self.known[l] + hertz[l].wide() + (shift - before) * self.rate;
            share[l] = self.band / frequency.abs();
        }
        self.fresh = [false; LANES];
        for l in 0..LANES {
            tones[l] = self.tables.tone(share[l]);
        }
        (angle, tones)
    }
}

/// The definition, for the twins.
#[derive(Debug)]
pub struct Additive {
    wave: Wave,
    band: f64,
    rate: f64,
    /// Phases of the samples within the last one of the engine, the newest last.
    turns: std::collections::VecDeque<f64>,
    span: usize,
}

impl Additive {
    /// For one voice whose twin runs at `rate`, in an engine at `engine_rate`.
    pub fn new(wave: Wave, rate: f64, engine_rate: f64) -> Self {
        let span = (rate / engine_rate).round().max(1.0) as usize;
        Self {
            wave,
            band: BAND * engine_rate,
            rate: engine_rate,
            turns: std::collections::VecDeque::new(),
            span,
        }
    }

    /// The ratio of B to the frequency, where `turns` is the modulation of the phase.
    pub fn share(&mut self, hertz: f64, turns: f64) -> f64 {
        self.turns.push_back(turns);
        if self.turns.len() > self.span + 1 {
            self.turns.pop_front();
        }
        let before = self.turns.front().copied().unwrap_or(turns);
        self.band / (hertz + (turns - before) * self.rate).abs()
    }

    /// The series at `turns`, weighted for `share`.
    pub fn at(&self, turns: f64, share: f64) -> f64 {
        let (most, base) = match self.wave {
            Wave::Sawtooth => (1024, std::f64::consts::FRAC_2_PI),
            Wave::Triangle => (256, 8.0 / std::f64::consts::PI.powi(2)),
        };
        let angle = std::f64::consts::TAU * (turns - turns.floor());
        let mut sum = 0.0;
        for k in (1..=most).take_while(|k| *k == 1 || f64::from(*k) < share) {
            let shape = match (self.wave, k % 4) {
                (Wave::Sawtooth, 1 | 3) => 1.0 / f64::from(k),
                (Wave::Sawtooth, _) => -1.0 / f64::from(k),
                (Wave::Triangle, 1) => 1.0 / f64::from(k * k),
                (Wave::Triangle, 3) => -1.0 / f64::from(k * k),
                (Wave::Triangle, _) => continue,
            };
            let weight = if k == 1 {
                8.0 * share - 7.0
            } else {
                let octave = 2f64.powi((k as u32).next_power_of_two().trailing_zeros() as i32);
                // `octave` is the power of two at or above k; ¾ of it may be, too.
                let (from, to) = if f64::from(k) <= 0.75 * octave {
                    (0.75 * octave, octave)
                } else {
                    (octave, 1.5 * octave)
                };
                (share - from) / (to - from)
            };
            sum += weight.clamp(0.0, 1.0) * shape * (f64::from(k) * angle).sin();
        }
        base * sum
    }
}

#[cfg(test)]
mod tests {
    use super::{Additive, Wave};

    #[test]
    fn tables_follow_the_series() {
        for wave in [Wave::Sawtooth, Wave::Triangle] {
            let twin = Additive::new(wave, 8000.0, 8000.0);
            for share in [0.8, 0.9, 1.0, 1.3, 2.0, 2.5, 3.5, 5.1, 14.0, 100.0, 1500.0, 1e9, f64::INFINITY] {
                let tone32 = wave.tables::<f32>().tone(share);
                let tone64 = wave.tables::<f64>().tone(share);
                let (mut error, mut double, mut energy) = (0.0, 0.0, 0.0);
                for n in 0..4001_u64 {
                    let phase = n.wrapping_mul(0x9E37_79B9_7F4A_7C15);
                    let exact = twin.at(phase as f64 / 2f64.powi(64), share);
                    error += (f64::from(wave.tables::<f32>().at(tone32, phase)) - exact).powi(2);
                    double += (wave.tables::<f64>().at(tone64, phase) - exact).powi(2);
                    energy += exact * exact;
                }
                if share < 0.875 {
                    assert_eq!((error, double), (0.0, 0.0));
                } else {
                    let [single, double] = [error, double].map(|e: f64| 10.0 * (e / energy).log10());
                    assert!(single < -115.0 && double < -115.0, "{wave:?} at {share}: {single}, {double}");
                }
            }
        }
    }

    #[test]
    fn the_series_is_the_wave() {
        let saw = Additive::new(Wave::Sawtooth, 8000.0, 8000.0);
        let triangle = Additive::new(Wave::Triangle, 8000.0, 8000.0);
        for turns in [-0.3_f64, -0.1, 0.0, 0.1, 0.25, 0.3] {
            assert!((saw.at(turns, 1e9) - 2.0 * turns).abs() < 2e-3, "{turns}");
            let exact = 1.0 - 4.0 * (turns - 0.25).abs().min((turns + 0.75).abs());
            assert!(
                (triangle.at(turns, 1e9) - exact).abs() < 2e-3,
                "{turns}: {} {exact}",
                triangle.at(turns, 1e9)
            );
        }
    }
}
