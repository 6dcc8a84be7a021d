//! The stage's loops over rows of eight lanes. They are written lane by lane, and compile to vector instructions.
#![allow(clippy::needless_range_loop, reason = "several rows run under one lane index")]

use super::Row;
use super::design::{Design, MAX_TAPS, Pair, SECTIONS, Section};
use super::group::Target;
use crate::dsp::lanes::LANES;

/// State of the band limit on eight lanes: each section's first state, and the sum of both.
pub(super) type Cascade = [[Row; 2]; SECTIONS];
/// Its coefficients.
pub(super) type Sections = [Section; SECTIONS];

/// Input magnitude that is held, 120 dB over full scale; what is not finite lies beyond it.
pub(super) const LARGEST: f32 = 1e6;
/// A row of nothing.
pub(super) const SILENCE: Row = [0.0; LANES];

/// Largest magnitude of each lane, and whether a value may be wild: the exponents of all, or-ed, are all ones if one of
/// them is not finite (and sometimes if some are above 2, which costs a look and nothing else).
#[inline(always)]
pub(super) fn survey(rows: &[Row]) -> (Row, bool) {
    let mut peak = SILENCE;
    let mut bits = [0; LANES];
    for row in rows {
        for l in 0..LANES {
            let size = row[l].abs();
            peak[l] = if peak[l] > size { peak[l] } else { size };
            bits[l] |= row[l].to_bits();
        }
    }
    let mut wild = false;
    for l in 0..LANES {
        wild |= bits[l] & 0x7f80_0000 == 0x7f80_0000 || peak[l] > LARGEST;
    }
    (peak, wild)
}

/// One sample through the band limit, without its gain. It is the transposed direct form II with its second state
/// replaced by the sum of both, and coefficients counted from a double integrator's: single precision then keeps the
/// error 10 dB or more below that of the plain form.
#[inline(always)]
pub(super) fn cascade(sections: &Sections, state: &mut Cascade, x: Row) -> Row {
    let mut out = x;
    // Lanes outside, sections inside: the other way round the compiler splits the rows in halves.
    for l in 0..LANES {
        let mut x = out[l];
        for (section, [first, both]) in sections.iter().zip(state.iter_mut()) {
            let y = x + first[l];
            let drive = both[l] + section.zeros * x;
            first[l] = (first[l] + drive) - section.poles * y;
            both[l] = drive - section.pull * y;
            x = y;
        }
        out[l] = x;
    }
    out
}

#[inline(always)]
pub(super) fn filter(sections: &Sections, state: &mut Cascade, rows: &[Row], out: &mut [Row]) {
    let mut z = *state;
    for (x, y) in rows.iter().zip(out) {
        *y = cascade(sections, &mut z, *x);
    }
    *state = z;
}

/// A ratio of 1: nothing but the band limit's gain.
#[inline(always)]
pub(super) fn copy(design: &Design, line: &[Row], target: &mut Target<'_>) -> Row {
    let mut peak = SILENCE;
    let Target { out, rest, place } = target;
    let frames = out.chunks_exact_mut(place.channels).chain(rest.chunks_exact_mut(place.channels));
    for (row, frame) in line[MAX_TAPS - 1..].iter().zip(frames) {
        let mut y = *row;
        for value in &mut y {
            *value *= design.gain;
        }
        put(frame, place.first, &y, &mut peak);
    }
    peak
}

/// `line` holds room for the past, which is in `past`, and then the block. `P` is the number of pairs where it is known
/// to be half the ratio, else 0. Returns the peaks.
#[inline(always)]
pub(super) fn up_sample<const T: usize, const P: usize>(
    design: &Design,
    line: &mut [Row],
    past: &mut [Row; MAX_TAPS - 1],
    target: &mut Target<'_>,
) -> Row {
    let mut peak = SILENCE;
    let channels = target.place.channels;
    let step = design.fir.ratio * channels;
    let known = design.pairs.first_chunk::<P>();
    let line = &mut line[MAX_TAPS - T..];
    line[..T - 1].copy_from_slice(&past[..T - 1]);
    let (mut left, rest) = (&mut *target.out, &mut *target.rest);
    let mut last = Some(rest);
    for window in line.windows(T) {
        let frames = if left.len() >= step {
            let (now, later) = left.split_at_mut(step);
            left = later;
            now
        } else {
            match last.take() {
                Some(rest) if rest.len() >= step => rest,
                _ => break,
            }
        };
        let frames = &mut frames[target.place.first..];
        let (sum, difference) = fold::<T>(window);
        match known {
            Some(pairs) if P > 0 => {
                for (p, pair) in pairs.iter().enumerate() {
                    let (near, far) = pair_of::<T>(pair, &sum, &difference);
                    put(frames, p * channels, &near, &mut peak);
                    put(frames, (2 * P - 1 - p) * channels, &far, &mut peak);
                }
            }
            _ => {
                // The pairs run from both ends of the frames to the middle.
                let (mut first, mut last) = (0, step - channels);
                for pair in &design.pairs {
                    let (near, far) = pair_of::<T>(pair, &sum, &difference);
                    put(frames, first, &near, &mut peak);
                    put(frames, last, &far, &mut peak);
                    first += channels;
                    last = last.wrapping_sub(channels);
                }
            }
        }
    }
    let end = line.len() - (T - 1);
    past[..T - 1].copy_from_slice(&line[end..]);
    peak
}

type Half = [Row; MAX_TAPS / 2];

/// Sums and differences of what mirrors each other in the window.
#[inline(always)]
fn fold<const T: usize>(window: &[Row]) -> (Half, Half) {
    let (mut sum, mut difference) = ([SILENCE; MAX_TAPS / 2], [SILENCE; MAX_TAPS / 2]);
    for k in 0..T.div_ceil(2) {
        for l in 0..LANES {
            let (here, mirrored) = (window[k][l], window[T - 1 - k][l]);
            sum[k][l] = if k == T - 1 - k { here } else { here + mirrored };
            difference[k][l] = here - mirrored;
        }
    }
    (sum, difference)
}

/// Two frames at the same distance from both ends.
#[inline(always)]
fn pair_of<const T: usize>(pair: &Pair, sum: &Half, difference: &Half) -> (Row, Row) {
    let (mut near, mut far) = (SILENCE, SILENCE);
    for l in 0..LANES {
        let mut even = pair.sum[0][l] * sum[0][l];
        let mut odd = pair.difference[0][l] * difference[0][l];
        for k in 1..T.div_ceil(2) {
            even += pair.sum[k][l] * sum[k][l];
            odd += pair.difference[k][l] * difference[k][l];
        }
        near[l] = even + odd;
        far[l] = even - odd;
    }
    (near, far)
}

/// Writes a row at `at` and follows its peak.
#[inline(always)]
fn put(frames: &mut [f32], at: usize, row: &Row, peak: &mut Row) {
    for l in 0..LANES {
        let size = row[l].abs();
        peak[l] = if peak[l] > size { peak[l] } else { size };
    }
    if let Some(to) = frames.get_mut(at..at.wrapping_add(LANES)) {
        to.copy_from_slice(row);
    }
}
