//! Steps one by one, which keep where the motor is out of memory.

use super::drive::{Drive, MOST_DRIVE};
use super::model::Motor;
use super::swift::{NONE, State};

/// Steps of a motor one after the other, each at a voltage of its own: what [`Motor::drive`] and [`Motor::step`] do, to the bit.
///
/// A motor that is stepped by itself stores where it is and loads it again in the next step. A processor hands a number from a store on to a load
/// in some nine cycles, and the longest way from one state of a linear motor to the next, a product and two sums whatever their order, is nine more:
/// 4.9 ns at 3.7 GHz at the least, and 5.5 as it is. Here it stays in registers; the motor has it when this is dropped.
#[derive(Debug)]
pub struct Steps<'a> {
    motor: &'a mut Motor,
    state: State,
    volts: f64,
}

impl Motor {
    /// Steps of it one by one.
    pub fn steps(&mut self) -> Steps<'_> {
        let (state, volts) = (self.state, self.volts);
        Steps { motor: self, state, volts }
    }
}

impl Steps<'_> {
    /// One step further at a voltage, V.
    #[inline(always)]
    pub fn step(&mut self, volts: f64) {
        let motor = &*self.motor;
        if motor.lean
            && volts.abs() <= MOST_DRIVE
            && let Some((next, _)) = motor.swift.step::<NONE, false, false>(&self.state, volts)
        {
            (self.state, self.volts) = (next, volts);
        } else {
            (self.state, self.volts) = in_full(self.motor, self.state, self.volts, volts);
        }
    }

    /// The current, A.
    #[inline]
    pub fn current(&self) -> f64 {
        self.state.current
    }

    /// The speed, rad/s.
    #[inline]
    pub fn speed(&self) -> f64 {
        self.state.speed
    }

    /// The angle in turns, within ±½.
    #[inline]
    pub fn phase(&self) -> f64 {
        self.state.phase
    }
}

impl Drop for Steps<'_> {
    #[inline(always)]
    fn drop(&mut self) {
        hand_back(self.motor, self.state, self.volts);
    }
}

/// A step in which something may happen.
#[cold]
#[inline(never)]
fn in_full(motor: &mut Motor, state: State, before: f64, volts: f64) -> (State, f64) {
    hand_back(motor, state, before);
    motor.drive(Drive::Voltage(volts));
    motor.step();
    (motor.state, motor.volts)
}

/// Tells the motor where it is.
#[inline(always)]
fn hand_back(motor: &mut Motor, state: State, volts: f64) {
    motor.state = state;
    if motor.lean {
        (motor.drive, motor.volts) = (Drive::Voltage(volts), volts);
    }
}
