//! A knob for tests: the exact step of J θ̈ = torque − b θ̇ − f_c sgn θ̇ under a held torque.

use std::f64::consts::TAU;

/// A rigid knob with dry friction.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    pub inertia: f64,
    pub damping: f64,
    pub friction: f64,
    pub angle: f64,
    pub speed: f64,
    // Of the last time for which these were computed: 1 − e^{−x}, its integral, and those by torque.
    cached: [f64; 4],
    period: f64,
}

impl Plant {
    pub fn new(inertia: f64, damping: f64, friction: f64, period: f64) -> Self {
        let cached = steps(inertia, damping, period);
        Self { inertia, damping, friction, angle: 0.0, speed: 0.0, cached, period }
    }

    fn coast(&mut self, torque: f64, c: [f64; 4]) {
        let (w, t) = (self.speed, torque);
        self.angle += c[0] * w + c[1] * t;
        self.speed = w - c[2] * w + c[3] * t;
    }

    /// One tick under a held torque.
    pub fn step(&mut self, torque: f64) {
        if self.friction == 0.0 {
            self.coast(torque, self.cached);
            return;
        }
        let mut left = self.period;
        for _ in 0..4 {
            let sign = if self.speed != 0.0 {
                self.speed.signum()
            } else if torque.abs() <= self.friction {
                return;
            } else {
                torque.signum()
            };
            let net = torque - sign * self.friction;
            let c = if left == self.period { self.cached } else { steps(self.inertia, self.damping, left) };
            let mut next = *self;
            next.coast(net, c);
            if next.speed * sign >= 0.0 {
                (self.angle, self.speed) = (next.angle, next.speed);
                return;
            }
            // ω(t) = ω₀ e^{−bt/J} + net (1 − e^{−bt/J}) / b is 0 at t = (J / b) ln(1 − b ω₀ / net).
            let (j, b) = (self.inertia, self.damping);
            let stop = if b > 0.0 { j / b * (-b * self.speed / net).ln_1p() } else { -j * self.speed / net };
            let stop = stop.clamp(0.0, left);
            self.coast(net, steps(j, b, stop));
            self.speed = 0.0;
            left -= stop;
        }
    }

    pub fn energy(&self) -> f64 {
        0.5 * self.inertia * self.speed * self.speed
    }
}

fn steps(j: f64, b: f64, t: f64) -> [f64; 4] {
    let x = b * t / j;
    if x < 0.5 {
        // (1 − e^{−x}) / x and (x − 1 + e^{−x}) / x², whose closed forms lose digits here.
        let series = |first: f64| (0..16).rev().fold(0.0, |sum, k| (1.0 - x * sum) / (first + f64::from(k)));
        let (one, two) = (series(1.0), 0.5 * (1.0 - x * series(3.0)));
        return [t * one, t * t / j * two, x * one, t / j * one];
    }
    let gone = -(-x).exp_m1();
    [gone * j / b, (t - gone * j / b) / b, gone, gone / b]
}

/// A count of an encoder with so many counts a turn, and its floor.
pub fn count(counts: f64) -> f64 {
    TAU / counts
}

pub fn floor(angle: f64, count: f64) -> f64 {
    if count == 0.0 { angle } else { count * (angle / count).floor() }
}

/// Torque that comes late by whole ticks.
pub struct Delay {
    line: Vec<f64>,
    at: usize,
}

impl Delay {
    pub fn new(ticks: usize) -> Self {
        Self { line: vec![0.0; ticks], at: 0 }
    }

    pub fn pass(&mut self, x: f64) -> f64 {
        if self.line.is_empty() {
            return x;
        }
        let out = std::mem::replace(&mut self.line[self.at], x);
        self.at = (self.at + 1) % self.line.len();
        out
    }
}
