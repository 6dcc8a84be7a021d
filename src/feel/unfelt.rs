//! Outputs of which is not known what they move.

use crate::rig::{Actuator, Amplifier, Drive, Model, Output, OutputKind, Rig};
use crate::text::Problem;

/// An output that has no trace, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Unfelt {
    /// Its name.
    pub output: String,
    /// Why, and what would help: all of it, at least one.
    pub why: Vec<Problem>,
}

/// What keeps an output of `channels` from being computed, as far as the rig alone tells.
pub(super) fn lacking(rig: &Rig, output: &Output, channels: usize) -> Vec<Problem> {
    let name = &output.name;
    let at = |what: String, help: &str| Problem::error(&output.span, what).help(help.to_string());
    match output.kind {
        OutputKind::Trigger { .. } => {
            let what = format!("output `{name}` is a trigger: its pulses move nothing");
            return vec![Problem::error(&output.span, what)];
        }
        OutputKind::Torque => {
            let what = format!("output `{name}` is of kind torque, which is not rendered yet");
            return vec![Problem::error(&output.span, what)];
        }
        OutputKind::Vibration | OutputKind::Raw | OutputKind::Drive(_) => {}
    }
    let mut why = Vec::new();
    match output.actuator.as_ref().map(|name| (name, rig.actuator(name))) {
        None => why.push(at(
            format!("output `{name}` has no actuator: what it moves is not known"),
            "name one, actuator = \"NAME\", and describe it under [actuator.NAME]: by the `part` it is, or by its `model` and figures",
        )),
        Some((wanted, None)) => why.push(at(
            format!("output `{name}` has an actuator `{wanted}`, which is not there"),
            &format!("describe it under [actuator.{wanted}]"),
        )),
        Some((_, Some(actuator))) => why.extend(unknown(actuator)),
    }
    if let Some(wanted) = &output.amplifier {
        match rig.amplifier(wanted) {
            None => why.push(at(
                format!("output `{name}` has an amplifier `{wanted}`, which is not there"),
                &format!("describe it under [amplifier.{wanted}]"),
            )),
            Some(amplifier) if amplifier.gain == 0.0 => why.push(
                Problem::error(
                    &amplifier.span,
                    format!("amplifier `{wanted}` has a gain of 0: nothing reaches what it drives"),
                )
                .help("give its gain".to_string()),
            ),
            Some(amplifier) => why.extend(rectified(rig, output, amplifier)),
        }
    }
    if rig.device.full_scale_volts.is_none() && super::chain::Lines::of(rig, output).is_none() {
        let what =
            "how many volts a sample of 1.0 is at the device's outputs is not known: models need volts";
        let help = "play a full sine, hold a meter to an output, and write the peak under [device]: full_scale_volts = 1.4";
        why.push(Problem::of_file(what).help(help.to_string()));
    }
    if output.channel == 0 || output.channel as usize > channels {
        let what =
            format!("output `{name}` is on channel {}, where {channels} were rendered", output.channel);
        why.push(at(what, "channels count from 1"));
    }
    why
}

/// That what is no motor hangs behind diodes.
fn rectified(rig: &Rig, output: &Output, amplifier: &Amplifier) -> Option<Problem> {
    let actuator = rig.actuator(output.actuator.as_ref()?)?;
    if !matches!(amplifier.drive, Drive::Carrier(_)) || actuator.model == Model::RumbleMotor {
        return None;
    }
    let what = format!(
        "output `{}` has {} behind the rectifier of `{}`, where only rumble motors are simulated",
        output.name,
        actuator.model.word(),
        amplifier.name
    );
    let help = "give it an amplifier of another `drive`".to_string();
    Some(Problem::error(&output.span, what).help(help))
}

/// What is not known of an actuator that its model needs.
fn unknown(actuator: &Actuator) -> Option<Problem> {
    let (name, word) = (&actuator.name, actuator.model.word());
    let error = |what: String, help: String| Some(Problem::error(&actuator.span, what).help(help));
    match actuator.model {
        Model::Generic => {
            return error(
                format!("actuator `{name}` is of model generic: how it moves is not known"),
                "say which part it is, part = \"...\" (`pacinian parts` lists them), or its `model` and figures".into(),
            );
        }
        Model::Piezo => {
            return error(
                format!("actuator `{name}` is of model piezo, of which there is no motion to simulate"),
                "voice-coil, inertial-motor, lra and rumble-motor are simulated".into(),
            );
        }
        Model::VoiceCoil | Model::InertialMotor | Model::RumbleMotor | Model::Lra => {}
    }
    let lacking = actuator.lacking();
    if !lacking.is_empty() {
        let listed: Vec<String> = lacking.iter().map(|key| format!("`{key}`")).collect();
        let what =
            format!("actuator `{name}` ({word}) lacks {}: how it moves is not known", listed.join(", "));
        let help = match actuator.part {
            Some(_) => "its part does not say that; give it here",
            None => "give it here, or name a part that ships: part = \"...\"; `pacinian parts` lists them",
        };
        return error(what, help.into());
    }
    let cannot = match actuator.model {
        Model::RumbleMotor => actuator.rumble_motor().err(),
        _ => actuator.coil().err(),
    };
    cannot.and_then(|why| error(format!("actuator `{name}` cannot be: {why}"), "correct it here".into()))
}
