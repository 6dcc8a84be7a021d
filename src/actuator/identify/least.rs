//! Least squares: linear and not, and how far off the result may be.

use crate::dsp::student;

/// A square matrix, row by row.
type Matrix = Vec<Vec<f64>>;

/// Blocks over which what a fit leaves counts as connected.
const BLOCKS: usize = 12;
/// Share of the residuals over which their correlation is followed, and the most work that is spent on it.
const FOLLOWED: usize = 8;
const WORK: usize = 100_000_000;
/// The most that a residual may have of the last one.
const MOST_CARRIED: f64 = 0.98;
/// The most by which that widens a covariance.
const MOST_MORE: f64 = 4.0;
/// A pivot below this share of its diagonal: nothing depends on it alone.
const SINGULAR: f64 = 1e-12;
/// Steps of a descent, and by what its damping changes.
const STEPS: usize = 60;
const EASE: f64 = 0.2;
/// A step that takes off less than this share of the squares is the last.
const ENOUGH: f64 = 1e-8;
const STIFFEN: f64 = 5.0;

/// The result of a fit.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// The parameters.
    pub values: Vec<f64>,
    /// Covariances: as if what is left were white; as its blocks are (White, 1980, with blocks as clusters); as its correlation is
    /// (Newey & West, 1987, of all residuals as one).
    covariances: [Matrix; 3],
    /// Mean square of what is left, by degrees of freedom.
    pub left: f64,
    /// By how many deviations an interval of 95 % reaches.
    reach: f64,
}

impl Fit {
    /// How far off a combination of the parameters may be, with 95 % probability: by the worst of the covariances.
    pub fn off(&self, gradient: &[f64]) -> f64 {
        let of = |matrix: &Matrix| {
            let row = |r: &Vec<f64>| r.iter().zip(gradient).map(|(m, g)| m * g).sum::<f64>();
            matrix.iter().zip(gradient).map(|(r, g)| g * row(r)).sum::<f64>().max(0.0)
        };
        self.reach * self.covariances.iter().map(of).fold(0.0, f64::max).sqrt()
    }

    /// The same of a function of the parameters, its gradient taken by differences.
    pub fn off_of(&self, function: impl Fn(&[f64]) -> f64) -> f64 {
        let mut values = self.values.clone();
        let gradient: Vec<f64> = (0..values.len())
            .map(|n| {
                let (at, step) = (values[n], 1e-5 * values[n].abs().max(1e-12));
                let ends = [1.0, -1.0].map(|sign| {
                    values[n] = at + sign * step;
                    function(&values)
                });
                values[n] = at;
                (ends[0] - ends[1]) / (2.0 * step)
            })
            .collect();
        self.off(&gradient)
    }
}

/// The inverse of a symmetric matrix with a positive diagonal; `None` where it has none.
pub(super) fn inverse(matrix: &Matrix) -> Option<Matrix> {
    let size = matrix.len();
    let scale: Vec<f64> = (0..size).map(|n| 1.0 / matrix[n][n].sqrt()).collect();
    if !scale.iter().all(|s| s.is_finite()) {
        return None;
    }
    let mut rows: Matrix = (0..size)
        .map(|i| {
            let mut row: Vec<f64> = (0..size).map(|j| matrix[i][j] * scale[i] * scale[j]).collect();
            row.extend((0..size).map(|j| if i == j { 1.0 } else { 0.0 }));
            row
        })
        .collect();
    for n in 0..size {
        let pivot = (n..size).max_by(|a, b| rows[*a][n].abs().total_cmp(&rows[*b][n].abs()))?;
        rows.swap(n, pivot);
        let by = rows[n][n];
        if by.abs() <= SINGULAR || by.is_nan() {
            return None;
        }
        rows[n].iter_mut().for_each(|x| *x /= by);
        let from = rows[n].clone();
        for (i, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != n) {
            debug_assert_ne!(i, n);
            let by = row[n];
            row.iter_mut().zip(&from).for_each(|(x, f)| *x -= by * f);
        }
    }
    Some((0..size).map(|i| (0..size).map(|j| rows[i][size + j] * scale[i] * scale[j]).collect()).collect())
}

/// Solves A x = b for a symmetric A with a positive diagonal.
pub(super) fn solve(matrix: &Matrix, right: &[f64]) -> Option<Vec<f64>> {
    let inverse = inverse(matrix)?;
    Some(inverse.iter().map(|row| row.iter().zip(right).map(|(a, b)| a * b).sum()).collect())
}

/// The x that makes the rows' sums of squares |row · x − value| the least.
pub(super) fn linear(rows: impl Iterator<Item = (Vec<f64>, f64)>, size: usize) -> Option<Vec<f64>> {
    let (mut matrix, mut right) = (vec![vec![0.0; size]; size], vec![0.0; size]);
    for (row, value) in rows {
        for i in 0..size {
            right[i] += row[i] * value;
            for j in 0..size {
                matrix[i][j] += row[i] * row[j];
            }
        }
    }
    solve(&matrix, &right)
}

fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// The parameters near `start` that make the sum of squares of `residuals` the least (Levenberg and Marquardt), and how far off they may be.
///
/// `residuals` gives as many numbers each time, or `None` where the parameters cannot be; `steps` are those of the differences that
/// stand for derivatives. `None`: the start cannot be, or something does not depend on the parameters.
pub(super) fn descend(
    start: &[f64],
    steps: &[f64],
    mut residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<Fit> {
    let size = start.len();
    let mut values = start.to_vec();
    let mut rest = residuals(&values)?;
    let (mut damping, mut done) = (1e-3, false);
    let mut sides: Vec<Vec<f64>> = Vec::new();
    for _ in 0..STEPS {
        sides.clear();
        for n in 0..size {
            let mut moved = values.clone();
            moved[n] += steps[n];
            let by = steps[n];
            sides.push(residuals(&moved)?.iter().zip(&rest).map(|(m, r)| (m - r) / by).collect());
        }
        if done {
            break;
        }
        let (normal, slope) = normal(&sides, &rest);
        let before = squares(&rest);
        done = true;
        for _ in 0..12 {
            let mut stiff = normal.clone();
            (0..size).for_each(|n| stiff[n][n] *= 1.0 + damping);
            let step = solve(&stiff, &slope)?;
            let moved: Vec<f64> = values.iter().zip(&step).map(|(v, s)| v - s).collect();
            let better = residuals(&moved).filter(|r| squares(r) <= before);
            if let Some(better) = better {
                let gain = before - squares(&better);
                (values, rest, damping) = (moved, better, damping * EASE);
                done = gain <= ENOUGH * before;
                break;
            }
            damping *= STIFFEN;
        }
    }
    let (normal, _) = normal(&sides, &rest);
    let plain = inverse(&normal)?;
    let degrees = rest.len().checked_sub(size).filter(|d| *d > 0)?;
    let left = squares(&rest) / degrees as f64;
    let blocks = BLOCKS.min(rest.len() / 2).max(1);
    let few = blocks as f64 / (blocks as f64 - 1.0).max(1.0) * rest.len() as f64 / degrees as f64;
    let blocked = scaled(&around(&plain, &in_blocks(&sides, &rest, blocks)), few);
    let (lags, connected) = in_lags(&sides, &rest);
    // What is connected counts as fewer: parameters take more of it with them.
    let count = rest.len() as f64 / connected;
    let free = (count - size as f64).max(2.0);
    // Weights that fade out take a part of what is connected for noise.
    let more = (carried(&rest) / connected).clamp(1.0, MOST_MORE);
    let followed = scaled(&around(&plain, &lags), more * count.max(free) / free);
    let covariances = [scaled(&plain, left), blocked, followed];
    Some(Fit {
        values,
        covariances,
        left,
        reach: student::quantile((blocks - 1).min(degrees).min(free as usize).max(1)),
    })
}

/// The sum over blocks of what each adds to the slope, squared.
fn in_blocks(sides: &[Vec<f64>], rest: &[f64], blocks: usize) -> Matrix {
    let size = sides.len();
    let mut sum = vec![vec![0.0; size]; size];
    for block in 0..blocks {
        let range = block * rest.len() / blocks..(block + 1) * rest.len() / blocks;
        let part = |side: &Vec<f64>| dot(&side[range.clone()], &rest[range.clone()]);
        let score: Vec<f64> = sides.iter().map(part).collect();
        for i in 0..size {
            (0..size).for_each(|j| sum[i][j] += score[i] * score[j]);
        }
    }
    sum
}

/// The same expected from the autocovariance of the residuals, which fades out over the lags (Bartlett's weights); and how many of them, at
/// least one, go together.
fn in_lags(sides: &[Vec<f64>], rest: &[f64]) -> (Matrix, f64) {
    let (size, count) = (sides.len(), rest.len());
    let most = (count / FOLLOWED).min(WORK / (count * size * size)).max(1);
    let mut sum = vec![vec![0.0; size]; size];
    let (mut square, mut connected) = (0.0, 1.0);
    for lag in 0..=most {
        let weight = 1.0 - lag as f64 / (most as f64 + 1.0);
        let together = weight * dot(&rest[lag..], &rest[..count - lag]) / count as f64;
        (square, connected) =
            if lag == 0 { (together, 1.0) } else { (square, connected + 2.0 * together / square) };
        for i in 0..size {
            for j in 0..size {
                let both = dot(&sides[i][lag..], &sides[j][..count - lag]) * together;
                sum[i][j] += both;
                if lag > 0 {
                    sum[j][i] += both;
                }
            }
        }
    }
    let connected = if connected > 1.0 { connected } else { 1.0 };
    (sum, connected)
}

/// How much more a mean of residuals varies than one of white ones, if each is ρ times the last and something new: (1 + ρ)/(1 − ρ). ρ comes
/// out too small by (1 + 3 ρ)/n (Kendall, 1954).
fn carried(rest: &[f64]) -> f64 {
    let count = rest.len() as f64;
    let is = dot(&rest[1..], &rest[..rest.len() - 1]) / dot(rest, rest);
    let share = is + (1.0 + 3.0 * is) / count;
    if is * count.sqrt() > 2.0 { (1.0 + share) / (1.0 - share.min(MOST_CARRIED)) } else { 1.0 }
}

fn around(outer: &Matrix, inner: &Matrix) -> Matrix {
    times(&times(outer, inner), outer)
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |row: &[f64], j: usize| row.iter().zip(b).map(|(x, other)| x * other[j]).sum();
    a.iter().map(|row| (0..b.len()).map(|j| entry(row, j)).collect()).collect()
}

fn scaled(matrix: &Matrix, by: f64) -> Matrix {
    matrix.iter().map(|row| row.iter().map(|x| x * by).collect()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// JᵀJ and Jᵀr.
fn normal(sides: &[Vec<f64>], rest: &[f64]) -> (Matrix, Vec<f64>) {
    let matrix = sides.iter().map(|a| sides.iter().map(|b| dot(a, b)).collect()).collect();
    (matrix, sides.iter().map(|a| dot(a, rest)).collect())
}

#[cfg(test)]
mod tests;
