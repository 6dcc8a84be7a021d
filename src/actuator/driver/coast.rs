//! How a motor comes to rest by itself, with open terminals and lying flat: J ω' = −b ω − T_c.

use crate::actuator::elementary::exp_m1;
use crate::actuator::motor::Parameters;

/// A motor that rolls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coast {
    /// b/J, 1/s, and T_c/J, rad/s².
    viscous: f64,
    dry: f64,
}

/// The share of its full speed below which a motor stands.
pub const STANDS: f64 = 1e-4;

/// Below this share of what matters, a logarithm is taken by its first terms.
const SMALL: f64 = 1e-4;

impl Coast {
    /// Of a motor.
    pub fn new(parameters: &Parameters) -> Self {
        let inertia = parameters.effective_inertia();
        Self { viscous: parameters.viscous / inertia, dry: parameters.coulomb / inertia }
    }

    /// The speed (rad/s) after so many seconds, not below 0 both: ω e^(−z) − (T_c/J) t (1 − e^(−z))/z with z = b t/J, and 0 from where that is.
    pub fn after(&self, speed: f64, seconds: f64) -> f64 {
        let z = self.viscous * seconds;
        let lost = -exp_m1(-z);
        let mean = if z > 0.0 { lost / z } else { 1.0 };
        (speed - (lost * speed + mean * seconds * self.dry)).max(0.0)
    }

    /// How long it takes from a speed (rad/s, forward) down to another, s; infinite where nothing slows it, or dry friction lacks and it is
    /// to stand.
    pub fn seconds(&self, from: f64, to: f64) -> f64 {
        let (from, to) = (from.max(0.0), to.max(0.0));
        if from <= to {
            return 0.0;
        }
        // ln((b ω₁ + T)/(b ω₂ + T))/(b/J), and what that is without b.
        let slowest = self.viscous * to + self.dry;
        if slowest == 0.0 {
            return f64::INFINITY;
        }
        let share = self.viscous * (from - to) / slowest;
        if share < SMALL {
            return (from - to) / slowest * (1.0 - 0.5 * share);
        }
        share.ln_1p() / self.viscous
    }

    /// How far it turns from a speed (rad/s, forward) to rest, rad; infinite where nothing slows it.
    pub fn angle(&self, speed: f64) -> f64 {
        let speed = speed.max(0.0);
        if speed == 0.0 {
            return 0.0;
        }
        let share = self.viscous * speed / self.dry;
        if share < SMALL {
            return 0.5 * speed * speed / self.dry * (1.0 - share / 1.5);
        }
        let kept = if share.is_finite() { share.ln_1p() / share } else { 0.0 };
        speed / self.viscous * (1.0 - kept)
    }
}

#[cfg(test)]
mod tests {
    use super::Coast;
    use crate::actuator::motor::{Drive, Level, Motor, Parameters, Plan};

    /// The model with open terminals, from several speeds, with both kinds of friction and with either alone.
    #[test]
    fn it_rolls_as_the_model_does() {
        let coin = Parameters { gravity: 0.0, ..Parameters::COIN };
        for (viscous, coulomb) in
            [(coin.viscous, coin.coulomb), (0.0, coin.coulomb), (coin.viscous, 1e-11), (1e-13, coin.coulomb)]
        {
            let p = Parameters { viscous, coulomb, ..coin };
            let coast = Coast::new(&p);
            for speed in [1500.0, 100.0] {
                let rate = 8000.0;
                let mut motor = Motor::<false>::new(&p, &Plan::whole(Level::Default), rate).unwrap();
                motor.place(0.0, speed);
                motor.drive(Drive::Open);
                let (mut rolled, mut steps) = (speed, 0);
                let begin = motor.turned();
                while motor.speed() > 0.01 * speed {
                    motor.step();
                    rolled = coast.after(rolled, 1.0 / rate);
                    steps += 1;
                    assert!(
                        (motor.speed() - rolled).abs() < 1e-6 * speed,
                        "{viscous} {coulomb}: {} {rolled}",
                        motor.speed()
                    );
                }
                let took = coast.seconds(speed, motor.speed());
                assert!((took * rate - f64::from(steps)).abs() < 1.01, "{took} {steps}");
                let turned = coast.angle(speed) - coast.angle(motor.speed());
                assert!(
                    (motor.turned() - begin - turned).abs() < 1e-4 * turned + 0.02,
                    "{} {turned}",
                    motor.turned()
                );
            }
        }
    }

    /// The model with open terminals again, step for step and over a long step, of motors that are stopped by oil within 0.1 ms or within 10 s: steps
    /// are up to ten times that long.
    #[test]
    fn steps_may_be_long() {
        let coin = Parameters { gravity: 0.0, ..Parameters::COIN };
        let inertia = coin.effective_inertia();
        for time in [1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0] {
            // Dry friction that is nothing, that stops it at the end of what oil does, and that stops it long before.
            for dry in [0.0, 1e-3, 1.0, 30.0] {
                let viscous = inertia / time;
                let coulomb = dry * viscous * 1500.0;
                let p = Parameters { viscous, coulomb, stiction: coulomb, ..coin };
                let coast = Coast::new(&p);
                for rate in [1000.0, 8000.0, 192_000.0] {
                    let mut motor = Motor::<false>::new(&p, &Plan::whole(Level::Default), rate).unwrap();
                    motor.place(0.0, 1500.0);
                    motor.drive(Drive::Open);
                    let mut rolled = 1500.0;
                    for n in 1..=400 {
                        motor.step();
                        rolled = coast.after(rolled, 1.0 / rate);
                        let whole = coast.after(1500.0, f64::from(n) / rate);
                        for is in [rolled, whole] {
                            let off = (motor.speed() - is).abs();
                            assert!(off < 1e-9 * 1500.0, "{time} {dry} {rate} {n}: {} {is}", motor.speed());
                        }
                    }
                }
            }
        }
        let coast = Coast::new(&coin);
        assert_eq!((coast.after(1500.0, 0.0), coast.after(1500.0, 1e9)), (1500.0, 0.0));
    }

    #[test]
    fn what_nothing_slows_rolls_for_ever() {
        let free = Coast::new(&Parameters { viscous: 0.0, coulomb: 0.0, ..Parameters::COIN });
        assert_eq!((free.seconds(10.0, 0.0), free.angle(10.0)), (f64::INFINITY, f64::INFINITY));
        assert_eq!((free.seconds(0.0, 0.0), free.angle(0.0), free.after(3.0, 1.0)), (0.0, 0.0, 3.0));
        let oiled = Coast::new(&Parameters { coulomb: 0.0, ..Parameters::COIN });
        assert_eq!(oiled.seconds(10.0, 0.0), f64::INFINITY);
        assert!((oiled.seconds(10.0, 1.0) / (10.0_f64.ln() / oiled.viscous) - 1.0).abs() < 1e-12);
        assert!((oiled.angle(10.0) * oiled.viscous / 10.0 - 1.0).abs() < 1e-12);
    }
}
