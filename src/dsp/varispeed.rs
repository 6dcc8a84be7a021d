//! A stream of samples, read at any speed: windowed sinc, whose phase may move on by another step at each sample.
//!
//! The kernel is a sinc under Kaiser's window (J. F. Kaiser, "Nonrecursive digital filter design using the I₀-sinh window function",
//! ISCAS 1974), tabled at 256 places between two samples with a straight line between them (J. O. Smith, "Digital audio resampling
//! home page", 2002). Relative to the lower of the two rates it passes up to 0.29 and stops from 0.5 on, by 100 dB.

use std::f64::consts::PI;

/// Samples of the lower rate under the kernel.
const TAPS: f64 = 32.0;

/// Places between two samples, where the kernel is as narrow as it gets.
const PLACES: f64 = 256.0;

/// Kaiser's parameter for 100 dB, and the width of the transition that follows from it, in shares of the lower rate.
const BETA: f64 = 10.06;
const TRANSITION: f64 = 0.207;

/// Reads channels of a stream at places between its samples.
#[derive(Debug)]
pub struct Varispeed {
    /// By place, from 0 to 1: weights of the samples, oldest first.
    rows: Vec<f32>,
    taps: usize,
    places: usize,
    channels: usize,
    /// By channel: the last samples, twice in a row, so that they are in one piece wherever they begin.
    past: Vec<f32>,
    /// Where the oldest is, and where the next will be.
    at: usize,
    /// The weights at the place at hand.
    weights: Vec<f32>,
}

impl Varispeed {
    /// From about one rate to about another (Hz); for so many channels.
    pub fn new(from: f64, to: f64, channels: usize) -> Self {
        let stretch = (from / to).max(1.0);
        let half = (TAPS * stretch / 2.0).ceil();
        let (taps, places) = (2 * half as usize, (PLACES / stretch).max(16.0) as usize);
        // The cut-off, in shares of the rate that comes in, where the kernel is half as high.
        let cut = (0.5 - TRANSITION / 2.0) / stretch;
        let kernel = |x: f64| {
            let angle = 2.0 * PI * cut * x;
            let sinc = if angle == 0.0 { 1.0 } else { angle.sin() / angle };
            let inside = 1.0 - (x / half).powi(2);
            if inside < 0.0 { 0.0 } else { sinc * bessel(BETA * inside.sqrt()) }
        };
        let rows = (0..=places)
            .flat_map(|place| {
                let place = place as f64 / places as f64;
                let row: Vec<f64> = (0..taps).map(|k| kernel(k as f64 - (half - 1.0) - place)).collect();
                // A steady value passes as it is, at every place.
                let sum: f64 = row.iter().sum();
                row.into_iter().map(move |h| (h / sum) as f32)
            })
            .collect();
        let past = vec![0.0; 2 * taps * channels];
        Self { rows, taps, places, channels, past, at: 0, weights: vec![0.0; taps] }
    }

    /// Samples by which what is read at place 0 is behind the latest that was taken.
    pub fn behind(&self) -> usize {
        self.taps / 2
    }

    /// Forgets everything it has taken.
    pub fn clear(&mut self) {
        self.past.fill(0.0);
    }

    /// Takes the next frame; channels that it does not have are silence, as is what is no number.
    pub fn take(&mut self, frame: &[f32]) {
        for (channel, past) in self.past.chunks_exact_mut(2 * self.taps).enumerate() {
            let value = frame.get(channel).copied().filter(|x| x.is_finite()).unwrap_or(0.0);
            past[self.at] = value;
            past[self.at + self.taps] = value;
        }
        self.at = (self.at + 1) % self.taps;
    }

    /// The frame at a place from 0 to 1 between the two samples in the middle.
    pub fn read(&mut self, place: f64, frame: &mut [f32]) {
        // What is no number counts as 0.
        let exact = place.max(0.0).min(1.0) * self.places as f64;
        let row = (exact as usize).min(self.places - 1);
        let share = (exact - row as f64) as f32;
        let (low, high) = self.rows[row * self.taps..][..2 * self.taps].split_at(self.taps);
        for ((weight, low), high) in self.weights.iter_mut().zip(low).zip(high) {
            *weight = low + (high - low) * share;
        }
        let all = self.past.chunks_exact(2 * self.taps).map(|past| &past[self.at..][..self.taps]);
        for (value, past) in frame.iter_mut().zip(all) {
            *value = past.iter().zip(&self.weights).map(|(x, w)| x * w).sum();
        }
        if let Some(rest) = frame.get_mut(self.channels..) {
            rest.fill(0.0);
        }
    }
}

/// The modified Bessel function I₀, by its power series.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term, quarter) = (1.0, 1.0, x * x / 4.0);
    for k in 1..64 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::Varispeed;
    use std::f64::consts::TAU;

    /// What comes of a tone of `hertz` that is read at `speed`, and what it is exactly; two channels, the second half as loud.
    fn run(hertz: f64, from: f64, to: f64, speed: f64) -> Vec<(f64, f64)> {
        let mut stream = Varispeed::new(from, to, 2);
        let tone = |n: f64| (TAU * hertz * n / from + 0.3).sin();
        let (mut taken, mut place, mut out) = (0_u32, 0.0, Vec::new());
        for _ in 0..20_000 {
            while place >= 1.0 {
                let x = tone(f64::from(taken)) as f32;
                stream.take(&[x, 0.5 * x]);
                (taken, place) = (taken + 1, place - 1.0);
            }
            let mut frame = [f32::NAN; 3];
            stream.read(place, &mut frame);
            assert!((frame[1] - 0.5 * frame[0]).abs() < 1e-6 && frame[2] == 0.0);
            let at = f64::from(taken) - 1.0 - stream.behind() as f64 + place;
            out.push((f64::from(frame[0]), tone(at)));
            place += from / to * speed;
        }
        out.split_off(3000)
    }

    fn decibel(part: f64, whole: f64) -> f64 {
        10.0 * (part / whole).log10()
    }

    #[test]
    fn what_the_skin_feels_comes_as_it_is_at_any_speed() {
        for (from, to) in
            [(48_000.0, 48_000.0), (44_100.0, 48_000.0), (48_000.0, 44_100.0), (192_000.0, 44_100.0)]
        {
            for (hertz, most) in [(1.0, -110.0), (250.0, -110.0), (1000.0, -100.0), (8000.0, -100.0)] {
                let all = run(hertz, from, to, 1.0002);
                let error: f64 = all.iter().map(|(a, b)| (a - b).powi(2)).sum();
                let whole: f64 = all.iter().map(|(_, b)| b * b).sum();
                let error = decibel(error, whole);
                assert!(error < most, "{hertz} Hz from {from} to {to}: {error:.1} dB");
            }
        }
    }

    #[test]
    fn what_the_lower_rate_cannot_hold_does_not_fold() {
        // 47.7 kHz would be felt at 300 Hz.
        for (hertz, from, to) in
            [(47_700.0, 96_000.0, 48_000.0), (24_100.0, 192_000.0, 48_000.0), (23_000.0, 48_000.0, 44_100.0)]
        {
            let all = run(hertz, from, to, 0.9998);
            let level: f64 = all.iter().map(|(a, _)| a * a).sum::<f64>() / all.len() as f64;
            assert!(decibel(level, 0.5) < -95.0, "{hertz} Hz from {from}: {:.1} dB", decibel(level, 0.5));
        }
    }

    #[test]
    fn nothing_but_numbers_comes_out() {
        let mut stream = Varispeed::new(48_000.0, 48_000.0, 1);
        for x in [f32::NAN, f32::INFINITY, 1.0] {
            stream.take(&[x]);
        }
        stream.take(&[]);
        for place in [-1.0, 0.0, 0.5, 1.0, f64::NAN, 1e300] {
            let mut frame = [f32::NAN];
            stream.read(place, &mut frame);
            assert!(frame[0].is_finite(), "{place}");
        }
        stream.clear();
        let mut frame = [1.0];
        stream.read(0.3, &mut frame);
        assert_eq!(frame, [0.0]);
    }
}
