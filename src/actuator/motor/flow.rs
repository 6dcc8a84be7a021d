//! The exact motion of a rotor at constant voltage, while the torque beside the coil's follows a parabola.
//!
//! With a coil: L i' = V − R i − k ω, J ω' = k i − b ω + T. Where no voltage acts (open, or the current is held by the source), and where
//! the coil has no inductance (i = (V − k ω) / R), one equation remains: J ω' = −B ω + what drives.

use super::kernels::{Kernels, Matrix, Pair, of_number};

/// What flows and turns: current, A, and speed, rad/s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Motion {
    pub current: f64,
    pub speed: f64,
}

/// What acts over a time: volts at the terminals, and torque beside the coil's, N m, with its first and second derivative at the
/// beginning.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Push {
    pub volts: f64,
    pub torque: f64,
    pub slope: f64,
    pub curve: f64,
}

/// How far all went: current, speed and angle (rad).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Change {
    pub current: f64,
    pub speed: f64,
    pub angle: f64,
}

/// The numbers of a rotor and its coil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rotor {
    /// R, ohms.
    pub resistance: f64,
    /// L, henries; 0: none.
    pub inductance: f64,
    /// k, N m/A and V s.
    pub gain: f64,
    /// J, kg m².
    pub inertia: f64,
    /// b, N m s.
    pub viscous: f64,
}

/// How a rotor moves by itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flow {
    rotor: Rotor,
    /// 1/J, and 1/L where there is an inductance.
    inverse: (f64, f64),
    /// 1/R.
    conductance: f64,
    kind: Kind,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// Coil and rotor.
    Coil(Pair),
    /// Rotor alone: −B / J, and what the current changes with the speed.
    Single { pole: f64, follows: f64 },
}

impl Flow {
    /// At a voltage.
    pub fn of_voltage(rotor: &Rotor) -> Self {
        let Rotor { resistance: r, inductance: l, gain: k, inertia: j, viscous: b } = *rotor;
        let kind = if l > 0.0 {
            let a: Matrix = [[-r / l, -k / l], [k / j, -b / j]];
            Kind::Coil(Pair::new(a, (r / l) * (b / j) + (k / l) * (k / j)))
        } else {
            Kind::Single { pole: -(b + k * k / r) / j, follows: -k / r }
        };
        Self {
            rotor: *rotor,
            inverse: (1.0 / j, if l > 0.0 { 1.0 / l } else { 0.0 }),
            conductance: 1.0 / r,
            kind,
        }
    }

    /// At a current that stays as it is: held by the source, or none.
    pub fn of_current(rotor: &Rotor) -> Self {
        let kind = Kind::Single { pole: -rotor.viscous / rotor.inertia, follows: 0.0 };
        Self { rotor: *rotor, inverse: (1.0 / rotor.inertia, 0.0), conductance: 1.0 / rotor.resistance, kind }
    }

    /// Where voltage and speed dictate the current: what of each makes it.
    #[inline]
    pub fn dictates(&self) -> Option<(f64, f64)> {
        match self.kind {
            Kind::Single { follows, .. } if follows != 0.0 => Some((self.conductance, follows)),
            _ => None,
        }
    }

    /// The current that voltage and speed dictate, where they do.
    #[inline]
    pub fn dictated(&self, speed: f64, volts: f64) -> Option<f64> {
        self.dictates().map(|(of_volts, of_speed)| of_volts * volts + of_speed * speed)
    }

    /// What it is the flow of.
    pub fn rotor(&self) -> &Rotor {
        &self.rotor
    }

    /// Whether the current stays as it is.
    pub fn is_held(&self) -> bool {
        matches!(self.kind, Kind::Single { follows, .. } if follows == 0.0)
    }

    /// The largest |eigenvalue|, 1/s.
    pub fn fastest(&self) -> f64 {
        match &self.kind {
            Kind::Coil(pair) => pair.fastest(),
            Kind::Single { pole, .. } => pole.abs(),
        }
    }

    /// At what rate it turns by itself, rad/s.
    pub fn turning(&self) -> f64 {
        if let Kind::Coil(pair) = &self.kind { pair.turning() } else { 0.0 }
    }

    /// Derivatives of current and speed, A/s and rad/s².
    #[inline]
    pub fn rates(&self, x: Motion, push: &Push) -> Motion {
        let rotor = &self.rotor;
        let speed = (rotor.gain * x.current - rotor.viscous * x.speed + push.torque) * self.inverse.0;
        let current = match self.kind {
            Kind::Coil(_) => {
                (push.volts - rotor.resistance * x.current - rotor.gain * x.speed) * self.inverse.1
            }
            Kind::Single { follows, .. } => follows * speed,
        };
        Motion { current, speed }
    }

    /// The way to a later time.
    pub fn over(&self, t: f64) -> Way {
        let kernels = match &self.kind {
            Kind::Coil(pair) => Over::Coil(pair.over(t)),
            Kind::Single { pole, follows } => Over::Single(of_number(pole * t), *follows),
        };
        Way { t, lightness: self.inverse.0, kernels }
    }
}

/// A way to a later time, the same from every state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    t: f64,
    lightness: f64,
    kernels: Over,
}

#[derive(Debug, Clone, Copy)]
enum Over {
    Coil(Kernels),
    Single([f64; 4], f64),
}

impl Way {
    /// How far all goes, from derivatives and speed at the beginning.
    pub fn change(&self, rates: Motion, speed: f64, push: &Push) -> Change {
        let (t, slope, curve) = (self.t, push.slope * self.lightness, push.curve * self.lightness);
        match &self.kernels {
            Over::Coil(kernels) => {
                let v = [rates.current, rates.speed];
                let (one, two) = (kernels.times(1, v), kernels.times(2, v));
                let mut change =
                    Change { current: t * one[0], speed: t * one[1], angle: t * (speed + t * two[1]) };
                if slope != 0.0 || curve != 0.0 {
                    let (p, q) = ([0.0, slope], [0.0, curve]);
                    let (two, three) = (kernels.times(2, p), kernels.times(3, q));
                    change.current += t * t * (two[0] + t * three[0]);
                    change.speed += t * t * (two[1] + t * three[1]);
                    change.angle += t * t * t * (kernels.times(3, p)[1] + t * kernels.times(4, q)[1]);
                }
                change
            }
            Over::Single(phi, follows) => {
                let turned = t * (phi[0] * rates.speed + t * (phi[1] * slope + t * phi[2] * curve));
                let angle =
                    t * (speed + t * (phi[1] * rates.speed + t * (phi[2] * slope + t * phi[3] * curve)));
                Change { current: follows * turned, speed: turned, angle }
            }
        }
    }
}

#[cfg(test)]
mod tests;
