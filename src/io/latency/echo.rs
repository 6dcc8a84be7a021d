//! A probe in what came in.

use realfft::RealFftPlanner;

use super::probe;

/// A probe that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// The sample at which it begins; it may lie between two.
    pub at: f64,
    /// Its level, where the probe was 1; negative if it came upside down.
    pub gain: f64,
    /// By how much it stands out of what else there is: the peak of the correlation, as a multiple of the root mean square of the rest.
    pub clarity: f64,
    /// What of all that was heard while it lasted is like it, 0 to 1: the coefficient of correlation.
    pub likeness: f64,
}

impl Echo {
    /// Whether it is one, and neither noise nor the outskirts of one that lies beyond what was looked at: those stand out of silence as
    /// well, and are next to nothing of what was heard there.
    pub fn is_clear(&self) -> bool {
        self.clarity >= CLEAR && self.likeness >= ALIKE
    }
}

/// From here on it is more than next to nothing: a probe that begins 5 ms beyond the edge leaves 0.001 and less within. Noise as strong as
/// [`CLEAR`] lets through leaves 0.04 and more of a probe; a steady part counts for nothing, and hum may be fifty times as strong.
const ALIKE: f64 = 0.004;

/// Seconds at either end where nothing is believed: what is highest there may be next to something higher beyond, as the waves of a probe are 2 ms
/// long.
const EDGE: f64 = 0.002;

/// From here on it is one, and not what noise looks like by chance.
const CLEAR: f64 = 8.0;

/// Where in `heard` a probe begins whose samples are `step` seconds apart, by correlation (by way of the Fourier transform), between
/// samples by a parabola through its peak. `None` where there is silence, or less than a probe.
pub fn find(heard: &[f32], step: f64) -> Option<Echo> {
    let length = (probe::SECONDS / step).ceil() as usize + 1;
    let reference: Vec<f64> = (0..length).map(|n| probe::at(n as f64 * step)).collect();
    let energy: f64 = reference.iter().map(|x| x * x).sum();
    let places = heard.len().checked_sub(length)?;
    let size = (heard.len() + length).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, back) = (planner.plan_fft_forward(size), planner.plan_fft_inverse(size));
    let spectrum = |samples: &mut dyn Iterator<Item = f64>| {
        let mut padded: Vec<f64> = samples.collect();
        padded.resize(size, 0.0);
        let mut bins = forward.make_output_vec();
        forward.process(&mut padded, &mut bins).ok().map(|()| bins)
    };
    let mut product = spectrum(&mut heard.iter().map(|x| f64::from(*x)))?;
    let pattern = spectrum(&mut reference.into_iter())?;
    product.iter_mut().zip(&pattern).for_each(|(a, b)| *a *= b.conj());
    let mut all = back.make_output_vec();
    back.process(&mut product, &mut all).ok()?;
    let scale = 1.0 / (size as f64 * energy);
    let found: Vec<f64> = all.iter().take(places + 1).map(|x| x * scale).collect();
    let (peak, &high) = found.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let edge = ((EDGE / step) as usize).max(1);
    if high == 0.0 || !high.is_finite() || peak < edge || peak + edge > places {
        return None;
    }
    // Noise has passed the correlation, too, and is as smooth as its peak: so the points may be near, where a parabola is right.
    let apart = ((1.0 / 48_000.0) / step).round().max(1.0) as usize;
    let (before, after) = (found.get(peak.wrapping_sub(apart)), found.get(peak + apart));
    let shift = match (before, after) {
        (Some(before), Some(after)) => {
            let bend = before - 2.0 * high + after;
            if bend == 0.0 { 0.0 } else { (0.5 * (before - after) / bend).clamp(-1.0, 1.0) * apart as f64 }
        }
        _ => 0.0,
    };
    let near = length / 4;
    let rest = || found.iter().enumerate().filter(|(n, _)| n.abs_diff(peak) > near).map(|(_, x)| x * x);
    let rms = (rest().sum::<f64>() / rest().count().max(1) as f64).sqrt();
    let clarity = if rms > 0.0 { high.abs() / rms } else { f64::INFINITY };
    let beside = heard.iter().skip(peak).take(length).map(|x| f64::from(*x));
    let steady = beside.clone().sum::<f64>() / length as f64;
    let there = beside.map(|x| (x - steady).powi(2)).sum::<f64>();
    let likeness = if there > 0.0 { high.abs() * (energy / there).sqrt() } else { 0.0 };
    Some(Echo { at: peak as f64 + shift, gain: high, clarity, likeness })
}

#[cfg(test)]
mod tests {
    use super::super::probe;
    use super::{ALIKE, CLEAR, find};

    /// Numbers from -1 to 1 that look random.
    fn noise(n: u64) -> f64 {
        let n = n.wrapping_add(77).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let n = (n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((n ^ (n >> 32)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn heard(at: f64, gain: f64, floor: f64, rate: f64) -> Vec<f32> {
        let sample = |n: u32| gain * probe::at((f64::from(n) - at) / rate) + floor * noise(u64::from(n));
        (0..(0.4 * rate) as u32).map(|n| sample(n) as f32).collect()
    }

    #[test]
    fn it_is_found_between_samples_upside_down_and_in_noise() {
        for rate in [8_000.0, 44_100.0, 48_000.0, 192_000.0] {
            for (at, gain, floor, most) in [
                (1000.0, 0.1, 0.0, 0.005),
                (777.37, -0.02, 0.0, 0.005),
                (500.5, 0.1, 0.01, 0.1),
                (620.25, 1.0, 0.001, 0.05),
            ] {
                let echo = find(&heard(at, gain, floor, rate), 1.0 / rate).unwrap();
                assert!((echo.at - at).abs() < most * (rate / 48_000.0).max(1.0), "{rate}: {echo:?}, {at}");
                assert!((echo.gain / gain - 1.0).abs() < 0.05 && echo.is_clear(), "{rate}: {echo:?}, {at}");
            }
        }
    }

    #[test]
    fn one_that_lies_beyond_what_was_looked_at_is_not_taken_for_one_within() {
        for rate in [8_000.0, 48_000.0, 192_000.0] {
            for early in [0.0, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.04, 0.07] {
                let part = heard(-early * rate, 0.5, 0.0, rate);
                let echo = find(&part, 1.0 / rate);
                assert!(echo.is_none_or(|echo| !echo.is_clear()), "{rate}, {early}: {echo:?}");
            }
        }
    }

    /// As loud as noise may be for one to be clear, and a hum of mains fifty times as loud as it, on an offset.
    #[test]
    fn one_in_noise_or_hum_is_like_enough() {
        for rate in [8_000.0, 48_000.0, 192_000.0_f64] {
            // The correlation's noise is that of the samples over the root of the probe's energy; noise of +-1 has a root mean square of 0.577.
            let energy: f64 = (0..(0.08 * rate) as u32).map(|n| probe::at(f64::from(n) / rate).powi(2)).sum();
            let floor = 0.1 * energy.sqrt() / (1.3 * CLEAR * 0.577);
            let mut noisy = heard(2000.0, 0.1, floor, rate);
            let echo = find(&noisy, 1.0 / rate).unwrap();
            assert!(echo.is_clear() && (echo.at - 2000.0).abs() < 5e-4 * rate, "{rate}: {echo:?}");
            assert!(echo.likeness > 10.0 * ALIKE, "{rate}: {echo:?}");
            noisy = heard(2000.0, 0.02, 0.0, rate);
            for (n, x) in noisy.iter_mut().enumerate() {
                *x += 0.5 + (std::f64::consts::TAU * 50.0 * n as f64 / rate).sin() as f32;
            }
            let echo = find(&noisy, 1.0 / rate).unwrap();
            assert!(echo.is_clear(), "{rate}: {echo:?}");
        }
    }

    #[test]
    fn noise_and_silence_are_no_probe() {
        for n in 0..20 {
            let echo = find(&heard(1e9, 0.0, 0.1 + f64::from(n), 48_000.0), 1.0 / 48_000.0).unwrap();
            assert!(!echo.is_clear(), "{echo:?}");
        }
        assert_eq!(find(&[0.0; 20_000], 1.0 / 48_000.0), None);
        assert_eq!((find(&[0.1; 100], 1.0 / 48_000.0), find(&[], 1.0 / 48_000.0)), (None, None));
        // Hum is none either.
        let hum: Vec<f32> = (0..19_200_u16).map(|n| (f32::from(n) * 0.0065).sin()).collect();
        let echo = find(&hum, 1.0 / 48_000.0).unwrap();
        assert!(!echo.is_clear(), "{echo:?}");
    }
}
