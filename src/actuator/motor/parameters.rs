//! What a rumble motor is made of.

use super::flow::Rotor;
use crate::actuator::fault::{Fault, Limit, within};

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// The numbers of a motor, its eccentric mass, and what it sits in.
///
/// [`Parameters::check`] says what is wrong with them. What is derived from them is only meant for those that passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Winding resistance R, 1e-3 to 1e9 ohms.
    pub resistance: f64,
    /// Winding inductance L, 1e-12 to 1e3 henries; 0: the current follows the voltage at once.
    pub inductance: f64,
    /// Torque a current gives and voltage a speed gives, k: 1e-9 to 1e3 N m/A, which is V s/rad.
    pub gain: f64,
    /// All that spins, about the shaft, J: 1e-18 to 1e3 kg m². The eccentric mass is part of it.
    pub inertia: f64,
    /// Viscous friction b, 0 to 1e3 N m s/rad.
    pub viscous: f64,
    /// Friction while it turns, T_c: 0 to 1e3 N m.
    pub coulomb: f64,
    /// Friction that holds it at rest, T_s: T_c to 1e3 N m. With 0 there is no dry friction at all.
    pub stiction: f64,
    /// Eccentric mass times the distance of its centre from the shaft, m_e r: 0 to 1e3 kg m.
    pub eccentric: f64,
    /// Gravity in the plane of rotation, 0 to 1000 m/s²: [`GRAVITY`] times the cosine of the tilt of that plane off upright.
    pub gravity: f64,
    /// What holds the motor.
    pub casing: Casing,
    /// What it is made for, 1e-6 to 1e6 V.
    pub rated_volts: f64,
}

/// What holds a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Casing {
    /// Something that does not move.
    Held,
    /// Nothing: casing and all that is fixed to it move freely in the plane of rotation.
    Free {
        /// All that moves, eccentric mass included, M_t: 1e-9 to 1e6 kg.
        mass: f64,
    },
    /// Springs. The eccentric mass moves the casing; that the casing moves in turn does not reach the rotor.
    Suspended {
        /// All that moves, eccentric mass included, M_t: 1e-9 to 1e6 kg.
        mass: f64,
        /// What holds it sideways.
        across: Suspension,
        /// What holds it up and down.
        upright: Suspension,
    },
}

/// A spring and a damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suspension {
    /// 0 to 1e12 N/m.
    pub stiffness: f64,
    /// 0 to 1e9 N s/m.
    pub damping: f64,
}

impl Casing {
    /// What moves, kg; `None` where nothing does.
    pub fn mass(&self) -> Option<f64> {
        match *self {
            Self::Held => None,
            Self::Free { mass } | Self::Suspended { mass, .. } => Some(mass),
        }
    }
}

impl Parameters {
    /// Whether such a motor can be.
    ///
    /// # Errors
    /// The first field that is beyond its limits. A free casing must be heavier than (m_e r)²/J: with less, the rotor would have no
    /// inertia left about the common centre of mass.
    pub fn check(&self) -> Result<(), Fault> {
        within("resistance", self.resistance, (1e-3, 1e9), "ohms")?;
        if self.inductance != 0.0 {
            within("inductance", self.inductance, (1e-12, 1e3), "henries, or 0 for none")?;
        }
        within("gain", self.gain, (1e-9, 1e3), "N m/A")?;
        within("inertia", self.inertia, (1e-18, 1e3), "kg m2")?;
        within("viscous", self.viscous, (0.0, 1e3), "N m s/rad")?;
        within("coulomb", self.coulomb, (0.0, 1e3), "N m")?;
        within("stiction", self.stiction, (self.coulomb, 1e3), "N m: no less than holds it while it turns")?;
        within("eccentric", self.eccentric, (0.0, 1e3), "kg m")?;
        within("gravity", self.gravity, (0.0, 1e3), "m/s2")?;
        within("rated_volts", self.rated_volts, (1e-6, 1e6), "V")?;
        if let Some(mass) = self.casing.mass() {
            within("casing mass", mass, (1e-9, 1e6), "kg")?;
        }
        match self.casing {
            Casing::Held => {}
            Casing::Free { mass } => {
                let least = self.eccentric * self.eccentric / self.inertia;
                if self.free_inertia(mass) < 1e-18 {
                    let least = Limit::Above(least);
                    return Err(Fault::because(
                        "casing mass",
                        mass,
                        least,
                        "in kg: (m_e r)²/J of what spins in it",
                    ));
                }
            }
            Casing::Suspended { across, upright, .. } => {
                for (stiffness, damping, by) in [
                    ("casing stiffness across", "casing damping across", across),
                    ("casing stiffness upright", "casing damping upright", upright),
                ] {
                    within(stiffness, by.stiffness, (0.0, 1e12), "N/m")?;
                    within(damping, by.damping, (0.0, 1e9), "N s/m")?;
                }
            }
        }
        Ok(())
    }

    fn free_inertia(&self, mass: f64) -> f64 {
        self.inertia - self.eccentric * self.eccentric / mass
    }

    /// The inertia a torque meets, J_e, kg m²: a free casing gives way, so that J_e = J − (m_e r)²/M_t.
    pub fn effective_inertia(&self) -> f64 {
        if let Casing::Free { mass } = self.casing { self.free_inertia(mass) } else { self.inertia }
    }

    /// Torque of gravity with the mass held level, m_e r g, N m.
    pub fn weight(&self) -> f64 {
        self.eccentric * self.gravity
    }

    /// Friction and back-EMF at a voltage, B = b + k²/R, N m s.
    pub fn damping(&self) -> f64 {
        self.viscous + self.gain * self.gain / self.resistance
    }

    /// L/R, s.
    pub fn electrical_time(&self) -> f64 {
        self.inductance / self.resistance
    }

    /// J_e/B, s.
    pub fn mechanical_time(&self) -> f64 {
        self.effective_inertia() / self.damping()
    }

    /// Torque at a voltage with the rotor held, k V/R, N m.
    pub fn stall_torque(&self, volts: f64) -> f64 {
        self.gain * volts / self.resistance
    }

    /// The speed at which it runs at a voltage, without gravity, rad/s; 0 where friction holds it.
    pub fn steady_speed(&self, volts: f64) -> f64 {
        let left = self.stall_torque(volts.abs()) - self.coulomb;
        (left / self.damping()).max(0.0).copysign(volts)
    }

    /// The current at that speed, A.
    pub fn steady_current(&self, volts: f64) -> f64 {
        (volts - self.gain * self.steady_speed(volts)) / self.resistance
    }

    /// What friction takes of the voltage while it turns, V: T_c R/k.
    pub fn running_volts(&self) -> f64 {
        self.coulomb * self.resistance / self.gain
    }

    /// The voltage that starts it from wherever the mass hangs: (T_s + m_e g r) R/k.
    pub fn start_volts(&self) -> f64 {
        (self.stiction + self.weight()) * self.resistance / self.gain
    }

    /// Speed at the rated voltage, rad/s.
    pub fn rated_speed(&self) -> f64 {
        self.steady_speed(self.rated_volts)
    }

    /// Casing acceleration at that speed, m_e r ω²/M_t, m/s²: what a free casing does, and one on springs far above their resonance;
    /// `None` where nothing moves.
    pub fn rated_acceleration(&self) -> Option<f64> {
        self.casing.mass().map(|mass| self.eccentric / mass * self.rated_speed() * self.rated_speed())
    }

    /// Rate at which the mass swings about its lowest place, √(m_e g r/J_e), rad/s.
    pub fn pendulum_rate(&self) -> f64 {
        (self.weight() / self.effective_inertia()).sqrt()
    }

    pub(super) fn rotor(&self, inductance: bool) -> Rotor {
        Rotor {
            resistance: self.resistance,
            inductance: if inductance { self.inductance } else { 0.0 },
            gain: self.gain,
            inertia: self.effective_inertia(),
            viscous: self.viscous,
        }
    }
}

#[cfg(test)]
impl Parameters {
    /// For tests: a coin motor of 10 mm on 100 g, upright.
    pub(crate) const COIN: Self = Self {
        resistance: 30.0,
        inductance: 3e-4,
        gain: 0.955e-3,
        inertia: 1.8e-9,
        viscous: 2.15e-8,
        coulomb: 1.5e-5,
        stiction: 2e-5,
        eccentric: 7.3e-7,
        gravity: GRAVITY,
        casing: Casing::Free { mass: 0.1 },
        rated_volts: 3.0,
    };
}

#[cfg(test)]
mod tests {
    use super::{Casing, Parameters, Suspension};

    /// The figures of the set `coin10`, as its author computed them: two or three digits each.
    #[test]
    fn the_derived_figures_are_those_of_the_set() {
        let p = Parameters::COIN;
        assert_eq!(p.check(), Ok(()));
        let near =
            |got: f64, expected: f64, by: f64| assert!((got - expected).abs() <= by, "{got} {expected}");
        near(p.electrical_time(), 10e-6, 1e-12);
        near(Parameters { casing: Casing::Held, ..p }.mechanical_time(), 34.681_524e-3, 1e-8);
        near(p.rated_speed(), 1551.0, 0.5);
        near(p.rated_acceleration().unwrap(), 17.6, 0.05);
        near(p.pendulum_rate(), 63.0, 0.2);
        near(p.start_volts() / 3.0, (2e-5 + 7.3e-7 * 9.80665) / p.stall_torque(3.0), 1e-12);
        let drawn = (p.damping() - p.gain * p.gain / 30.0) * 1551.0 / p.gain + 1.5e-5 / p.gain;
        near(p.steady_current(3.0), drawn, 1e-4);
        assert_eq!(p.steady_speed(-3.0), -p.rated_speed());
        assert_eq!(p.steady_speed(0.01), 0.0);
        assert_eq!(Parameters { casing: Casing::Held, ..p }.rated_acceleration(), None);
    }

    #[test]
    fn every_bad_value_is_named_with_its_limit() {
        let spring = Suspension { stiffness: 100.0, damping: 0.1 };
        let on = |across, upright| Casing::Suspended { mass: 0.1, across, upright };
        let p = Parameters::COIN;
        for (field, bad) in [
            ("resistance", Parameters { resistance: 0.0, ..p }),
            ("resistance", Parameters { resistance: -1.0, ..p }),
            ("resistance", Parameters { resistance: f64::INFINITY, ..p }),
            ("inductance", Parameters { inductance: -1e-6, ..p }),
            ("inductance", Parameters { inductance: 1e-300, ..p }),
            ("gain", Parameters { gain: 0.0, ..p }),
            ("inertia", Parameters { inertia: 0.0, ..p }),
            ("inertia", Parameters { inertia: f64::NAN, ..p }),
            ("viscous", Parameters { viscous: -1e-9, ..p }),
            ("coulomb", Parameters { coulomb: -1e-9, stiction: 1.0, ..p }),
            ("stiction", Parameters { stiction: 1.4e-5, ..p }),
            ("eccentric", Parameters { eccentric: -1e-9, ..p }),
            ("gravity", Parameters { gravity: -9.8, ..p }),
            ("rated_volts", Parameters { rated_volts: 0.0, ..p }),
            ("casing mass", Parameters { casing: Casing::Free { mass: 0.0 }, ..p }),
            ("casing mass", Parameters { casing: Casing::Free { mass: 2.9e-4 }, ..p }),
            (
                "casing mass",
                Parameters { casing: Casing::Suspended { mass: -1.0, across: spring, upright: spring }, ..p },
            ),
            (
                "casing stiffness across",
                Parameters { casing: on(Suspension { stiffness: -1.0, ..spring }, spring), ..p },
            ),
            (
                "casing damping upright",
                Parameters { casing: on(spring, Suspension { damping: f64::NAN, ..spring }), ..p },
            ),
        ] {
            let fault = bad.check().unwrap_err();
            assert_eq!(fault.field, field, "{bad:?}");
            assert!(fault.to_string().contains(field));
        }
        let light = Parameters { casing: Casing::Free { mass: 2.9e-4 }, ..p }.check().unwrap_err();
        assert!(
            light.to_string().starts_with("`casing mass` is 0.00029, but must be above 0.000296"),
            "{light}"
        );
        assert_eq!(
            Parameters { inductance: 0.0, stiction: 0.0, coulomb: 0.0, viscous: 0.0, ..p }.check(),
            Ok(())
        );
    }
}
