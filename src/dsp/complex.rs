//! Complex numbers, for frequency responses and poles.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A complex number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// The number `re + j im`.
    pub const fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// The Laplace variable of a steady oscillation, j 2π `hertz`.
    pub fn oscillation(hertz: f64) -> Self {
        Self::new(0.0, std::f64::consts::TAU * hertz)
    }

    /// The unit vector at an angle (radians).
    pub fn turned(angle: f64) -> Self {
        Self::new(angle.cos(), angle.sin())
    }

    /// Absolute value.
    pub fn abs(self) -> f64 {
        self.re.hypot(self.im)
    }

    /// Angle (radians, ±π).
    pub fn angle(self) -> f64 {
        self.im.atan2(self.re)
    }

    /// e to this power.
    pub fn exp(self) -> Self {
        Self::turned(self.im) * self.re.exp()
    }
}

impl From<f64> for Complex {
    fn from(re: f64) -> Self {
        Self::new(re, 0.0)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.re + o.re, self.im + o.im)
    }
}

impl Add<f64> for Complex {
    type Output = Self;
    fn add(self, o: f64) -> Self {
        Self::new(self.re + o, self.im)
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.re - o.re, self.im - o.im)
    }
}

impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(self.re * o.re - self.im * o.im, self.re * o.im + self.im * o.re)
    }
}

impl Mul<f64> for Complex {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        Self::new(self.re * o, self.im * o)
    }
}

impl Div for Complex {
    type Output = Self;
    /// After Smith (1962), so that neither square overflows.
    fn div(self, o: Self) -> Self {
        if o.re.abs() >= o.im.abs() {
            let (ratio, scale) = (o.im / o.re, o.re + o.im * (o.im / o.re));
            Self::new((self.re + self.im * ratio) / scale, (self.im - self.re * ratio) / scale)
        } else {
            let (ratio, scale) = (o.re / o.im, o.re * (o.re / o.im) + o.im);
            Self::new((self.re * ratio + self.im) / scale, (self.im * ratio - self.re) / scale)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Complex;

    #[test]
    fn a_quotient_times_its_divisor_is_the_dividend() {
        for (a, b) in
            [((3.0, -1.0), (0.5, 2.0)), ((1e200, 1e200), (2e200, -1e199)), ((1.0, 0.0), (0.0, -4.0))]
        {
            let (a, b) = (Complex::new(a.0, a.1), Complex::new(b.0, b.1));
            assert!((a / b * b - a).abs() <= 1e-15 * a.abs(), "{a:?} {b:?}");
        }
        let turn = Complex::new(0.0, std::f64::consts::PI).exp();
        assert!((turn + 1.0).abs() < 1e-15 && (Complex::turned(1.0).angle() - 1.0).abs() < 1e-15);
        assert_eq!((-Complex::oscillation(0.5)).im, -std::f64::consts::PI);
    }
}
