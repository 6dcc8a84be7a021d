//! A coil actuator on an output: a voice coil, an inertial motor, a linear resonant actuator.

use super::heat::Heat;
use crate::actuator::coil::energy::Passed;
use crate::actuator::coil::model::Model;
use crate::actuator::coil::parameters::Coil;
use crate::actuator::coil::plant::Plant;
use crate::actuator::coil::readout::Outputs;
use crate::actuator::coil::supply::Supply;
use crate::actuator::drive::Drive;
use crate::actuator::fault::Fault;
use crate::actuator::link::amplifier::Amplifier;

/// A coil actuator, what drives it, and what is seen of it.
#[derive(Debug, Clone)]
pub(super) struct Swinger {
    model: Model,
    /// Where the amplifier has another limit than that on what it imposes.
    supply: Option<Supply>,
    seen: Seen,
}

#[derive(Debug, Clone)]
struct Seen {
    coil: Coil,
    drive: Drive,
    rate: f64,
    /// Whether a casing is felt, and not a contactor.
    shakes: bool,
    velocity: f64,
    /// Displacement and current at the end of the last sample.
    last: [f64; 2],
    farthest: f64,
    energy: f64,
    heat: Heat,
}

impl Swinger {
    /// At rest, `rate` samples a second.
    ///
    /// # Errors
    /// A rate or a limit that cannot be.
    pub fn new(plant: &Plant, amplifier: &Amplifier, rate: f64, heat: Heat) -> Result<Self, Fault> {
        let other = match amplifier.drive {
            Drive::Voltage => amplifier.amperes,
            Drive::Current => amplifier.volts,
        };
        let supply =
            other.map(|_| Supply::new(amplifier.drive, amplifier.volts, amplifier.amperes)).transpose()?;
        let drive = if supply.is_some() { Drive::Voltage } else { amplifier.drive };
        let seen = Seen {
            coil: plant.coil(),
            drive,
            rate,
            shakes: plant.shakes(),
            velocity: 0.0,
            last: [0.0; 2],
            farthest: 0.0,
            energy: 0.0,
            heat,
        };
        Ok(Self { model: Model::new(plant, rate, drive)?, supply, seen })
    }

    /// Holds each drive (V or A) for a sample; the mean acceleration over each.
    pub fn run(&mut self, drives: &[f64], felt: &mut [[f64; 2]]) {
        let (seen, mut felt) = (&mut self.seen, felt.iter_mut());
        let mut see = |outputs: Outputs| {
            let mean = seen.take(&outputs);
            if let Some(felt) = felt.next() {
                *felt = [mean, 0.0];
            }
        };
        match &mut self.supply {
            None => self.model.run(drives, see),
            Some(supply) => drives.iter().for_each(|drive| see(supply.step(&mut self.model, *drive))),
        }
    }

    /// The farthest from rest, m.
    pub fn farthest(&self) -> f64 {
        self.seen.farthest
    }

    /// Drawn so far, J.
    pub fn energy(&self) -> f64 {
        self.seen.energy
    }

    /// See [`Heat::warmest`].
    pub fn warmest(&self) -> Option<f64> {
        self.seen.heat.warmest()
    }

    /// Samples at which the amplifier's other limit was met, and drives that the model did not take.
    pub fn counts(&self) -> [u64; 2] {
        [self.supply.as_ref().map_or(0, Supply::limited), self.model.masked()]
    }
}

impl Seen {
    #[inline]
    fn take(&mut self, end: &Outputs) -> f64 {
        let velocity = if self.shakes { end.casing_velocity } else { end.velocity };
        let passed = Passed::of(&self.coil, self.drive, 1.0 / self.rate, self.last, end);
        self.energy += passed.energy;
        self.heat.take(passed.charge * self.rate);
        self.farthest = self.farthest.max(end.displacement.abs());
        self.last = [end.displacement, end.current];
        (velocity - std::mem::replace(&mut self.velocity, velocity)) * self.rate
    }
}
