//! A coil actuator under a held voltage, from sample to sample, as matrices for whoever has to foresee it.

use super::plant::{MOST_STATES, Plant, Touch};
use super::resonance::Resonance;
use crate::actuator::drive::Drive;
use crate::actuator::exponential::{MOST, Square, exponential};

/// As many rows as the largest state has; those beyond `size` are 0.
pub(in crate::actuator) type Table = [[f64; MOST_STATES]; MOST_STATES];

/// x after a sample is x + `change` x + `drive` V; the first state is the displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::actuator) struct Sampled {
    /// States: 2 to 5.
    pub size: usize,
    pub change: Table,
    pub drive: [f64; MOST_STATES],
    /// P in the energy ½ xᵀ P x of masses, springs and coil. With shorted terminals it only falls, since the actuator is passive.
    pub energy: Table,
    /// Amperes for each unit of state, and for each volt.
    pub current: [f64; MOST_STATES],
    pub conductance: f64,
}

impl Sampled {
    const NONE: Self = Self {
        size: 0,
        change: [[0.0; MOST_STATES]; MOST_STATES],
        drive: [0.0; MOST_STATES],
        energy: [[0.0; MOST_STATES]; MOST_STATES],
        current: [0.0; MOST_STATES],
        conductance: 0.0,
    };

    /// x after a sample from x before it: e^(A h) − 1 of [[A, B], [0, 0]].
    fn flowing(&mut self, system: &Square, size: usize, rate: f64) {
        let flow = exponential(system, size + 1, 1.0 / rate);
        self.size = size;
        for i in 0..size {
            self.change[i][..size].copy_from_slice(&flow[i][..size]);
            self.drive[i] = flow[i][size];
        }
    }

    /// ẍ + (ω / Q) ẋ + ω² x = ω² `per_volt` V, of which no current is known. Energy is that of a kilogram.
    pub(in crate::actuator) fn resonant(resonance: &Resonance, per_volt: f64, rate: f64) -> Self {
        let omega = resonance.omega();
        let mut system = [[0.0; MOST]; MOST];
        system[0][1] = 1.0;
        system[1][..3].copy_from_slice(&[-omega * omega, -omega / resonance.q, omega * omega * per_volt]);
        let mut it = Self::NONE;
        it.flowing(&system, 2, rate);
        (it.energy[0][0], it.energy[1][1]) = (omega * omega, 1.0);
        it
    }
}

impl Plant {
    /// From sample to sample, so many of them a second, each voltage held.
    pub(in crate::actuator) fn sampled(&self, rate: f64) -> Sampled {
        let system = self.system(Drive::Voltage, &Touch::default());
        let (size, n) = (system.size, 2 * self.bodies);
        let mut it = Sampled::NONE;
        it.flowing(&system.matrix, size, rate);
        // ½ xᵀ P x for unit states and their sums gives P.
        let unit = |i: usize, j: usize| {
            let mut x = [0.0; MOST_STATES];
            x[i] = 1.0;
            x[j] = 1.0;
            self.mechanical_energy(&x)
        };
        for i in 0..n {
            for j in 0..n {
                it.energy[i][j] =
                    if i == j { 2.0 * unit(i, i) } else { unit(i, j) - unit(i, i) - unit(j, j) };
            }
        }
        if size > n {
            it.energy[n][n] = self.coil.inductance;
            it.current[n] = 1.0;
        } else {
            it.conductance = 1.0 / self.coil.resistance;
            it.current[1] = -self.coil.force_factor / self.coil.resistance;
        }
        it
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_STATES, Plant, Sampled};
    use crate::actuator::coil::model::Model;
    use crate::actuator::coil::parameters::tests::{held, inertial, layered, tactor};
    use crate::actuator::coil::parameters::{Coil, VoiceCoil};
    use crate::actuator::drive::Drive;

    fn advance(s: &Sampled, x: &[f64; MOST_STATES], volts: f64) -> [f64; MOST_STATES] {
        std::array::from_fn(|i| {
            x[i] + s.drive[i] * volts + (0..MOST_STATES).map(|j| s.change[i][j] * x[j]).sum::<f64>()
        })
    }

    #[test]
    fn displacement_current_and_energy_are_those_of_the_model() {
        let bare = VoiceCoil { coil: Coil { inductance: 0.0, ..tactor().coil }, ..tactor() };
        let plants = [tactor(), layered(), bare].map(|v| Plant::voice_coil(&v).unwrap());
        for plant in plants.into_iter().chain([inertial(), held()].map(|m| Plant::inertial(&m).unwrap())) {
            let s = plant.sampled(8000.0);
            let mut model = Model::new(&plant, 8000.0, Drive::Voltage).unwrap();
            let mut x = [0.0; MOST_STATES];
            for n in 0..2000 {
                let volts = if n % 37 < 15 { 2.0 } else { -1.0 + f64::from(n % 5) };
                let seen = model.step(volts);
                x = advance(&s, &x, volts);
                let current =
                    s.conductance * volts + (0..MOST_STATES).map(|i| s.current[i] * x[i]).sum::<f64>();
                let energy: f64 = (0..MOST_STATES)
                    .flat_map(|i| (0..MOST_STATES).map(move |j| (i, j)))
                    .map(|(i, j)| 0.5 * s.energy[i][j] * x[i] * x[j])
                    .sum();
                assert!((x[0] - seen.displacement).abs() < 1e-15 && (current - seen.current).abs() < 1e-12);
                assert!((energy / model.energy() - 1.0).abs() < 1e-9, "{energy} {}", model.energy());
            }
        }
    }
}
