//! Samples to bytes: clamping, dither, packing.

use super::WavSpec;
use crate::dsp::random;
use std::fmt;
use std::str::FromStr;

/// How a sample is stored, always little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Encoding {
    /// IEEE float of 32 bits: stored as it is.
    #[default]
    F32,
    /// Integer of 24 bits in three bytes, dithered.
    I24,
    /// Integer of 16 bits, dithered.
    I16,
}

impl Encoding {
    /// Bytes a sample.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::I24 => 3,
            Self::I16 => 2,
        }
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::I24 => "i24",
            Self::I16 => "i16",
        })
    }
}

impl FromStr for Encoding {
    type Err = UnknownEncoding;

    fn from_str(word: &str) -> Result<Self, UnknownEncoding> {
        [Self::F32, Self::I24, Self::I16]
            .into_iter()
            .find(|encoding| encoding.to_string() == word)
            .ok_or_else(|| UnknownEncoding(word.to_owned()))
    }
}

/// A word that names no [`Encoding`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownEncoding(pub String);

impl fmt::Display for UnknownEncoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is no sample format: choose f32, i24 or i16", self.0)
    }
}

impl std::error::Error for UnknownEncoding {}

/// What had to be changed on the way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Tally {
    pub clipped: u64,
    pub non_finite: u64,
}

/// Appends whole frames to `out`. `first` is the number of the first frame; the bytes depend on it, on `spec` and on the
/// samples alone, so it does not matter how a run is cut.
pub(super) fn encode(spec: &WavSpec, first: u64, samples: &[f32], out: &mut Vec<u8>) -> Tally {
    let WavSpec { channels, encoding, seed, unbounded, .. } = *spec;
    let mut tally = Tally::default();
    let start = out.len();
    out.resize(start + samples.len() * encoding.bytes(), 0);
    let bytes = &mut out[start..];
    match encoding {
        Encoding::F32 if unbounded => {
            for (&x, word) in samples.iter().zip(bytes.chunks_exact_mut(4)) {
                tally.non_finite += u64::from(!x.is_finite());
                word.copy_from_slice(&if x.is_finite() { x } else { 0.0 }.to_le_bytes());
            }
        }
        Encoding::F32 => {
            // Counters of a sample's width let the compiler take several samples at a time.
            for (samples, bytes) in samples.chunks(1 << 16).zip(bytes.chunks_mut(4 << 16)) {
                let (mut clipped, mut non_finite) = (0_u32, 0_u32);
                for (&x, word) in samples.iter().zip(bytes.chunks_exact_mut(4)) {
                    word.copy_from_slice(&limited(x, &mut clipped, &mut non_finite).to_le_bytes());
                }
                tally.clipped += u64::from(clipped);
                tally.non_finite += u64::from(non_finite);
            }
        }
        Encoding::I24 => quantise::<3>(channels, seed, first, samples, bytes, &mut tally),
        Encoding::I16 => quantise::<2>(channels, seed, first, samples, bytes, &mut tally),
    }
    tally
}

/// Within full scale; what is no number is silence.
#[inline(always)]
fn limited(x: f32, clipped: &mut u32, non_finite: &mut u32) -> f32 {
    let finite = x.abs() <= f32::MAX;
    *non_finite += u32::from(!finite);
    *clipped += u32::from(finite && x.abs() > 1.0);
    if finite { x.clamp(-1.0, 1.0) } else { 0.0 }
}

/// What stands in a stream's name where others have their voice: no voice is called so.
const DITHER: u64 = u64::from_be_bytes(*b"\xFFdither\xFF");

/// To integers of so many bytes.
fn quantise<const BYTES: usize>(
    channels: usize,
    seed: u64,
    first: u64,
    samples: &[f32],
    bytes: &mut [u8],
    tally: &mut Tally,
) {
    let full_scale = f64::from(1_u32 << (8 * BYTES - 1));
    // Each channel has a stream of its own, each frame a word of it.
    let streams: Vec<u64> =
        (0..channels as u64).map(|channel| random::stream(seed, DITHER, channel)).collect();
    let mut words = vec![[0; 4]; channels];
    let frames = samples.chunks_exact(channels).zip(bytes.chunks_exact_mut(BYTES * channels));
    for (frame, (samples, bytes)) in (first..).zip(frames) {
        if frame == first || frame.is_multiple_of(4) {
            words.iter_mut().zip(&streams).for_each(|(words, s)| *words = random::words(*s, frame / 4));
        }
        let (mut clipped, mut non_finite) = (0, 0);
        for ((&x, words), word) in samples.iter().zip(&words).zip(bytes.chunks_exact_mut(BYTES)) {
            let x = limited(x, &mut clipped, &mut non_finite);
            let noise = words[(frame % 4) as usize];
            let value = if x == 0.0 { 0 } else { dithered(x, full_scale, noise) };
            word.copy_from_slice(&value.to_le_bytes()[..BYTES]);
        }
        tally.clipped += u64::from(clipped);
        tally.non_finite += u64::from(non_finite);
    }
}

/// To the nearest step after adding noise of triangular density within ±1 step, which makes the mean and the power of the
/// error independent of the signal (Lipshitz, Wannamaker & Vanderkooy 1992). Exact zero is not to be dithered: it has no
/// error to whiten, and a tactor that rests must rest, not hiss at the last bit.
#[inline(always)]
fn dithered(x: f32, full_scale: f64, noise: u32) -> i32 {
    let triangular = (f64::from(noise >> 16) - f64::from(noise & 0xFFFF)) / 65_536.0;
    // Above zero, truncation is rounding down.
    const LIFT: f64 = 16_777_216.0;
    let steps = (f64::from(x) * full_scale + triangular + 0.5 + LIFT) as i32 - LIFT as i32;
    // One step less at the top: two's complement has no +1.0.
    steps.clamp(-(full_scale as i32), full_scale as i32 - 1)
}

#[cfg(test)]
mod tests {
    use super::{DITHER, Encoding, WavSpec, encode};
    use crate::dsp::random;

    fn i16s(channels: usize, seed: u64, first: u64, samples: &[f32]) -> Vec<i16> {
        let mut out = Vec::new();
        let spec = WavSpec { seed, ..WavSpec::new(channels, 8000, Encoding::I16) };
        encode(&spec, first, samples, &mut out);
        out.chunks_exact(2).map(|b| i16::from_le_bytes([b[0], b[1]])).collect()
    }

    #[test]
    fn the_dither_leaves_an_error_without_mean_and_of_a_quarter_step_power() {
        // TPDF of two steps peak to peak: total error variance (1/12 + 1/6) = 1/4 step², whatever the signal.
        for level in [0.01, 0.25, 0.5, 0.77] {
            let n = 200_000;
            let x = vec![(100.0 + level) / 32_768.0; n];
            let error: Vec<f64> =
                i16s(1, 7, 0, &x).iter().map(|&q| f64::from(q) - 100.0 - f64::from(level)).collect();
            let mean = error.iter().sum::<f64>() / n as f64;
            let power = error.iter().map(|e| e * e).sum::<f64>() / n as f64;
            assert!(mean.abs() < 0.005, "{level}: mean {mean}");
            assert!((power - 0.25).abs() < 0.005, "{level}: power {power}");
            assert!(error.iter().all(|e| e.abs() <= 1.5), "{level}");
        }
    }

    #[test]
    fn errors_of_neighbours_in_time_and_across_channels_have_nothing_in_common() {
        let n = 100_000;
        let error: Vec<f64> =
            i16s(2, 3, 0, &vec![0.3_f32; 2 * n]).iter().map(|&q| f64::from(q) - 0.3 * 32_768.0).collect();
        for lag in 1..=4 {
            let product: f64 =
                error.iter().zip(&error[lag..]).map(|(a, b)| a * b).sum::<f64>() / (2 * n) as f64;
            assert!(product.abs() < 0.25 * 0.02, "lag {lag}: {product}");
        }
    }

    #[test]
    fn it_does_not_matter_how_a_run_is_cut() {
        let x: Vec<f32> = (0..3 * 100).map(|i| (i as f32 * 0.37).sin() * 0.4).collect();
        let whole = i16s(3, 99, 0, &x);
        let (a, b) = x.split_at(3 * 41);
        assert_eq!(whole, [i16s(3, 99, 0, a), i16s(3, 99, 41, b)].concat());
        assert_ne!(whole, i16s(3, 98, 0, &x), "another seed, another dither");
    }

    #[test]
    fn silence_is_silent_and_the_ends_of_the_scale_hold() {
        assert_eq!(i16s(1, 1, 0, &[0.0, -0.0]), [0, 0]);
        let ends = i16s(1, 1, 0, &[1.0, -1.0].repeat(1000));
        assert!(ends.chunks(2).all(|e| e[0] >= 32_766 && e[1] <= -32_767), "{ends:?}");
    }

    #[test]
    fn what_is_clamped_or_no_number_is_counted() {
        let x = [0.5, 1.5, f32::NAN, -2.0, f32::INFINITY, -1.0, f32::NEG_INFINITY, f32::MIN];
        for encoding in [Encoding::F32, Encoding::I24, Encoding::I16] {
            let mut out = Vec::new();
            let tally = encode(&WavSpec::new(2, 8000, encoding), 0, &x, &mut out);
            assert_eq!((tally.clipped, tally.non_finite), (3, 3), "{encoding}");
            assert_eq!(out.len(), 8 * encoding.bytes());
        }
        let kept = |unbounded: bool| {
            let mut out = Vec::new();
            let spec = WavSpec { unbounded, ..WavSpec::new(1, 8000, Encoding::F32) };
            let tally = encode(&spec, 0, &x, &mut out);
            let read = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
            (out.chunks_exact(4).map(read).collect::<Vec<f32>>(), tally.clipped, tally.non_finite)
        };
        assert_eq!(kept(false), (vec![0.5, 1.0, 0.0, -1.0, 0.0, -1.0, 0.0, -1.0], 3, 3));
        assert_eq!(kept(true), (vec![0.5, 1.5, 0.0, -2.0, 0.0, -1.0, 0.0, f32::MIN], 0, 3), "figures stay");
    }

    #[test]
    fn an_i24_is_within_a_step_and_a_half() {
        let x: Vec<f32> = (0..5000).map(|i| (i as f32 * 0.013).sin() * 0.9).collect();
        let mut out = Vec::new();
        let spec = WavSpec { seed: 5, ..WavSpec::new(1, 8000, Encoding::I24) };
        encode(&spec, 0, &x, &mut out);
        for (x, b) in x.iter().zip(out.chunks_exact(3)) {
            let q = i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8;
            assert!((f64::from(q) - f64::from(*x) * 8_388_608.0).abs() <= 1.5);
        }
    }

    #[test]
    fn the_dither_is_that_of_the_published_generator() {
        // By the definition: word `frame` of the channel's stream, its halves one minus the other.
        let x = 0.3_f32;
        let found = i16s(3, 11, 6, &[x; 3 * 9]);
        for (i, q) in found.iter().enumerate() {
            let (channel, frame) = (i as u64 % 3, 6 + i as u64 / 3);
            let word = random::bits(random::stream(11, DITHER, channel), frame);
            let triangular = (f64::from(word >> 16) - f64::from(word & 0xFFFF)) / 65_536.0;
            assert_eq!(f64::from(*q), (f64::from(x) * 32_768.0 + triangular).round(), "{channel} {frame}");
        }
    }

    #[test]
    fn words_name_encodings() {
        for encoding in [Encoding::F32, Encoding::I24, Encoding::I16] {
            assert_eq!(encoding.to_string().parse(), Ok(encoding));
        }
        let error = "i8".parse::<Encoding>().unwrap_err();
        assert_eq!(error.to_string(), "`i8` is no sample format: choose f32, i24 or i16");
    }
}
