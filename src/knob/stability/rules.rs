//! Closed forms of the literature for stability and passivity of a rendered spring and damper.
//!
//! Arguments are SI; `lag` is the delay from reading to torque without the hold's half tick, seconds.

use std::f64::consts::PI;

/// The stiffest passive wall without delay, b ≥ K T / 2 + |B| (Colgate & Schenkel 1997), N m/rad; 0 if there is none.
pub fn colgate(damping: f64, computed: f64, period: f64) -> f64 {
    (2.0 * (damping - computed.abs()) / period).max(0.0)
}

/// The damping b that makes any environment H(e^{jωT}) passive: (T / 2) max_ω Re{(1 − e^{−jωT}) H} / (1 − cos ωT) (Colgate & Schenkel
/// 1997). `environment` gives real and imaginary part of torque over angle at an angle ωT within 0 and π. The maximum is
/// taken over `points` angles, π among them; more are closer.
pub fn colgate_general<H: Fn(f64) -> (f64, f64)>(period: f64, points: usize, environment: H) -> f64 {
    let of = |k: usize| {
        let phi = PI * k as f64 / points as f64;
        let (re, im) = environment(phi);
        let (sin, half) = (phi.sin(), (0.5 * phi).sin());
        let versine = 2.0 * half * half;
        0.5 * period * (versine * re - sin * im) / versine
    };
    (1..=points.max(1)).map(of).fold(0.0, f64::max)
}

/// The stiffness where a delayed spring begins to swing, (b + B) / (T / 2 + lag), for a small B and a light knob (Gil et al. 2009, Hulin et
/// al. 2013), N m/rad.
pub fn gil(damping: f64, computed: f64, period: f64, lag: f64) -> f64 {
    (damping + computed) / (0.5 * period + lag)
}

/// The stiffness up to which dry friction f_c holds a knob still between two counts of an encoder, 2 f_c / δ, N m/rad.
pub fn quantisation(friction: f64, count: f64) -> f64 {
    2.0 * friction / count
}

/// The stiffest passive wall with an encoder and dry friction, min(2 b / T, 2 f_c / δ) (Abbott & Okamura 2005), N m/rad.
pub fn abbott_okamura(damping: f64, friction: f64, period: f64, count: f64) -> f64 {
    colgate(damping, 0.0, period).min(quantisation(friction, count))
}

/// The swing (radians) below which dry friction brings an unstable spring to rest: 4 f_c / (π ω_n (K (T / 2 + lag) − b)) (after Diolaiti et
/// al. 2006); infinite where the spring is stable by itself.
pub fn held_by_friction(stiffness: f64, inertia: f64, damping: f64, friction: f64, late: f64) -> f64 {
    let gain = stiffness * late - damping;
    if gain <= 0.0 { f64::INFINITY } else { 4.0 * friction / (PI * (stiffness / inertia).sqrt() * gain) }
}

/// Energy out over energy in of one touch of a sampled wall, e^{π ω_n t_d} with t_d = T / 2 + lag, without losses.
pub fn bounce(stiffness: f64, inertia: f64, late: f64) -> f64 {
    (PI * (stiffness / inertia).sqrt() * late).exp()
}
