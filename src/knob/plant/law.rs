//! The motion of one inertia between events, in closed form.
//!
//! J p̈ + B ṗ + K p = τ with τ held. Its speed v = ṗ follows the same equation without τ, so from v(0) and v̇(0) alone
//! v = v(0) c + v̇(0) h and p = p(0) + v(0) (h + 2a H) + v̇(0) H, where h is the impulse response, H its integral, c = ḣ + 2a h,
//! 2a = B/J and w² = K/J. Over-damped, critically damped and springless motion (w = 0) are the same formulas, and written as
//! changes they lose no digits where a step is short.

use crate::actuator::elementary::{cosine, exp, exp_m1, ln, sine};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Below this 2at and wt, the power series is used: its terms then fall by more than half each.
const SHORT: f64 = 0.4;
const TERMS: usize = 16;

/// 1 / n
const INVERSE: [f64; TERMS + 1] = {
    let (mut all, mut n) = ([1.0; TERMS + 1], 1);
    while n <= TERMS {
        all[n] = 1.0 / n as f64;
        n += 1;
    }
    all
};

/// One inertia with what is proportional to its speed and its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Law {
    /// a = B / 2J, 1/s.
    half: f64,
    /// w² = K / J, 1/s².
    square: f64,
    /// √|w² − a²|, and whether it oscillates.
    root: f64,
    oscillates: bool,
    /// The slower of the two rates where it does not oscillate.
    slow: f64,
}

/// What a time does to speed and position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Over {
    /// Speed from speed, c.
    pub keeps: f64,
    /// Speed from acceleration, h, seconds.
    pub gains: f64,
    /// Position from speed, h + 2a H, seconds.
    pub goes: f64,
    /// Position from acceleration, H, seconds squared.
    pub bends: f64,
}

impl Law {
    /// Inertia (kg m², above 0), damping (N m s) and stiffness (N m).
    pub fn new(inertia: f64, damping: f64, stiffness: f64) -> Self {
        let (half, square) = (0.5 * damping / inertia, stiffness / inertia);
        let difference = square - half * half;
        let root = difference.abs().sqrt();
        let oscillates = difference > 0.0;
        let fast = half + root;
        let slow = if oscillates || fast == 0.0 { 0.0 } else { square / fast };
        Self { half, square, root, oscillates, slow }
    }

    /// The change of acceleration a second, from speed and acceleration.
    pub fn jerk(&self, speed: f64, acceleration: f64) -> f64 {
        -2.0 * self.half * acceleration - self.square * speed
    }

    /// Half of its period, s, where it oscillates.
    pub fn half_period(&self) -> Option<f64> {
        self.oscillates.then(|| PI / self.root)
    }

    /// What a time of `t` seconds does, 0 or more.
    pub fn over(&self, t: f64) -> Over {
        let (a, square) = (self.half, self.square);
        if 2.0 * a * t < SHORT && square * t * t < SHORT * SHORT {
            return self.series(t);
        }
        let (gains, keeps) = if self.oscillates {
            let (turns, decay) = (self.root * t / TAU, exp(-a * t));
            let swing = sine(turns) / self.root;
            (decay * swing, decay * (cosine(turns) + a * swing))
        } else {
            let decay = exp(-self.slow * t);
            let apart = 2.0 * self.root;
            // Two rates that are one.
            let spread = if apart * t < 1e-9 { t } else { -exp_m1(-apart * t) / apart };
            (decay * spread, decay * (1.0 + self.slow * spread))
        };
        if square == 0.0 {
            return Over { keeps: 1.0, gains, goes: t, bends: (t - gains) / (2.0 * a) };
        }
        let bends = (1.0 - keeps) / square;
        Over { keeps, gains, goes: gains + 2.0 * a * bends, bends }
    }

    fn series(&self, t: f64) -> Over {
        let (damping, spring) = (-2.0 * self.half * t, -self.square * t * t);
        // Derivatives of h at 0 times t^k / k!, in units of t: 0, 1, then by the equation.
        let (mut before, mut now) = (0.0, 1.0);
        let (mut gains, mut bends) = (1.0, 0.5);
        for k in 2..TERMS {
            let next = (damping * now + spring * INVERSE[k - 1] * before) * INVERSE[k];
            gains += next;
            bends += next * INVERSE[k + 1];
            (before, now) = (now, next);
        }
        let (gains, bends) = (gains * t, bends * t * t);
        let goes = if self.square == 0.0 { t } else { gains + 2.0 * self.half * bends };
        Over { keeps: 1.0 - self.square * bends, gains, goes, bends }
    }

    /// The first time after now at which what starts as `value` and changes by `rate` a second, and follows the equation without
    /// a torque, is zero.
    pub fn zero(&self, value: f64, rate: f64) -> Option<f64> {
        let slope = rate + self.half * value;
        let time = if self.oscillates {
            if value == 0.0 {
                return self.half_period();
            }
            angle(value.abs() * self.root, if value > 0.0 { -slope } else { slope }) / self.root
        } else {
            let z = -value / slope;
            let x = self.root * z;
            // Written so that what is no number is no zero either.
            if !(z > 0.0 && x < 1.0) {
                return None;
            }
            if x < 1e-5 { z * (1.0 + x * x / 3.0) } else { 0.5 * log_1p(2.0 * x / (1.0 - x)) / self.root }
        };
        (time > 0.0 && time.is_finite()).then_some(time)
    }
}

/// ln(1 + x) for x > 0 without losing the digits of a small x.
fn log_1p(x: f64) -> f64 {
    let sum = 1.0 + x;
    let rounded = sum - 1.0;
    if rounded == 0.0 { x } else { ln(sum) * (x / rounded) }
}

/// The angle of a point above the horizontal axis, 0 to π: `y` is 0 or more.
pub(super) fn angle(y: f64, x: f64) -> f64 {
    let size = x.abs().max(y);
    // Zero, and what is no number.
    if size.is_nan() || size <= 0.0 || !size.is_finite() {
        return FRAC_PI_2;
    }
    let (y, x) = (y / size, x / size);
    let length = (x * x + y * y).sqrt();
    let (y, x) = (y / length, x / length);
    let near = if x.abs() > y { 0.0 } else { FRAC_PI_2 };
    let z = if near == 0.0 { y / x } else { -x / y };
    let guess = near + z / (1.0 + 0.28 * z * z);
    let mut at = if guess < 0.0 || (near == 0.0 && x < 0.0) { guess + PI } else { guess };
    for _ in 0..3 {
        let turns = at / TAU;
        let off = y * cosine(turns) - x * sine(turns);
        at += off + off * off * off / 6.0;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::{Law, angle};

    #[test]
    fn it_follows_the_textbook_at_every_damping() {
        let (j, k) = (6e-6f64, 40.0f64);
        let w = (k / j).sqrt();
        for zeta in [0.0, 1e-3, 0.05, 0.7, 0.999_999_9, 1.0, 1.000_000_1, 1.5, 5.0] {
            let law = Law::new(j, 2.0 * zeta * (k * j).sqrt(), k);
            for t in [1e-9, 1e-6, 1e-4, 3e-4, 1e-3, 1e-2] {
                let (a, q) = (zeta * w, w * (1.0f64 - zeta * zeta).abs().sqrt());
                let e = (-a * t).exp();
                let (h, c) = if q * t < 1e-4 {
                    (e * t, e * (1.0 + a * t))
                } else if zeta < 1.0 {
                    (e * (q * t).sin() / q, e * ((q * t).cos() + a * (q * t).sin() / q))
                } else {
                    let (one, two) = (((q - a) * t).exp(), (-(q + a) * t).exp());
                    (0.5 * (one - two) / q, 0.5 * ((one + two) + a * (one - two) / q))
                };
                let over = law.over(t);
                assert!(
                    (over.gains - h).abs() * w < 1e-8 * (q * t < 1e-4) as u8 as f64 + 3e-12,
                    "{zeta} {t}"
                );
                assert!((over.keeps - c).abs() < 1e-8 * (q * t < 1e-4) as u8 as f64 + 3e-12, "{zeta} {t}");
            }
        }
    }

    #[test]
    fn two_rates_may_be_one() {
        let law = Law::new(1.0, 2.0, 1.0);
        for t in [1e-6, 0.1, 1.0, 30.0] {
            let (over, e) = (law.over(t), (-t).exp());
            assert!((over.gains - t * e).abs() < 1e-15 && (over.keeps - (1.0 + t) * e).abs() < 1e-15, "{t}");
            assert!((over.bends - (1.0 - (1.0 + t) * e)).abs() < 1e-15);
        }
        assert_eq!(law.zero(1.0, -2.0), Some(1.0));
        assert_eq!(law.zero(1.0, -1.0), None);
    }

    /// Two steps of half a time are one of all of it: at every damping, and across the seam between series and closed form.
    #[test]
    fn halves_make_a_whole() {
        for (damping, stiffness) in [
            (0.0, 0.0),
            (2e-5, 0.0),
            (1e-3, 0.0),
            (1.0, 0.0),
            (0.0, 0.4),
            (2e-5, 400.0),
            ((4.0f64 * 6e-6 * 40.0).sqrt(), 40.0),
        ] {
            let law = Law::new(6e-6, damping, stiffness);
            for t in [1e-9, 1e-6, 2e-5, 1e-4, 1e-3, 0.1] {
                let (v, a) = (3.0, -700.0);
                let (whole, half) = (law.over(t), law.over(0.5 * t));
                let jerk = law.jerk(v, a);
                let (v1, p1) = (v * half.keeps + a * half.gains, v * half.goes + a * half.bends);
                let a1 = a * half.keeps + jerk * half.gains;
                let (v2, p2) = (v1 * half.keeps + a1 * half.gains, p1 + v1 * half.goes + a1 * half.bends);
                let (v3, p3) = (v * whole.keeps + a * whole.gains, v * whole.goes + a * whole.bends);
                let scale = v.abs() + a.abs() * t;
                assert!((v2 - v3).abs() < 1e-13 * scale, "{damping} {stiffness} {t}: {v2} {v3}");
                assert!((p2 - p3).abs() < 1e-13 * scale * t, "{damping} {stiffness} {t}: {p2} {p3}");
            }
        }
    }

    #[test]
    fn zeros_are_zeros_and_the_first() {
        for (damping, stiffness) in
            [(0.0, 0.0), (2e-5, 0.0), (1e-5, 0.4), (0.1, 0.4), (2.0 * 24e-7f64.sqrt(), 0.4)]
        {
            let law = Law::new(6e-6, damping, stiffness);
            for (v, a) in
                [(3.0, -700.0), (-3.0, 700.0), (1e-6, -1.0), (2.0, 50.0), (-2.0, -50.0), (5.0, -1e5)]
            {
                let at = |t: f64| {
                    let o = law.over(t);
                    v * o.keeps + a * o.gains
                };
                let end = law.zero(v, a);
                if let Some(t) = end {
                    assert!(
                        at(t).abs() < 1e-13 * (v.abs() + a.abs() * t),
                        "{damping} {v} {a}: {} at {t}",
                        at(t)
                    );
                }
                let until = end.unwrap_or(1.0) * 0.999;
                assert!((0..1000).all(|n| at(until * f64::from(n) / 1000.0) * v >= 0.0), "{damping} {v} {a}");
            }
        }
    }

    #[test]
    fn angles_are_angles() {
        for n in 0..=1000 {
            let (s, c) = (std::f64::consts::PI * f64::from(n) / 1000.0).sin_cos();
            for size in [1e-200, 1.0, 1e200] {
                assert!((angle(s.abs() * size, c * size) - s.abs().atan2(c)).abs() < 1e-15 * 8.0, "{n}");
            }
        }
    }
}
