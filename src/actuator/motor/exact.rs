//! For tests: arithmetic with 106 bits, and the exponential of a matrix in it.

use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

/// The unevaluated sum of two numbers, the second within half a unit of the last place of the first (Dekker, 1971).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Twice(pub f64, pub f64);

impl Twice {
    pub fn of(x: f64) -> Self {
        Self(x, 0.0)
    }

    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let c = s - a;
        Self(s, (a - (s - c)) + (b - c))
    }

    fn product(a: f64, b: f64) -> Self {
        let split = |x: f64| {
            let c = 134_217_729.0 * x;
            let high = c - (c - x);
            (high, x - high)
        };
        let (p, (ah, al), (bh, bl)) = (a * b, split(a), split(b));
        Self(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
    }

    /// The quotient, by two steps of long division and one more.
    pub fn over(self, d: Self) -> Self {
        let first = self.0 / d.0;
        let rest = self - d * Self::of(first);
        let second = rest.0 / d.0;
        let rest = rest - d * Self::of(second);
        Self::of(first) + Self::of(second) + Self::of(rest.0 / d.0)
    }
}

impl Add for Twice {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (s, t) = (Self::sum(self.0, o.0), Self::sum(self.1, o.1));
        let s = Self::sum(s.0, s.1 + t.0);
        Self::sum(s.0, s.1 + t.1)
    }
}

impl Neg for Twice {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Twice {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Twice {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = Self::product(self.0, o.0);
        Self::sum(p.0, p.1 + (self.0 * o.1 + self.1 * o.0))
    }
}

pub(super) type Square<const N: usize> = [[Twice; N]; N];

fn product<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    from_fn(|r| from_fn(|c| (0..N).fold(Twice::of(0.0), |sum, k| sum + a[r][k] * b[k][c])))
}

/// e^m, by 30 terms of Taylor's series of m / 2^n and n squarings.
pub(super) fn exponential<const N: usize>(m: &Square<N>) -> Square<N> {
    let norm = m.iter().map(|row| row.iter().map(|x| x.0.abs()).sum::<f64>()).fold(0.0, f64::max);
    let halvings = (norm.log2().ceil() + 2.0).max(0.0) as i32;
    let scale = Twice::of(0.5_f64.powi(halvings));
    let small: Square<N> = m.map(|row| row.map(|x| x * scale));
    let one: Square<N> = from_fn(|r| from_fn(|c| Twice::of(f64::from(u8::from(r == c)))));
    let mut sum = one;
    for n in (1..30).rev() {
        let next = product(&small, &sum);
        sum = from_fn(|r| from_fn(|c| one[r][c] + next[r][c].over(Twice::of(f64::from(n)))));
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    sum
}

#[test]
fn it_knows_e_and_a_rotation() {
    let e = exponential(&[[Twice::of(1.0)]])[0][0];
    // e − 2.718281828459045 (nearest f64), to 32 digits.
    assert_eq!(e.0, std::f64::consts::E);
    assert!((e.1 - 1.445_646_891_729_250_2e-16).abs() < 1e-30, "{e:?}");
    let turn = Twice::of(3.0).over(Twice::of(2.0)) * Twice::of(2.0);
    let zero = Twice::of(0.0);
    let r = exponential(&[[zero, -turn], [turn, zero]]);
    assert!((r[0][0].0 - 3f64.cos()).abs() < 1e-15 && (r[1][0].0 - 3f64.sin()).abs() < 1e-15);
}
