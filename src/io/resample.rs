//! A recording at another rate, in place and at its level.

use rubato::audioadapter_buffers::direct::InterleavedSlice;
use rubato::{Fft, FixedSync, Resampler, WindowFunction};

/// The least length of the filter, in samples of the lower rate: the pass band reaches to 97 % of half the lower rate, and
/// what is beyond half of it is below -100 dB. Rates whose ratio has large terms get a longer, steeper filter.
const FILTER: u64 = 1024;
/// The largest number in the ratio of two rates.
const LARGEST: u64 = 1 << 18;

/// A recording on its way to another rate, sample by sample, band-limited to the lower of the two; only what comes out is held.
///
/// The first sample of the output is at the time of the first of the input. The output has as many samples as begin before
/// the input's last ends. The ratio of the rates is exact where both of its terms are below 2¹⁸, as they are for whole
/// numbers of hertz up to 262,144; else it is right to a few millionths.
pub struct Converter {
    fft: Option<Fft<f64>>,
    from: f64,
    to: f64,
    /// The ratio of the rates.
    into: u64,
    out_of: u64,
    block: Vec<f64>,
    filled: usize,
    result: Vec<f64>,
    /// Samples at the beginning that are the filter's delay.
    skip: usize,
    taken: u64,
    out: Vec<f32>,
}

impl Converter {
    /// From one rate to another, hertz.
    ///
    /// # Errors
    /// When a rate is not a positive number, or when the two are more than a factor of 4,096 apart.
    pub fn new(from: f64, to: f64) -> Result<Self, String> {
        for rate in [from, to] {
            if !(rate.is_finite() && rate > 0.0) {
                return Err(format!("{rate} Hz is no rate of a recording: it must be above 0"));
            }
        }
        let (fft, block, result) = (None, Vec::new(), Vec::new());
        let (filled, skip, taken, out) = (0, 0, 0, Vec::new());
        let mut all = Self { fft, from, to, into: 1, out_of: 1, block, filled, result, skip, taken, out };
        if from == to {
            return Ok(all);
        }
        if !(1.0 / 4096.0..=4096.0).contains(&(to / from)) {
            return Err(format!(
                "{from} Hz and {to} Hz are too far apart to convert: record at a rate between 1 and 192 kHz"
            ));
        }
        (all.into, all.out_of) = ratio(to / from);
        // An even number of periods, so that half a block, which is the delay, is a whole number of samples on both sides.
        let periods = 2 * FILTER.div_ceil(2 * all.into.min(all.out_of));
        let (block_in, block_out) = ((periods * all.out_of) as usize, (periods * all.into) as usize);
        let fft = Fft::<f64>::new_custom(
            all.out_of as usize,
            all.into as usize,
            block_in,
            1,
            1,
            WindowFunction::BlackmanHarris2,
            FixedSync::Both,
        )
        .map_err(|error| all.failed(&error))?;
        if (fft.input_frames_next(), fft.output_frames_next()) != (block_in, block_out) {
            return Err(format!(
                "{from} Hz cannot be converted to {to} Hz in blocks of {block_in}: convert the file first"
            ));
        }
        (all.block, all.result, all.skip) = (vec![0.0; block_in], vec![0.0; block_out], block_out / 2);
        all.fft = Some(fft);
        Ok(all)
    }

    /// How many samples come of so many.
    pub fn length(&self, samples: u64) -> u64 {
        u64::try_from((u128::from(samples) * u128::from(self.into)).div_ceil(u128::from(self.out_of)))
            .unwrap_or(u64::MAX)
    }

    /// Samples of the input behind an instant that have a part in what comes out before it, at most.
    pub fn margin(&self) -> u64 {
        2 * self.block.len() as u64
    }

    /// Makes room for what comes of so many samples.
    ///
    /// # Errors
    /// When there is none.
    pub fn reserve(&mut self, samples: u64) -> Result<(), String> {
        let length = self.length(samples);
        // The last block goes past the end.
        let whole = length.saturating_add(self.result.len() as u64);
        let room = usize::try_from(whole).ok().and_then(|n| self.out.try_reserve_exact(n).ok());
        room.ok_or_else(|| {
            format!("there is no memory for its {length} samples at {} Hz: cut it shorter", self.to)
        })
    }

    /// Takes the next sample.
    ///
    /// # Errors
    /// When a block cannot be converted.
    pub fn push(&mut self, x: f32) -> Result<(), String> {
        self.taken += 1;
        if self.fft.is_none() {
            self.out.push(x);
            return Ok(());
        }
        if let Some(slot) = self.block.get_mut(self.filled) {
            *slot = f64::from(x);
        }
        self.filled += 1;
        if self.filled < self.block.len() { Ok(()) } else { self.convert() }
    }

    /// All samples at the new rate.
    ///
    /// # Errors
    /// As [`Converter::push`].
    pub fn finish(mut self) -> Result<Vec<f32>, String> {
        let wanted = usize::try_from(self.length(self.taken)).unwrap_or(usize::MAX);
        while self.out.len() < wanted {
            // Silence behind the end.
            self.block.iter_mut().skip(self.filled).for_each(|slot| *slot = 0.0);
            self.convert()?;
        }
        self.out.truncate(wanted);
        Ok(self.out)
    }

    fn convert(&mut self) -> Result<(), String> {
        self.filled = 0;
        let Some(fft) = &mut self.fft else { return Ok(()) };
        let (block_in, block_out) = (self.block.len(), self.result.len());
        let converted = InterleavedSlice::new(&self.block, 1, block_in).map_err(|error| error.to_string());
        let converted = converted.and_then(|read| {
            let mut write = InterleavedSlice::new_mut(&mut self.result, 1, block_out)
                .map_err(|error| error.to_string())?;
            fft.process_into_buffer(&read, &mut write, None).map_err(|error| error.to_string())
        });
        converted.map_err(|error| self.failed(&error))?;
        self.out.extend(self.result.iter().skip(self.skip).map(|&x| x as f32));
        self.skip = 0;
        Ok(())
    }

    fn failed(&self, error: &dyn std::fmt::Display) -> String {
        format!("{} Hz cannot be converted to {} Hz ({error}): convert the file first", self.from, self.to)
    }
}

/// The fraction nearest to `x` whose terms stay below [`LARGEST`], by continued fraction.
fn ratio(x: f64) -> (u64, u64) {
    let (mut before, mut now) = ((0_u64, 1_u64), (1_u64, 0_u64));
    let mut rest = x;
    loop {
        let whole = rest.floor();
        let next = |a: u64, b: u64| (whole as u64).checked_mul(a).and_then(|m| m.checked_add(b));
        let (Some(p), Some(q)) = (next(now.0, before.0), next(now.1, before.1)) else { return now };
        if p > LARGEST || q > LARGEST {
            return now;
        }
        (before, now) = (now, (p, q));
        // Nearer than what rounding leaves of x itself.
        if (p as f64 / q as f64 - x).abs() <= 4.0 * f64::EPSILON * x {
            return now;
        }
        rest = 1.0 / (rest - whole);
    }
}

#[cfg(test)]
mod tests {
    use super::{Converter, ratio};
    use std::f64::consts::TAU;

    /// Faded in and out over an eighth of its length, as an abrupt end has a spectrum of its own.
    fn sine(hertz: f64, rate: f64, seconds: f64) -> Vec<f32> {
        let length = (rate * seconds) as usize;
        let fade = |n: usize| {
            let share = n.min(length - 1 - n) as f64 / (length / 8) as f64;
            0.5 - 0.5 * (0.5 * TAU * share.min(1.0)).cos()
        };
        (0..length)
            .map(|n| (0.5 * fade(n) * (TAU * (hertz * n as f64 / rate).fract()).sin()) as f32)
            .collect()
    }

    /// Level and phase (cycles) of the sine of `hertz` in `x`, and the level of all else, away from the ends.
    fn fit(x: &[f32], hertz: f64, rate: f64) -> (f64, f64, f64) {
        let inner = x.len() / 4..3 * x.len() / 4;
        let basis = |n: usize| (TAU * (hertz * n as f64 / rate).fract()).sin_cos();
        let (mut ss, mut sc, mut cc, mut xs, mut xc) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for n in inner.clone() {
            let (s, c) = basis(n);
            let v = f64::from(x[n]);
            (ss, sc, cc, xs, xc) = (ss + s * s, sc + s * c, cc + c * c, xs + v * s, xc + v * c);
        }
        let det = ss * cc - sc * sc;
        let (a, b) = ((xs * cc - xc * sc) / det, (xc * ss - xs * sc) / det);
        let rest = inner
            .clone()
            .map(|n| {
                let (s, c) = basis(n);
                (f64::from(x[n]) - a * s - b * c).powi(2)
            })
            .sum::<f64>();
        (a.hypot(b), b.atan2(a) / TAU, (rest / inner.len() as f64).sqrt())
    }

    const RATES: [f64; 9] =
        [1_000.0, 7_999.0, 11_025.0, 16_000.0, 22_050.0, 44_100.0, 48_000.0, 96_000.0, 192_000.0];
    // 2/6 of 48 and 44.1 kHz, and 2/11 of 88.2 kHz, which is no whole number.
    const TARGETS: [f64; 3] = [16_000.0, 14_700.0, 2.0 * 88_200.0 / 11.0];

    fn resample(samples: &[f32], from: f64, to: f64) -> Result<Vec<f32>, String> {
        let mut converter = Converter::new(from, to)?;
        converter.reserve(samples.len() as u64)?;
        samples.iter().try_for_each(|x| converter.push(*x))?;
        converter.finish()
    }

    #[test]
    fn a_sine_keeps_its_place_and_level_and_nothing_is_added() {
        for from in RATES {
            for to in TARGETS {
                for hertz in [50.0, 437.0, 0.484 * from.min(to)] {
                    if hertz > 0.484 * from {
                        continue;
                    }
                    let x = sine(hertz, from, 4.0);
                    let y = resample(&x, from, to).unwrap();
                    assert_eq!(y.len(), (x.len() as f64 / from * to - 1e-6).ceil() as usize);
                    let (level, phase, rest) = fit(&y, hertz, to);
                    let case =
                        format!("{hertz} Hz, {from} to {to}: level {level}, phase {phase}, rest {rest:e}");
                    assert!((20.0 * (level / 0.5).log10()).abs() < 0.01, "{case}");
                    assert!(phase.abs() < 1e-4, "{case}");
                    assert!(20.0 * (rest / level * 2_f64.sqrt()).log10() < -110.0, "{case}");
                }
            }
        }
    }

    #[test]
    fn what_the_lower_rate_cannot_hold_is_gone() {
        for from in [22_050.0, 44_100.0, 48_000.0, 192_000.0, 384_000.0] {
            for to in TARGETS {
                for hertz in [0.5 * to + 20.0, 0.5 * to + 150.0, to - 100.0, to + 437.0, 0.49 * from] {
                    if hertz < 0.5 * from {
                        let y = resample(&sine(hertz, from, 2.0), from, to).unwrap();
                        let inner = &y[y.len() / 4..3 * y.len() / 4];
                        let power =
                            inner.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / inner.len() as f64;
                        let alias = 10.0 * (power / 0.125).log10();
                        assert!(alias < -100.0, "{hertz} Hz, {from} to {to}: {alias} dB");
                    }
                }
            }
        }
    }

    #[test]
    fn the_first_sample_stays_the_first() {
        // A smooth bump whose top is at 20 ms of either rate.
        let bump = |rate: f64| {
            (0..(0.1 * rate) as usize)
                .map(move |n| (-((n as f64 / rate - 0.02) / 0.002).powi(2)).exp() as f32)
        };
        for from in [11_025.0, 44_100.0, 48_000.0] {
            let y = resample(&bump(from).collect::<Vec<_>>(), from, 16_000.0).unwrap();
            for (n, (got, want)) in y.iter().zip(bump(16_000.0)).enumerate() {
                assert!((got - want).abs() < 1e-5, "{from}, sample {n}: {got} for {want}");
            }
        }
    }

    #[test]
    fn the_same_rate_changes_nothing_and_short_recordings_are_whole() {
        let x = sine(100.0, 16_000.0, 0.1);
        assert_eq!(resample(&x, 16_000.0, 16_000.0).unwrap(), x);
        assert_eq!(resample(&[], 48_000.0, 16_000.0).unwrap(), Vec::<f32>::new());
        assert_eq!(resample(&[1.0], 8_000.0, 16_000.0).unwrap().len(), 2);
        assert_eq!(resample(&[1.0; 4], 48_000.0, 16_000.0).unwrap().len(), 2);
    }

    #[test]
    fn the_room_that_was_made_is_enough() {
        for (from, to, samples) in
            [(1_000.0, 16_000.0, 5_000), (44_100.0, 16_000.0, 100_001), (8_000.0, 8_000.0, 99)]
        {
            let mut converter = Converter::new(from, to).unwrap();
            converter.reserve(samples).unwrap();
            let room = converter.out.capacity();
            (0..samples).for_each(|n| converter.push(n as f32).unwrap());
            let all = converter.finish().unwrap();
            assert_eq!(all.capacity(), room, "{from} to {to}: it had to move");
            assert!(room - all.len() < 20_000, "{room} for {}", all.len());
        }
        assert!(Converter::new(1_000.0, 16_000.0).unwrap().reserve(1 << 60).is_err());
    }

    #[test]
    fn ratios_are_exact_or_near() {
        assert_eq!(ratio(16_000.0 / 44_100.0), (160, 441));
        assert_eq!(ratio(2.0 * 88_200.0 / 11.0 / 44_100.0), (4, 11));
        assert_eq!(ratio(16_000.0 / 191_999.0), (16_000, 191_999));
        for x in [std::f64::consts::PI / 9.0, 1.0 / 4096.0 + 1e-9, 4_095.999_9, 0.123_456_789_012] {
            let (p, q) = ratio(x);
            assert!((p as f64 / q as f64 / x - 1.0).abs() < 1e-7, "{x}: {p}/{q}");
        }
    }

    #[test]
    fn rates_that_are_none_are_refused() {
        for (from, to) in [(0.0, 1.0), (1.0, f64::NAN), (-1.0, 1.0), (f64::INFINITY, 1.0), (1.0, 16_000.0)] {
            assert!(resample(&[0.0; 9], from, to).unwrap_err().contains(" Hz"), "{from} {to}");
        }
    }
}
