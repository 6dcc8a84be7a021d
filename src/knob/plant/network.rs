//! Everything of a knob that is linear, as a matrix for each of the states that friction, stops and supply can be in.

use super::parts::{Build, Drive};
use crate::actuator::elementary::{exp, ln};
use crate::actuator::exponential::{MOST, Square, exponential};

/// Angle and speed of the motor, then those of the knob, current and integral of the loop, where the hand holds: as far as there are such.
pub(super) type State = [f64; MOST];
/// Angle and speed of the motor.
pub(super) const ANGLE: usize = 0;
pub(super) const SPEED: usize = 1;

/// Which of the things that switch do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Mode {
    pub stuck: bool,
    pub touching: bool,
    pub saturated: bool,
}

impl Mode {
    pub fn index(self) -> usize {
        usize::from(self.stuck) | usize::from(self.touching) << 1 | usize::from(self.saturated) << 2
    }
}

/// ẋ = A x + f.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linear {
    pub matrix: Square,
    /// ∫ e^{A s} ds over a piece of a step: x moves by that times ẋ.
    pub passes: Square,
}

/// Where each thing is in a state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Network {
    pub size: usize,
    /// Angle of what hand and stops act on; its speed is the next.
    pub knob: usize,
    pub current: Option<usize>,
    pub integral: Option<usize>,
    pub target: Option<usize>,
    /// Of the winding as warm as it is, ohms; what the current loop was set for is that of its build.
    pub resistance: f64,
    pub build: Build,
}

impl Network {
    pub fn new(build: &Build) -> Self {
        let mut size = 2;
        let mut take = |wanted: bool, many: usize| {
            let at = size;
            size += if wanted { many } else { 0 };
            wanted.then_some(at)
        };
        let knob = take(build.shaft.is_some(), 2).unwrap_or(0);
        let current = take(build.winding().is_some(), 1);
        let integral = take(matches!(build.drive, Drive::Current { .. }), 1);
        let target = take(build.grasp.is_some(), 1);
        let resistance = build.winding().map_or(0.0, |winding| winding.resistance);
        Self { size, knob, current, integral, target, resistance, build: *build }
    }

    /// Inertia of what hand and stops act on.
    pub fn knob_inertia(&self) -> f64 {
        self.build.shaft.map_or(self.build.parameters.inertia, |shaft| shaft.inertia)
    }

    /// K_p and K_i of the current loop.
    pub fn loop_gains(&self) -> (f64, f64) {
        match self.build.drive {
            Drive::Current { winding, bandwidth, .. } => {
                (winding.inductance * bandwidth, winding.resistance * bandwidth)
            }
            _ => (0.0, 0.0),
        }
    }

    /// Whether it can be in a mode at all.
    pub fn comes_into(&self, mode: Mode) -> bool {
        let p = &self.build.parameters;
        (!mode.stuck || p.stiction > 0.0)
            && (!mode.touching || p.stops.is_some())
            && (!mode.saturated || self.integral.is_some())
    }

    /// A of a mode.
    pub fn matrix(&self, mode: Mode) -> Square {
        let mut a = [[0.0; MOST]; MOST];
        let p = &self.build.parameters;
        a[ANGLE][SPEED] = 1.0;
        a[SPEED][SPEED] = -p.viscous / p.inertia;
        if let Some(shaft) = &self.build.shaft {
            let (angle, speed) = (self.knob, self.knob + 1);
            a[angle][speed] = 1.0;
            a[speed][speed] = -shaft.viscous / shaft.inertia;
            for (row, inertia, sign) in [(SPEED, p.inertia, -1.0), (speed, shaft.inertia, 1.0)] {
                let (spring, damper) = (sign * shaft.stiffness / inertia, sign * shaft.damping / inertia);
                a[row][ANGLE] += spring;
                a[row][angle] -= spring;
                a[row][SPEED] += damper;
                a[row][speed] -= damper;
            }
        }
        let (angle, speed, inertia) = (self.knob, self.knob + 1, self.knob_inertia());
        if let (Some(grasp), Some(target)) = (&self.build.grasp, self.target) {
            a[speed][angle] -= grasp.stiffness / inertia;
            a[speed][speed] -= grasp.damping / inertia;
            a[speed][target] += grasp.stiffness / inertia;
        }
        if let Some(stops) = p.stops.filter(|_| mode.touching) {
            a[speed][angle] -= stops.stiffness / inertia;
            a[speed][speed] -= stops.damping / inertia;
        }
        if let (Some(winding), Some(i)) = (self.build.winding(), self.current) {
            a[SPEED][i] = winding.gain / p.inertia;
            a[i][i] = -self.resistance / winding.inductance;
            a[i][SPEED] = -winding.gain / winding.inductance;
            if let Some(q) = self.integral {
                let (proportional, integral) = self.loop_gains();
                if mode.saturated {
                    a[q][q] = -integral / proportional;
                } else {
                    a[i][i] -= proportional / winding.inductance;
                    a[i][q] = integral / winding.inductance;
                    a[q][i] = -1.0;
                }
            }
        }
        if mode.stuck {
            a[SPEED] = [0.0; MOST];
        }
        a
    }

    /// The matrix of a mode and what it does over a time.
    pub fn linear(&self, mode: Mode, time: f64) -> Linear {
        let matrix = self.matrix(mode);
        let mut passes = [[0.0; MOST]; MOST];
        for column in 0..self.size {
            // The response to a held unit of one derivative, by one more row and column.
            let mut driven = matrix;
            (0..self.size).for_each(|row| driven[row][self.size] = f64::from(u8::from(row == column)));
            let response = exponential(&driven, self.size + 1, time);
            (0..self.size).for_each(|row| passes[row][column] = response[row][self.size]);
        }
        Linear { matrix, passes }
    }

    /// About the largest |eigenvalue| of a mode, 1/s, and not less: ‖A^64‖^{1/64}.
    pub fn fastest(&self, mode: Mode) -> f64 {
        let mut power = self.matrix(mode);
        let mut log = 0.0;
        for squaring in 0..=6 {
            let norm = power[..self.size]
                .iter()
                .map(|row| row[..self.size].iter().map(|e| e.abs()).sum::<f64>())
                .fold(0.0, f64::max);
            if norm.is_nan() || norm <= 0.0 {
                return 0.0;
            }
            log += ln(norm) / f64::from(1 << squaring);
            let scaled = power.map(|row| row.map(|e| e / norm));
            power = [[0.0; MOST]; MOST];
            for i in 0..self.size {
                for k in 0..self.size {
                    for j in 0..self.size {
                        power[i][j] += scaled[i][k] * scaled[k][j];
                    }
                }
            }
        }
        exp(log)
    }
}

/// A x + f.
#[inline]
pub(super) fn rates(a: &Square, x: &State, f: &State, size: usize) -> State {
    let mut rates = *f;
    for (row, rate) in a.iter().zip(&mut rates).take(size) {
        for (e, x) in row.iter().zip(x).take(size) {
            *rate += e * x;
        }
    }
    rates
}
