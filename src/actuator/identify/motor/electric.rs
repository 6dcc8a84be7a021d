//! What motion and current of a motor tell together: its coil, and the rotor under its current.

use super::Recording;
use crate::actuator::identify::estimate::Identified;
use crate::actuator::identify::rotor::{Rotor, Told};
use crate::actuator::identify::spin::Push;
use crate::actuator::identify::winding::Winding;

/// How often speed and current are made from each other.
const REFINED: usize = 2;

/// What motion and current together tell.
pub(super) struct Electric {
    pub winding: Winding,
    /// The rotor under the current: k/J, b/J, T_c/J.
    pub rotor: Rotor,
}

impl Electric {
    pub fn of(recording: &Recording, current: &[f64], rotor: &Rotor, volts: &Push) -> Option<Self> {
        let open = |n: usize| if recording.is_open(n) { 0.0 } else { current[n] };
        let current: Vec<f64> = (0..current.len()).map(open).collect();
        let push = Push { samples: &current, held: false, open: &[], period: volts.period };
        let x = recording.acceleration.samples;
        let law = Winding::law(rotor, volts, &push)?;
        let mut rotor = rotor.again(x, &push, law)?;
        let mut speeds = rotor.speeds(&push);
        let mut winding = Winding::of(&current, &speeds, volts)?;
        // The noise of the current is in the speed so far. The winding's own current has none.
        for _ in 0..REFINED {
            let clean = winding.current(&current, &speeds, volts);
            let push = Push { samples: &clean, ..push };
            rotor = rotor.again(x, &push, rotor.law)?;
            speeds = rotor.speeds(&push);
            winding = Winding::of(&current, &speeds, volts)?;
        }
        Some(Self { winding, rotor })
    }

    /// L/R, s: its least, itself, its most; and the part of friction in the damping, b/B.
    pub fn times(&self) -> ([f64; 3], f64) {
        let ([r, _], [k, _]) = (self.winding.resistance, self.winding.gain);
        let viscous = k * self.rotor.law.rate / self.rotor.law.gain;
        (self.winding.electrical_time(), viscous / (viscous + k * k / r))
    }

    pub fn tell(&self, recording: &Recording, rotor: &Rotor, all: &mut Identified) {
        self.winding.tell(all);
        let [k, off_k] = self.winding.gain;
        // What a free casing takes off the inertia that a torque meets.
        let moved = recording.mass.filter(|_| recording.is_calibrated).map_or([0.0; 2], |mass| {
            let (arm, off) = rotor.arm;
            [arm * arm * mass, 2.0 * arm * off * mass]
        });
        let mut tell = |name, unit, (value, off): Told, more: [f64; 2]| {
            let off = (k * off).hypot(off_k * value) + more[1];
            all.key(name, unit, k * value + more[0], [off, off]);
        };
        tell("inertia", "kg m2", self.rotor.told(|law| 1.0 / law.gain), moved);
        tell("viscous_friction", "N m s/rad", self.rotor.told(|law| law.rate / law.gain), [0.0; 2]);
        tell("coulomb_friction", "N m", self.rotor.told(|law| law.drag / law.gain), [0.0; 2]);
    }
}
