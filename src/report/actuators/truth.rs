//! What a problem comes to: Taylor series of order 24, restarted where friction or an end stop begins or ends to act.
//!
//! Those instants are found to the last place of the time by halving; places and speeds are summed with what rounding took off, so that
//! millions of pieces add nothing to the error. Against trajectories of 19 digits it is within 3e-16 of the rated speed and 6e-14 rad.

use super::equation::{Equation, State};
use super::problem::Problem;
use super::series::{Regime, Series};

/// Points of a piece at which it is looked whether something has happened.
const LOOKS: usize = 16;
/// Pieces of a sample, at most; what takes more has no truth.
const MOST: usize = 2000;

/// The states at the end of each sample. Not a number from where the motion is beyond the reach of the equation, or something happens
/// without end.
pub fn truth(problem: &Problem, rate: f64) -> Vec<State> {
    from(&problem.equation(), [0.0; 3], &problem.drives(rate), rate)
}

/// The same of any equation, from a first state, with what is held over each sample.
pub fn from(equation: &Equation, state: State, drives: &[f64], rate: f64) -> Vec<State> {
    let mut motion = Motion::new(*equation, state);
    drives.iter().map(|drive| motion.sample(*drive, 1.0 / rate)).collect()
}

/// What ends a regime.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// The speed would turn against friction.
    Stops,
    /// Friction does not hold it any more.
    BreaksAway,
    /// The end stop on a side.
    Meets(f64),
    /// It leaves the end stop.
    Leaves,
}

/// A motion.
#[derive(Debug, Clone)]
struct Motion {
    equation: Equation,
    state: State,
    /// What rounding took off it.
    lost: State,
    regime: Regime,
    /// What is held.
    drive: f64,
}

impl Motion {
    fn new(equation: Equation, state: State) -> Self {
        let mut new = Self { equation, state, lost: [0.0; 3], regime: Regime::default(), drive: 0.0 };
        if state[1] == 0.0 {
            new.grip();
        } else if equation.coulomb > 0.0 {
            new.regime.slips = 1f64.copysign(state[1]);
        }
        new
    }

    /// Holds a drive for a time.
    fn sample(&mut self, drive: f64, seconds: f64) -> State {
        self.drive = drive;
        let mut left = if self.state[2].is_nan() { f64::NAN } else { seconds };
        for _ in 0..MOST {
            // Not a number: it has left its reach before.
            if left.is_nan() || left <= 0.0 {
                return self.state;
            }
            let series = Series::new(&self.equation, &self.regime, self.state, drive);
            let time = series.reach(left);
            let end = self.end(&series, time);
            let time = end.map_or(time, |(time, _)| time);
            self.go(&series, time);
            left -= time;
            if let Some((_, what)) = end {
                self.turn(what);
            }
            let far = self.state[2].abs();
            if far.is_nan() || far > self.equation.reach {
                break;
            }
        }
        self.state = [f64::NAN; 3];
        self.state
    }

    fn go(&mut self, series: &Series, time: f64) {
        let change = series.change(time);
        for n in 0..3 {
            let (from, more) = (self.state[n], change[n] + self.lost[n]);
            let sum = from + more;
            let of_more = sum - from;
            self.lost[n] = (from - (sum - of_more)) + (more - of_more);
            self.state[n] = sum;
        }
    }

    /// What ends the regime, if a state is beyond its end.
    fn ended(&self, x: &State) -> Option<End> {
        let (e, r) = (&self.equation, &self.regime);
        let pushes = |side: f64| {
            let (depth, along) = (side * x[2] - e.stroke, side * x[1]);
            depth > 0.0 && e.stop_stiffness * depth + e.stop_damping * along > 0.0
        };
        if r.sticks && self.torque(x).abs() > e.stiction {
            return Some(End::BreaksAway);
        }
        if r.slips * x[1] < 0.0 {
            return Some(End::Stops);
        }
        if r.stop != 0.0 {
            return (!pushes(r.stop)).then_some(End::Leaves);
        }
        [1.0, -1.0].into_iter().find(|side| pushes(*side)).map(End::Meets)
    }

    /// The first instant within a time at which something ends the regime, and what.
    fn end(&self, series: &Series, time: f64) -> Option<(f64, End)> {
        let at = |look: usize| time * look as f64 / LOOKS as f64;
        let ended = |time: f64| self.ended(&series.at(time));
        let (look, mut what) = (1..=LOOKS).find_map(|look| Some((look, ended(at(look))?)))?;
        let (mut low, mut high) = (at(look - 1), at(look));
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return Some((high, what));
            }
            match ended(middle) {
                Some(sooner) => (high, what) = (middle, sooner),
                None => low = middle,
            }
        }
    }

    /// Takes on what comes after the end of a regime.
    fn turn(&mut self, end: End) {
        match end {
            End::Stops => {
                (self.state[1], self.lost[1]) = (0.0, 0.0);
                self.grip();
            }
            End::BreaksAway => {
                let slips = 1f64.copysign(self.torque(&self.state));
                self.regime = Regime { sticks: false, slips, ..self.regime };
            }
            End::Meets(side) => self.regime.stop = side,
            End::Leaves => self.regime.stop = 0.0,
        }
    }

    /// What friction has to hold at rest.
    fn torque(&self, x: &State) -> f64 {
        let e = &self.equation;
        e.gain * x[0] + e.direct * self.drive - e.weight * x[2].sin()
    }

    /// At rest: whether friction holds it, or in which sense it slips.
    fn grip(&mut self) {
        if self.equation.stiction > 0.0 {
            let torque = self.torque(&self.state);
            self.regime.sticks = torque.abs() <= self.equation.stiction;
            self.regime.slips = if self.regime.sticks { 0.0 } else { 1f64.copysign(torque) };
        }
    }
}

#[cfg(test)]
mod tests;
