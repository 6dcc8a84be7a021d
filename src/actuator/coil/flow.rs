//! The exact flow of a linear system over a time, its inputs held.

use super::plant::System;
use crate::actuator::exponential::{MOST, exponential};

/// From a state of `N` numbers to the one a fixed time later, the drive held: x + (e^(A h) − 1) x + Γ (drive, 1).
#[derive(Debug, Clone, Copy)]
pub(super) struct Flow<const N: usize> {
    /// e^(A h) − 1.
    change: [[f64; N]; N],
    /// What the drive and the steady force add.
    drive: [f64; N],
    steady: [f64; N],
}

impl<const N: usize> Flow<N> {
    /// Over `time` seconds.
    pub fn new(system: &System, time: f64) -> Self {
        let d = exponential(&system.matrix, N + 2, time);
        Self {
            change: std::array::from_fn(|i| std::array::from_fn(|j| d[i][j])),
            drive: std::array::from_fn(|i| d[i][N]),
            steady: std::array::from_fn(|i| d[i][N + 1]),
        }
    }

    /// The state after it, without the steady force.
    #[inline(always)]
    pub fn driven(&self, x: &[f64; N], drive: f64) -> [f64; N] {
        std::array::from_fn(|i| tree(&self.change[i], x, x[i] + self.drive[i] * drive))
    }

    /// The state after it.
    #[inline(always)]
    pub fn after(&self, x: &[f64; N], drive: f64) -> [f64; N] {
        let mut y = self.driven(x, drive);
        for i in 0..N {
            y[i] += self.steady[i];
        }
        y
    }
}

/// A sum of products and of `more`, in pairs: one waits for another as little as can be.
#[inline(always)]
fn tree<const N: usize>(weights: &[f64; N], x: &[f64; N], more: f64) -> f64 {
    let term = |j: usize| weights[j] * x[j];
    match N {
        2 => (term(0) + term(1)) + more,
        3 => (term(0) + term(1)) + (term(2) + more),
        4 => (term(0) + term(1)) + ((term(2) + term(3)) + more),
        _ => ((term(0) + term(1)) + (term(2) + term(3))) + ((4..N).map(term).sum::<f64>() + more),
    }
}

/// How far y and ẏ may get from where they are within a time: bounds for each unit of state and inputs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach<const N: usize> {
    state: [[f64; N]; 2],
    drive: [f64; 2],
    steady: [f64; 2],
}

/// For what happens between the points at which the flow is looked at, which are close to each other.
const MARGIN: f64 = 1.25;

impl<const N: usize> Reach<N> {
    /// For `time`, its half, its quarter and so on, `count` of them; the shortest is short for everything that moves.
    pub fn halvings(system: &System, time: f64, count: usize) -> Vec<Self> {
        let finest = time * 0.5f64.powi(count as i32 - 1);
        let step = exponential(&system.matrix, N + 2, finest);
        let (mut d, mut most) = (step, [[0.0f64; MOST]; 2]);
        let mut all = Vec::with_capacity(count);
        for k in 1..=1usize << (count - 1) {
            for row in 0..2 {
                for j in 0..N + 2 {
                    most[row][j] = most[row][j].max(MARGIN * d[row][j].abs());
                }
            }
            if k.is_power_of_two() {
                let of = |j: usize| [most[0][j], most[1][j]];
                let state = std::array::from_fn(|row| std::array::from_fn(|j| most[row][j]));
                all.push(Self { state, drive: of(N), steady: of(N + 1) });
            }
            // Rows of y and ẏ alone: (1 + d) (1 + step) − 1.
            let last = d;
            for row in 0..2 {
                for j in 0..N + 2 {
                    let sum: f64 = (0..N + 2).map(|l| last[row][l] * step[l][j]).sum();
                    d[row][j] = last[row][j] + step[row][j] + sum;
                }
            }
        }
        all.reverse();
        all
    }

    /// Bounds on |y(t) − y| and |ẏ(t) − ẏ|.
    #[inline(always)]
    pub fn of(&self, x: &[f64; N], drive: f64) -> [f64; 2] {
        std::array::from_fn(|row| {
            let mut sum = self.steady[row] + self.drive[row] * drive.abs();
            for j in 0..N {
                sum += self.state[row][j] * x[j].abs();
            }
            sum
        })
    }
}
