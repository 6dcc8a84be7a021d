//! Clicks and thumps: the rotor is thrown forward and stopped.

use std::f64::consts::TAU;

use super::course::Course;
use super::root::root;
use super::trial::{PATIENCE, RATE, Trial, angle};
use super::unreachable::Unreachable;
use crate::actuator::fault::{Fault, Limit, within};
use crate::actuator::motor::{Drive, Motor, Parameters};

/// A short movement that begins and ends at rest: a click of a part of a turn, a thump of one or a few.
///
/// The drive goes forward, then backward until the rotor stands still. Backward for as long as forward would leave it running the wrong
/// way: friction and back-EMF help to stop what they hindered. The instants are found on the motor's own model, with its inductance and,
/// where the mass is known to hang, gravity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Click {
    /// By how much the mass turns altogether: 1e-4 to 1000 turns, negative backward. With [`Ending::Stopped`] until the drive ends.
    pub turns: f64,
    /// What it is driven with either way: a voltage, or a current.
    pub drive: Drive,
    /// Where the mass hangs before, rad from straight down.
    pub angle: f64,
    /// How it ends.
    pub ending: Ending,
}

/// How a click ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The drive ends, in a short circuit or a current of 0, as soon as the rotor stands still. What then still runs in the coil gives it a last push
    /// back; in a small motor it is gone in microseconds.
    Stopped,
    /// A last forward pulse takes the current out of the coil as well, so that rotor and coil come to rest together.
    Settled,
}

/// A click that was worked out.
#[derive(Debug, Clone, PartialEq)]
pub struct Clicked {
    /// What to do.
    pub course: Course,
    /// Seconds forward, backward, and forward again.
    pub seconds: [f64; 3],
    /// The largest speed, rad/s.
    pub peak_speed: f64,
    /// The speed when the drive ends, rad/s.
    pub left: f64,
    /// Where the mass hangs when the drive ends, rad from straight down, whole turns included.
    pub angle: f64,
}

impl Click {
    /// Works it out.
    ///
    /// # Errors
    /// A number beyond its limits; a drive that does not start the motor, or does not turn it that far within 10 s.
    pub fn solve(&self, parameters: &Parameters) -> Result<Clicked, Unreachable> {
        self.check()?;
        let drive = self.drive.with(self.drive.amount().abs().copysign(self.turns));
        let at_rest = Trial::new(parameters, self.angle, RATE)?;
        let far = TAU * self.turns.abs();
        let turned = |trial: &Trial| (trial.angle() - at_rest.angle()) * self.turns.signum();
        // The forward drive is over by the time at which it alone has turned the mass that far.
        let mut whole = at_rest.clone();
        let begin = at_rest.angle();
        let left = |motor: &Motor| far - (angle(motor) - begin) * self.turns.signum();
        let Some(most) = whole.until(drive, PATIENCE, left) else {
            let never = turned(&whole) < 1e-3 && whole.motor.is_stuck();
            return Err(match never {
                true => Unreachable::Start(self.drive, starts(parameters, self.drive)),
                false => Unreachable::Slow(self.drive, PATIENCE),
            });
        };
        let beyond = |click: &Clicked| (click.angle - begin) * self.turns.signum() - far;
        let farthest = self.try_for(&at_rest, most, drive)?;
        let mut failed = None;
        let forward = root((0.0, -far), (most, beyond(&farthest)), |forward| {
            self.try_for(&at_rest, forward, drive).map_or_else(
                |why| {
                    failed = Some(why);
                    0.0
                },
                |click| beyond(&click),
            )
        });
        failed.map_or_else(|| self.try_for(&at_rest, forward, drive), Err)
    }

    fn check(&self) -> Result<(), Unreachable> {
        within("turns", self.turns.abs(), (1e-4, 1000.0), "turns, either way")?;
        match self.drive {
            Drive::Voltage(volts) => within("volts", volts.abs(), (1e-6, 1e6), "V"),
            Drive::Current { amperes, limit } => within("amperes", amperes.abs(), (1e-6, 1e6), "A")
                .and_then(|()| within("compliance", limit, (1e-6, 1e6), "V")),
            Drive::Open => Err(Fault::because("drive", 0.0, Limit::Absent, "open terminals turn nothing")),
        }?;
        within("angle", self.angle, (-1e6, 1e6), "rad")?;
        Ok(())
    }

    /// Forward for so long, and then to rest.
    fn try_for(&self, at_rest: &Trial, forward: f64, drive: Drive) -> Result<Clicked, Unreachable> {
        let mut trial = at_rest.clone();
        let (sign, reverse) = (drive.amount().signum(), drive.with(-drive.amount()));
        trial.run(forward, drive);
        let fast = trial.clone();
        let late = || Unreachable::Slow(self.drive, PATIENCE);
        let running = |motor: &Motor| motor.speed() * sign;
        let stop = trial.until(reverse, PATIENCE, running).ok_or_else(late)?;
        let (mut backward, mut again) = (stop, 0.0);
        // The coil still turns it faster for a while after the switch.
        let mut peak = fast.clone();
        let rising = |motor: &Motor| motor.angular_acceleration() * sign;
        peak.until(reverse, stop, rising);
        if self.ending == Ending::Settled && trial.motor.current() * sign < 0.0 {
            // With a shorter way back, the pulse that empties the coil ends with the rotor still running: longer, and it runs backward.
            let runs_on = |trial: &Trial| trial.motor.speed() * sign;
            let emptied = |backward: f64| {
                let mut trial = fast.clone();
                trial.run(backward, reverse);
                let empties = |motor: &Motor| -motor.current() * sign;
                trial.until(drive, PATIENCE, empties).map(|again| (again, trial))
            };
            let ends = |backward: f64| emptied(backward).map_or(f64::NAN, |(_, trial)| runs_on(&trial));
            backward = root((0.0, runs_on(&fast)), (stop, ends(stop)), ends);
            (again, trial) = emptied(backward).ok_or_else(late)?;
        }
        let course = Course::ending_in(drive.with(0.0))
            .then(forward, drive)
            .then(backward, reverse)
            .then(again, drive);
        Ok(Clicked {
            course,
            seconds: [forward, backward, again],
            peak_speed: peak.motor.speed().abs(),
            left: trial.motor.speed(),
            angle: trial.angle(),
        })
    }
}

/// The drive of a kind that starts a motor from wherever its mass hangs.
pub fn starts(parameters: &Parameters, of: Drive) -> Drive {
    match of {
        Drive::Current { .. } => of.with(parameters.start_volts() / parameters.resistance),
        _ => Drive::Voltage(parameters.start_volts()),
    }
}
