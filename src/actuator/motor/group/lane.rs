//! A motor as a lane of a group sees it.

use crate::actuator::motor::drive::Drive;
use crate::actuator::motor::model::{Grip, Motor};
use crate::actuator::motor::swift::State as Kept;

impl Motor {
    /// Current, speed, angle and turns, and the voltage.
    pub(super) fn lane_state(&self) -> ([f64; 4], f64) {
        let Kept { current, speed, phase, turns, .. } = self.state;
        ([current, speed, phase, turns], self.volts)
    }

    pub(super) fn set_lane(&mut self, [current, speed, phase, turns]: [f64; 4], volts: Option<f64>) {
        self.state = Kept { current, speed, phase, turns, ..self.state };
        if let Some(volts) = volts {
            (self.drive, self.volts) = (Drive::Voltage(volts), volts);
        }
    }

    /// Whether its steps are numbers times numbers, as long as nothing happens.
    pub(super) fn is_plain(&self) -> bool {
        self.grip != Grip::Sticks
            && !matches!(self.drive, Drive::Current { .. })
            && self.mount.is_none()
            && self.swift.bounds.sense != (0.0, 0.0)
    }
}
