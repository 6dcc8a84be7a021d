//! Coulomb friction by implicit Euler, in closed form.
//!
//! R. Kikuuwe, N. Takesue, A. Sano, H. Mochiyama, H. Fujimoto: "Admittance and impedance representations of friction based on implicit Euler
//! integration", IEEE Transactions on Robotics, 2006. The friction of a step is the one that the speed at its end asks for: J (v' − v) / h =
//! τ − b v' − f with f within ±T_c at v' = 0 and T_c sgn v' elsewhere. That inclusion has one solution, f = clamp(J v / h + τ, ±T_c): friction
//! stops the knob if it can within the step, and otherwise acts in full. It is stable at every step, does not chatter, holds at rest without
//! creeping, and errs by the instant of a stop, in first order.

use crate::actuator::fault::{Fault, within};
use crate::knob::plant::parameters::{MOST_TORQUE, Parameters};

/// A knob of one inertia, without stops, whose friction is judged at the end of each step.
#[derive(Debug, Clone)]
pub struct ImplicitCoulomb {
    parameters: Parameters,
    period: f64,
    angle: f64,
    speed: f64,
}

impl ImplicitCoulomb {
    /// At rest at 0 rad, for `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first parameter, or the rate, beyond its limits.
    pub fn new(parameters: &Parameters, rate: f64) -> Result<Self, Fault> {
        parameters.check()?;
        within("rate", rate, (1.0, 1e8), "steps a second")?;
        Ok(Self { parameters: *parameters, period: 1.0 / rate, angle: 0.0, speed: 0.0 })
    }

    /// Puts it at an angle (rad) with a speed (rad/s).
    pub fn place(&mut self, angle: f64, speed: f64) {
        (self.angle, self.speed) = (angle, speed);
    }

    /// Angle, rad.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Speed, rad/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Passes one step with a torque (N m) held over it; what is no number counts as none.
    pub fn step(&mut self, torque: f64) {
        let torque = if torque.abs() <= MOST_TORQUE { torque } else { 0.0 };
        let (p, h) = (&self.parameters, self.period);
        // At rest it is stiction that has to be overcome.
        if self.speed == 0.0 && torque.abs() <= p.stiction {
            return;
        }
        let push = p.inertia * self.speed + h * torque;
        let most = h * p.coulomb;
        if push.abs() <= most {
            self.speed = 0.0;
            return;
        }
        self.speed = (push - most.copysign(push)) / (p.inertia + h * p.viscous);
        self.angle += h * self.speed;
    }
}

#[cfg(test)]
mod tests {
    use super::{ImplicitCoulomb, Parameters};
    use crate::knob::plant::rotor::Rotor;

    fn parameters() -> Parameters {
        Parameters { coulomb: 1e-3, stiction: 1.4e-3, ..Parameters::default() }
    }

    /// Of first order: the error of where it stops falls as the step does.
    #[test]
    fn it_stops_closer_to_the_truth_at_shorter_steps() {
        let mut exact = Rotor::<false>::new(&parameters(), 1e3).unwrap();
        exact.place(0.0, 35.0).unwrap();
        (0..300).for_each(|_| exact.step(0.0));
        let error = |rate: f64| {
            let mut knob = ImplicitCoulomb::new(&parameters(), rate).unwrap();
            knob.place(0.0, 35.0);
            (0..(0.3 * rate) as usize).for_each(|_| knob.step(0.0));
            assert_eq!(knob.speed(), 0.0);
            (knob.angle() / exact.angle() - 1.0).abs()
        };
        let [one, four, sixteen] = [2e3, 8e3, 32e3].map(error);
        assert!(
            (3.6..4.4).contains(&(one / four)) && (3.6..4.4).contains(&(four / sixteen)),
            "{one} {four} {sixteen}"
        );
        assert!(one < 0.01, "{one}");
    }

    /// The step is the solution of its inclusion, whatever the numbers.
    #[test]
    fn the_closed_form_solves_the_inclusion() {
        let p = parameters();
        for rate in [10.0, 1e3, 1e6] {
            for n in 0..200 {
                let (v, torque) = (0.2 * f64::from(n % 20 - 10) + 0.01, 4e-4 * f64::from(n / 20 - 5));
                let mut knob = ImplicitCoulomb::new(&p, rate).unwrap();
                knob.place(0.0, v);
                knob.step(torque);
                let friction = torque - p.viscous * knob.speed() - p.inertia * (knob.speed() - v) * rate;
                let bound = p.coulomb * (1.0 + 1e-9) + 1e-15 * rate;
                assert!(friction.abs() <= bound, "{rate} {v} {torque}: {friction}");
                if knob.speed() != 0.0 {
                    let expected = p.coulomb.copysign(knob.speed());
                    assert!(
                        (friction - expected).abs() < 1e-9 * p.coulomb + 1e-15 * rate,
                        "{rate} {v} {torque}"
                    );
                }
            }
        }
    }

    #[test]
    fn it_holds_until_stiction_gives_way_and_never_creeps() {
        let mut knob = ImplicitCoulomb::new(&parameters(), 1e3).unwrap();
        for n in 0..10_000 {
            knob.step(1.39e-3 * (0.1 * f64::from(n)).sin());
        }
        assert_eq!((knob.angle(), knob.speed()), (0.0, 0.0));
        knob.step(1.41e-3);
        assert!(knob.speed() > 0.0);
        knob.step(f64::NAN);
        assert!(knob.speed().is_finite());
        assert_eq!(ImplicitCoulomb::new(&parameters(), f64::NAN).unwrap_err().field, "rate");
    }
}
