//! Up to a speed and down again, as fast as the voltage allows.

use super::course::Course;
use super::trial::{PATIENCE, RATE, Trial};
use super::unreachable::Unreachable;
use crate::actuator::fault::within;
use crate::actuator::motor::{Drive, Motor, Parameters};

/// A buzz with overdrive and active braking: the full voltage until the wanted speed is there, then what holds it; at the end the full
/// voltage backward until the rotor stands.
///
/// A voltage alone takes three time constants to 95 % of its speed, and a rotor that is left alone longer than that to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spin {
    /// The wanted speed, rad/s, either way.
    pub speed: f64,
    /// Seconds from the beginning until it is braked, 0 to 1e6.
    pub seconds: f64,
    /// What overdrives and brakes it, V.
    pub volts: f64,
    /// Where the mass hangs before, rad from straight down.
    pub angle: f64,
}

impl Spin {
    /// Works it out: at first the overdrive, then what holds the speed, then the brake; shorted behind that. Where the time is over before
    /// the speed is reached, it is braked from where it is.
    ///
    /// # Errors
    /// A number beyond its limits; a voltage that does not start the motor, or does not bring it to that speed within 10 s.
    pub fn solve(&self, parameters: &Parameters) -> Result<Course, Unreachable> {
        within("speed", self.speed.abs(), (1e-6, 1e6), "rad/s, either way")?;
        within("seconds", self.seconds, (0.0, 1e6), "s")?;
        within("volts", self.volts.abs(), (1e-6, 1e6), "V")?;
        within("angle", self.angle, (-1e6, 1e6), "rad")?;
        let sign = self.speed.signum();
        let (full, hold) = (self.volts.abs() * sign, held_by(parameters, self.speed));
        let mut trial = Trial::new(parameters, self.angle, RATE)?;
        let slow = |motor: &Motor| (self.speed - motor.speed()) * sign;
        let Some(up) = trial.until(Drive::Voltage(full), PATIENCE, slow) else {
            return Err(match trial.motor.is_stuck() {
                true => {
                    Unreachable::Start(Drive::Voltage(self.volts), Drive::Voltage(parameters.start_volts()))
                }
                false => Unreachable::Slow(Drive::Voltage(self.volts), PATIENCE),
            });
        };
        if up >= self.seconds {
            trial = Trial::new(parameters, self.angle, RATE)?;
            trial.run(self.seconds, Drive::Voltage(full));
        } else {
            trial.run(self.seconds - up, Drive::Voltage(hold));
        }
        let runs = |motor: &Motor| motor.speed() * sign;
        let brake = trial.until(Drive::Voltage(-full), PATIENCE, runs);
        let brake = brake.ok_or(Unreachable::Slow(Drive::Voltage(self.volts), PATIENCE))?;
        Ok(Course::ending_in(Drive::SHORT)
            .then(up.min(self.seconds), Drive::Voltage(full))
            .then(self.seconds - up, Drive::Voltage(hold))
            .then(brake, Drive::Voltage(-full)))
    }
}

/// The voltage at which a motor runs at a speed (rad/s) without gravity: (B ω + T_c) R/k. It is also the static map of envelopes.
pub fn held_by(parameters: &Parameters, speed: f64) -> f64 {
    let torque = parameters.damping() * speed + parameters.coulomb * sign(speed);
    torque * parameters.resistance / parameters.gain
}

/// 1, −1, or 0 of 0.
pub fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
