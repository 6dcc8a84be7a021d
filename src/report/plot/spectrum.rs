//! The power spectrum of many channels, gathered while they pass.
//!
//! Segments with Hann windows, two thirds overlapping, are transformed and their powers summed (Welch 1967). At that overlap the
//! squared windows add up to the same for every sample, so that the spectrum holds the signal's energy exactly (Parseval), be it
//! a tone or a click. Before the first sample lies silence.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::num_complex::Complex64;
use realfft::{RealFftPlanner, RealToComplex};

/// Seconds over which the end fades out, so that a sound cut off there is not counted as a click.
const FADE: f64 = 0.05;
/// Mean square of a sine of full scale.
const SINE: f64 = 0.5;
/// Bins at each side of a Hann window's main lobe that hold a tone's power within 0.005 dB.
const LOBE: usize = 2;

/// A finished power spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Hertz from one bin to the next.
    pub bin_hertz: f64,
    /// Mean square of each bin, from 0 Hz: mean over time and over the channels that sound.
    pub power: Vec<f64>,
}

impl Spectrum {
    /// Hertz of the band that a level sums.
    pub fn band_hertz(&self) -> f64 {
        self.bin_hertz * (2 * LOBE + 1) as f64
    }

    /// The greatest level between two frequencies in hertz; where no bin lies there, the level between its neighbours.
    pub fn peak_level(&self, from: f64, to: f64) -> f64 {
        let (from, to) = (from.max(0.0) / self.bin_hertz, to.max(0.0) / self.bin_hertz);
        let (first, last) = (from.ceil() as usize, (to.floor() as usize).min(self.power.len()));
        if first <= last {
            return (first..=last).map(|k| self.level_of_bin(k)).fold(f64::NEG_INFINITY, f64::max);
        }
        let at = 0.5 * (from + to);
        let (below, share) = (at.floor(), at - at.floor());
        let [low, high] = [below, below + 1.0].map(|k| self.level_of_bin(k as usize).max(f64::MIN));
        low + share * (high - low)
    }

    /// Power in the band around a bin, in dB; 0 dB is that of a sine of full scale, wherever it lies between the bins. −∞ where
    /// there is none.
    fn level_of_bin(&self, centre: usize) -> f64 {
        let first = centre.saturating_sub(LOBE);
        let power: f64 = self.power.iter().take(centre.saturating_add(LOBE + 1)).skip(first).sum();
        10.0 * (power / SINE).log10()
    }

    /// Power above a frequency in hertz as a share of all power, in dB; −∞ for none, nothing for silence or where the rate
    /// holds no such frequency.
    pub fn above(&self, hertz: f64) -> Option<f64> {
        let bins = self.power.iter().enumerate();
        if self.bin_hertz * self.power.len().saturating_sub(1) as f64 <= hertz {
            return None;
        }
        let above: f64 = bins.filter(|(k, _)| *k as f64 * self.bin_hertz > hertz).map(|(_, p)| p).sum();
        let all: f64 = self.power.iter().sum();
        (all > 0.0).then(|| 10.0 * (above / all).log10())
    }
}

/// A spectrum being gathered.
pub(super) struct Welch {
    hop: usize,
    fade: usize,
    rate: f64,
    fft: Arc<dyn RealToComplex<f64>>,
    window: Vec<f64>,
    /// By channel: what is not yet done, at most a segment and a fade.
    waiting: Vec<Vec<f32>>,
    /// By bin: the sum over segments and channels.
    power: Vec<f64>,
    segment: Vec<f64>,
    bins: Vec<Complex64>,
    scratch: Vec<Complex64>,
    frames: u64,
}

impl Welch {
    /// `rate` is in samples a second, above 0.
    pub fn new(channels: usize, rate: f64) -> Self {
        // Three hops make a segment, half a second or a little more: 2 Hz a bin.
        let hop = ((rate / 6.0).clamp(64.0, 65_536.0) as usize).next_power_of_two();
        let size = 3 * hop;
        let fft = RealFftPlanner::new().plan_fft_forward(size);
        Self {
            hop,
            fade: ((rate * FADE) as usize).min(hop),
            rate,
            window: (0..size).map(|n| 0.5 - 0.5 * (TAU * n as f64 / size as f64).cos()).collect(),
            waiting: vec![vec![0.0; size - hop]; channels],
            power: vec![0.0; size / 2 + 1],
            segment: fft.make_input_vec(),
            bins: fft.make_output_vec(),
            scratch: fft.make_scratch_vec(),
            fft,
            frames: 0,
        }
    }

    /// Takes whole frames of `stride` samples, of which the first channels count. All samples must be finite.
    pub fn push(&mut self, frames: &[f32], stride: usize) {
        let (size, most) = (self.window.len(), self.window.len() + self.fade);
        let mut rest = frames;
        while !rest.is_empty() && stride > 0 {
            let Some(room) = self.waiting.first().map(|w| most - w.len()) else { return };
            let (now, later) = rest.split_at(rest.len().min(room * stride));
            for (c, waiting) in self.waiting.iter_mut().enumerate() {
                waiting.extend(now.iter().skip(c).step_by(stride));
            }
            self.frames += (now.len() / stride) as u64;
            rest = later;
            if self.waiting.first().is_some_and(|w| w.len() == most) {
                for c in 0..self.waiting.len() {
                    self.add(c, 0..size);
                    if let Some(waiting) = self.waiting.get_mut(c) {
                        waiting.drain(..self.hop);
                    }
                }
            }
        }
    }

    /// Adds the power of a segment of what waits in a channel; silence follows where it ends early.
    fn add(&mut self, channel: usize, at: std::ops::Range<usize>) {
        let Some(waiting) = self.waiting.get(channel) else { return };
        let samples = waiting.iter().take(at.end).skip(at.start);
        if samples.clone().all(|x| *x == 0.0) {
            return;
        }
        self.segment.fill(0.0);
        for ((into, x), w) in self.segment.iter_mut().zip(samples).zip(&self.window) {
            *into = f64::from(*x) * w;
        }
        // The lengths are the plan's own, so this cannot fail.
        let _ = self.fft.process_with_scratch(&mut self.segment, &mut self.bins, &mut self.scratch);
        self.power.iter_mut().zip(&self.bins).for_each(|(p, b)| *p += b.norm_sqr());
    }

    /// The spectrum of what came so far, as a mean over `sounding` channels.
    pub fn finish(&self, sounding: usize) -> Spectrum {
        let (size, fade) = (self.window.len(), self.fade);
        let mut end = Self {
            waiting: self.waiting.clone(),
            power: self.power.clone(),
            window: self.window.clone(),
            segment: self.segment.clone(),
            bins: self.bins.clone(),
            scratch: self.scratch.clone(),
            fft: Arc::clone(&self.fft),
            ..*self
        };
        for waiting in &mut end.waiting {
            for (n, x) in waiting.iter_mut().rev().take(fade).enumerate() {
                let share = 0.5 - 0.5 * (0.5 * TAU * (n as f64 + 0.5) / fade as f64).cos();
                *x = (f64::from(*x) * share) as f32;
            }
        }
        let length = end.waiting.first().map_or(0, Vec::len);
        for start in (0..length).step_by(self.hop) {
            for c in 0..end.waiting.len() {
                end.add(c, start..start + size);
            }
        }
        // Squared windows at this overlap sum to 9/8 for every sample; bins other than the outer two stand for two.
        let weight = size as f64 * 1.125 * self.frames.max(1) as f64 * sounding.max(1) as f64;
        let last = end.power.len() - 1;
        for (k, power) in end.power.iter_mut().enumerate() {
            *power *= if k == 0 || k == last { 1.0 } else { 2.0 } / weight;
        }
        Spectrum { bin_hertz: self.rate / size as f64, power: end.power }
    }
}

#[cfg(test)]
mod tests {
    use super::{Spectrum, Welch};
    use std::f64::consts::TAU;

    fn of(signal: &[f32], rate: f64) -> Spectrum {
        let mut welch = Welch::new(1, rate);
        welch.push(signal, 1);
        welch.finish(1)
    }

    fn level(spectrum: &Spectrum, hertz: f64) -> f64 {
        spectrum.level_of_bin((hertz / spectrum.bin_hertz).round() as usize)
    }

    fn sine(hertz: f64, rate: f64, seconds: f64) -> impl Iterator<Item = f32> {
        (0..(rate * seconds) as usize).map(move |n| (TAU * hertz * n as f64 / rate).sin() as f32)
    }

    /// A sine that rises over 0.1 s, for a sudden one has power at every frequency.
    fn rising(hertz: f64, rate: f64, seconds: f64) -> impl Iterator<Item = f32> {
        let rise = move |n: usize| (n as f64 / rate / 0.1).min(1.0) * 0.25 * TAU;
        sine(hertz, rate, seconds).enumerate().map(move |(n, x)| x * (rise(n).sin().powi(2) as f32))
    }

    #[test]
    fn a_sine_of_full_scale_reads_0_db_wherever_it_lies() {
        for (rate, hertz) in
            [(48e3, 20.0), (48e3, 100.0), (48e3, 250.97), (44.1e3, 1000.0), (8e3, 333.3), (192e3, 60.0)]
        {
            let spectrum = of(&rising(hertz, rate, 10.0).collect::<Vec<_>>(), rate);
            let at = |hertz: f64| level(&spectrum, hertz);
            let level = at(hertz);
            assert!(level.abs() < 0.1, "{level} dB for {hertz} Hz at {rate}");
            assert!(at(hertz + 40.0) < -60.0, "{hertz}: {}", at(hertz + 40.0));
            assert!(spectrum.band_hertz() < 11.0);
        }
    }

    #[test]
    fn energy_is_kept_exactly_for_a_click_anywhere() {
        let rate = 8000.0;
        for at in [0, 1, 100, 2047, 2048, 5000, 9000] {
            let mut signal = vec![0.0; 10_000];
            signal[at] = 0.5;
            let energy = of(&signal, rate).power.iter().sum::<f64>() * signal.len() as f64;
            assert!((energy / 0.25 - 1.0).abs() < 1e-9, "{energy} for a click at {at}");
        }
    }

    #[test]
    fn power_above_a_frequency_is_that_of_the_tones_there() {
        let rate = 48e3;
        for (amplitude, db) in [(0.1, -20.0432), (0.001, -60.0)] {
            let two: Vec<f32> = rising(250.0, rate, 4.0)
                .zip(rising(1300.0, rate, 4.0))
                .map(|(a, b)| 0.5 * (a + amplitude * b))
                .collect();
            let above = of(&two, rate).above(1000.0).unwrap();
            assert!((above - db).abs() < 0.01, "{above} for {db}");
        }
    }

    #[test]
    fn a_cut_at_the_end_is_no_click() {
        // Cut at its crest, a sine of 250 Hz would show about −35 dB.
        let signal: Vec<f32> = rising(250.0, 48e3, 1.001).collect();
        let above = of(&signal, 48e3).above(1000.0).unwrap();
        assert!(above < -90.0, "{above}");
        // But a jump at the beginning is one, for the device was still before.
        let cosine: Vec<f32> = sine(250.0, 48e3, 1.001).skip(48).collect();
        let above = of(&cosine, 48e3).above(1000.0).unwrap();
        assert!((-50.0..-30.0).contains(&above), "{above}");
    }

    #[test]
    fn channels_are_averaged() {
        let one: Vec<f32> = sine(200.0, 8e3, 5.0).collect();
        let frames: Vec<f32> = one.iter().flat_map(|x| [*x, 0.0, 0.5 * x]).collect();
        let mut welch = Welch::new(3, 8e3);
        welch.push(&frames, 3);
        let level = level(&welch.finish(2), 200.0);
        assert!((level - 10.0 * (1.25f64 / 2.0).log10()).abs() < 0.1, "{level}");
    }

    #[test]
    fn silence_and_low_rates_have_no_share() {
        assert_eq!(of(&[0.0; 100], 8e3).above(1000.0), None);
        assert_eq!(of(&[1.0; 100], 1500.0).above(1000.0), None);
        assert_eq!(level(&of(&[], 8e3), 100.0), f64::NEG_INFINITY);
    }
}
