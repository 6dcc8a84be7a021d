//! A motor behind diodes: they let current in and none out, and while they block, its terminals are open.

use super::carrier::Rectifier;
use crate::actuator::elementary::ln;
use crate::actuator::motor::{Drive, Level, Motor};

/// Diodes before a motor, in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diodes {
    rectifier: Rectifier,
    /// Seconds of a step of the motor.
    period: f64,
}

impl Diodes {
    /// Those before a motor that makes `rate` steps a second.
    pub fn new(rectifier: Rectifier, rate: f64) -> Self {
        Self { rectifier, period: 1.0 / rate }
    }

    /// One step of the motor, with the source at so many volts meanwhile. After each piece of it `seen` gets the motor, the volts at its
    /// terminals while current flowed (`None` where none did), and how long that was, s.
    ///
    /// The instant within the step at which the current ends is that for the speed at its beginning, which no inductance outlives.
    #[inline]
    pub fn step<const BOOKED: bool>(
        &self,
        motor: &mut Motor<BOOKED>,
        source: f64,
        mut seen: impl FnMut(&Motor<BOOKED>, Option<f64>, f64),
    ) {
        let volts = self.rectifier.behind(source);
        if volts - motor.parameters().gain * motor.speed() > 0.0 {
            motor.drive(Drive::Voltage(volts));
            motor.step();
            return seen(motor, Some(volts), self.period);
        }
        self.part(motor, source, 1.0, seen);
    }

    /// The same for a part of a step, its share within 0 to 1.
    pub fn part<const BOOKED: bool>(
        &self,
        motor: &mut Motor<BOOKED>,
        source: f64,
        share: f64,
        mut seen: impl FnMut(&Motor<BOOKED>, Option<f64>, f64),
    ) {
        let volts = self.rectifier.behind(source);
        let (p, plan) = (*motor.parameters(), *motor.plan());
        let has_coil = plan.inductance && plan.level != Level::Economy && p.inductance > 0.0;
        let emf = p.gain * motor.speed();
        let current = if has_coil { motor.current().max(0.0) } else { 0.0 };
        let beyond = (volts - emf) / p.resistance;
        // i(t) = i∞ + (i₀ − i∞) e^(−t R/L) with i∞ not above 0.
        let ends = if beyond > 0.0 {
            f64::INFINITY
        } else if current > 0.0 {
            p.electrical_time() * ln(((current - beyond) / -beyond).min(1e300)) / self.period
        } else {
            0.0
        };
        let flows = if beyond.is_nan() { share } else { ends.min(share) };
        if flows > 0.0 {
            motor.drive(Drive::Voltage(volts));
            move_on(motor, flows);
            seen(motor, Some(volts), flows * self.period);
        }
        if flows < share {
            motor.drive(Drive::Open);
            move_on(motor, share - flows);
            seen(motor, None, (share - flows) * self.period);
        }
    }
}

fn move_on<const BOOKED: bool>(motor: &mut Motor<BOOKED>, share: f64) {
    if share == 1.0 { motor.step() } else { motor.part(share) }
}

#[cfg(test)]
mod tests {
    use super::super::carrier::Rectifier;
    use super::Diodes;
    use crate::actuator::motor::{Level, Motor, Parameters, Plan};
    use std::f64::consts::TAU;

    /// A motor behind diodes at 48 000 steps a second with its source held, against the circuit's own equations in steps of 0.1 µs: with a
    /// current that is over at once, one that lasts a part of a half-wave, one that never ends.
    #[test]
    fn it_is_the_circuit() {
        let coin =
            Parameters { gravity: 0.0, stiction: 0.0, coulomb: 0.0, viscous: 2e-7, ..Parameters::COIN };
        for full_wave in [true, false] {
            for inductance in [0.0, 3e-4, 3e-3, 3e-2] {
                let p = Parameters { inductance, ..coin };
                let rectifier = Rectifier { full_wave, drop: 0.7 };
                let (rate, fine) = (48_000.0, 208);
                let mut motor = Motor::<false>::new(&p, &Plan::whole(Level::Default), rate).unwrap();
                let diodes = Diodes::new(rectifier, rate);
                let (mut speed, mut current, dt) = (0.0_f64, 0.0_f64, 1.0 / rate / f64::from(fine));
                let (mut charge, mut sum) = (0.0, 0.0);
                for n in 0..4800 {
                    let source = 5.0 * (TAU * 1710.0 * f64::from(n) / rate).sin();
                    let (mut before, mut turned) = (motor.current(), motor.turned());
                    diodes.step(&mut motor, source, |motor, volts, seconds| {
                        if let Some(volts) = volts {
                            let stored =
                                if inductance > 0.0 { inductance * (motor.current() - before) } else { 0.0 };
                            charge += (volts * seconds - stored - p.gain * (motor.turned() - turned))
                                / p.resistance;
                        }
                        (before, turned) = (motor.current(), motor.turned());
                    });
                    let given = if full_wave { source.abs() } else { source } - rectifier.drop;
                    for _ in 0..fine {
                        let beyond = given - p.gain * speed;
                        if inductance == 0.0 {
                            current = (beyond / p.resistance).max(0.0);
                        } else {
                            let change = |i: f64| dt / inductance * (beyond - p.resistance * i);
                            let middle = current + 0.5 * change(current);
                            current = (current + change(middle)).max(0.0);
                        }
                        sum += current * dt;
                        speed += dt / p.effective_inertia() * (p.gain * current - p.viscous * speed);
                    }
                }
                assert!(motor.current() >= -1e-6);
                assert!(
                    (motor.speed() / speed - 1.0).abs() < 2e-3,
                    "{full_wave} {inductance}: {} {speed}",
                    motor.speed()
                );
                assert!((charge / sum - 1.0).abs() < 2e-3, "{full_wave} {inductance}: {charge} {sum}");
            }
        }
    }
}
