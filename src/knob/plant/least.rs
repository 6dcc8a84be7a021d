//! A knob of any build, as the least model that it needs.

use super::chain::Chain;
use super::parts::{Build, Hand};
use super::rotor::{Counts, Rotor};
use crate::actuator::fault::Fault;

/// A knob, step by step. Which model it is was chosen when it was made.
#[derive(Debug, Clone)]
pub enum Plant {
    /// One inertia, friction, an ideal torque.
    Bare(Rotor<false>),
    /// And stops.
    Stopped(Rotor<true>),
    /// And whatever else.
    Chain(Box<Chain>),
}

impl Plant {
    /// At rest at 0 rad, for `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first field of the build, or the rate, beyond its limits.
    pub fn new(build: &Build, rate: f64) -> Result<Self, Fault> {
        build.check()?;
        match (build.is_plain(), build.parameters.stops) {
            (true, None) => Rotor::new(&build.parameters, rate).map(Self::Bare),
            (true, Some(_)) => Rotor::new(&build.parameters, rate).map(Self::Stopped),
            (false, _) => Ok(Self::Chain(Box::new(Chain::new(build, rate)?))),
        }
    }

    /// Passes one step with a command held over it (a torque, N m; of [`Drive::Voltage`](super::parts::Drive::Voltage) volts) and a hand.
    /// Without a grasp a hand's target is nothing.
    #[inline]
    pub fn step(&mut self, command: f64, hand: &Hand) {
        match self {
            Self::Bare(rotor) => rotor.step(command + hand.torque),
            Self::Stopped(rotor) => rotor.step(command + hand.torque),
            Self::Chain(chain) => chain.step(command, hand),
        }
    }

    /// Its winding, where there is one, has another resistance from here on, ohms: see [`Chain::warm`].
    pub fn warm(&mut self, resistance: f64) {
        if let Self::Chain(chain) = self {
            chain.warm(resistance);
        }
    }

    /// Puts it at an angle (rad) with a speed (rad/s), each within ±1e9.
    ///
    /// # Errors
    /// Which of the two is beyond its limits.
    pub fn place(&mut self, angle: f64, speed: f64) -> Result<(), Fault> {
        match self {
            Self::Bare(rotor) => rotor.place(angle, speed),
            Self::Stopped(rotor) => rotor.place(angle, speed),
            Self::Chain(chain) => chain.place(angle, speed),
        }
    }

    /// What the encoder sees, rad: the motor's angle.
    #[inline]
    pub fn angle(&self) -> f64 {
        match self {
            Self::Bare(rotor) => rotor.angle(),
            Self::Stopped(rotor) => rotor.angle(),
            Self::Chain(chain) => chain.angle(),
        }
    }

    /// The motor's speed, rad/s.
    #[inline]
    pub fn speed(&self) -> f64 {
        match self {
            Self::Bare(rotor) => rotor.speed(),
            Self::Stopped(rotor) => rotor.speed(),
            Self::Chain(chain) => chain.speed(),
        }
    }

    /// What the hand holds, rad: with a shaft another angle than the motor's.
    pub fn knob_angle(&self) -> f64 {
        if let Self::Chain(chain) = self { chain.knob_angle() } else { self.angle() }
    }

    /// Speed of what the hand holds, rad/s.
    pub fn knob_speed(&self) -> f64 {
        if let Self::Chain(chain) = self { chain.knob_speed() } else { self.speed() }
    }

    /// Current in the winding, A; 0 of an ideal torque.
    pub fn current(&self) -> f64 {
        if let Self::Chain(chain) = self { chain.current() } else { 0.0 }
    }

    /// Voltage at the winding, V; 0 of an ideal torque.
    pub fn voltage(&self) -> f64 {
        if let Self::Chain(chain) = self { chain.voltage() } else { 0.0 }
    }

    /// Kinetic energy and that of pressed stops, a bent shaft and cogging, J.
    pub fn energy(&self) -> f64 {
        match self {
            Self::Bare(rotor) => rotor.energy(),
            Self::Stopped(rotor) => rotor.energy(),
            Self::Chain(chain) => chain.energy(),
        }
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        match self {
            Self::Bare(rotor) => rotor.counts(),
            Self::Stopped(rotor) => rotor.counts(),
            Self::Chain(chain) => chain.counts(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Build, Hand, Plant};
    use crate::knob::plant::parameters::Parameters;
    use crate::knob::plant::parts::Grasp;
    use crate::knob::plant::stops::Stops;

    #[test]
    fn it_is_the_least_that_is_needed() {
        let plain = Build::default();
        let stops = Some(Stops { low: -1.0, high: 1.0, stiffness: 40.0, damping: 0.0 });
        let stopped = Build { parameters: Parameters { stops, ..plain.parameters }, ..plain };
        let held = Build { grasp: Some(Grasp { stiffness: 1.0, damping: 0.0 }), ..plain };
        assert!(matches!(Plant::new(&plain, 1e3), Ok(Plant::Bare(_))));
        assert!(matches!(Plant::new(&stopped, 1e3), Ok(Plant::Stopped(_))));
        assert!(matches!(Plant::new(&held, 1e3), Ok(Plant::Chain(_))));
    }

    #[test]
    fn a_hand_pushes_whatever_the_model() {
        let hand = Hand { torque: 2e-3, ..Hand::default() };
        let plain = Build::default();
        let held = Build { grasp: Some(Grasp { stiffness: 0.0, damping: 0.0 }), ..plain };
        let mut plants = [plain, held].map(|build| Plant::new(&build, 1e3).unwrap());
        for plant in &mut plants {
            plant.place(0.1, 1.0).unwrap();
            (0..50).for_each(|_| plant.step(1e-3, &hand));
        }
        assert!((plants[0].angle() - plants[1].angle()).abs() < 1e-13);
        assert!((plants[0].speed() - plants[1].speed()).abs() < 1e-12 && plants[0].speed() > 10.0);
    }
}
