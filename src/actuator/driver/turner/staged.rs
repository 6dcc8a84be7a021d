//! Levels that switch a drive on and off, and drives that are held by a voltage or a current until the motor is to be slower.

use super::Turner;
use crate::actuator::drive::Drive;
use crate::actuator::driver::order::{After, By, Switch};

/// Of the full speed, by how much a motor is faster than it is to be when it is let go.
const FASTER: f64 = 0.01;

impl Turner {
    /// The most there may be while the level is up, and what follows once it is down.
    pub(super) fn on_off(&mut self, wished: f64) -> f64 {
        let stage = self.setup.stage;
        let level = (wished / self.setup.full_speed()).powi(2).copysign(wished);
        let holds = self.on * level > stage.off_at;
        if level.abs() >= stage.on_at && !(holds && self.on != 0.0) {
            self.on = level.signum();
        } else if !holds {
            self.on = 0.0;
        }
        if self.on != 0.0 {
            return self.on(Switch {
                amount: self.on * stage.share * self.setup.limit,
                by: stage.by,
                after: stage.after,
            });
        }
        if self.stands() { 0.0 } else { self.after(stage.after) }
    }

    /// What holds the speed; where something else than that is to follow, the motor is let go as long as it is faster than it is to be.
    pub(super) fn plain(&mut self, wished: f64) -> f64 {
        let stage = self.setup.stage;
        let speed = self.motor.as_ref().map_or(0.0, |motor| motor.speed());
        let faster = speed.abs() - if speed * wished >= 0.0 { wished.abs() } else { 0.0 };
        self.rolls = faster > if self.rolls { 0.0 } else { FASTER * self.setup.full_speed() };
        if stage.after != After::Nothing && (self.rolls || wished == 0.0) {
            return if self.stands() { 0.0 } else { self.after(stage.after) };
        }
        if stage.by == By::Amplifier {
            return self.setup.held_by(wished).clamp(self.setup.least(), self.setup.limit);
        }
        let p = &self.setup.parameters;
        let damping = if stage.by == By::Voltage { p.damping() } else { p.viscous };
        let friction = if wished == 0.0 { 0.0 } else { p.coulomb.copysign(wished) };
        let amperes = (damping * wished + friction) / p.gain;
        let amount = if self.setup.imposes == Drive::Voltage { amperes * p.resistance } else { amperes };
        self.on(Switch { amount, by: stage.by, after: stage.after })
    }
}
