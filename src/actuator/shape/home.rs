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
    /// The same where resistance, torque constant, inertia or friction is 5 % less or more than was reckoned with, of 8 angles each: up to π. Where friction is
    /// several times the weight, what the creeping drive has to spare for the weight is little of it, and lost by little.
    pub astray: f64,
}

/// The speed at which it is as good as caught, rad/s: where friction is viscous rather than dry, it creeps ever more slowly.
const STILL: f64 = 0.01;

/// Seconds in which it must be caught, and in which it must have swung out once it is let go.
const CAUGHT: f64 = 4.0;

/// How much longer it is held and swings out, as from 64 angles the slowest is not known for certain.
const LONGER: f64 = 1.3;

/// By how much a figure may be off, as a share of it.
const OFF: f64 = 0.05;

/// What swings no farther rests, rad.
const RESTS: f64 = 1e-3;

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
    /// A number beyond its limits; no gravity; a voltage that does not start the motor from everywhere; a motor that nothing catches within 4 s, or that
    /// swings for longer than that once it is let go.
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
        let mut why = Unreachable::Adrift(CAUGHT);
        let mut rough: Vec<(f64, f64)> = Vec::new();
        for share in SHARES.map(|n| f64::from(n) / 20.0) {
            match caught(&some, share) {
                Ok(homed) => rough.push((homed.spread, share)),
                Err(other) => why = other,
            }
        }
        rough.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<Homed> = None;
        for (least, share) in rough {
            if best.as_ref().is_some_and(|best| best.spread <= least) {
                break;
            }
            match caught(&trials, share) {
                Ok(homed) => {
                    best = best.into_iter().chain([homed]).min_by(|a, b| a.spread.total_cmp(&b.spread));
                }
                Err(other) => why = other,
            }
        }
        let best = best.ok_or(why)?;
        Ok(Homed { astray: astray(parameters, &best)?, ..best })
    }

    /// Where those that spin come to rest when the creeping drive exceeds friction by a share of the weight.
    ///
    /// # Errors
    /// One of them does not.
    fn caught(
        &self,
        parameters: &Parameters,
        mut trials: Vec<Trial>,
        spin: f64,
        share: f64,
    ) -> Result<Homed, Unreachable> {
        let torque = parameters.coulomb + share * parameters.weight();
        let creep = (torque * parameters.resistance / parameters.gain).copysign(self.volts);
        let mut hold = 0.0_f64;
        for trial in &trials {
            let moves = |motor: &Motor| if motor.is_stuck() { 0.0 } else { motor.speed().abs() - STILL };
            let caught = trial.clone().until(Drive::Voltage(creep), CAUGHT, moves);
            hold = hold.max(caught.ok_or(Unreachable::Adrift(CAUGHT))?);
        }
        let hold = LONGER * hold + 1.0 / SLOW;
        let mut swings = 0.0_f64;
        for trial in &mut trials {
            trial.run(hold, Drive::Voltage(creep));
            // Whether friction holds it without the drive as well shows a step later.
            trial.run(1.0 / SLOW, Drive::SHORT);
            if !trial.motor.is_stuck() {
                let still = trial.until(Drive::SHORT, CAUGHT, |motor| swing(motor) - RESTS);
                swings = swings.max(still.ok_or(Unreachable::Swings(CAUGHT))? + 1.0 / SLOW);
            }
        }
        let first = trials.first().ok_or(Unreachable::Adrift(CAUGHT))?.angle();
        let off = trials.iter().map(|trial| (trial.angle() - first + PI).rem_euclid(TAU) - PI);
        let (least, most) = off.fold((0.0_f64, 0.0_f64), |(l, m), x| (l.min(x), m.max(x)));
        let course = Course::ending_in(Drive::SHORT)
            .then(spin, Drive::Voltage(self.volts))
            .then(hold, Drive::Voltage(creep))
            .then(LONGER * swings, Drive::SHORT);
        Ok(Homed { course, angle: first + 0.5 * (least + most), spread: 0.5 * (most - least), astray: PI })
    }
}

/// How far from where it should be one comes to rest that is not quite what it is said to be.
fn astray(p: &Parameters, homed: &Homed) -> Result<f64, Unreachable> {
    let others = |by: f64| {
        [
            Parameters { resistance: by * p.resistance, ..*p },
            Parameters { gain: by * p.gain, ..*p },
            Parameters { inertia: by * p.inertia, ..*p },
            Parameters { viscous: by * p.viscous, coulomb: by * p.coulomb, stiction: by * p.stiction, ..*p },
        ]
    };
    let mut most = homed.spread;
    for other in others(1.0 - OFF).into_iter().chain(others(1.0 + OFF)) {
        // A casing may be too light for less inertia.
        if other.check().is_err() {
            continue;
        }
        for begin in (0..TRIED).step_by(ROUGHLY).map(|n| TAU * f64::from(n) / f64::from(TRIED)) {
            let (mut trial, mut from) = (Trial::new(&other, begin, SLOW)?, 0.0);
            for (end, drive) in homed.course.pieces() {
                trial.run(end - from, *drive);
                from = *end;
            }
            trial.run(1.0 / SLOW, Drive::SHORT);
            let rests = trial.until(Drive::SHORT, CAUGHT, |motor| swing(motor) - RESTS);
            let off = ((trial.angle() - homed.angle + PI).rem_euclid(TAU) - PI).abs();
            most = most.max(if rests.is_some() { off } else { PI });
        }
    }
    Ok(most)
}

/// How far from its lowest place a mass that is left to itself can still get, rad, by what it has of energy: E = J ω²/2 + L i²/2 + m g r (1 − cos θ) never
/// grows, and with all of it as height 1 − cos θ = E/(m g r). 0 of one that friction holds, which stays where it is; infinite of one that can get over the top.
fn swing(motor: &Motor) -> f64 {
    if motor.is_stuck() {
        return 0.0;
    }
    let (p, speed, current) = (motor.parameters(), motor.speed(), motor.current());
    let moving = 0.5 * (p.effective_inertia() * speed * speed + p.inductance * current * current);
    // 1 − cos θ = 2 sin² θ/2, to all digits near the bottom.
    let height = (0.5 * angle(motor)).sin().powi(2) + 0.5 * moving / p.weight();
    if height < 1.0 { 2.0 * height.sqrt().asin() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::{CAUGHT, Drive, Home, Parameters, Trial, Unreachable};
    use crate::actuator::motor::GRAVITY;
    use std::f64::consts::{PI, TAU};

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
        let turn = trial.until(Drive::Voltage(volts), 10.0, |motor| TAU - motor.turned());
        assert!(turn.is_some());
        let torque = wheel.coulomb + 0.05 * wheel.weight();
        trial.run(CAUGHT, Drive::Voltage(torque * wheel.resistance / wheel.gain));
        assert!(trial.motor.speed() > 1.0, "{}", trial.motor.speed());
        let told = Unreachable::Adrift(CAUGHT).to_string();
        assert!(told.contains("within 4 s") && told.contains("tilt = 0.0"), "{told}");
    }

    /// Where friction does not hold a mass against its weight it swings down once it is let go: home is where it is when that is over, and the course lasts
    /// until then, from wherever it hung, also from angles that were not tried.
    #[test]
    fn what_gravity_moves_at_rest_is_home_when_it_has_swung_out() {
        let coin = Parameters { gravity: GRAVITY, ..Parameters::COIN };
        let light = |share: f64| Parameters {
            coulomb: 0.8 * share * coin.weight(),
            stiction: share * coin.weight(),
            ..coin
        };
        for (share, quick) in [(0.6, 1.0), (0.2, 1.0), (0.05, 1.0), (0.0, 1.0), (0.05, 0.3)] {
            // With less damping it swings to and fro.
            let motor = Parameters { gain: quick * coin.gain, ..light(share) };
            let homed = Home { volts: 1.5 * motor.start_volts() }.solve(&motor).unwrap();
            // What stays near the top as well as near the bottom is nowhere at home, and told to be.
            assert_eq!(homed.spread > std::f64::consts::FRAC_PI_4, share > 0.5, "{homed:?}");
            if share > 0.5 {
                continue;
            }
            let near = |angle: f64, of: f64| ((angle - of + PI).rem_euclid(TAU) - PI).abs();
            for begin in (0..23).map(|n| TAU * (f64::from(n) + 0.37) / 23.0) {
                let mut trial = Trial::new(&motor, begin, 48_000.0).unwrap();
                let mut before = 0.0;
                for (end, drive) in homed.course.pieces() {
                    trial.run(end - before, *drive);
                    before = *end;
                }
                let rests = trial.angle();
                assert!(
                    near(rests, homed.angle) < homed.spread + 0.01,
                    "{share} {quick} from {begin}: {rests} {homed:?}"
                );
                assert!(
                    rests.sin().abs() < share + 0.01,
                    "{share} {quick}: {rests}: it would not stay there"
                );
                trial.run(5.0, Drive::SHORT);
                assert!(
                    near(trial.angle(), rests) < 2e-3,
                    "{share} {quick} from {begin}: {rests} {}",
                    trial.angle()
                );
            }
        }
        // A mass that friction holds is let go, and there is nothing to wait for.
        assert_eq!(Home { volts: 1.5 * coin.start_volts() }.solve(&coin).unwrap().course.pieces().len(), 2);
    }

    /// One that hardly anything damps swings on, and that is said.
    #[test]
    fn what_swings_on_is_no_home() {
        let coin = Parameters { gravity: GRAVITY, ..Parameters::COIN };
        let free = Parameters {
            gain: 0.1 * coin.gain,
            viscous: 0.01 * coin.viscous,
            coulomb: 0.0,
            stiction: 0.0,
            ..coin
        };
        let told = Home { volts: 1.5 * free.start_volts() }.solve(&free).unwrap_err();
        // What is left of a swing falls with B/2J.
        assert!(free.damping() / (2.0 * free.effective_inertia()) * CAUGHT < 6.0);
        assert!(matches!(told, Unreachable::Swings(_) | Unreachable::Adrift(_)), "{told}");
        assert!(Unreachable::Swings(CAUGHT).to_string().contains("swings for more than 4 s"));
    }
}
