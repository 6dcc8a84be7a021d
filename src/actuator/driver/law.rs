//! The drive that brings speeds about.
//!
//! [`Follow`] is the inverse of the motor for speeds that it can follow: their torque, and the volts that it takes on average over each
//! sample. It is the twin of [`Inverse`](crate::actuator::shape::Inverse), which knows an envelope as a whole: what is written twice here is
//! so on purpose, and the two are held against one another.
//!
//! [`Seek`] takes it to another speed as fast as the drive allows. Of the two ways in which speed and current decay, the slow one is
//! s = (ω − ω*) + w (i − i*), with w = (k/J)/(R/L + λ), λ its rate; what is imposed enters it alone as in a first-order system:
//! ṡ = λ s + v k/(J (R + λ L)). So s is brought to nothing within a sample once that is within the limit, and what is left of the current
//! then dies away in L/R without the speed swinging back.

use super::setup::Setup;
use crate::actuator::drive::Drive;

/// The inverse for planned speeds.
#[derive(Debug, Clone, Copy)]
pub struct Follow {
    setup: Setup,
    step: f64,
    inertia: f64,
    /// What one sample could not give and the next is to make up for.
    owed: f64,
    /// The current that is to flow now.
    flows: f64,
}

impl Follow {
    /// From rest.
    pub fn new(setup: &Setup) -> Self {
        let inertia = setup.parameters.effective_inertia();
        Self { setup: *setup, step: 1.0 / setup.rate, inertia, owed: 0.0, flows: 0.0 }
    }

    /// Forgets what it owes; the current is this.
    pub fn restart(&mut self, current: f64) {
        (self.owed, self.flows) = (0.0, current);
    }

    /// The mean drive over a sample with these speeds at its beginning, at its end, and a sample later; and whether it is at the limit. Of a
    /// motor that turns one way, no less than what it makes itself by turning: then nothing flows.
    pub fn step(&mut self, [now, next, after]: [f64; 3]) -> (f64, bool) {
        let (p, limit) = (&self.setup.parameters, self.setup.limit);
        let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
        let turned = 0.5 * self.step * (now + next);
        let friction = p.viscous * turned + p.coulomb * self.step * sign(now + next);
        let pushed = (self.inertia * (next - now) + friction) / p.gain;
        let later =
            self.inertia * (after - now) * 0.5 / self.step + p.viscous * next + p.coulomb * sign(next);
        let later = later / p.gain;
        let wanted = match self.setup.imposes {
            Drive::Voltage => {
                (p.resistance * pushed + p.gain * turned + p.inductance * (later - self.flows)) / self.step
                    + self.owed
            }
            Drive::Current => pushed / self.step + self.owed,
        };
        let least = if self.setup.one_way { p.gain * turned / self.step } else { -limit };
        let given = wanted.max(least).min(limit);
        // What diodes keep back is over with the sample.
        self.owed = (wanted - given).clamp(self.setup.least(), limit);
        self.flows = later;
        (given, if self.setup.one_way { given < wanted } else { given != wanted })
    }
}

/// The way to another speed.
#[derive(Debug, Clone, Copy)]
pub struct Seek {
    setup: Setup,
    /// w: what a current is worth as speed.
    worth: f64,
    /// What a sample leaves of s, what it adds for each unit of drive, and for each N m.
    keeps: f64,
    gains: f64,
    torque: f64,
}

impl Seek {
    /// For a motor.
    pub fn new(setup: &Setup) -> Self {
        let (p, step) = (&setup.parameters, 1.0 / setup.rate);
        let inertia = p.effective_inertia();
        let slow = -setup.damping() / inertia;
        let (rate, worth, enters) = match setup.imposes {
            Drive::Current => (slow, 0.0, p.gain / inertia),
            Drive::Voltage => {
                // det(A − λ) = 0 by Newton from the rate without inductance; where both ways are alike or swing, that rate will do.
                let (r, l, k, b) = (p.resistance, p.inductance, p.gain, p.viscous);
                let mut rate = slow;
                for _ in 0..16 {
                    let (at, slope) = (
                        (r + l * rate) * (b + inertia * rate) + k * k,
                        l * (b + inertia * rate) + inertia * (r + l * rate),
                    );
                    let next = rate - at / slope;
                    if !(slope > 0.0 && next * l > -0.5 * r) {
                        rate = slow.max(-0.5 * r / l.max(f64::MIN_POSITIVE));
                        break;
                    }
                    rate = next;
                }
                (rate, (k / inertia) * l / (r + l * rate), k / (inertia * (r + l * rate)))
            }
        };
        let z = rate * step;
        let stretch = if z.abs() < 1e-9 { step } else { step * z.exp_m1() / z };
        Self { setup: *setup, worth, keeps: z.exp(), gains: enters * stretch, torque: stretch / inertia }
    }

    /// By how much the limit changes a speed within a sample, rad/s.
    pub fn most(&self) -> f64 {
        self.gains * self.setup.limit
    }

    /// How far a speed and a current are from a wish, rad/s.
    pub fn off(&self, speed: f64, current: f64, wished: f64) -> f64 {
        let p = &self.setup.parameters;
        let friction = if wished == 0.0 { 0.0 } else { p.coulomb.copysign(wished) };
        let holds = (p.viscous * wished + friction) / p.gain;
        (speed - wished) + self.worth * (current - holds)
    }

    /// The drive for the next sample.
    pub fn step(&self, speed: f64, current: f64, wished: f64) -> f64 {
        let p = &self.setup.parameters;
        // What holds the wish pays for friction that way; where friction acts the other way, or nothing is to be held, it helps.
        let paid = if wished == 0.0 { 0.0 } else { p.coulomb.copysign(wished) };
        let acts = if speed == 0.0 { paid } else { p.coulomb.copysign(speed) };
        let left = self.keeps * self.off(speed, current, wished) - self.torque * (acts - paid);
        let passes = left * self.off(speed, current, wished) < 0.0;
        // Friction alone stops it within the sample.
        let wanted = if passes { 0.0 } else { -left / self.gains };
        (self.setup.held_by(wished) + wanted).clamp(self.setup.least(), self.setup.limit)
    }
}
