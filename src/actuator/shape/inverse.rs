//! Inverse dynamics: from the envelope that shall be felt to the voltage that makes it.

use super::spin::sign;
use crate::actuator::fault::{Fault, within};
use crate::actuator::motor::Parameters;

/// From a wanted speed to a voltage.
///
/// The torque a motion needs is J ω̇ + b ω + T_c sgn ω + m_e g r sin θ, the current i that over k, the voltage R i + k ω + L di/dt. A converter
/// holds a voltage for a sample, so that sample's voltage is the mean of that over it: what the motor needs in volt-seconds is exact,
/// whatever its inductance, and nothing rings as it would if each sample made the speed right by itself.
///
/// What the voltage cannot do is taken out of the wish before: speeds that would have to rise faster than the motor can are reached later, and
/// those that would have to fall faster are left earlier. So the brake begins ahead of the fall, which is why the whole envelope must be
/// known.
///
/// It is open loop, and as good as the figures: what it misses where one of them is off is what the same volts make of another motor. Of a raised
/// cosine of 150 ms that the motor can follow, nothing (below 0.005 % of its peak, root mean square); with a figure 10 % off, a coin motor misses 3 %
/// (friction) to 12 % (resistance).
#[derive(Debug, Clone, Copy)]
pub struct Inverse {
    /// The motor.
    pub parameters: Parameters,
    /// The largest voltage, V, either way.
    pub limit: f64,
    /// Samples a second of envelope and converter.
    pub rate: f64,
    /// Where the mass hangs before, rad from straight down; `None`: unknown, and gravity is left to itself.
    pub angle: Option<f64>,
}

/// What became of a wish.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaped {
    /// Volts, a sample each.
    pub volts: Vec<f64>,
    /// The speeds that were aimed at, rad/s: the wish, where the motor can do it. One more than samples of voltage.
    pub speeds: Vec<f64>,
    /// The most by which they fall short of the wish, rad/s.
    pub short: f64,
    /// Samples in which the voltage was at its limit.
    pub limited: usize,
}

/// Share of the limit that plans of speed keep to; the rest is for what they do not know of: inductance and gravity.
const KEPT: f64 = 0.98;

impl Inverse {
    /// The speed (rad/s) at which a casing of mass M_t shakes with an acceleration of that amplitude (m/s²): ω = √(a M_t/(m_e r)); 0 where
    /// nothing moves.
    pub fn speed_of(&self, acceleration: f64) -> f64 {
        let per = self.parameters.casing.mass().map_or(0.0, |mass| mass / self.parameters.eccentric);
        let speed = (acceleration.max(0.0) * per).sqrt();
        if speed.is_finite() { speed } else { 0.0 }
    }

    /// The voltages for speeds (rad/s) at the beginning of each sample and at the end of the last. What is no number counts as 0.
    ///
    /// # Errors
    /// A number of the motor, the limit or the rate beyond its bounds.
    pub fn shape(&self, wished: &[f64]) -> Result<Shaped, Fault> {
        self.parameters.check()?;
        within("limit", self.limit, (1e-6, 1e6), "V")?;
        within("rate", self.rate, (1.0, 1e8), "samples a second")?;
        let sane = |w: &f64| if w.abs() <= 1e9 { *w } else { 0.0 };
        let wished: Vec<f64> = wished.iter().map(sane).collect();
        let mut speeds = wished.clone();
        self.make_feasible(&mut speeds);
        let short = wished.iter().zip(&speeds).fold(0.0_f64, |most, (w, s)| most.max((w - s).abs()));
        let (volts, limited) = self.voltages(&speeds);
        Ok(Shaped { volts, speeds, short, limited })
    }

    /// What is wished of size and direction, so that neither rises faster than the motor can, nor falls faster than it can be braked:
    /// forward for what speeds it up, backward for what slows it down.
    fn make_feasible(&self, speeds: &mut [f64]) {
        let (p, step) = (&self.parameters, 1.0 / self.rate);
        let full = p.stall_torque(self.limit) * KEPT;
        let rise = |speed: f64| ((full - p.damping() * speed - p.coulomb) / p.effective_inertia()).max(0.0);
        let fall = |speed: f64| (full + p.damping() * speed + p.coulomb) / p.effective_inertia();
        // From the one sample to the next it may pass through rest, and then it begins there.
        let reach = |speed: &mut f64, from: f64, by: &dyn Fn(f64) -> f64| {
            let from = if from * *speed > 0.0 { from.abs() } else { 0.0 };
            *speed = speed.abs().min(from + step * by(from)).copysign(*speed);
        };
        let mut from = 0.0;
        for speed in speeds.iter_mut() {
            reach(speed, from, &rise);
            from = *speed;
        }
        let mut to = 0.0;
        for speed in speeds.iter_mut().rev() {
            reach(speed, to, &fall);
            to = *speed;
        }
    }

    /// The mean voltage of each sample, and in how many it was at its limit.
    fn voltages(&self, speeds: &[f64]) -> (Vec<f64>, usize) {
        let p = &self.parameters;
        let (step, inertia) = (1.0 / self.rate, p.effective_inertia());
        let at = |n: usize| speeds.get(n).copied().unwrap_or(0.0);
        // Angle from the start, by the trapezoidal rule, at each instant.
        let (mut angle, weight) = (self.angle.unwrap_or(0.0), self.angle.map_or(0.0, |_| p.weight()));
        let rises = |n: usize| {
            let before = if n == 0 { 0.0 } else { at(n - 1) };
            (at(n + 1) - before) * 0.5 * self.rate
        };
        let current = |n: usize, angle: f64| {
            let friction = p.viscous * at(n) + p.coulomb * sign(at(n));
            (inertia * rises(n) + friction + weight * angle.sin()) / p.gain
        };
        let (mut volts, mut limited, mut owed) = (Vec::with_capacity(speeds.len()), 0, 0.0);
        let mut flows = 0.0;
        for n in 0..speeds.len().saturating_sub(1) {
            let turned = 0.5 * step * (at(n) + at(n + 1));
            let friction = p.viscous * turned + p.coulomb * step * sign(at(n) + at(n + 1));
            let pull = weight * step * (angle + 0.5 * turned).sin();
            let needed = (inertia * (at(n + 1) - at(n)) + friction + pull) / p.gain;
            let next =
                if n + 2 == speeds.len() && at(n + 1) == 0.0 { 0.0 } else { current(n + 1, angle + turned) };
            let wanted =
                (p.resistance * needed + p.gain * turned + p.inductance * (next - flows)) / step + owed;
            let given = wanted.clamp(-self.limit, self.limit);
            limited += usize::from(given != wanted);
            // What one sample could not give, the next ones do, as far as that is still of use.
            owed = (wanted - given).clamp(-self.limit, self.limit);
            volts.push(given);
            (angle, flows) = (angle + turned, next);
        }
        (volts, limited)
    }
}
