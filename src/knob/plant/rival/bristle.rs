//! Friction with a state: bristles that bend before they slip.
//!
//! LuGre (Canudas de Wit et al., 1995): ż = v − σ0 |v| z / g(v), T_f = σ0 z + σ1 ż + σ2 v, g = T_c + (T_s − T_c) e^{−(v/v_s)²}. Dahl (1968):
//! ż = v − σ0 |v| z / T_c, T_f = σ0 z. Both creep under a held torque below T_s, which set-valued friction does not, and slip at rates of
//! 1e3 to 1e7 1/s. The step freezes v over it, so that z is exact in it, and takes the speed implicitly: it is stable at every step, and of
//! first order.

use crate::actuator::elementary::exp;
use crate::actuator::fault::{Fault, within};
use crate::knob::plant::parameters::{MOST_TORQUE, Parameters};

/// The bristles, beside T_c, T_s and b of [`Parameters`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bristle {
    /// σ0 (1e-3 to 1e9 N m/rad), σ1 (0 to 1e3 N m s/rad) and v_s (1e-6 to 1e6 rad/s).
    LuGre {
        /// Stiffness of the bristles, N m/rad.
        stiffness: f64,
        /// Their damping, N m s/rad.
        damping: f64,
        /// Speed at which they lose what they hold beyond T_c, rad/s.
        stribeck: f64,
    },
    /// σ0, 1e-3 to 1e9 N m/rad.
    Dahl {
        /// Stiffness of the bristles, N m/rad.
        stiffness: f64,
    },
}

/// A knob of one inertia, without stops, on bristles.
#[derive(Debug, Clone)]
pub struct Bristled {
    parameters: Parameters,
    bristle: Bristle,
    period: f64,
    angle: f64,
    speed: f64,
    bent: f64,
}

impl Bristled {
    /// At rest at 0 rad, for `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first parameter, or the rate, beyond its limits: there has to be dry friction, of 1e-12 N m or more.
    pub fn new(parameters: &Parameters, bristle: Bristle, rate: f64) -> Result<Self, Fault> {
        parameters.check()?;
        within("rate", rate, (1.0, 1e8), "steps a second")?;
        within("coulomb", parameters.coulomb, (1e-12, 1e3), "N m, for there to be bristles")?;
        let (Bristle::LuGre { stiffness, .. } | Bristle::Dahl { stiffness }) = bristle;
        within("bristle stiffness", stiffness, (1e-3, 1e9), "N m/rad")?;
        if let Bristle::LuGre { damping, stribeck, .. } = bristle {
            within("bristle damping", damping, (0.0, 1e3), "N m s/rad")?;
            within("stribeck", stribeck, (1e-6, 1e6), "rad/s")?;
        }
        Ok(Self { parameters: *parameters, bristle, period: 1.0 / rate, angle: 0.0, speed: 0.0, bent: 0.0 })
    }

    /// Puts it at an angle (rad) with a speed (rad/s), its bristles straight.
    pub fn place(&mut self, angle: f64, speed: f64) {
        (self.angle, self.speed, self.bent) = (angle, speed, 0.0);
    }

    /// Angle, rad.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Speed, rad/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// How far the bristles are bent, rad.
    pub fn bent(&self) -> f64 {
        self.bent
    }

    /// Passes one step with a torque (N m) held over it; what is no number counts as none.
    pub fn step(&mut self, torque: f64) {
        let torque = if torque.abs() <= MOST_TORQUE { torque } else { 0.0 };
        let (p, h) = (&self.parameters, self.period);
        let (stiffness, damping, slips_at) = match self.bristle {
            Bristle::LuGre { stiffness, damping, stribeck } => {
                let x = self.speed / stribeck;
                (stiffness, damping, p.coulomb + (p.stiction - p.coulomb) * exp(-x * x))
            }
            Bristle::Dahl { stiffness } => (stiffness, 0.0, p.coulomb),
        };
        let (v, z) = (self.speed, self.bent);
        let rate = stiffness * v.abs() / slips_at;
        // With v frozen: z goes to where it slips, of which what follows v at once (h v) is taken with the new speed.
        let decay = exp(-rate * h);
        let share = if rate * h > 1e-8 { (1.0 - decay) / (rate * h) } else { 1.0 };
        // J (v' − v) / h = τ − b v' − σ0 z' − σ1 ż with z' = z e^{−r h} + h φ v' and so ż = v' − r z' = e^{−r h} (v' − r z).
        let (bends, kept) = (h * share, z * decay);
        let (drives, yields) = (damping * decay * rate * z, damping * decay);
        let weight = p.inertia + h * (p.viscous + yields + stiffness * bends);
        let speed = (p.inertia * v + h * (torque - stiffness * kept + drives)) / weight;
        self.bent = kept + bends * speed;
        self.speed = speed;
        self.angle += h * speed;
    }
}

#[cfg(test)]
mod tests {
    use super::{Bristle, Bristled, Parameters};
    use crate::knob::plant::rotor::Rotor;

    fn parameters() -> Parameters {
        Parameters { coulomb: 1e-3, stiction: 1e-3, ..Parameters::default() }
    }

    fn kinds(stiffness: f64) -> [Bristle; 2] {
        let damping = 2.0 * 0.5 * (stiffness * 6e-6f64).sqrt();
        [Bristle::LuGre { stiffness, damping, stribeck: 0.5 }, Bristle::Dahl { stiffness }]
    }

    /// Stiff bristles are Coulomb's friction: where it stops.
    #[test]
    fn stiff_ones_stop_where_coulomb_says() {
        let mut exact = Rotor::<false>::new(&parameters(), 1e3).unwrap();
        exact.place(0.0, 35.0).unwrap();
        (0..300).for_each(|_| exact.step(0.0));
        for kind in kinds(100.0) {
            let mut knob = Bristled::new(&parameters(), kind, 192e3).unwrap();
            knob.place(0.0, 35.0);
            (0..57_600).for_each(|_| knob.step(0.0));
            let error = (knob.angle() / exact.angle() - 1.0).abs();
            assert!(error < 1e-3, "{kind:?}: {error:e}");
        }
    }

    #[test]
    fn below_slipping_they_are_a_spring() {
        for kind in kinds(10.0) {
            let mut knob = Bristled::new(&parameters(), kind, 48e3).unwrap();
            (0..48_000).for_each(|_| knob.step(0.2e-3));
            assert!((knob.bent() / 2e-5 - 1.0).abs() < 0.3, "{kind:?} {}", knob.bent());
            assert!(knob.angle() < 1e-3, "{kind:?} {}", knob.angle());
        }
    }

    #[test]
    fn they_are_stable_however_stiff() {
        for stiffness in [1.0, 1e3, 1e5, 1e9] {
            for kind in kinds(stiffness) {
                for rate in [1e3, 48e3] {
                    let mut knob = Bristled::new(&parameters(), kind, rate).unwrap();
                    for n in 0..2000 {
                        knob.step(5e-3 * (f64::from(n) * 188.0 / rate).sin());
                        assert!(knob.speed().abs() < 200.0 && knob.bent().is_finite(), "{kind:?} {rate}");
                    }
                }
            }
        }
        assert!(Bristled::new(&Parameters::default(), kinds(1.0)[0], 1e3).is_err());
        assert!(Bristled::new(&parameters(), Bristle::Dahl { stiffness: 0.0 }, 1e3).is_err());
    }
}
