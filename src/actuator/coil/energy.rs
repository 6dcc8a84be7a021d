//! Where the energy goes.

use super::model::Model;
use super::readout::Outputs;
use crate::actuator::drive::Drive;

/// An account of the energy of a [`Model`]: what its drive supplied, what it holds, what became heat.
///
/// What is supplied over a step is exact: the voltage is held, and the charge follows from R ∫i dt = V T − L Δi − Bl Δy. Under a
/// current drive the coil's own energy, which leaps with the current, is left out on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ledger {
    /// Joules at the beginning.
    begin: f64,
    /// Joules supplied since.
    pub supplied: f64,
    /// Joules held now.
    pub stored: f64,
}

impl Ledger {
    /// Begins with what a model holds.
    pub fn new(model: &Model) -> Self {
        Self { begin: model.energy(), supplied: 0.0, stored: model.energy() }
    }

    /// A step of the model, entered into the account.
    pub fn step(&mut self, model: &mut Model, drive: f64) -> Outputs {
        let (coil, before) = (model.plant().coil(), model.state());
        let outputs = model.step(drive);
        let (after, period) = (model.state(), model.period());
        let moved = coil.force_factor * (after.displacement - before.displacement);
        self.supplied += match model.drive() {
            Drive::Voltage => {
                let (volts, stored) = (outputs.voltage, coil.inductance * (after.current - before.current));
                volts * (volts * period - stored - moved) / coil.resistance
            }
            Drive::Current => outputs.current * (coil.resistance * outputs.current * period + moved),
        };
        self.stored = model.energy();
        outputs
    }

    /// Joules that became heat, in the coil, in dampers and at stops: never negative, and never less than before.
    pub fn lost(&self) -> f64 {
        self.begin + self.supplied - self.stored
    }
}
