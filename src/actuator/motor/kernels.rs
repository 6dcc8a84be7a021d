//! The functions that carry a linear system over a time: of a number, and of a matrix of two rows.
//!
//! ẋ = A x + p₀ + p₁ t + p₂ t²/2 from x₀ gives x(t) = x₀ + t φ₁(At)(A x₀ + p₀) + t² φ₂(At) p₁ + t³ φ₃(At) p₂ with
//! φₖ(z) = Σ zⁿ / (n + k)!, so that φₖ = 1/k! + z φₖ₊₁ (Hochbruck and Ostermann: "Exponential integrators", Acta Numerica 2010).
//! Nothing is divided by an eigenvalue that may be small, nor by the distance of two.

use crate::actuator::elementary::{cosine, exp, sine};

/// Where the largest |zt| is below this, a Taylor series serves.
const NEAR: f64 = 2.0;
/// Terms of that series: 2^23 / 27! is 8e-22.
const TERMS: usize = 24;

/// Terms below this are left out; the first is 1/24.
const LEAST: f64 = 1e-19;

/// 1 / n!
const INVERSE_FACTORIAL: [f64; TERMS + 5] = {
    let (mut all, mut n) = ([1.0; TERMS + 5], 1);
    while n < TERMS + 5 {
        all[n] = all[n - 1] / n as f64;
        n += 1;
    }
    all
};

/// Two rows of two.
pub(super) type Matrix = [[f64; 2]; 2];

/// φ₁ to φ₄ of a number that is not above 0.
pub(super) fn of_number(z: f64) -> [f64; 4] {
    if z.abs() > NEAR {
        let inverse = 1.0 / z;
        let one = (exp(z) - 1.0) * inverse;
        let two = (one - 1.0) * inverse;
        let three = (two - 0.5) * inverse;
        return [one, two, three, (three - INVERSE_FACTORIAL[3]) * inverse];
    }
    let (mut four, mut power) = (0.0, 1.0);
    for n in 0..TERMS {
        let term = power * INVERSE_FACTORIAL[n + 4];
        four += term;
        if term.abs() < LEAST {
            break;
        }
        power *= z;
    }
    let three = INVERSE_FACTORIAL[3] + z * four;
    let two = 0.5 + z * three;
    [1.0 + z * two, two, three, four]
}

/// φ₁ to φ₄ of a matrix, each as x times one matrix and y times another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kernels {
    /// By function: what of the first matrix and what of the second.
    share: [(f64, f64); 4],
    /// The two matrices.
    of: (Matrix, Matrix),
}

impl Kernels {
    /// φₖ times a vector, `k` from 1 to 4.
    #[inline]
    pub fn times(&self, k: usize, v: [f64; 2]) -> [f64; 2] {
        let ((x, y), (a, b)) = (self.share[k - 1], &self.of);
        [
            x * (a[0][0] * v[0] + a[0][1] * v[1]) + y * (b[0][0] * v[0] + b[0][1] * v[1]),
            x * (a[1][0] * v[0] + a[1][1] * v[1]) + y * (b[1][0] * v[0] + b[1][1] * v[1]),
        ]
    }
}

/// A matrix whose eigenvalues have no positive real part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    a: Matrix,
    trace: f64,
    determinant: f64,
    poles: Poles,
}

/// The eigenvalues.
#[derive(Debug, Clone, Copy)]
enum Poles {
    /// Far apart: the smaller, the larger, and the projections on their directions.
    Apart(f64, f64, (Matrix, Matrix)),
    /// Less than a factor of two apart, or equal: the smaller, the larger.
    Close(f64, f64),
    /// m ± i p.
    Turning(f64, f64),
}

const IDENTITY: Matrix = [[1.0, 0.0], [0.0, 1.0]];

impl Pair {
    /// Of a matrix and its determinant, which the caller knows better than a difference of products would.
    pub fn new(a: Matrix, determinant: f64) -> Self {
        let trace = a[0][0] + a[1][1];
        let middle = 0.5 * trace;
        let square = middle * middle - determinant;
        let poles = if square < 0.0 {
            Poles::Turning(middle, (-square).sqrt())
        } else {
            let fast = middle - square.sqrt();
            let slow = if fast == 0.0 { 0.0 } else { determinant / fast };
            if fast.abs() < 2.0 * slow.abs() || fast == 0.0 {
                Poles::Close(slow, fast)
            } else {
                Poles::Apart(slow, fast, projections(&a, slow, fast))
            }
        };
        Self { a, trace, determinant, poles }
    }

    /// The largest |eigenvalue|, 1/s.
    pub fn fastest(&self) -> f64 {
        match self.poles {
            Poles::Apart(_, fast, _) | Poles::Close(_, fast) => fast.abs(),
            Poles::Turning(..) => self.determinant.sqrt(),
        }
    }

    /// At what rate it turns, rad/s.
    pub fn turning(&self) -> f64 {
        if let Poles::Turning(_, p) = self.poles { p } else { 0.0 }
    }

    /// The kernels for a time.
    pub fn over(&self, t: f64) -> Kernels {
        if self.fastest() * t <= NEAR {
            return Kernels { share: self.series(t), of: (IDENTITY, scaled(&self.a, t, 0.0)) };
        }
        match self.poles {
            Poles::Apart(slow, fast, of) => {
                let (s, f) = (of_number(slow * t), of_number(fast * t));
                Kernels { share: std::array::from_fn(|k| (s[k], f[k])), of }
            }
            Poles::Close(slow, fast) => {
                Kernels { share: divided(slow * t, fast * t), of: (IDENTITY, scaled(&self.a, t, slow)) }
            }
            Poles::Turning(m, p) => {
                Kernels { share: turning(m * t, p * t), of: (IDENTITY, scaled(&self.a, t, m)) }
            }
        }
    }

    /// φₖ = x + y A t by powers of A t, each reduced with A² = trace A − determinant.
    fn series(&self, t: f64) -> [(f64, f64); 4] {
        let (trace, determinant) = (self.trace * t, self.determinant * t * t);
        let (mut u, mut v) = (1.0, 0.0);
        let mut four = (0.0, 0.0);
        for n in 0..TERMS {
            four.0 += u * INVERSE_FACTORIAL[n + 4];
            four.1 += v * INVERSE_FACTORIAL[n + 4];
            if (u.abs() + v.abs()) * INVERSE_FACTORIAL[n + 4] < LEAST {
                break;
            }
            (u, v) = (-determinant * v, u + trace * v);
        }
        let up = |k: usize, (x, y): (f64, f64)| (INVERSE_FACTORIAL[k] - determinant * y, x + trace * y);
        let three = up(3, four);
        let two = up(2, three);
        [up(1, two), two, three, four]
    }
}

/// t (A − shift).
fn scaled(a: &Matrix, t: f64, shift: f64) -> Matrix {
    [[t * (a[0][0] - shift), t * a[0][1]], [t * a[1][0], t * (a[1][1] - shift)]]
}

/// The projections on the directions of the slow and the fast eigenvalue. What is small of them is not taken as a difference of
/// what is large: the eigenvalues add up to the trace.
fn projections(a: &Matrix, slow: f64, fast: f64) -> (Matrix, Matrix) {
    let distance = slow - fast;
    let first = a[0][0].abs() > a[1][1].abs();
    let [one, two] = if first { [slow - a[1][1], a[1][1] - fast] } else { [a[0][0] - fast, slow - a[0][0]] };
    let (x, y) = (a[0][1] / distance, a[1][0] / distance);
    let (one, two) = (one / distance, two / distance);
    ([[one, x], [y, two]], [[two, -x], [-y, one]])
}

/// Newton's form for eigenvalues a, b times t that lie close: φₖ(a) and the divided difference φₖ\[a, b\].
fn divided(a: f64, b: f64) -> [(f64, f64); 4] {
    let at = of_number(a);
    let mut difference = exp(a) * of_number(b - a)[0];
    at.map(|value| {
        difference = (difference - value) / b;
        (value, difference)
    })
}

/// For eigenvalues x ± i y times t: real part of φₖ, and imaginary part over y.
fn turning(x: f64, y: f64) -> [(f64, f64); 4] {
    let (size, turns) = (exp(x), y * (0.5 / std::f64::consts::PI));
    let (inverse, bend) = (1.0 / (x * x + y * y), y * y);
    let flat = if y.abs() < 1e-4 { 1.0 - bend / 6.0 } else { sine(turns) / y };
    let (mut c, mut s) = (size * cosine_of(turns), size * flat);
    std::array::from_fn(|k| {
        let rest = c - INVERSE_FACTORIAL[k];
        (c, s) = ((x * rest + bend * s) * inverse, (x * s - rest) * inverse);
        (c, s)
    })
}

/// Cosine of any number of turns.
fn cosine_of(turns: f64) -> f64 {
    cosine(crate::actuator::elementary::wrapped(turns).0)
}
