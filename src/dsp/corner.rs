//! Jumps and corners at any instant between samples, band-limited.
//!
//! A signal that is sampled from its closed form is exact except where it, or a derivative of it, jumps: there what lies
//! beyond half the rate folds into the band. The cure is a short correction added to the samples around the instant.
//!
//! For a unit jump of the derivative of order p at `a` samples, the signal is (t − a)^p / p! from there on; its transform is
//! e^(−jωa) / (jω)^(p+1), and the sampled form has that of Σ (n − a)^p / p! e^(−jωn) over n ≥ 2. The correction is the
//! sequence of [`TAPS`] numbers whose transform is nearest to the difference, in the sense of least squares relative to
//! 1/|ω|^(p+1), up to a quarter of the rate: beyond, the output stage lets nothing through. (Band-limited steps of finite
//! length are due to E. Brandt, "Hard sync without aliasing", ICMC 2001; minimising the error inside the band alone takes
//! the place of the windowed sinc.) Largest error to 0.14 of the rate: −105 dB for a jump, −114 dB for a corner, less for
//! higher orders; to a quarter of it −67 dB and −83 dB.
//!
//! The sequences are smooth in `a`, so one polynomial a tap stands for all instants.

use std::sync::OnceLock;

use super::lanes::{LANES, Real};

/// Length of a correction, in samples. It begins 1 to 2 samples before its instant.
pub const TAPS: usize = 12;

/// Derivatives whose jumps are corrected, from the value itself (order 0) on.
pub const ORDERS: usize = 6;

const DEGREE: usize = 9;

/// The corrections for all instants.
#[derive(Debug)]
pub struct Corner {
    /// By order, power of 2a − 3 and tap.
    powers: [[[f64; TAPS]; DEGREE + 1]; ORDERS],
}

impl Corner {
    /// The one table, computed at the first call (about a millisecond): call it before the audio thread needs it.
    pub fn prepare() -> &'static Self {
        static TABLE: OnceLock<Corner> = OnceLock::new();
        TABLE.get_or_init(Self::design)
    }

    /// What is added to the samples 0, 1, … of a signal whose derivative `order` jumps by 1 at `ahead` samples, where
    /// 1 ≤ `ahead` ≤ 2 and the samples from 2 on are those of the signal after the jump.
    pub fn taps(&self, order: usize, ahead: f64) -> [f64; TAPS] {
        let x = 2.0 * ahead - 3.0;
        let mut sum = [0.0; TAPS];
        for row in self.powers[order].iter().rev() {
            for (sum, c) in sum.iter_mut().zip(row) {
                *sum = *sum * x + c;
            }
        }
        sum
    }

    fn design() -> Self {
        let nodes: [f64; DEGREE + 1] =
            std::array::from_fn(|k| (std::f64::consts::PI * (k as f64 + 0.5) / (DEGREE + 1) as f64).cos());
        let mut powers = [[[0.0; TAPS]; DEGREE + 1]; ORDERS];
        for (order, powers) in powers.iter_mut().enumerate() {
            let fit = Fit::new(order);
            // Newton's divided differences, then powers of x.
            let mut difference: [[f64; TAPS]; DEGREE + 1] =
                std::array::from_fn(|k| fit.solve(1.5 + 0.5 * nodes[k]));
            for level in 1..=DEGREE {
                for k in (level..=DEGREE).rev() {
                    let (before, from) = (difference[k - 1], nodes[k] - nodes[k - level]);
                    for (value, before) in difference[k].iter_mut().zip(before) {
                        *value = (*value - before) / from;
                    }
                }
            }
            for k in (0..=DEGREE).rev() {
                // Times (x − node), plus the difference.
                let mut lower = difference[k];
                for row in powers.iter_mut() {
                    for (value, lower) in row.iter_mut().zip(&mut lower) {
                        let old = *value;
                        *value = *lower - nodes[k] * old;
                        *lower = old;
                    }
                }
            }
        }
        Self { powers }
    }
}

/// Points of the frequency grid, from 0 to a quarter of the rate.
const POINTS: usize = 96;

/// Least squares for one order: the factored normal equations.
struct Fit {
    order: usize,
    /// Radians a sample, and the square of the weight there.
    grid: [(f64, f64); POINTS],
    /// Lower triangle of Cholesky's factor.
    factor: [[f64; TAPS]; TAPS],
}

impl Fit {
    fn new(order: usize) -> Self {
        // 0.14 of the rate is 1 kHz at 7,350 Hz, the lowest engine rate of the usual devices.
        let edge = std::f64::consts::TAU * 0.14;
        let grid = std::array::from_fn(|k| {
            let w = std::f64::consts::FRAC_PI_2 * (k as f64 + 0.5) / POINTS as f64;
            let weight = if w <= edge { 1.0 } else { 0.05 } * w.powi(order as i32 + 1);
            (w, weight * weight)
        });
        let mut factor = [[0.0; TAPS]; TAPS];
        for i in 0..TAPS {
            for j in 0..=i {
                let mut sum: f64 = grid.iter().map(|(w, weight)| weight * (w * (i - j) as f64).cos()).sum();
                if i == j {
                    // Tikhonov's term keeps the taps small where the band leaves them free.
                    sum += 1e-12 * POINTS as f64;
                }
                sum -= factor[i][..j].iter().zip(&factor[j]).map(|(a, b)| a * b).sum::<f64>();
                factor[i][j] = if i == j { sum.sqrt() } else { sum / factor[j][j] };
            }
        }
        Self { order, grid, factor }
    }

    fn solve(&self, ahead: f64) -> [f64; TAPS] {
        let mut x = [0.0; TAPS];
        for (w, weight) in self.grid {
            let (re, im) = folded(self.order, ahead, w);
            for (tap, x) in x.iter_mut().enumerate() {
                let (sin, cos) = (w * tap as f64).sin_cos();
                *x += weight * (re * cos - im * sin);
            }
        }
        for i in 0..TAPS {
            for k in 0..i {
                x[i] -= self.factor[i][k] * x[k];
            }
            x[i] /= self.factor[i][i];
        }
        for i in (0..TAPS).rev() {
            for k in i + 1..TAPS {
                x[i] -= self.factor[k][i] * x[k];
            }
            x[i] /= self.factor[i][i];
        }
        x
    }
}

/// Transform of the continuous signal minus that of its samples, at `w` radians a sample.
fn folded(order: usize, ahead: f64, w: f64) -> (f64, f64) {
    // The sampled transforms of all orders are the coefficients of s^order in e^(s(2 − a)) z² / (1 − z e^s), z = e^(−jω).
    let z = unit(-w);
    let z2 = unit(-2.0 * w);
    let first = (1.0 - z.0, -z.1);
    let mut sampled = [(0.0, 0.0); ORDERS];
    let mut power = 1.0;
    for p in 0..=order {
        let mut top = (z2.0 * power, z2.1 * power);
        let mut inverse_factorial = 1.0;
        for i in 1..=p {
            inverse_factorial /= i as f64;
            let term = product(z, sampled[p - i]);
            top = (top.0 + term.0 * inverse_factorial, top.1 + term.1 * inverse_factorial);
        }
        sampled[p] = quotient(top, first);
        power *= (2.0 - ahead) / (p + 1) as f64;
    }
    let mut whole = unit(-w * ahead);
    for _ in 0..=order {
        whole = quotient(whole, (0.0, w));
    }
    (whole.0 - sampled[order].0, whole.1 - sampled[order].1)
}

fn unit(angle: f64) -> (f64, f64) {
    (angle.cos(), angle.sin())
}

fn product(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn quotient(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let p = product(a, (b.0, -b.1));
    let d = b.0 * b.0 + b.1 * b.1;
    (p.0 / d, p.1 / d)
}

const RING: usize = 16;

/// The corrections under way on a group of lanes.
#[derive(Debug, Clone)]
pub struct Corrections<R> {
    rows: [[R; LANES]; RING],
    head: usize,
    /// Rows from the head on that may hold something.
    pending: usize,
    table: &'static Corner,
}

impl<R: Real> Corrections<R> {
    /// None under way. Computes the table if that has not been done.
    pub fn new() -> Self {
        Self { rows: [[R::ZERO; LANES]; RING], head: 0, pending: 0, table: Corner::prepare() }
    }

    /// Forgets what is under way on `lane`.
    pub fn clear(&mut self, lane: usize) {
        for row in &mut self.rows {
            row[lane] = R::ZERO;
        }
    }

    /// Derivatives 0, 1, … of the signal on `lane`, by samples, jump by `heights` at 1 to 2 samples after the next one.
    /// The signal's own samples must be those after the jump from the second after the next one on. Not-a-number and
    /// infinity count as no jump.
    pub fn add(&mut self, lane: usize, ahead: f64, heights: &[f64]) {
        let ahead = if ahead > 1.0 { ahead.min(2.0) } else { 1.0 };
        for (order, height) in heights.iter().enumerate().take(ORDERS) {
            if *height == 0.0 || !height.is_finite() {
                continue;
            }
            for (k, tap) in self.table.taps(order, ahead).into_iter().enumerate() {
                self.rows[(self.head + k) % RING][lane] += R::of(height * tap);
            }
            self.pending = TAPS;
        }
    }

    /// What is added to the next sample.
    #[inline(always)]
    pub fn next_row(&mut self) -> [R; LANES] {
        if self.pending == 0 {
            return [R::ZERO; LANES];
        }
        self.pending -= 1;
        let row = std::mem::replace(&mut self.rows[self.head], [R::ZERO; LANES]);
        self.head = (self.head + 1) % RING;
        row
    }

    /// Adds what is due to the next `output.len()` samples; the same as [`Corrections::next_row`] for each.
    #[inline(always)]
    pub fn apply(&mut self, output: &mut [[R; LANES]]) {
        let due = self.pending.min(output.len());
        for out in &mut output[..due] {
            let row = self.next_row();
            for l in 0..LANES {
                out[l] += row[l];
            }
        }
    }

    /// Whether nothing is under way on any lane.
    #[inline(always)]
    pub fn are_over(&self) -> bool {
        self.pending == 0
    }
}

impl<R: Real> Default for Corrections<R> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::{Corner, Corrections, ORDERS, TAPS};
    use crate::dsp::lanes::LANES;

    /// Largest error, dB relative to 1/ω^(order+1), of the corrected samples against the continuous transform, up to `edge`
    /// of the rate. The sampled signal is summed as it stands, with a slow exponential to make the sum end; the continuous
    /// one has the same, so this shares nothing with the design.
    fn error_db(order: usize, ahead: f64, edge: f64, taps: &[f64; TAPS]) -> f64 {
        let fade = 0.02;
        let factorial: f64 = (1..=order).map(|k| k as f64).product();
        let mut worst = 0.0_f64;
        for k in 1..=40 {
            let w = std::f64::consts::TAU * edge * f64::from(k) / 40.0;
            let (mut re, mut im) = (0.0, 0.0);
            for n in 0..4000 {
                let t = n as f64 - ahead;
                let mut value =
                    if n >= 2 { t.powi(order as i32) / factorial * (-fade * t).exp() } else { 0.0 };
                if n < TAPS {
                    value += residual(order, ahead, n, fade, taps);
                }
                re += value * (w * n as f64).cos();
                im -= value * (w * n as f64).sin();
            }
            // e^(−jωa) / (fade + jω)^(order+1)
            let size = (fade * fade + w * w).sqrt().powi(order as i32 + 1);
            let angle = -w * ahead - (order as f64 + 1.0) * w.atan2(fade);
            let (dr, di) = (re - angle.cos() / size, im - angle.sin() / size);
            worst = worst.max((dr * dr + di * di).sqrt() * size);
        }
        20.0 * worst.log10()
    }

    /// t^p e^(−ft) / p! jumps in its higher derivatives too: those are corrected by their orders.
    fn residual(order: usize, ahead: f64, n: usize, fade: f64, taps: &[f64; TAPS]) -> f64 {
        let table = Corner::prepare();
        let mut sum = taps[n];
        let (mut factor, mut choose) = (1.0, 1.0);
        for higher in order + 1..ORDERS {
            factor *= -fade;
            choose *= higher as f64 / (higher - order) as f64;
            sum += choose * factor * table.taps(higher, ahead)[n];
        }
        sum
    }

    #[test]
    fn corrected_jumps_of_every_order_have_the_spectrum_of_the_continuous_ones() {
        let table = Corner::prepare();
        let limits = [(-104.0, -67.0), (-113.0, -82.0), (-125.0, -94.0), (-120.0, -100.0)];
        for (order, (inner, outer)) in limits.into_iter().enumerate() {
            for k in 0..=64 {
                let ahead = 1.0 + f64::from(k) / 64.0;
                let taps = table.taps(order, ahead);
                let got = (error_db(order, ahead, 0.14, &taps), error_db(order, ahead, 0.25, &taps));
                assert!(got.0 < inner && got.1 < outer, "order {order}, {ahead}: {got:?}");
            }
        }
    }

    #[test]
    fn every_tap_matters() {
        for order in 0..2 {
            for tap in 0..TAPS {
                let mut taps = Corner::prepare().taps(order, 1.3);
                taps[tap] += 1e-4;
                assert!(error_db(order, 1.3, 0.14, &taps) > -95.0, "order {order}, tap {tap}");
            }
        }
    }

    #[test]
    fn corrections_come_out_once_on_their_lane_and_end() {
        let mut corrections = Corrections::<f64>::new();
        let table = Corner::prepare();
        for round in 0..40_usize {
            corrections.add(2, 1.5, &[2.0]);
            corrections.next_row();
            corrections.add(2, 1.25, &[0.0, 1.0]);
            corrections.add(5, 2.0, &[f64::NAN]);
            assert!(!corrections.are_over());
            for n in 1..TAPS + 1 + round % 5 {
                let row = corrections.next_row();
                let jump = if n < TAPS { 2.0 * table.taps(0, 1.5)[n] } else { 0.0 };
                let corner = if n <= TAPS { table.taps(1, 1.25)[n - 1] } else { 0.0 };
                for (lane, value) in row.into_iter().enumerate() {
                    assert_eq!(value, if lane == 2 { jump + corner } else { 0.0 }, "lane {lane}, sample {n}");
                }
            }
            assert!(corrections.are_over());
        }
    }

    #[test]
    fn a_block_gets_what_single_samples_get() {
        let (mut one, mut many) = (Corrections::<f32>::new(), Corrections::<f32>::new());
        let mut block = [[1.0_f32; LANES]; 30];
        for corrections in [&mut one, &mut many] {
            corrections.add(4, 1.1, &[1.0, -0.5, 0.25]);
        }
        many.apply(&mut block[..5]);
        many.apply(&mut block[5..]);
        for row in block {
            assert_eq!(row, one.next_row().map(|v| 1.0 + v));
        }
        one.add(4, 1.1, &[1.0]);
        one.clear(4);
        assert_eq!(one.next_row(), [0.0; LANES]);
    }
}
