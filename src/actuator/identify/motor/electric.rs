//! What motion and current of a motor tell together: its coil, and the rotor under its current.

use super::Recording;
use crate::actuator::identify::estimate::Identified;
use crate::actuator::identify::joint::Joint;
use crate::actuator::identify::rotor::{Rotor, Told};
use crate::actuator::identify::spin::{Law, Push, Run};
use crate::actuator::identify::winding::{Instant, Winding};

/// How often speed and current are made from each other.
const REFINED: usize = 2;

/// What motion and current together tell.
pub(super) struct Electric {
    pub winding: Winding,
    /// The rotor under the current: k/J, b/J, T_c/J.
    pub rotor: Rotor,
    /// All of it in one, where the coil is seen.
    joint: Option<Joint>,
    /// The same if the current were sooner and later by as much as is not known.
    others: Vec<(Winding, Rotor)>,
}

impl Electric {
    pub fn of(recording: &Recording, current: &[f64], moved: &Rotor, volts: &Push) -> Option<Self> {
        let open = |n: usize| if recording.is_open(n) { 0.0 } else { current[n] };
        let current: Vec<f64> = (0..current.len()).map(open).collect();
        let push = Push { samples: &current, held: false, open: &[], period: volts.period };
        let x = recording.acceleration.samples;
        let law = Winding::law(moved, volts, &push)?;
        let rotor = moved.again(x, &push, law)?;
        let instant = match (&recording.voltage, recording.current_delay) {
            (Some(_), _) => Instant::Fixed(0.0),
            (None, Some(delay)) => Instant::About(delay),
            (None, None) => Instant::Unknown,
        };
        let speeds = rotor.speeds(&push);
        let winding = Winding::of(&current, &speeds, volts, instant)?;
        // The noise of the current is in the speed so far. The winding's own current has none.
        let refined = |winding: &Winding, rotor: &Rotor, speeds: &[(Run, Vec<f64>)], instant| {
            let clean = winding.currents(&current, speeds, volts);
            let push = Push { samples: &clean, held: true, ..push };
            let rotor = rotor.again(x, &push, rotor.law)?;
            let speeds = rotor.speeds(&push);
            Some((Winding::of(&current, &speeds, volts, instant)?, rotor, speeds))
        };
        let mut all = (winding, rotor, speeds);
        for _ in 0..REFINED {
            all = refined(&all.0, &all.1, &all.2, instant)?;
        }
        let (winding, rotor, speeds) = all;
        let other = |instant| {
            let moved = Winding::of(&current, &speeds, volts, instant)?;
            let (winding, rotor, _) = refined(&moved, &rotor, &speeds, instant)?;
            Some((winding, rotor))
        };
        let others: Vec<_> = winding.others().into_iter().filter_map(other).collect();
        let winding = winding.wider(others.iter().map(|(winding, _)| winding));
        // What is measured at the terminals, or not there at all, is no drive that is held.
        let held = recording.voltage.is_none() && recording.open.is_empty();
        let joint =
            (held && winding.is_told).then(|| Joint::of(x, push.samples, &winding, moved, &rotor, volts));
        Some(Self { winding, rotor, joint: joint.flatten(), others })
    }

    /// A figure of the rotor under the current, and how far off it may be, what is not known of instants included.
    fn told(&self, figure: impl Fn(&Law) -> f64) -> Told {
        let (value, off) = self.rotor.told(&figure);
        let others = self.others.iter().map(|(_, rotor)| (figure(&rotor.law) - value).abs());
        (value, off + others.fold(0.0, f64::max))
    }

    /// L/R, s: its least, itself, its most; and the part of friction in the damping, b/B.
    pub fn times(&self) -> ([f64; 3], f64) {
        if let Some(joint) = &self.joint {
            let (time, off) = joint.told(|motor| motor.inductance / motor.resistance);
            let (share, _) = joint
                .told(|motor| motor.viscous / (motor.viscous + motor.gain * motor.gain / motor.resistance));
            return ([(time - off).max(0.0), time, time + off], share);
        }
        let ([r, _], [k, _]) = (self.winding.resistance, self.winding.gain);
        let viscous = k * self.rotor.law.rate / self.rotor.law.gain;
        (self.winding.electrical_time(), viscous / (viscous + k * k / r))
    }

    pub fn tell(&self, recording: &Recording, rotor: &Rotor, all: &mut Identified) {
        let late = match &self.joint {
            Some(joint) => {
                for (name, unit, (value, off)) in [
                    ("resistance", "ohm", joint.told(|motor| motor.resistance)),
                    ("inductance", "H", joint.told(|motor| motor.inductance)),
                    ("torque_constant", "N m/A", joint.told(|motor| motor.gain)),
                ] {
                    all.key(name, unit, value, [off, off]);
                }
                joint.late()
            }
            None => {
                self.winding.tell(all);
                self.winding.late.into()
            }
        };
        all.aside("current_lateness", "s", late.0, late.1);
        // What a free casing takes off the inertia that a torque meets.
        let moved = recording.mass.filter(|_| recording.is_calibrated).map_or([0.0; 2], |mass| {
            let (arm, off) = rotor.arm;
            [arm * arm * mass, 2.0 * arm * off * mass]
        });
        let [k, off_k] = self.winding.gain;
        let torque = |(value, off): Told| (k * value, (k * off).hypot(off_k * value));
        let [inertia, viscous, dry] = match &self.joint {
            Some(joint) => [
                joint.told(|motor| motor.inertia),
                joint.told(|motor| motor.viscous),
                joint.told(|motor| motor.dry),
            ],
            None => [
                torque(self.told(|law| 1.0 / law.gain)),
                torque(self.told(|law| law.rate / law.gain)),
                torque(self.told(|law| law.drag / law.gain)),
            ],
        };
        all.key("inertia", "kg m2", inertia.0 + moved[0], [inertia.1 + moved[1]; 2]);
        all.key("viscous_friction", "N m s/rad", viscous.0, [viscous.1; 2]);
        all.key("coulomb_friction", "N m", dry.0, [dry.1; 2]);
    }
}
