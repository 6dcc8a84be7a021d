//! Where a motor comes to stand if it is driven backward from now on: in closed form, with gravity and coil, so that a click from a place that is
//! known can be ended by the motor's model while it is under way.
//!
//! Backward at V, J ω' = −(k V/R + T_c + m g r sin φ) − (b + k²/R) ω, as if it coasted with more of both frictions; the weight is that in the middle
//! of the way. The coil comes behind by τ = L/R: what still flows the other way is worth k τ/J a unit of current as speed, given τ later.

use super::coast::Coast;
use crate::actuator::motor::{Motor, Parameters};

/// Rounds in which the mean speed is found while the coil is emptied.
const ROUNDS: usize = 2;

/// Of what it is driven by and friction, what is left at least where its mass pulls the other way.
const LEAST: f64 = 0.1;

/// Of what turns it at all from where it hangs, what is given at least so that it turns for certain.
const CERTAIN: f64 = 1.1;

/// A motor at a voltage, on its way to rest.
#[derive(Debug, Clone, Copy)]
pub struct Stopping<'a> {
    /// The motor, as it is.
    pub motor: &'a Motor,
    /// Which way it goes: 1 or -1.
    pub way: f64,
    /// What it is driven with either way, V, above 0.
    pub volts: f64,
}

impl Stopping<'_> {
    /// How far it still turns until it stands, rad along its way, driven backward from now on; 0 where it does not turn that way.
    pub fn angle(&self) -> f64 {
        let p = self.motor.parameters();
        let (inertia, time) = (p.effective_inertia(), p.electrical_time());
        let (speed, current) = (self.way * self.motor.speed(), self.way * self.motor.current());
        let flows = -(self.volts + p.gain * speed) / p.resistance;
        // Of a current that is what the voltage makes of it at once, nothing.
        let owed = if time > 0.0 { p.gain * time / inertia * (current - flows) } else { 0.0 };
        let drives = p.gain * self.volts / p.resistance + p.coulomb;
        let brakes = |weight: f64| {
            // However its mass pulls, what it is driven by must not become nothing.
            let dry = (drives + weight).max(LEAST * drives);
            let slowed = Parameters { viscous: p.damping(), coulomb: dry, ..*p };
            (Coast::new(&slowed).angle(speed + owed) - owed * time).max(0.0)
        };
        let pulls = |ahead: f64| self.way * p.weight() * (self.motor.turned() + self.way * ahead).sin();
        if p.weight() == 0.0 {
            return brakes(0.0);
        }
        let first = brakes(pulls(0.0));
        brakes(pulls(0.5 * first))
    }

    /// Driven forward from now on until its coil is empty: how long that takes (s), and how fast it is then, rad/s along its way.
    pub fn emptied(&self) -> (f64, f64) {
        let p = self.motor.parameters();
        let (speed, current) = (self.way * self.motor.speed(), self.way * self.motor.current());
        let time = p.electrical_time();
        if !(time > 0.0 && current < 0.0) {
            return (0.0, speed);
        }
        let pulls = self.way * p.weight() * self.motor.turned().sin();
        let mut mean = 0.5 * speed.max(0.0);
        let mut ends = (0.0, speed);
        for _ in 0..ROUNDS {
            let flows = (self.volts - p.gain * mean) / p.resistance;
            if flows <= 0.0 {
                break;
            }
            // i = i∞ + (i₀ − i∞) e^(−t/τ), 0 at t = τ ln(1 − i₀/i∞); and ∫ i until then.
            let seconds = time * (-current / flows).ln_1p();
            let charge = flows * seconds + time * current;
            let lost = (p.coulomb + pulls + p.viscous * mean) * seconds;
            ends = (seconds, speed + (p.gain * charge - lost) / p.effective_inertia());
            mean = 0.5 * (speed + ends.1).max(0.0);
        }
        ends
    }
}

/// Volts, of those that are wished for and those that there are at most, with which a mass turns from where it hangs (rad), that way.
pub fn certain(p: &Parameters, hangs: f64, way: f64, wished: f64, most: f64) -> f64 {
    let starts = p.stiction + way * p.weight() * hangs.sin();
    let keeps = p.coulomb + p.weight();
    wished.max(CERTAIN * starts.max(keeps) * p.resistance / p.gain).min(most)
}
