//! What steps a knob, and which problems it is for.

use super::problem::Problem;
use crate::actuator::fault::Fault;
use crate::knob::plant::Plant;
use crate::knob::plant::parts::Hand;
use crate::knob::plant::rival::bristle::{Bristle, Bristled};
use crate::knob::plant::rival::implicit_coulomb::ImplicitCoulomb;
use crate::knob::plant::rival::integrator::{Method, Rival};

/// Stiffness of bristles, N m/rad: 10 µrad of give at 1 mN m; and damping by half the critical, N m s/rad; and the speed at which they lose
/// what they hold at rest, rad/s.
const BRISTLES: f64 = 100.0;
const BRISTLE_DAMPING: f64 = 0.0245;
const STRIBECK: f64 = 0.5;

/// A knob that is stepped. It is made for one rate.
pub trait Steps {
    /// Puts it at an angle (rad) with a speed (rad/s).
    fn place(&mut self, angle: f64, speed: f64);
    /// A step with a torque (N m) held over it.
    fn step(&mut self, torque: f64);
    /// Angle and speed.
    fn state(&self) -> (f64, f64);
    /// From a place, as many steps as there are torques: what is timed, within one call.
    fn run(&mut self, start: (f64, f64), torques: &[f64]);
}

macro_rules! steps {
    ($($of:ty: $place:expr, $step:expr;)*) => {
        $(impl Steps for $of {
            fn place(&mut self, angle: f64, speed: f64) {
                $place(self, angle, speed);
            }

            fn step(&mut self, torque: f64) {
                $step(self, torque);
            }

            fn state(&self) -> (f64, f64) {
                (self.angle(), self.speed())
            }

            fn run(&mut self, (angle, speed): (f64, f64), torques: &[f64]) {
                $place(self, angle, speed);
                for torque in torques {
                    $step(self, *torque);
                }
            }
        })*
    };
}

steps! {
    // Problems begin within the plant's limits.
    Plant: |k: &mut Plant, angle, speed| _ = Plant::place(k, angle, speed),
        |k: &mut Plant, torque| Plant::step(k, torque, &Hand::default());
    Rival: Rival::place, Rival::step;
    ImplicitCoulomb: ImplicitCoulomb::place, ImplicitCoulomb::step;
    Bristled: Bristled::place, Bristled::step;
}

/// A method that can be raced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    /// The project's own: exact between events, events at their instants.
    Exact,
    /// An integrator of its own accord, which judges friction and contact where it looks.
    Plain(Method),
    /// Coulomb friction by implicit Euler (Kikuuwe et al. 2006).
    Kikuuwe,
    /// Bristles of LuGre.
    LuGre,
    /// Bristles of Dahl.
    Dahl,
}

impl Contender {
    /// Those for a problem, the project's own first. Models of friction are for knobs that have some and nothing else.
    pub fn of(problem: &Problem) -> Vec<Self> {
        let plain = [
            Method::ForwardEuler,
            Method::SymplecticEuler,
            Method::RungeKutta4,
            Method::ImplicitMidpoint,
            Method::BackwardEuler,
        ];
        let mut all = vec![Self::Exact];
        all.extend(plain.map(Self::Plain));
        if problem.parameters.coulomb > 0.0 && problem.detent.is_none() && problem.parameters.stops.is_none()
        {
            all.extend([Self::Kikuuwe, Self::LuGre, Self::Dahl]);
        }
        all
    }

    /// What tables and pictures call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact, events",
            Self::Plain(Method::ForwardEuler) => "Euler",
            Self::Plain(Method::RungeKutta4) => "RK4",
            Self::Plain(method) => method.name(),
            Self::Kikuuwe => "Kikuuwe",
            Self::LuGre => "LuGre",
            Self::Dahl => "Dahl",
        }
    }

    /// Whether it is the project's own.
    pub fn is_own(self) -> bool {
        self == Self::Exact
    }

    /// Hands it, made for a problem and a rate, to what measures it.
    ///
    /// # Errors
    /// What keeps the method from it: parameters or a rate beyond its limits.
    pub fn made<T>(
        self,
        problem: &Problem,
        rate: f64,
        measure: &mut dyn FnMut(&mut dyn Steps) -> T,
    ) -> Result<T, Fault> {
        let p = &problem.parameters;
        Ok(match self {
            Self::Exact => measure(&mut Plant::new(&problem.build()?, rate)?),
            Self::Plain(method) => measure(&mut Rival::new(p, method, rate)?.cogged(&problem.wave()?)),
            Self::Kikuuwe => measure(&mut ImplicitCoulomb::new(p, rate)?),
            Self::LuGre => {
                let (stiffness, damping, stribeck) = (BRISTLES, BRISTLE_DAMPING, STRIBECK);
                measure(&mut Bristled::new(p, Bristle::LuGre { stiffness, damping, stribeck }, rate)?)
            }
            Self::Dahl => measure(&mut Bristled::new(p, Bristle::Dahl { stiffness: BRISTLES }, rate)?),
        })
    }
}
