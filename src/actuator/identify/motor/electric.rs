//! What motion and current of a motor tell together: its coil, and the rotor under its current.

use super::Recording;
use crate::actuator::identify::estimate::Identified;
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
    /// The same if the current were sooner and later by as much as is not known.
    others: Vec<(Winding, Rotor)>,
}

impl Electric {
    pub fn of(recording: &Recording, current: &[f64], rotor: &Rotor, volts: &Push) -> Option<Self> {
        let open = |n: usize| if recording.is_open(n) { 0.0 } else { current[n] };
        let current: Vec<f64> = (0..current.len()).map(open).collect();
        let push = Push { samples: &current, held: false, open: &[], period: volts.period };
        let x = recording.acceleration.samples;
        let law = Winding::law(rotor, volts, &push)?;
        let rotor = rotor.again(x, &push, law)?;
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
        Some(Self { winding, rotor, others })
    }

    /// A figure of the rotor under the current, and how far off it may be, what is not known of instants included.
    fn told(&self, figure: impl Fn(&Law) -> f64) -> Told {
        let (value, off) = self.rotor.told(&figure);
        let others = self.others.iter().map(|(_, rotor)| (figure(&rotor.law) - value).abs());
        (value, off + others.fold(0.0, f64::max))
    }

    /// L/R, s: its least, itself, its most; and the part of friction in the damping, b/B.
    pub fn times(&self) -> ([f64; 3], f64) {
        let ([r, _], [k, _]) = (self.winding.resistance, self.winding.gain);
        let viscous = k * self.rotor.law.rate / self.rotor.law.gain;
        (self.winding.electrical_time(), viscous / (viscous + k * k / r))
    }

    pub fn tell(&self, recording: &Recording, rotor: &Rotor, all: &mut Identified) {
        self.winding.tell(all);
        let [late, off] = self.winding.late;
        all.aside("current_lateness", "s", late, off);
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
        tell("inertia", "kg m2", self.told(|law| 1.0 / law.gain), moved);
        tell("viscous_friction", "N m s/rad", self.told(|law| law.rate / law.gain), [0.0; 2]);
        tell("coulomb_friction", "N m", self.told(|law| law.drag / law.gain), [0.0; 2]);
    }
}
