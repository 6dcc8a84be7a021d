//! The loop of a knob and a computer that renders a spring and a damper, without an approximation.
//!
//! At tick k the computer reads θ_k and commands −K θ_k − B v_k, v_k being a plain difference (θ_k − θ_{k−1}) / T or what another
//! [estimator](crate::knob::velocity::transfer) makes of the readings, which acts d ticks later and is held for T. Between
//! ticks the plant is linear, so its state moves by e^{AT}; a delay that is no whole number of ticks splits the tick at the
//! instant where the torque changes. From the state's step come the polynomials of θ / torque in w = z − 1 (Leverrier and Faddeev's
//! recursion): in w, because the plant's slow eigenvalues are small differences from 1.

use super::edge::{Edge, Grid, least};
use super::roots::{Characteristic, add, excess, product, value};
use crate::actuator::exponential::{Square, exponential};
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::dsp::complex::Complex;
use crate::knob::low_pass::LowPass;
use crate::knob::velocity::transfer::Transfer;

/// The longest delay, ticks.
pub const MOST_DELAY: f64 = 8192.0;

/// A rigid knob: J θ̈ = torque − b θ̇.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotor {
    /// J, kg m².
    pub inertia: f64,
    /// b, N m s/rad: what is left of it under the drive. Under current drive a shorted motor's damping is not.
    pub damping: f64,
}

/// A motor with its encoder, a shaft that twists, and a knob: J_m θ̈_m = torque − b θ̇_m − k (θ_m − θ_k) − c (θ̇_m − θ̇_k).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// J_m, kg m².
    pub motor: f64,
    /// J_k, kg m².
    pub knob: f64,
    /// Frequency of the motor against the clamped knob, √(k / J_m) / 2π, hertz.
    pub clamped: f64,
    /// c, N m s/rad.
    pub loss: f64,
    /// b, N m s/rad.
    pub damping: f64,
}

impl Shaft {
    /// k, N m/rad.
    pub fn stiffness(&self) -> f64 {
        self.motor * (std::f64::consts::TAU * self.clamped).powi(2)
    }

    /// The resonance while the knob is free, hertz.
    pub fn free(&self) -> f64 {
        self.clamped * (1.0 + self.motor / self.knob).sqrt()
    }
}

/// A plant with its hold and its delay, waiting for a spring and a damper.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    pub(super) period: f64,
    /// Angle over torque is `above` / (`below` z^`lag`), in w.
    pub(super) above: Vec<f64>,
    pub(super) below: Vec<f64>,
    pub(super) lag: usize,
    /// The plant's own step: state, torque that ends within the tick, torque that begins.
    states: Vec<Vec<f64>>,
    ending: Vec<f64>,
    beginning: Vec<f64>,
    filtered: bool,
    estimator: Transfer,
    /// Ticks by which the spring's torque is sooner than the damping's.
    ahead: usize,
}

impl Loop {
    /// A rigid knob, read every `period` seconds, its torque late by `delay` ticks (0 to [`MOST_DELAY`], also fractions).
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn rigid(rotor: &Rotor, period: f64, delay: f64) -> Result<Self, Fault> {
        positive("inertia", rotor.inertia)?;
        not_negative("damping", rotor.damping)?;
        positive("period", period)?;
        let mut a = Square::default();
        // States are the angle and what the speed would add to it in one tick.
        a[0][1] = 1.0;
        a[1][1] = -rotor.damping / rotor.inertia * period;
        a[1][2] = period * period / rotor.inertia;
        Self::new(&a, 2, period, delay)
    }

    /// A motor and a knob on a shaft that twists; encoder and torque are the motor's.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn shaft(shaft: &Shaft, period: f64, delay: f64) -> Result<Self, Fault> {
        positive("motor", shaft.motor)?;
        positive("knob", shaft.knob)?;
        positive("clamped", shaft.clamped)?;
        not_negative("loss", shaft.loss)?;
        not_negative("damping", shaft.damping)?;
        positive("period", period)?;
        let mut a = Square::default();
        let (k, tt) = (shaft.stiffness(), period * period);
        // Angle, twist, and their steps.
        a[0][2] = 1.0;
        a[1][3] = 1.0;
        a[2][1] = -k * tt / shaft.motor;
        a[2][2] = -shaft.damping * period / shaft.motor;
        a[2][3] = -shaft.loss * period / shaft.motor;
        a[2][4] = tt / shaft.motor;
        let both = 1.0 / shaft.motor + 1.0 / shaft.knob;
        a[3][1] = -k * tt * both;
        a[3][2] = a[2][2];
        a[3][3] = -shaft.loss * period * both;
        a[3][4] = a[2][4];
        Self::new(&a, 4, period, delay)
    }

    fn new(a: &Square, size: usize, period: f64, delay: f64) -> Result<Self, Fault> {
        check("delay", delay, Limit::Within(0.0, MOST_DELAY, "ticks"))?;
        let (whole, late) = (delay.floor(), delay - delay.floor());
        let all = exponential(a, size + 1, 1.0);
        let after = exponential(a, size + 1, 1.0 - late);
        let states: Vec<Vec<f64>> = (0..size).map(|i| all[i][..size].to_vec()).collect();
        let beginning: Vec<f64> = (0..size).map(|i| after[i][size]).collect();
        let ending: Vec<f64> = (0..size).map(|i| all[i][size] - after[i][size]).collect();
        let (below, [first, last]) = polynomials(&states, [&beginning, &ending]);
        let (above, lag) = if late > 0.0 {
            // beginning z + ending, over z.
            let mut sum = product(&first, &[1.0, 1.0]);
            last.iter().enumerate().for_each(|(k, c)| sum[k] += c);
            (sum, whole as usize + 1)
        } else {
            (first, whole as usize)
        };
        Ok(Self {
            period,
            above,
            below,
            lag,
            states,
            ending,
            beginning,
            filtered: false,
            estimator: Transfer::difference(1),
            ahead: 0,
        })
    }

    /// The same loop with a low-pass on the torque.
    #[must_use]
    pub fn filtered(mut self, low_pass: &LowPass) -> Self {
        let (above, below) = low_pass.polynomials();
        self.above = product(&self.above, &above);
        self.below = product(&self.below, &below);
        self.filtered = true;
        self
    }

    /// The same loop with speed by an estimator.
    #[must_use]
    pub fn estimated(mut self, estimator: Transfer) -> Self {
        self.estimator = estimator;
        self
    }

    /// The same loop with a spring whose torque comes so many ticks sooner than that of the damping, at most as many as that is late: one
    /// that is evaluated where the angle is read, and not where the damping is computed.
    #[must_use]
    pub fn sooner(mut self, ticks: usize) -> Self {
        self.ahead = ticks.min(self.lag);
        self
    }

    /// Seconds between readings.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The closed loop's characteristic equation for a stiffness K (N m/rad) and a computed damping B (N m s/rad).
    pub fn characteristic(&self, stiffness: f64, damping: f64) -> Characteristic {
        let b = damping / self.period;
        if b == 0.0 {
            let fed_back = self.above.iter().map(|c| c * stiffness).collect();
            return Characteristic {
                delayed: self.below.clone(),
                lag: self.lag - self.ahead,
                fed_back,
                ..Characteristic::default()
            };
        }
        let Transfer { ticks, above, below } = &self.estimator;
        let delayed = product(&self.below, below);
        let (spring, damper) = (product(&self.above, below), product(&self.above, above));
        let b = b / *ticks as f64;
        if self.ahead > 0 {
            // K z^(m + n) + B (z^n − 1) / n T, over z^n.
            let scaled = |p: &[f64], by: f64| p.iter().map(|c| c * by).collect::<Vec<_>>();
            let between =
                vec![(scaled(&spring, stiffness), self.ahead + ticks), (scaled(&damper, b), *ticks)];
            let fed_back = scaled(&damper, -b);
            return Characteristic { delayed, lag: self.lag + ticks, between, fed_back };
        }
        if *ticks == 1 {
            // K z + B w / T, over z.
            let mut fed_back = product(&spring, &[stiffness, stiffness]);
            add(&mut fed_back, &product(&damper, &[0.0, b]));
            return Characteristic { delayed, lag: self.lag + 1, fed_back, ..Characteristic::default() };
        }
        // K z^n + B (z^n − 1) / n T, over z^n.
        let mut between: Vec<f64> = spring.iter().map(|c| c * stiffness).collect();
        add(&mut between, &damper.iter().map(|c| c * b).collect::<Vec<_>>());
        let fed_back = damper.iter().map(|c| -c * b).collect();
        Characteristic { delayed, lag: self.lag + ticks, between: vec![(between, *ticks)], fed_back }
    }

    /// How far outside the unit circle the plant's own eigenvalues lie, without the one at 1 that every knob has.
    fn own_excess(&self) -> f64 {
        Characteristic {
            delayed: self.below[1..].to_vec(),
            lag: 0,
            fed_back: vec![0.0],
            ..Characteristic::default()
        }
        .excess()
    }

    /// Every eigenvalue of the closed loop, as z.
    pub fn eigenvalues(&self, stiffness: f64, damping: f64) -> Vec<Complex> {
        self.characteristic(stiffness, damping).roots().into_iter().map(|w| w + 1.0).collect()
    }

    /// How fast the outermost eigenvalue grows, 1/s: ln |z| / T. Negative where the knob comes to rest.
    pub fn growth(&self, stiffness: f64, damping: f64) -> f64 {
        self.characteristic(stiffness, damping).excess().ln_1p() / self.period
    }

    /// The spectral radius of the closed loop.
    pub fn radius(&self, stiffness: f64, damping: f64) -> f64 {
        1.0 + self.characteristic(stiffness, damping).excess()
    }

    /// The stiffness up to which the knob comes to rest with a computed damping B: 0 if it never does.
    pub fn edge(&self, damping: f64) -> Edge {
        // A soft spring rests where its speed does: by the damping of its own, or by one computed within its edge.
        let rests = if damping == 0.0 { self.own_excess() < 0.0 } else { damping < self.damping_edge().gain };
        if rests { self.edge_within(damping) } else { Edge::NONE }
    }

    /// The same for a damping that is known to lie within [`Loop::damping_edge`]: no eigenvalue is computed.
    pub(crate) fn edge_within(&self, damping: f64) -> Edge {
        let b = damping / self.period;
        let fixed = |phi: f64, w: Complex, turned: Complex| {
            let (up, down) = self.estimator.at(phi, w);
            value(&self.below, w) * turned * down + value(&self.above, w) * up * b
        };
        let scaled = |phi: f64, w: Complex| {
            value(&self.above, w) * self.estimator.at(phi, w).1 * Complex::turned(phi * self.ahead as f64)
        };
        least(&self.grid(), fixed, scaled)
    }

    /// The computed damping up to which a knob without a spring comes to rest.
    pub fn damping_edge(&self) -> Edge {
        if self.own_excess() > 1e-12 {
            return Edge::NONE;
        }
        let fixed = |phi: f64, w: Complex, turned: Complex| {
            value(&self.below[1..], w) * turned * self.estimator.at(phi, w).1
        };
        let scaled = |phi: f64, w: Complex| {
            value(&self.above, w) * self.estimator.at(phi, w).0 / w * (1.0 / self.period)
        };
        least(&self.grid(), fixed, scaled)
    }

    /// By what factor both a stiffness and a damping may grow together. It computes all eigenvalues once: seconds for long delays.
    pub fn margin(&self, stiffness: f64, damping: f64) -> Edge {
        let b = damping / self.period;
        let fixed = |phi: f64, w: Complex, turned: Complex| {
            value(&self.below, w) * turned * self.estimator.at(phi, w).1
        };
        let scaled = |phi: f64, w: Complex| {
            let (up, down) = self.estimator.at(phi, w);
            value(&self.above, w) * (up * b + down * stiffness * Complex::turned(phi * self.ahead as f64))
        };
        let edge = least(&self.grid(), fixed, scaled);
        // Without damping of its own the knob may swing however small the factor is.
        let inside = if edge.gain.is_finite() { 0.5 * edge.gain } else { 1.0 };
        let stable = self.characteristic(inside * stiffness, inside * damping).excess() < 0.0;
        if stable { edge } else { Edge::NONE }
    }

    /// Where to look for the edge.
    fn grid(&self) -> Grid {
        Grid::new(self.lag, self.estimator.ticks, self.period, &self.marks())
    }

    /// Angles of the plant's own poles and zeros: near a sharp resonance the phase turns within a narrow band.
    fn marks(&self) -> Vec<(f64, f64)> {
        let of = |p: &[f64]| {
            Characteristic { delayed: p.to_vec(), lag: 0, fed_back: vec![0.0], ..Characteristic::default() }
                .roots()
        };
        let all = of(&self.below[1..]).into_iter().chain(of(&self.above));
        let all = all.chain(of(&self.estimator.below));
        all.map(|w| ((w + 1.0).angle().abs(), excess(w).abs())).filter(|m| m.0 > 0.0).collect()
    }

    /// The closed loop as a matrix: the state of a tick gives that of the next. States are the plant's, the angle read before
    /// and the torques under way. `None` with a low-pass or another estimator, whose states are not among them, and with a spring that is sooner.
    pub fn matrix(&self, stiffness: f64, damping: f64) -> Option<Vec<Vec<f64>>> {
        if self.filtered || self.ahead > 0 || !self.estimator.is_plain() {
            return None;
        }
        let n = self.states.len();
        let late = self.lag;
        let size = n + 1 + late;
        let b = damping / self.period;
        let mut m = vec![vec![0.0; size]; size];
        // The command of this tick, as a row.
        let mut command = vec![0.0; size];
        (command[0], command[n]) = (-stiffness - b, b);
        // Torques under way, the newest first.
        let torque = |age: usize| -> Vec<f64> {
            if age == 0 {
                return command.clone();
            }
            let mut row = vec![0.0; size];
            row[n + age] = 1.0;
            row
        };
        let fractional = self.ending.iter().any(|g| *g != 0.0);
        let newest = torque(if fractional { late - 1 } else { late });
        let oldest = torque(late);
        for i in 0..n {
            for j in 0..n {
                m[i][j] = self.states[i][j] + f64::from(u8::from(i == j));
            }
            for j in 0..size {
                m[i][j] += self.beginning[i] * newest[j] + self.ending[i] * oldest[j];
            }
        }
        m[n][0] = 1.0;
        for age in 0..late {
            m[n + 1 + age] = torque(age);
        }
        Some(m)
    }
}

/// det(w − S) and, for each input, the numerator of the first state's response.
fn polynomials(states: &[Vec<f64>], inputs: [&[f64]; 2]) -> (Vec<f64>, [Vec<f64>; 2]) {
    let n = states.len();
    let mut below = vec![0.0; n + 1];
    below[n] = 1.0;
    let mut above = [vec![0.0; n], vec![0.0; n]];
    let mut adjoint = vec![vec![0.0; n]; n];
    (0..n).for_each(|i| adjoint[i][i] = 1.0);
    for k in 1..=n {
        for (numerator, input) in above.iter_mut().zip(inputs) {
            numerator[n - k] = (0..n).map(|j| adjoint[0][j] * input[j]).sum();
        }
        let mut next = vec![vec![0.0; n]; n];
        for i in 0..n {
            for j in 0..n {
                next[i][j] = (0..n).map(|l| states[i][l] * adjoint[l][j]).sum();
            }
        }
        below[n - k] = -(0..n).map(|i| next[i][i]).sum::<f64>() / k as f64;
        (0..n).for_each(|i| next[i][i] += below[n - k]);
        adjoint = next;
    }
    // Nothing holds the knob where it is, so one eigenvalue is 1.
    below[0] = 0.0;
    (below, above)
}
