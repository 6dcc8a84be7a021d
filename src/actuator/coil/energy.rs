//! Where the energy goes.

use super::model::Model;
use super::parameters::Coil;
use super::readout::Outputs;
use crate::actuator::drive::Drive;

/// What passes the terminals in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Passed {
    /// Coulombs.
    pub charge: f64,
    /// Joules.
    pub energy: f64,
}

impl Passed {
    /// Of a step of `period` seconds with its drive held, from displacement (m) and current (A; any, where the coil stores nothing) before it
    /// and what is seen at its end. Exact: the voltage is held, and the charge follows from R ∫i dt = V T − L Δi − Bl Δy. Under a current
    /// drive the coil's own energy, which leaps with the current, is left out.
    #[inline]
    pub fn of(
        coil: &Coil,
        drive: Drive,
        period: f64,
        [displacement, current]: [f64; 2],
        end: &Outputs,
    ) -> Self {
        let moved = coil.force_factor * (end.displacement - displacement);
        match drive {
            Drive::Voltage => {
                let stored = coil.inductance * (end.current - current);
                let charge = (end.voltage * period - stored - moved) / coil.resistance;
                Self { charge, energy: end.voltage * charge }
            }
            Drive::Current => Self {
                charge: end.current * period,
                energy: end.current * (coil.resistance * end.current * period + moved),
            },
        }
    }
}

/// An account of the energy of a [`Model`]: what its drive supplied, what it holds, what became heat.
///
/// What is supplied over a step is exact, see [`Passed`]. Under a current drive the coil's own energy is left out on both sides.
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
        let before = [before.displacement, before.current];
        self.supplied += Passed::of(&coil, model.drive(), model.period(), before, &outputs).energy;
        self.stored = model.energy();
        outputs
    }

    /// Joules that became heat, in the coil, in dampers and at stops: never negative, and never less than before.
    pub fn lost(&self) -> f64 {
        self.begin + self.supplied - self.stored
    }
}
