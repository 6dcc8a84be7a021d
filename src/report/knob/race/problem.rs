//! What is computed: a knob of one inertia, what acts on it, from where.

use crate::actuator::fault::Fault;
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::Build;
use crate::knob::plant::stops::Stops;
use crate::knob::plant::wave::Wave;
use crate::report::actuators::equation::{Equation, State};
use crate::report::actuators::truth;

/// A problem. Torques are held over each step, of the truth as of every method, so that errors are the methods' alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// A word or two: "free run".
    pub name: &'static str,
    /// What happens in it, in a line.
    pub about: &'static str,
    /// The knob. With stops it has one, above, and no dry friction.
    pub parameters: Parameters,
    /// A detent that acts continuously: its torque (N m) and how many there are in a turn.
    pub detent: Option<(f64, f64)>,
    /// Angle (rad) and speed (rad/s) to begin with.
    pub start: (f64, f64),
    /// Torque over time, a saw: rises to this (N m) within that (s), falls to 0, and again.
    pub saw: Option<(f64, f64)>,
    /// Until when it is looked at.
    pub seconds: f64,
}

/// What truths are shifted by where there is a stop: they have two, this far from the middle, rad.
const ASIDE: f64 = 1.0;

impl Problem {
    /// What is held over each step: the torque where the step begins.
    pub fn torques(&self, rate: f64) -> Vec<f64> {
        let steps = (self.seconds * rate).round().max(1.0) as usize;
        let at = |n: usize| {
            self.saw.map_or(0.0, |(most, rise)| {
                // An instant that rounding puts just before the end of a tooth belongs to the next.
                let teeth = n as f64 / rate / rise + 1e-9;
                most * (teeth - teeth.floor()).max(0.0)
            })
        };
        (0..steps).map(at).collect()
    }

    /// What [`Plant`](crate::knob::plant::Plant) is made of.
    ///
    /// # Errors
    /// A detent that cannot be.
    pub fn build(&self) -> Result<Build, Fault> {
        Ok(Build { parameters: self.parameters, cogging: self.wave()?, ..Build::default() })
    }

    /// Torque over the angle.
    ///
    /// # Errors
    /// A detent that cannot be.
    pub fn wave(&self) -> Result<Wave, Fault> {
        self.detent.map_or(Ok(Wave::default()), |(torque, periods)| Wave::detent(torque, periods))
    }

    /// Angle and speed at the end of each step: Taylor series of order 24 with events found by halving, of another room and without a
    /// line in common with what is raced. Tested against closed forms and trajectories of 50 digits, it is within 1e-13 of the largest
    /// speed.
    pub fn truth(&self, rate: f64) -> Vec<(f64, f64)> {
        let (p, (angle, speed)) = (&self.parameters, self.start);
        // With N times the angle for a detent, whose pull is then that of gravity on a pendulum.
        let (times, pull) = self.detent.map_or((1.0, 0.0), |(torque, periods)| (periods, torque));
        let mut equation = Equation::turned(p.inertia / times, p.viscous / times);
        (equation.coulomb, equation.stiction, equation.weight) = (p.coulomb, p.stiction, pull);
        let mut shift = 0.0;
        if let Some(stops) = p.stops {
            (equation.stroke, shift) = (ASIDE, ASIDE - stops.high);
            (equation.stop_stiffness, equation.stop_damping) = (stops.stiffness, stops.damping);
        }
        let start: State = [0.0, times * speed, times * angle + shift];
        let states = truth::from(&equation, start, &self.torques(rate), rate);
        states.into_iter().map(|[_, speed, place]| ((place - shift) / times, speed / times)).collect()
    }
}

const KNOB: Parameters =
    Parameters { inertia: 6e-6, viscous: 2e-5, coulomb: 0.0, stiction: 0.0, stops: None };

/// Those that are raced: friction twice, a wall soft and stiff, a detent.
pub fn listed() -> Vec<Problem> {
    let free = Problem {
        name: "free run",
        about: "from 35 rad/s, T_c 1 mN m, b 20 µN m s/rad, until it stands",
        parameters: Parameters { coulomb: 1e-3, stiction: 1e-3, ..KNOB },
        detent: None,
        start: (0.0, 35.0),
        saw: None,
        seconds: 0.2,
    };
    let wall = |name, about, stiffness| {
        let stops = Stops::of_ratio(f64::NEG_INFINITY, 0.0, stiffness, 0.05, KNOB.inertia);
        Problem {
            name,
            about,
            parameters: Parameters { stops: Some(stops), ..KNOB },
            start: (-0.0503, 20.0),
            seconds: 0.03,
            ..free.clone()
        }
    };
    vec![
        free.clone(),
        Problem {
            name: "stick-slip",
            about: "torque rises to 1.5 mN m in 50 ms, four times; T_c 1, T_s 1.4 mN m",
            parameters: Parameters { coulomb: 1e-3, stiction: 1.4e-3, ..KNOB },
            start: (0.0, 0.0),
            saw: Some((1.5e-3, 0.05)),
            ..free.clone()
        },
        wall("soft wall", "20 rad/s against 0.4 N m/rad, damped by 0.05: contact 12 ms", 0.4),
        wall("stiff wall", "20 rad/s against 400 N m/rad, damped by 0.05: contact 0.38 ms", 400.0),
        Problem {
            name: "detent",
            about: "9 rad/s through detents of 8 mN m, 24 a turn, until it swings in one",
            parameters: KNOB,
            detent: Some((8e-3, 24.0)),
            start: (0.02, 9.0),
            seconds: 0.05,
            ..free
        },
    ]
}
