//! What a rendering differs by from its reference, within the band, and what it has beyond.

use std::convert::Infallible;

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

use super::reference::Reference;

/// Hertz up to which error is counted and beyond which power is.
pub const BAND: f64 = 1000.0;

/// A rendering against its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Power of the difference within the band, as a share of the reference's, in dB; −∞ where both are silent.
    pub error_db: f64,
    /// Power above the band, as a share of all power, in dB.
    pub above_db: f64,
}

/// Compares frames (interleaved, at `ratio` times the reference's rate) with a reference.
///
/// `response` is the designed linear response of the output stage on a channel (from 0) at a frequency, its delay taken out; `delay` is the delay the
/// engine reports, in seconds, and is what is taken out of `frames`, exactly. Both should end in silence.
pub fn compare(
    frames: &[f32],
    reference: &Reference,
    ratio: usize,
    delay: f64,
    response: &dyn Fn(usize, f64) -> Complex64,
) -> Comparison {
    let always = &mut |_| Ok::<(), Infallible>(());
    let Ok(comparison) = compare_watched(frames, reference, ratio, delay, response, always);
    comparison
}

/// As [`compare`]; `watch` is asked before each channel, with the share that is done.
///
/// # Errors
/// The first that `watch` gives.
pub fn compare_watched<S>(
    frames: &[f32],
    reference: &Reference,
    ratio: usize,
    delay: f64,
    response: &dyn Fn(usize, f64) -> Complex64,
    watch: &mut dyn FnMut(f64) -> Result<(), S>,
) -> Result<Comparison, S> {
    let channels = reference.channels.len();
    let length = reference.channels.first().map_or(0, Vec::len);
    let (mut difference, mut wanted, mut above, mut all) = (0.0, 0.0, 0.0, 0.0);
    let mut planner = RealFftPlanner::<f64>::new();
    let (low, high) =
        (planner.plan_fft_forward(length.max(2)), planner.plan_fft_forward((length * ratio).max(2)));
    let bins = length as f64 / reference.rate;
    for (c, ideal) in reference.channels.iter().enumerate() {
        watch(c as f64 / channels as f64)?;
        let mut is: Vec<f64> = frames.iter().skip(c).step_by(channels).map(|x| f64::from(*x)).collect();
        is.resize(high.len(), 0.0);
        if is.iter().all(|x| *x == 0.0) && ideal.iter().all(|x| *x == 0.0) {
            continue;
        }
        let mut should = ideal.clone();
        should.resize(low.len(), 0.0);
        let (mut is_bins, mut should_bins) = (high.make_output_vec(), low.make_output_vec());
        // The lengths are the plans' own, so neither can fail.
        if high.process(&mut is, &mut is_bins).is_err() || low.process(&mut should, &mut should_bins).is_err()
        {
            continue;
        }
        for (k, is) in is_bins.iter().enumerate() {
            let hertz = k as f64 / bins;
            let power = is.norm_sqr();
            all += power;
            if hertz > BAND {
                above += power;
                continue;
            }
            let Some(should) = should_bins.get(k) else { continue };
            let should = should * response(c, hertz);
            let is = is / ratio as f64 * Complex64::cis(std::f64::consts::TAU * hertz * delay);
            difference += (is - should).norm_sqr();
            wanted += should.norm_sqr();
        }
    }
    Ok(Comparison { error_db: decibels(difference, wanted), above_db: decibels(above, all) })
}

fn decibels(part: f64, whole: f64) -> f64 {
    if part == 0.0 { f64::NEG_INFINITY } else { 10.0 * (part / whole).log10() }
}
