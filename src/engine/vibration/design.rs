//! Coefficients of the stage, computed once in `f64`, laid out for the loops.

use super::limiter::Limits;
use super::{Options, Refusal, Row};
use crate::dsp::blocker::{Blocker, CORNER};
use crate::dsp::elliptic::{BAND_SECTIONS, Elliptic};
use crate::dsp::interpolator::Interpolator;
use crate::dsp::lanes::LANES;

/// Sections of the band limit.
pub(super) const SECTIONS: usize = BAND_SECTIONS;
/// Longest up-sampling filter, taps a phase.
pub(super) const MAX_TAPS: usize = 12;
/// Rate the engine aims at, Hz.
const ENGINE: f64 = 8000.0;

/// A section of the band limit, b = (1, b1, 1), in numbers that are small and lose little by rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// 2 + b1.
    pub zeros: f32,
    /// 2 + a1.
    pub poles: f32,
    /// 1 + a1 + a2.
    pub pull: f32,
}

/// Two phases that mirror each other, the p-th from the start and from the end: their sum is worked out from sums of mirrored samples, their difference from
/// differences, at half the multiplications. Each coefficient is held eight times, as the loops want it.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Pair {
    pub sum: [Row; MAX_TAPS / 2],
    pub difference: [Row; MAX_TAPS / 2],
}

/// All that does not change while running.
#[derive(Debug)]
pub(super) struct Design {
    pub rate: f64,
    pub band_limit: Elliptic,
    pub blocker: Blocker,
    pub fir: Interpolator,
    pub sections: [Section; SECTIONS],
    pub pairs: Vec<Pair>,
    /// Gain of the band limit, which runs at the end, folded into the up-sampling.
    pub gain: f32,
    pub limits: Option<Limits>,
}

/// Rates that a device may have, Hz.
pub const DEVICE_RATES: std::ops::RangeInclusive<f64> = 6_000.0..=1e6;
/// Rates that an engine may have, Hz.
pub const ENGINE_RATES: std::ops::RangeInclusive<f64> = 6_000.0..=12_000.0;

impl Design {
    pub fn new(device_rate: f64, options: &Options) -> Result<Self, Refusal> {
        if !(4..=MAX_TAPS).contains(&options.taps) {
            return Err(Refusal::Taps(options.taps));
        }
        if !DEVICE_RATES.contains(&device_rate) {
            return Err(Refusal::Rate(device_rate));
        }
        let usual = (device_rate / ENGINE).round() as usize;
        let ratio = options.ratio.unwrap_or(usual).max(1);
        let rate = device_rate / ratio as f64;
        if !ENGINE_RATES.contains(&rate) {
            return Err(Refusal::EngineRate(rate));
        }
        let band_limit = Elliptic::band_limit(rate);
        let fir = Interpolator::design(options.taps, ratio, rate);
        let mut sections = [Section { zeros: 0.0, poles: 0.0, pull: 0.0 }; SECTIONS];
        for (section, exact) in sections.iter_mut().zip(&band_limit.sections) {
            let [a1, a2] = exact.a;
            let pull = (1.0 + a1 + a2) as f32;
            *section = Section { zeros: (2.0 + exact.b[1]) as f32, poles: (2.0 + a1) as f32, pull };
        }
        let limits = options.limiter.then(|| Limits::new(&band_limit));
        let pairs = pairs(&fir, band_limit.gain);
        let blocker = Blocker::new(CORNER, rate);
        Ok(Self { rate, gain: band_limit.gain as f32, band_limit, blocker, fir, sections, pairs, limits })
    }
}

fn pairs(fir: &Interpolator, gain: f64) -> Vec<Pair> {
    let (taps, ratio) = (fir.taps, fir.ratio);
    if ratio == 1 {
        return Vec::new();
    }
    // Tap on the k-th oldest of the samples in the window.
    let tap = |phase: usize, k: usize| gain * fir.response[(taps - 1 - k) * ratio + phase];
    (0..ratio.div_ceil(2))
        .map(|near| {
            let far = ratio - 1 - near;
            let mut pair =
                Pair { sum: [[0.0; LANES]; MAX_TAPS / 2], difference: [[0.0; LANES]; MAX_TAPS / 2] };
            for k in 0..taps.div_ceil(2) {
                // Where the window has a middle, the sample stands for its own sum and difference.
                let (here, mirrored) = (tap(near, k), tap(far, k));
                pair.sum[k] = [((here + mirrored) / 2.0) as f32; LANES];
                pair.difference[k] = [((here - mirrored) / 2.0) as f32; LANES];
            }
            pair
        })
        .collect()
}
