//! The exponential of a small matrix.
//!
//! Scaling and squaring of Taylor's series (Moler & Van Loan, "Nineteen dubious ways ...", 2003, method 3), carried out on e^A − 1 rather
//! than on e^A: (1 + D)² − 1 = 2 D + D². So slow rates beside fast ones, which are small differences from 1, keep all their digits.

/// The largest size.
pub const MOST: usize = 8;
/// A square matrix of up to [`MOST`] rows; of what lies beyond its size, nothing is read.
pub type Square = [[f64; MOST]; MOST];
/// Norm to which a matrix is scaled, and the terms that bring the series below rounding there: 0.5^17 / 17! is 2e-20.
const NORM: f64 = 0.5;
const TERMS: usize = 16;
/// Enough for any norm that `f64` holds.
const MOST_SQUARINGS: i32 = 1030;
const SWEEPS: usize = 12;

/// e^(`a` `time`) − 1 of the first `size` rows and columns of `a`.
///
/// For `a` = [[A, B], [0, 0]] the result holds what an input held over `time` adds to the state: columns of B become those of
/// the zero-order hold. A matrix with an entry that is not finite gives zeros, as does a time that is not.
pub fn exponential(a: &Square, size: usize, time: f64) -> Square {
    let size = size.min(MOST);
    let mut x = [[0.0; MOST]; MOST];
    for i in 0..size {
        for j in 0..size {
            x[i][j] = a[i][j] * time;
            if !x[i][j].is_finite() {
                return [[0.0; MOST]; MOST];
            }
        }
    }
    let scale = balance(&mut x, size);
    let norm = (0..size).map(|i| (0..size).map(|j| x[i][j].abs()).sum::<f64>()).fold(0.0, f64::max);
    let mut squarings = 0;
    while squarings < MOST_SQUARINGS && norm > NORM * 2f64.powi(squarings) {
        squarings += 1;
    }
    let halves = [0.5f64.powi(squarings / 2), 0.5f64.powi(squarings - squarings / 2)];
    x[..size].iter_mut().for_each(|row| row[..size].iter_mut().for_each(|e| *e = *e * halves[0] * halves[1]));
    let mut sum = [[0.0; MOST]; MOST];
    for k in (1..=TERMS).rev() {
        // x/k (1 + sum), the series from its last term.
        let product = multiply(&x, &sum, size);
        for i in 0..size {
            for j in 0..size {
                sum[i][j] = (x[i][j] + product[i][j]) / k as f64;
            }
        }
    }
    for _ in 0..squarings {
        let square = multiply(&sum, &sum, size);
        for i in 0..size {
            for j in 0..size {
                sum[i][j] = 2.0 * sum[i][j] + square[i][j];
            }
        }
    }
    for i in 0..size {
        for j in 0..size {
            sum[i][j] *= scale[i] / scale[j];
        }
    }
    sum
}

fn multiply(a: &Square, b: &Square, size: usize) -> Square {
    let mut c = [[0.0; MOST]; MOST];
    for i in 0..size {
        for k in 0..size {
            for j in 0..size {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// Makes rows and columns about as large as each other (Osborne, 1960), by powers of two so that nothing is rounded; returns by what the
/// entry i, j has to be multiplied to undo it: `scale[i] / scale[j]`.
fn balance(x: &mut Square, size: usize) -> [f64; MOST] {
    let mut scale = [1.0; MOST];
    for _ in 0..SWEEPS {
        let mut still = true;
        for i in 0..size {
            let [row, column] = norms(x, size, i);
            if row > 0.0 && column > 0.0 {
                still &= rescale(x, &mut scale, size, i, (row / column).sqrt());
            }
        }
        if still {
            break;
        }
    }
    // What only drives, or is only driven, as large as the rest: no larger, so that it costs no squarings; no smaller, so that
    // what it drives does not underflow.
    let most = (0..size)
        .map(|i| x[i][i].abs().max(norms(x, size, i)[0].min(norms(x, size, i)[1])))
        .fold(0.0, f64::max);
    for i in 0..size {
        match norms(x, size, i) {
            [0.0, column] if column > 0.0 && most > 0.0 => rescale(x, &mut scale, size, i, most / column),
            [row, 0.0] if row > 0.0 && most > 0.0 => rescale(x, &mut scale, size, i, row / most),
            _ => true,
        };
    }
    scale
}

/// The largest entries of row and column `i`, but for the one in both.
fn norms(x: &Square, size: usize, i: usize) -> [f64; 2] {
    let others = || (0..size).filter(move |&j| j != i);
    [others().map(|j| x[i][j].abs()).fold(0.0, f64::max), others().map(|j| x[j][i].abs()).fold(0.0, f64::max)]
}

/// Multiplies column `i` by the power of two next to `factor`, and divides the row by it; says whether that changed nothing.
fn rescale(x: &mut Square, scale: &mut [f64; MOST], size: usize, i: usize, factor: f64) -> bool {
    let factor = power_of_two(factor);
    scale[i] *= factor;
    for j in 0..size {
        if j != i {
            x[j][i] *= factor;
            x[i][j] /= factor;
        }
    }
    factor == 1.0
}

/// The power of two next to a number, within 1e±150.
fn power_of_two(value: f64) -> f64 {
    2f64.powi(value.clamp(1e-150, 1e150).log2().round() as i32)
}

#[cfg(test)]
mod tests;
