//! What one sees of a coil actuator in motion.

use super::parameters::Skin;
use super::plant::{Kind, Plant, System};
use crate::actuator::drive::Drive;

/// What an actuator does at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs {
    /// Of the contactor in its housing, or the slug in its casing, metres from rest.
    pub displacement: f64,
    /// Of the same, metres a second.
    pub velocity: f64,
    /// Of the same, metres a second squared.
    pub acceleration: f64,
    /// On the skin beyond the preload, or on the hand that holds the casing, newtons.
    pub force: f64,
    /// Acceleration of the casing, metres a second squared; 0 for a tactor, whose housing is held.
    pub casing: f64,
    /// Velocity of the casing, metres a second; 0 for a tactor.
    pub casing_velocity: f64,
    /// Amperes.
    pub current: f64,
    /// At the terminals, volts. A current drive's leap through the inductance is not in it.
    pub voltage: f64,
}

/// A weighted sum of state and inputs.
#[derive(Debug, Clone, Copy)]
struct Row<const N: usize> {
    state: [f64; N],
    drive: f64,
    steady: f64,
}

/// The outputs as sums of state and drive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Readout<const N: usize> {
    acceleration: Row<N>,
    force: Row<N>,
    casing: Row<N>,
    casing_velocity: Row<N>,
    current: Row<N>,
    voltage: Row<N>,
}

impl<const N: usize> Row<N> {
    const NONE: Self = Self { state: [0.0; N], drive: 0.0, steady: 0.0 };

    fn of_system(system: &System, row: usize) -> Self {
        let a = &system.matrix[row];
        Self { state: std::array::from_fn(|j| a[j]), drive: a[N], steady: a[N + 1] }
    }

    fn times(mut self, factor: f64) -> Self {
        self.state.iter_mut().for_each(|e| *e *= factor);
        Self { drive: self.drive * factor, steady: self.steady * factor, ..self }
    }

    fn plus(mut self, at: usize, weight: f64) -> Self {
        self.state[at] += weight;
        self
    }

    #[inline(always)]
    fn read(&self, x: &[f64; N], drive: f64) -> f64 {
        let mut sum = self.drive * drive + self.steady;
        for j in 0..N {
            sum += self.state[j] * x[j];
        }
        sum
    }
}

impl<const N: usize> Readout<N> {
    /// Of a plant under a drive; `touched` says that the contactor is on the skin, and else that it has lost it by `preload` newtons.
    pub fn new(plant: &Plant, drive: Drive, system: &System, touched: bool, preload: f64) -> Self {
        let coil = plant.coil;
        let acceleration = Row::of_system(system, 1);
        let two = plant.bodies == 2;
        let (mut force, mut casing, mut casing_velocity) = (Row::NONE, Row::NONE, Row::NONE);
        match &plant.kind {
            Kind::Tactor(_) if !touched => force.steady = -preload,
            Kind::Tactor(v) => {
                if let Skin::One(tissue) | Skin::Two(tissue, _) = &v.skin {
                    force = acceleration.times(tissue.mass);
                    force = force.plus(0, tissue.spring.stiffness).plus(1, tissue.spring.damping);
                }
                if let Skin::Two(_, layer) = &v.skin {
                    let spring = &layer.coupling;
                    force = force.plus(0, spring.stiffness).plus(1, spring.damping);
                    force = force.plus(2, -spring.stiffness).plus(3, -spring.damping);
                }
            }
            Kind::Inertial(m) => {
                let total = m.casing_mass + m.hand.mass;
                (casing, casing_velocity) = if two {
                    (Row::of_system(system, 3), Row::NONE.plus(3, 1.0))
                } else {
                    let share = -m.slug_mass / (m.slug_mass + total);
                    (acceleration.times(share), Row::NONE.plus(1, share))
                };
                force = casing.times(m.hand.mass);
                if two {
                    force = force.plus(2, m.hand.spring.stiffness).plus(3, m.hand.spring.damping);
                }
            }
        }
        let (mut current, mut voltage) = (Row::NONE, Row::NONE);
        match drive {
            Drive::Current => {
                current.drive = 1.0;
                voltage = Row { drive: coil.resistance, ..voltage }.plus(1, coil.force_factor);
            }
            Drive::Voltage => {
                voltage.drive = 1.0;
                current = if N % 2 == 1 {
                    current.plus(N - 1, 1.0)
                } else {
                    let conductance = 1.0 / coil.resistance;
                    Row { drive: conductance, ..current }.plus(1, -coil.force_factor * conductance)
                };
            }
        }
        Self { acceleration, force, casing, casing_velocity, current, voltage }
    }

    #[inline(always)]
    pub fn read(&self, x: &[f64; N], drive: f64) -> Outputs {
        Outputs {
            displacement: x[0],
            velocity: x[1],
            acceleration: self.acceleration.read(x, drive),
            force: self.force.read(x, drive),
            casing: self.casing.read(x, drive),
            casing_velocity: self.casing_velocity.read(x, drive),
            current: self.current.read(x, drive),
            voltage: self.voltage.read(x, drive),
        }
    }
}
