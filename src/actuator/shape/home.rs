//! Finding out where the mass hangs, without a sensor: gravity catches it.

use std::f64::consts::{PI, TAU};

use super::course::Course;
use super::trial::{PATIENCE, Trial, angle};
use super::unreachable::Unreachable;
use crate::actuator::fault::{Fault, Limit, within};
use crate::actuator::motor::{Drive, Motor, Parameters};

/// Brings the mass to the same place from wherever it hangs.
///
/// A spin that starts the motor from anywhere, then a voltage that keeps it creeping against friction and is too weak to lift the mass over
/// the top: it is caught on the way up. Where dry friction exceeds the mass's weight, as in most motors, it stays there when the voltage is taken
/// away. How much the creeping drive exceeds friction is chosen so that the mass comes to rest in the narrowest arc. It takes some tenths of
/// a second, and gravity: with the plane of rotation level there is nothing that could catch it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Home {
    /// What starts it, V: more than [`Parameters::start_volts`], either way.
    pub volts: f64,
}

/// Where a mass is brought.
#[derive(Debug, Clone, PartialEq)]
pub struct Homed {
    /// What to do.
    pub course: Course,
    /// Where it hangs then, rad from straight down: the middle of where it comes from 64 angles.
    pub angle: f64,
    /// The most by which it may hang elsewhere, rad: of those 64.
    pub spread: f64,
}

/// The speed at which it is as good as caught, rad/s: where friction is viscous rather than dry, it creeps ever more slowly.
const STILL: f64 = 0.01;

/// Seconds in which it must be caught.
const CAUGHT: f64 = 4.0;

/// Angles from which it is tried, of which every so manieth is tried first, and shares of the weight by which the creeping drive may exceed
/// friction: twentieths.
const TRIED: u32 = 64;
const ROUGHLY: usize = 8;
const SHARES: std::ops::Range<u32> = 1..19;
/// Steps a second: there is much to try, and nothing that is fast.
const SLOW: f64 = 8000.0;

impl Home {
    /// Works it out.
    ///
    /// # Errors
    /// A number beyond its limits; no gravity; a voltage that does not start the motor from everywhere; a motor that nothing catches within 4 s.
    pub fn solve(&self, parameters: &Parameters) -> Result<Homed, Unreachable> {
        within("volts", self.volts.abs(), (1e-6, 1e6), "V")?;
        parameters.check()?;
        if parameters.weight() == 0.0 {
            let why = "only gravity on an eccentric mass can catch it";
            return Err(Fault::because("gravity", parameters.gravity, Limit::Above(0.0), why).into());
        }
        if self.volts.abs() < parameters.start_volts() {
            return Err(Unreachable::Start(
                Drive::Voltage(self.volts),
                Drive::Voltage(parameters.start_volts()),
            ));
        }
        let angles = (0..TRIED).map(|n| TAU * f64::from(n) / f64::from(TRIED));
        let mut trials =
            angles.map(|angle| Trial::new(parameters, angle, SLOW)).collect::<Result<Vec<_>, _>>()?;
        // Until each has made a turn.
        let mut spin = 0.0_f64;
        for trial in &trials {
            let (mut alone, begin) = (trial.clone(), trial.angle());
            let left = |motor: &Motor| TAU - (angle(motor) - begin).abs();
            let turned = alone.until(Drive::Voltage(self.volts), PATIENCE, left);
            spin = spin.max(turned.ok_or(Unreachable::Slow(Drive::Voltage(self.volts), PATIENCE))?);
        }
        trials.iter_mut().for_each(|trial| trial.run(spin, Drive::Voltage(self.volts)));
        // What some of them show, the others can only make worse: so most shares need not be tried from all.
        let some: Vec<Trial> = trials.iter().step_by(ROUGHLY).cloned().collect();
        let caught = |trials: &[Trial], share: f64| self.caught(parameters, trials.to_vec(), spin, share);
        let shares = SHARES.map(|n| f64::from(n) / 20.0);
        let mut rough: Vec<(f64, f64)> =
            shares.filter_map(|share| Some((caught(&some, share)?.spread, share))).collect();
        rough.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<Homed> = None;
        for (least, share) in rough {
            if best.as_ref().is_some_and(|best| best.spread <= least) {
                break;
            }
            let homed = caught(&trials, share);
            best = best.into_iter().chain(homed).min_by(|a, b| a.spread.total_cmp(&b.spread));
        }
        best.ok_or(Unreachable::Adrift(CAUGHT))
    }

    /// Where those that spin come to rest when the creeping drive exceeds friction by a share of the weight; `None` where one does not.
    fn caught(
        &self,
        parameters: &Parameters,
        mut trials: Vec<Trial>,
        spin: f64,
        share: f64,
    ) -> Option<Homed> {
        let torque = parameters.coulomb + share * parameters.weight();
        let creep = (torque * parameters.resistance / parameters.gain).copysign(self.volts);
        let mut hold = 0.0_f64;
        for trial in &trials {
            let moves = |motor: &Motor| if motor.is_stuck() { 0.0 } else { motor.speed().abs() - STILL };
            hold = hold.max(trial.clone().until(Drive::Voltage(creep), CAUGHT, moves)? + 1.0 / SLOW);
        }
        for trial in &mut trials {
            trial.run(hold, Drive::Voltage(creep));
            trial.run(0.05, Drive::SHORT);
        }
        let first = trials.first()?.angle();
        let off = trials.iter().map(|trial| (trial.angle() - first + PI).rem_euclid(TAU) - PI);
        let (least, most) = off.fold((0.0_f64, 0.0_f64), |(l, m), x| (l.min(x), m.max(x)));
        let course = Course::ending_in(Drive::SHORT)
            .then(spin, Drive::Voltage(self.volts))
            .then(hold, Drive::Voltage(creep));
        Some(Homed { course, angle: first + 0.5 * (least + most), spread: 0.5 * (most - least) })
    }
}

#[cfg(test)]
mod tests {
    use super::{CAUGHT, Drive, Home, Parameters, Trial, Unreachable};
    use crate::actuator::motor::GRAVITY;

    /// A flywheel takes longer to slow down than it is waited for, by whichever drive that it creeps with: nothing catches it, and it is not said to be caught.
    #[test]
    fn what_spins_on_is_adrift() {
        let coin = Parameters { gravity: GRAVITY, ..Parameters::COIN };
        let volts = 1.5 * coin.start_volts();
        assert!(Home { volts }.solve(&coin).is_ok());
        let wheel = Parameters { inertia: 100.0 * coin.inertia, ..coin };
        assert_eq!(Home { volts }.solve(&wheel), Err(Unreachable::Adrift(CAUGHT)));
        // The same by hand: a turn, then the least drive that the search tries, as long as it waits; it turns all the while.
        let mut trial = Trial::new(&wheel, 0.0, 8000.0).unwrap();
        let turn = trial.until(Drive::Voltage(volts), 10.0, |motor| std::f64::consts::TAU - motor.turned());
        assert!(turn.is_some());
        let torque = wheel.coulomb + 0.05 * wheel.weight();
        trial.run(CAUGHT, Drive::Voltage(torque * wheel.resistance / wheel.gain));
        assert!(trial.motor.speed() > 1.0, "{}", trial.motor.speed());
        let told = Unreachable::Adrift(CAUGHT).to_string();
        assert!(told.contains("within 4 s") && told.contains("tilt = 0.0"), "{told}");
    }
}
