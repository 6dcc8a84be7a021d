//! The stage's loops over rows of eight lanes. They are written lane by lane, and compile to vector instructions.
#![allow(clippy::needless_range_loop, reason = "several rows run under one lane index")]

use super::Row;
use super::design::{Design, MAX_TAPS, SECTIONS, Section};
use super::group::Place;
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
pub(super) fn copy(design: &Design, line: &[Row], out: &mut [f32], place: Place) -> Row {
    let mut peak = SILENCE;
    for (row, frame) in line.iter().zip(out.chunks_exact_mut(place.channels)) {
        let mut y = *row;
        for value in &mut y {
            *value *= design.gain;
        }
        put(frame, place.first, &y, &mut peak);
    }
    peak
}

/// `line` holds T - 1 samples of the past and then the block. Returns the peaks.
#[inline(always)]
pub(super) fn up_sample<const T: usize>(design: &Design, line: &[Row], out: &mut [f32], place: Place) -> Row {
    let mut peak = SILENCE;
    let step = design.fir.ratio * place.channels;
    let half = T.div_ceil(2);
    for (window, frames) in line.windows(T).zip(out.chunks_exact_mut(step)) {
        let (mut sum, mut difference) = ([SILENCE; MAX_TAPS / 2], [SILENCE; MAX_TAPS / 2]);
        for k in 0..half {
            for l in 0..LANES {
                let (here, mirrored) = (window[k][l], window[T - 1 - k][l]);
                sum[k][l] = if k == T - 1 - k { here } else { here + mirrored };
                difference[k][l] = here - mirrored;
            }
        }
        let frames = &mut frames[place.first..];
        // The pairs run from both ends of the frames to the middle.
        let (mut first, mut last) = (0, (design.fir.ratio - 1) * place.channels);
        for pair in &design.pairs {
            let (mut near, mut far) = (SILENCE, SILENCE);
            for l in 0..LANES {
                let mut even = pair.sum[0][l] * sum[0][l];
                let mut odd = pair.difference[0][l] * difference[0][l];
                for k in 1..half {
                    even += pair.sum[k][l] * sum[k][l];
                    odd += pair.difference[k][l] * difference[k][l];
                }
                near[l] = even + odd;
                far[l] = even - odd;
            }
            put(frames, first, &near, &mut peak);
            put(frames, last, &far, &mut peak);
            first += place.channels;
            last = last.wrapping_sub(place.channels);
        }
    }
    peak
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
