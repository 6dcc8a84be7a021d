//! How the voltage can be let go so that nothing goes beyond a stroke.

/// A way to let the voltage go: to a share ρ of it at each sample. So it is known what moves along, G for each volt.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way<const N: usize> {
    pub keep: f64,
    /// What a volt adds to the state, less G.
    pub rest: [f64; N],
    /// |G_y|.
    pub cost: f64,
}

impl<const N: usize> Way<N> {
    /// ‖free + rest V‖ + cost |V|: while the voltage is let go, no displacement is more.
    pub fn size(&self, free: &[f64; N], volts: f64) -> f64 {
        let z: [f64; N] = std::array::from_fn(|i| free[i] + self.rest[i] * volts);
        dot(&z, &z).sqrt() + self.cost * volts.abs()
    }

    /// Whether that is within the stroke.
    #[inline(always)]
    pub fn admits(&self, stroke: f64, free: &[f64; N], volts: f64) -> bool {
        let room = stroke - self.cost * volts.abs();
        let z: [f64; N] = std::array::from_fn(|i| free[i] + self.rest[i] * volts);
        room >= 0.0 && dot(&z, &z) <= room * room
    }

    /// The last drive admitted on the way from a safe one to one that is not.
    pub fn farthest(&self, stroke: f64, free: &[f64; N], safe: f64, wanted: f64) -> f64 {
        if safe * wanted >= 0.0 {
            self.side(stroke, free, safe, wanted)
        } else if self.admits(stroke, free, 0.0) {
            self.side(stroke, free, 0.0, wanted)
        } else {
            self.side(stroke, free, safe, 0.0)
        }
    }

    /// The same where both have one sign, σ: (r² − c²) V² + 2 (f r + s c σ) V + f² − s² = 0.
    fn side(&self, s: f64, free: &[f64; N], safe: f64, wanted: f64) -> f64 {
        let c = self.cost;
        let sign = if safe + wanted < 0.0 { -1.0 } else { 1.0 };
        // Around the safe drive, so that little cancels.
        let at: [f64; N] = std::array::from_fn(|i| free[i] + self.rest[i] * safe);
        let room = s - c * safe.abs();
        let a = dot(&self.rest, &self.rest) - c * c;
        let b = dot(&at, &self.rest) + room * c * sign;
        let left = (room * room - dot(&at, &at)).max(0.0);
        // a t² + 2 b t = left, the first t on the way.
        let way = if wanted < safe { -1.0 } else { 1.0 };
        let (b, most) = (b * way, (wanted - safe).abs());
        let inside = (b * b + a * left).max(0.0).sqrt();
        let t = if b > 0.0 {
            left / (b + inside)
        } else if a > 0.0 {
            (inside - b) / a
        } else {
            // Only by rounding: what is not admitted lies on the way, so it would end.
            0.0
        };
        safe + way * if t < most { t } else { most }
    }
}

/// A sum of products.
#[inline(always)]
pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum += a[i] * b[i];
    }
    sum
}

/// Solves M x = b by elimination; `None` where M is singular.
pub(super) fn solve<const N: usize>(mut m: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let pivot = (column..N).max_by(|&i, &j| m[i][column].abs().total_cmp(&m[j][column].abs()))?;
        m.swap(column, pivot);
        b.swap(column, pivot);
        for i in column + 1..N {
            let factor = m[i][column] / m[column][column];
            for j in column..N {
                m[i][j] -= factor * m[column][j];
            }
            b[i] -= factor * b[column];
        }
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|j| m[i][j] * b[j]).sum();
        b[i] = (b[i] - sum) / m[i][i];
    }
    b.iter().all(|x| x.is_finite()).then_some(b)
}

#[cfg(test)]
mod tests {
    use super::{Way, solve};

    #[test]
    fn a_system_is_solved_and_a_singular_one_refused() {
        let x = solve([[0.0, 2.0, 0.0], [1.0, 0.0, 1.0], [3.0, 0.0, -1.0]], [4.0, 4.0, 0.0]).unwrap();
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(is, should)| (is - should).abs() < 1e-15), "{x:?}");
        assert!(solve([[1.0, 2.0], [2.0, 4.0]], [1.0, 1.0]).is_none());
    }

    /// By the definition: in small steps from the safe drive to the one wanted, until one is not admitted; of either sign, and through none.
    #[test]
    fn the_farthest_is_the_last_that_is_admitted_on_the_way() {
        let (mut through, mut short) = (0, 0);
        for cost in [0.0, 0.2] {
            let way = Way { keep: 0.5, rest: [0.8, 0.3], cost };
            for free in [[-0.5, 0.0], [0.4, -0.3], [0.0, 0.0], [0.0, 0.95]] {
                for safe in [-0.6, -0.2, 0.0, 0.3] {
                    for wanted in [-4.0, -0.9, 1.1, 5.0] {
                        if !way.admits(1.0, &free, safe) || way.admits(1.0, &free, wanted) {
                            continue;
                        }
                        let step = (wanted - safe) / 200_000.0;
                        let at = |n: u32| safe + step * f64::from(n);
                        let last =
                            (0..=200_000).take_while(|n| way.admits(1.0, &free, at(*n))).last().unwrap();
                        let is = way.farthest(1.0, &free, safe, wanted);
                        assert!(
                            (is - at(last)).abs() <= 2.0 * step.abs() + 1e-9,
                            "{free:?} {safe} {wanted}: {is}"
                        );
                        through += u32::from(is * safe < 0.0);
                        short += u32::from(is * wanted < 0.0);
                    }
                }
            }
        }
        assert!(through > 5, "{through} {short}");
    }
}
