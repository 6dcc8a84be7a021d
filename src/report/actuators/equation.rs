//! The differential equations of a coil and what it moves, as one would write them down.
//!
//! L di/dt = u − R i − B v, m dv/dt = B i − c v − K y − κ y³ − w sin y − f, dy/dt = v. For a rumble motor v is the speed and y the angle,
//! w the weight m_e g r, and f dry friction; for a voice coil y is the displacement, B = Bl (1 − y²/y_B²), κ = k/y_k², and f an end stop.

use crate::actuator::coil::bounds::EndStop;
use crate::actuator::coil::large::Shape;
use crate::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, VoiceCoil};
use crate::actuator::elementary::{cosine, exp, sine};
use crate::actuator::motor::Parameters;

/// Current (A), speed (rad/s or m/s), and angle or displacement (rad or m).
pub type State = [f64; 3];

/// Linear, as far as the terms go that [`Equation::pull`] adds.
pub const LINEAR: u8 = 0;
/// With gravity and dry friction.
pub const MOTOR: u8 = 1;
/// With a force factor that falls, a spring that stiffens, and an end stop.
pub const LARGE: u8 = 2;

/// Dry friction that is smoothed is half of it at about half this share of the rated speed.
const SMOOTH: f64 = 0.002;

/// The numbers of the equations; what is 0 is not there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Equation {
    /// R, ohms.
    pub resistance: f64,
    /// L, henries, above 0.
    pub inductance: f64,
    /// B at rest: N m/A or N/A.
    pub gain: f64,
    /// What the drive does at once, without a winding, N m or N a unit of it; 0: nothing.
    pub direct: f64,
    /// m: kg m² or kg.
    pub inertia: f64,
    /// c: N m s or N s/m.
    pub damping: f64,
    /// K, N/m.
    pub stiffness: f64,
    /// w, N m.
    pub weight: f64,
    /// Friction while it moves, N m.
    pub coulomb: f64,
    /// Friction at rest, N m.
    pub stiction: f64,
    /// Speed by which smoothed friction is tanh 1 of it, rad/s.
    pub smooth: f64,
    /// 1/y_B², 1/m².
    pub falls: f64,
    /// κ, N/m³.
    pub cubic: f64,
    /// Where B and κ y³ are known to, m: beyond, a truth is not a number.
    pub reach: f64,
    /// Where an end stop begins, m; infinite: there is none.
    pub stroke: f64,
    /// Its stiffness, N/m.
    pub stop_stiffness: f64,
    /// Its damping, N s/m.
    pub stop_damping: f64,
    /// 1/L and 1/m, as [`Equation::ready`] sets them.
    pub(super) inverse: [f64; 2],
}

impl Equation {
    /// Of a rumble motor.
    pub fn motor(p: &Parameters) -> Self {
        Self {
            resistance: p.resistance,
            inductance: p.inductance,
            gain: p.gain,
            inertia: p.effective_inertia(),
            damping: p.viscous,
            weight: p.weight(),
            coulomb: p.coulomb,
            stiction: p.stiction,
            smooth: SMOOTH * p.rated_speed(),
            ..Self::bare()
        }
        .ready()
    }

    /// Of an inertia (kg m²) on a bearing (N m s/rad) that the drive turns at once, as a torque. What else acts on it is set afterwards.
    pub fn turned(inertia: f64, damping: f64) -> Self {
        Self { inductance: 1.0, direct: 1.0, inertia, damping, ..Self::bare() }.ready()
    }

    /// Of a tactor on a skin of one branch; a second branch is left out.
    pub fn tactor(v: &VoiceCoil) -> Self {
        let tissue = match v.skin {
            Skin::None => Default::default(),
            Skin::One(tissue) | Skin::Two(tissue, _) => tissue,
        };
        Self {
            inertia: v.mass + tissue.mass,
            damping: v.suspension.damping + tissue.spring.damping,
            stiffness: v.suspension.stiffness + tissue.spring.stiffness,
            ..Self::coil(&v.coil)
        }
        .ready()
    }

    /// Of an inertial motor that no hand holds: slug against casing, with the reduced mass.
    pub fn inertial(m: &Inertial) -> Self {
        let (slug, casing) = (m.slug_mass, m.casing_mass + m.hand.mass);
        Self {
            inertia: slug * casing / (slug + casing),
            damping: m.suspension.damping,
            stiffness: m.suspension.stiffness,
            ..Self::coil(&m.coil)
        }
        .ready()
    }

    /// The same in large motion, with an end stop. `suspension` is what stiffens.
    pub fn in_large(self, suspension: &Spring, shape: &Shape, stop: &EndStop) -> Self {
        let inverse_square = |at: Option<f64>| at.map_or(0.0, |at| 1.0 / (at * at));
        Self {
            falls: inverse_square(shape.force_falls),
            cubic: suspension.stiffness * inverse_square(shape.stiffens),
            reach: shape.reach,
            stroke: stop.stroke,
            stop_stiffness: stop.spring.stiffness,
            stop_damping: stop.spring.damping,
            ..self
        }
    }

    fn coil(coil: &Coil) -> Self {
        Self {
            resistance: coil.resistance,
            inductance: coil.inductance,
            gain: coil.force_factor,
            ..Self::bare()
        }
    }

    fn bare() -> Self {
        Self { reach: f64::INFINITY, stroke: f64::INFINITY, ..Self::default() }
    }

    /// With what is divided by worked out beforehand, so that no method is slower than it must be.
    pub(super) fn ready(self) -> Self {
        Self { inverse: [1.0 / self.inductance, 1.0 / self.inertia], ..self }
    }

    /// Which terms it has: [`LINEAR`], [`MOTOR`] or [`LARGE`].
    pub fn kind(&self) -> u8 {
        if self.falls != 0.0 || self.cubic != 0.0 || self.stroke.is_finite() {
            LARGE
        } else if self.weight != 0.0 || self.coulomb != 0.0 {
            MOTOR
        } else {
            LINEAR
        }
    }

    /// B at a place.
    #[inline(always)]
    pub fn gain_at<const KIND: u8>(&self, place: f64) -> f64 {
        if KIND == LARGE { self.gain * (1.0 - self.falls * place * place) } else { self.gain }
    }

    /// What pulls beside coil and damping, dry friction aside: N m or N.
    #[inline(always)]
    pub fn pull<const KIND: u8>(&self, speed: f64, place: f64) -> f64 {
        let mut pull = -self.stiffness * place;
        if KIND == MOTOR && self.weight != 0.0 {
            pull -= self.weight * sine(place * std::f64::consts::FRAC_1_PI * 0.5);
        }
        if KIND == LARGE {
            let depth = place.abs() - self.stroke;
            pull -= self.cubic * place * place * place;
            if depth > 0.0 {
                let side = 1f64.copysign(place);
                pull -= side * (self.stop_stiffness * depth + self.stop_damping * side * speed).max(0.0);
            }
        }
        pull
    }

    /// Derivatives of current, speed and place without dry friction.
    #[inline(always)]
    pub fn rates<const KIND: u8>(&self, [current, speed, place]: State, drive: f64) -> State {
        let gain = self.gain_at::<KIND>(place);
        let force =
            gain * current - self.damping * speed + self.pull::<KIND>(speed, place) + self.direct * drive;
        let left = drive - self.resistance * current - gain * speed;
        [left * self.inverse[0], force * self.inverse[1], speed]
    }

    /// The same with dry friction as T_c tanh(ω/ω_s), ω_s = 0.002 of the rated speed: the way to have it without cases.
    #[inline(always)]
    pub fn smooth_rates<const KIND: u8>(&self, x: State, drive: f64) -> State {
        let mut rates = self.rates::<KIND>(x, drive);
        if KIND == MOTOR && self.coulomb != 0.0 {
            let e = exp(-2.0 * (x[1] / self.smooth).abs());
            let tanh = ((1.0 - e) / (1.0 + e)).copysign(x[1]);
            rates[1] -= self.coulomb * tanh * self.inverse[1];
        }
        rates
    }

    /// How [`Equation::rates`] change with the state.
    pub fn jacobian<const KIND: u8>(&self, [current, speed, place]: State) -> [State; 3] {
        let (gain, [l, m]) = (self.gain_at::<KIND>(place), self.inverse);
        let mut a = [
            [-self.resistance * l, -gain * l, 0.0],
            [gain * m, -self.damping * m, -self.stiffness * m],
            [0.0, 1.0, 0.0],
        ];
        if KIND == MOTOR {
            a[1][2] -= self.weight * cosine(place * std::f64::consts::FRAC_1_PI * 0.5) * m;
        }
        if KIND == LARGE {
            let slope = -2.0 * self.gain * self.falls * place;
            a[0][2] -= slope * speed * l;
            a[1][2] += (slope * current - 3.0 * self.cubic * place * place) * m;
            let (depth, along) = (place.abs() - self.stroke, speed * 1f64.copysign(place));
            if depth > 0.0 && self.stop_stiffness * depth + self.stop_damping * along > 0.0 {
                a[1][1] -= self.stop_damping * m;
                a[1][2] -= self.stop_stiffness * m;
            }
        }
        a
    }
}

#[cfg(test)]
mod tests;
