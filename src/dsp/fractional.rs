//! Values between samples, by short filters that are right within a known band.
//!
//! T weights (a multiple of 8) for the samples 0 .. T − 1 give the value at a place between them. They minimise the mean square error over the
//! frequencies up to `band` (least squares: Laakso, Välimäki, Karjalainen, Laine, "Splitting the unit delay", IEEE Signal
//! Processing Magazine, 1996, III.B), with 1e-13 of that weight on their own size, so that what lies beyond is not amplified much.
//! They are kept for every 1/512 of a sample, with a straight line between; once for all that ask for the same.

use super::lanes::Real;
use std::any::Any;
use std::sync::{Mutex, PoisonError};

const STEPS: f64 = 512.0;

fn count(first: f64, last: f64) -> usize {
    ((last - first) * STEPS).ceil() as usize + 2
}

/// Weights, by the places and the band that they are for.
type Table = ([u64; 3], Box<dyn Any + Send>);

/// All that were asked for.
static TABLES: Mutex<Vec<Table>> = Mutex::new(Vec::new());

/// Weights for places from `first` on.
#[derive(Debug, Clone)]
pub struct Fractional<R: 'static, const T: usize> {
    rows: &'static [[R; T]],
    first: f64,
}

impl<R: Real, const T: usize> Fractional<R, T> {
    /// Weights for places from `first` to `last`, for frequencies up to `band` (in shares of the rate). The first who asks computes
    /// them, and they stay for as long as the program runs: it is for those who ask for the same few over and over, and not for
    /// the audio thread.
    #[allow(clippy::disallowed_methods)] // when an engine is made
    pub fn new(first: f64, last: f64, band: f64) -> Self {
        let asked = [first, last, band].map(f64::to_bits);
        let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
        let known = tables.iter().filter(|(of, _)| *of == asked);
        // Of that number type and that many taps.
        let rows = known.filter_map(|(_, rows)| rows.downcast_ref::<&'static [[R; T]]>()).next().copied();
        let rows = rows.unwrap_or_else(|| {
            let rows: &'static [[R; T]] = Self::compute(first, last, band).leak();
            tables.push((asked, Box::new(rows)));
            rows
        });
        Self { rows, first }
    }

    fn compute(first: f64, last: f64, band: f64) -> Vec<[R; T]> {
        let count = count(first, last);
        let sinc = |x: f64| {
            let angle = std::f64::consts::TAU * band * x;
            2.0 * band * if angle == 0.0 { 1.0 } else { angle.sin() / angle }
        };
        let inverse = inverse(|j, k| sinc(j as f64 - k as f64) + if j == k { 1e-13 } else { 0.0 }, T);
        (0..count)
            .map(|n| {
                let place = first + n as f64 / STEPS;
                let target: Vec<f64> = (0..T).map(|k| sinc(k as f64 - place)).collect();
                std::array::from_fn(|j| R::of(inverse[j].iter().zip(&target).map(|(a, b)| a * b).sum()))
            })
            .collect()
    }

    /// The value at `place` among `samples`; places outside the range count as its ends, what is not a number as the first.
    #[inline(always)]
    pub fn at(&self, place: f64, samples: &[R]) -> R {
        let steps = (place - self.first) * STEPS;
        let steps = if steps > 0.0 { steps } else { 0.0 };
        let row = (steps as u32 as usize).min(self.rows.len() - 2);
        let (share, [low, high]) = (R::of(steps - row as u32 as f64), [&self.rows[row], &self.rows[row + 1]]);
        let Some(samples) = samples.first_chunk::<T>() else { return R::ZERO };
        // Eight sums side by side, then by halves: always in the same order.
        let mut sums = [R::ZERO; 8];
        for ((low, high), samples) in
            low.as_chunks::<8>().0.iter().zip(high.as_chunks::<8>().0).zip(samples.as_chunks::<8>().0)
        {
            for k in 0..8 {
                sums[k] += (low[k] + (high[k] - low[k]) * share) * samples[k];
            }
        }
        let [a, b, c, d, e, f, g, h] = sums;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// By Gauss and Jordan with pivots.
fn inverse(entry: impl Fn(usize, usize) -> f64, size: usize) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = (0..size)
        .map(|j| {
            let unit = (0..size).map(|k| if j == k { 1.0 } else { 0.0 });
            (0..size).map(|k| entry(j, k)).chain(unit).collect()
        })
        .collect();
    for column in 0..size {
        let size_of = |j: usize| rows[j][column].abs();
        let pivot = (column..size).max_by(|a, b| size_of(*a).total_cmp(&size_of(*b))).unwrap_or(column);
        rows.swap(column, pivot);
        let scale = 1.0 / rows[column][column];
        rows[column].iter_mut().for_each(|v| *v *= scale);
        let chosen = rows[column].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(j, _)| *j != column) {
            let factor = row[column];
            row.iter_mut().zip(&chosen).for_each(|(v, c)| *v -= factor * c);
        }
    }
    rows.into_iter().map(|row| row[size..].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use super::Fractional;

    fn error_db(table: &Fractional<f64, 16>, place: f64, turns: f64) -> f64 {
        let mut worst = 0.0_f64;
        for n in 0..64 {
            let wave = |x: f64| (std::f64::consts::TAU * (turns * x + f64::from(n) / 64.0)).sin();
            let samples: Vec<f64> = (0..16).map(|k| wave(f64::from(k))).collect();
            worst = worst.max((table.at(place, &samples) - wave(place)).abs());
        }
        20.0 * worst.log10()
    }

    #[test]
    fn sines_within_the_band_are_right() {
        let table = Fractional::new(7.0, 8.0, 0.25);
        for n in 0..=50 {
            let place = 7.0 + f64::from(n) / 50.0;
            for (turns, most) in [(0.0, -110.0), (0.0625, -110.0), (0.125, -110.0), (0.24, -98.0)] {
                let error = error_db(&table, place, turns);
                assert!(error < most, "{turns} at {place}: {error}");
            }
        }
    }

    #[test]
    fn who_asks_for_the_same_gets_the_same() {
        let of = |last| Fractional::<f32, 8>::new(3.0, last, 0.136);
        let (a, b, c) = (of(7.0), of(7.0), of(6.0));
        assert!(std::ptr::eq(a.rows, b.rows));
        assert!(!std::ptr::eq(a.rows, c.rows) && a.rows.len() > c.rows.len());
        let wide = Fractional::<f64, 8>::new(3.0, 7.0, 0.136);
        let long = Fractional::<f32, 16>::new(3.0, 7.0, 0.136);
        assert_eq!((wide.rows.len(), long.rows.len()), (a.rows.len(), a.rows.len()));
        // They are what would be computed anew.
        assert_eq!(a.rows, Fractional::<f32, 8>::compute(3.0, 7.0, 0.136));
    }

    #[test]
    fn hostile_places_give_a_number() {
        let table = Fractional::<f64, 8>::new(3.0, 4.0, 0.16);
        for place in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e300] {
            let place = if place == f64::INFINITY { 4.0 } else { place };
            assert!(table.at(place, &[1.0; 8]).is_finite());
        }
        assert_eq!(table.at(3.5, &[1.0; 3]), 0.0);
    }
}
