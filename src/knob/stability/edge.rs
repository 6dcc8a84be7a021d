//! The gain at which the first eigenvalue reaches the unit circle.
//!
//! D-decomposition (Neimark 1949): where F(z) + g S(z) = 0 has a root e^{jφ}, Im(F S*) = 0 and g = −Re(F S*) / |S|². So all gains at
//! which a root lies on the circle are the zeros of one function of φ within 0 and π, and the least positive gain is the edge of
//! the interval of stable gains that begins at 0. A delay of m ticks adds m turns to that function and nothing to its cost, which
//! is why no eigenvalue needs to be computed.

use crate::dsp::complex::Complex;

/// The edge of stability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The gain: a stiffness (N m/rad), a damping (N m s/rad) or a factor. 0: no gain is stable; infinite: every gain is.
    pub gain: f64,
    /// The frequency at which the knob swings there, hertz.
    pub hertz: f64,
}

impl Edge {
    /// No gain is stable.
    pub const NONE: Self = Self { gain: 0.0, hertz: 0.0 };
}

/// Points of the grid for each turn of the delay, and for each decade below.
const PER_TURN: usize = 48;
/// The same for each tick that the estimator looks back.
const PER_WINDOW: usize = 16;
const PER_DECADE: usize = 40;
const LEAST: f64 = 1e-8;
const HALVINGS: usize = 64;

/// Angles ωT at which an edge is looked for.
pub(super) struct Grid {
    lag: usize,
    period: f64,
    angles: Vec<f64>,
}

impl Grid {
    /// For a delay of `lag` ticks and an estimator that looks back over `window`; `marks` are angles and half widths of resonances.
    pub(super) fn new(lag: usize, window: usize, period: f64, marks: &[(f64, f64)]) -> Self {
        let pi = std::f64::consts::PI;
        let mut grid = Vec::new();
        let turns = PER_TURN * (lag + 2) + PER_WINDOW * (window - 1);
        let step = pi / turns as f64;
        let decades = (step / LEAST).log10();
        let count = (decades * PER_DECADE as f64).ceil();
        grid.extend((0..count as usize).map(|k| LEAST * 10f64.powf(decades * k as f64 / count)));
        grid.extend((1..turns).map(|k| step * k as f64));
        for &(angle, width) in marks {
            for k in 0..60 {
                let aside = (width.max(1e-12) * 0.1) * 10f64.powf(f64::from(k) / 12.0);
                grid.extend([angle - aside, angle + aside]);
            }
            grid.push(angle);
        }
        grid.retain(|phi| *phi >= LEAST && *phi < pi);
        grid.sort_by(f64::total_cmp);
        Self { lag, period, angles: grid }
    }
}

/// The least positive g for which `fixed` + g `scaled` has a root on the unit circle. Both take the angle ωT and w = z − 1, and `fixed` z^lag.
pub(super) fn least<F, S>(grid: &Grid, fixed: F, scaled: S) -> Edge
where
    F: Fn(f64, Complex, Complex) -> Complex,
    S: Fn(f64, Complex) -> Complex,
{
    let at = |phi: f64| {
        #[cfg(test)]
        super::work::point();
        let half = (0.5 * phi).sin();
        let w = Complex::new(-2.0 * half * half, phi.sin());
        let turned = Complex::turned(phi * grid.lag as f64);
        let (f, s) = (fixed(phi, w, turned), scaled(phi, w));
        let size = s.re * s.re + s.im * s.im;
        (f.im * s.re - f.re * s.im, -(f.re * s.re + f.im * s.im) / size)
    };
    let mut edge = Edge { gain: f64::INFINITY, hertz: 0.0 };
    let mut offer = |gain: f64, phi: f64| {
        if gain > 0.0 && gain < edge.gain {
            edge = Edge { gain, hertz: phi / (std::f64::consts::TAU * grid.period) };
        }
    };
    let (mut below, mut sign) = (LEAST, at(LEAST).0);
    for &phi in &grid.angles {
        let (next, gain) = at(phi);
        if next == 0.0 {
            // A zero on the grid itself, as of an undamped knob at φ = π / 2: the sign goes on from before it.
            offer(gain, phi);
            continue;
        }
        if sign * next < 0.0 {
            let (mut left, mut right) = (below, phi);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (left + right);
                if at(middle).0 * sign > 0.0 {
                    left = middle;
                } else {
                    right = middle;
                }
            }
            offer(at(right).1, right);
        }
        (below, sign) = (phi, next);
    }
    offer(at(std::f64::consts::PI).1, std::f64::consts::PI);
    edge
}
