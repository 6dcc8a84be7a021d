//! The way from a sample to an actuator as a rig describes it, and what is assumed of it.

use crate::actuator::drive::Drive as Imposed;
use crate::actuator::link::Chain;
use crate::actuator::link::amplifier::Amplifier;
use crate::actuator::link::carrier::Carrier;
use crate::actuator::link::coupling::Corners;
use crate::rig::{
    Actuator, Amplifier as Amplifying, Coupling, Drive, Model, Output, OutputKind, Rig, Turning,
};

/// What stands between the samples of an output and its actuator, with what is assumed as nobody says it. `None` where the volts of the device
/// are not known, which is told elsewhere.
pub(super) fn chain(rig: &Rig, output: &Output, assumed: &mut Vec<String>) -> Option<Chain> {
    let amplifier = output.amplifier.as_ref().and_then(|name| rig.amplifier(name));
    if let Some(Amplifying { drive: Drive::Bridge { .. }, max_volts, .. }) = amplifier {
        // What its lines say comes as 1, 0 or -1; they are steady, or the rig is refused.
        let gain = (*max_volts)?;
        let amplifier =
            Amplifier { gain, inverted: false, drive: Imposed::Voltage, volts: None, amperes: None };
        return Some(Chain { full_scale: 1.0, corners: Corners::none(), amplifier });
    }
    let full_scale = rig.device.full_scale_volts?;
    // A carrier passes any.
    let is_carrier = carrier(rig, output).is_some();
    let mut known = |of: Option<Coupling>, whose: &str| {
        if of.is_none() && !is_carrier {
            assumed.push(format!("{whose} lets steady voltages through: its `coupling` is not known"));
        }
    };
    known(rig.device.coupling, "the device");
    if let Some(amplifier) = amplifier {
        known(amplifier.coupling, &format!("amplifier `{}`", amplifier.name));
    }
    let amplifier = match amplifier {
        Some(a) => {
            let drive = match a.drive {
                Drive::Current => Imposed::Current,
                Drive::Voltage | Drive::Bridge { .. } | Drive::Carrier(_) => Imposed::Voltage,
            };
            if a.max_volts.is_none() {
                let what = format!("amplifier `{}` gives any voltage: its `max_volts` is not known", a.name);
                assumed.push(what);
            }
            Amplifier {
                gain: a.gain.abs(),
                inverted: a.gain < 0.0,
                drive,
                volts: a.max_volts,
                amperes: a.max_amperes,
            }
        }
        None => {
            assumed.push(
                "where no amplifier is named, the device drives the actuator itself, with any current".into(),
            );
            Amplifier { gain: 1.0, inverted: false, drive: Imposed::Voltage, volts: None, amperes: None }
        }
    };
    Some(Chain { full_scale, corners: rig.corners(output), amplifier })
}

/// The diodes between amplifier and actuator, and the carrier that is for them.
pub(super) fn carrier(rig: &Rig, output: &Output) -> Option<Carrier> {
    match rig.amplifier(output.amplifier.as_ref()?)?.drive {
        Drive::Carrier(carrier) => Some(carrier),
        Drive::Voltage | Drive::Current | Drive::Bridge { .. } => None,
    }
}

/// The lines of a bridge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lines {
    /// The channel, from 0, of the one that says which way.
    direction: usize,
    /// What counts as on: half of what leaves.
    on: f32,
}

impl Lines {
    /// Those of an output behind a bridge; `None` for any other.
    pub fn of(rig: &Rig, output: &Output) -> Option<Self> {
        let amplifier = rig.amplifier(output.amplifier.as_ref()?)?;
        let OutputKind::Drive(Turning { direction: Some(direction), .. }) = output.kind else { return None };
        matches!(amplifier.drive, Drive::Bridge { .. }).then(|| Self {
            direction: direction.saturating_sub(1) as usize,
            on: 0.5 * rig.max_level(output) as f32,
        })
    }

    /// Which way it turns the motor in a frame, by what is on its channel (from 0): 1, -1, or 0 while it is off.
    pub fn read(&self, frame: &[f32], channel: usize) -> f32 {
        let is_on = |channel: usize| frame.get(channel).is_some_and(|sample| *sample > self.on);
        match (is_on(channel), is_on(self.direction)) {
            (false, _) => 0.0,
            (true, back) => {
                if back {
                    -1.0
                } else {
                    1.0
                }
            }
        }
    }
}

/// What is assumed of an actuator as nobody says it.
pub(super) fn assumed_of(actuator: &Actuator, amplifier: &Amplifier, assumed: &mut Vec<String>) {
    let name = &actuator.name;
    match actuator.model {
        Model::VoiceCoil
            if ["skin_mass", "skin_stiffness", "skin_damping"]
                .iter()
                .all(|key| actuator.value(key).is_none()) =>
        {
            assumed.push(format!(
                "the contactor of `{name}` touches nothing: the rig gives no skin (`skin_stiffness`)"
            ));
        }
        Model::RumbleMotor => {
            let mass = actuator.value("mass");
            if mass.is_none() && actuator.value("torque_constant").is_some() {
                assumed.push(format!("nothing moves with `{name}`: its `mass` is not known, so the force on what holds it is told"));
            }
            if amplifier.drive == Imposed::Voltage && amplifier.amperes.is_some() {
                assumed.push(format!("the amplifier gives `{name}` any current: a limit of amperes is not simulated for a motor at a voltage"));
            }
        }
        _ => {}
    }
}
