//! What is wrong with a rig as a whole.

use std::collections::{HashMap, HashSet};

use super::{Actuator, Amplifier, Coupling, Drive, MAX_CHANNELS, Model, Output, OutputKind, Rig, Turning};
use crate::text::Problem;
use crate::text::nearest::suggest;
use crate::text::sink::Sink;

/// What an amplifier makes of full scale, V.
const SCALE: [f64; 2] = [1e-6, 1e6];

/// Metres from the origin within which all of a body lies.
const BODY: f64 = 3.0;

impl Rig {
    /// That no body is so large, where positions were written in millimetres, say: once for the whole rig.
    fn too_large(&self) -> Option<Problem> {
        let far = |o: &Output| o.position.and_then(|p| p.into_iter().find(|x| x.abs() > BODY));
        let (output, x) = self.outputs.iter().find_map(|o| Some((o, far(o)?)))?;
        let what = format!(
            "output `{}` has {x} in its position: positions are metres, so that is {} m away",
            output.name,
            x.abs()
        );
        let help = format!("if {x} is millimetres, write {}", x / 1000.0);
        Some(Problem::warning(&output.span, what).help(help))
    }

    /// That a card with capacitors lets nothing steady through, whatever is said of an output.
    fn contradiction(&self) -> Option<Problem> {
        let Some(Coupling::HighPass(corner)) = self.device.coupling else { return None };
        let output = self.outputs.iter().find(|output| output.dc)?;
        let what = format!(
            "output `{}` has dc = true, but the device lets nothing steady through: its coupling is a high-pass at {corner} Hz",
            output.name
        );
        let help =
            "leave `dc` out, or say coupling = \"dc\" if the device lets steady voltages through".to_string();
        Some(Problem::warning(&output.span, what).help(help))
    }

    /// That it is of no use to know how a motor is held that is known from outside alone.
    fn weightless(&self) -> impl Iterator<Item = Problem> {
        let told = |output: &Output| {
            let OutputKind::Drive(Turning { tilt: Some(_), .. }) = output.kind else { return None };
            let actuator = self.actuator(output.actuator.as_ref()?)?;
            if actuator.model != Model::RumbleMotor || actuator.has_torques() {
                return None;
            }
            let what = format!(
                "output `{}` has a `tilt`, which counts for nothing: what the mass of `{}` weighs beside its torques is not known from outside",
                output.name, actuator.name
            );
            let help = "say what the motor is made of, `torque_constant` and what goes with it (`pacinian identify` tells it with a current channel), or leave `tilt` out"
                .to_string();
            Some(Problem::warning(&output.span, what).help(help))
        };
        self.outputs.iter().filter_map(told).take(Sink::MOST)
    }

    /// Amplifiers that make of full scale what none does.
    fn out_of_scale(&self) -> impl Iterator<Item = Problem> {
        let device = self.device.full_scale_volts;
        let told = move |amplifier: &Amplifier| {
            let amount = (device? * amplifier.gain).abs();
            if amplifier.drive == Drive::Current || amount == 0.0 || (SCALE[0]..=SCALE[1]).contains(&amount) {
                return None;
            }
            let what = format!(
                "amplifier `{}` makes {amount:.1e} V of `full_scale_volts`, but must make within {:.0e} and {:.0e} V of it",
                amplifier.name, SCALE[0], SCALE[1]
            );
            let help = "`gain` is its output over its input: 10 for 20 dB".to_string();
            Some(Problem::error(&amplifier.span, what).help(help))
        };
        self.amplifiers.iter().filter_map(told).take(Sink::MOST)
    }

    /// What is wrong with it as a whole: channels that the device lacks or that are taken twice, names that nothing has.
    pub fn check(&self) -> Vec<Problem> {
        self.checked(false)
    }

    pub(super) fn checked(&self, is_draft: bool) -> Vec<Problem> {
        let mut problems = Vec::new();
        if self.device.channels == 0 || self.device.channels > MAX_CHANNELS {
            let what = format!(
                "the device has {} channels; it may have from 1 to {MAX_CHANNELS}",
                self.device.channels
            );
            problems.push(Problem::of_file(what));
        }
        problems.extend(self.too_large());
        problems.extend(self.weightless());
        problems.extend(self.contradiction());
        problems.extend(self.rectified());
        problems.extend(self.biased());
        problems.extend(self.out_of_scale());
        problems.extend(self.check_groups());
        problems.extend(self.torque_way());
        // Of a figure that stands there and cannot be it is told as such, and not that it is missing.
        let told = |output: &&Output| {
            self.lacking(output).is_none_or(|(motor, key)| !is_draft && !motor.misread.contains(&key))
        };
        let wired = self.outputs.iter().filter(told).filter_map(|output| self.wiring(output)?.err());
        for problem in self.actuators.iter().filter_map(Actuator::contradiction).chain(wired).take(Sink::MOST)
        {
            // Of an actuator that cannot be it is told once, whatever hangs on it.
            if !problems.contains(&problem) {
                problems.push(problem);
            }
        }
        let measured = self.outputs.iter().filter_map(|output| self.calibrated(output));
        problems.extend(measured.take(Sink::MOST));
        let (mut names, mut channels) = (HashMap::new(), HashMap::new());
        let actuators: HashSet<&str> = self.actuators.iter().map(|a| a.name.as_str()).collect();
        let amplifiers: HashSet<&str> = self.amplifiers.iter().map(|a| a.name.as_str()).collect();
        for output in &self.outputs {
            if problems.len() >= Sink::MOST {
                break;
            }
            let name = output.name.as_str();
            if !name.is_empty() && names.insert(name, ()).is_some() {
                let help = "every output has its own name".to_string();
                problems.push(
                    Problem::error(&output.span, format!("there are two outputs called `{name}`")).help(help),
                );
            }
            // 0 stands for a channel that cannot be read, which has been said.
            if output.channel > self.device.channels {
                let what = format!(
                    "output `{name}` is on channel {}, the device has {}",
                    output.channel, self.device.channels
                );
                let help =
                    "channels count from 1; `channels` of the device says how many there are".to_string();
                problems.push(Problem::error(&output.channel_span, what).help(help));
            } else if let OutputKind::Drive(Turning { direction: Some(line), .. }) = output.kind
                && line > self.device.channels
            {
                let what = format!(
                    "output `{name}` has its direction on channel {line}, the device has {}",
                    self.device.channels
                );
                problems.push(Problem::error(&output.span, what));
            } else if output.channel > 0
                && let Some(other) = channels.insert(output.channel, name)
            {
                let what = format!("outputs `{other}` and `{name}` are both on channel {}", output.channel);
                problems.push(Problem::error(&output.channel_span, what));
            } else if output.channel == 0 && output.span.is_empty() {
                problems.push(Problem::error(
                    &output.span,
                    format!("output `{name}` is on channel 0; channels count from 1"),
                ));
            }
            if let OutputKind::Drive(Turning { direction: Some(line), .. }) = output.kind
                && line <= self.device.channels
                && let Some(other) = channels.insert(line, name)
            {
                let what =
                    format!("output `{name}` has its direction on channel {line}, on which is `{other}`");
                problems.push(Problem::error(&output.span, what));
            }
            if let Some(wanted) = output.actuator.as_deref().filter(|n| !actuators.contains(n)) {
                let what = format!("output `{name}` has an actuator `{wanted}`, which is not there");
                problems
                    .push(Problem::error(&output.span, what).help(missing(wanted, "actuator", &actuators)));
            }
            if let Some(wanted) = output.amplifier.as_deref().filter(|n| !amplifiers.contains(n)) {
                let what = format!("output `{name}` has an amplifier `{wanted}`, which is not there");
                problems.push(Problem::error(&output.span, what).help(missing(
                    wanted,
                    "amplifier",
                    &amplifiers,
                )));
            }
        }
        problems
    }
}

fn missing(word: &str, kind: &str, names: &HashSet<&str>) -> String {
    suggest(word, names.iter().copied()).unwrap_or_else(|| format!("describe it under [{kind}.{word}]"))
}

#[cfg(test)]
mod tests {
    use crate::rig::Rig;

    #[test]
    fn an_amplifier_out_of_scale_is_told_where_it_stands() {
        let of = |volts: f64, gain: f64, drive: &str| {
            let rig = format!(
                "format = \"pacinian-rig/1\"\ntitle = \"T\"\n[device]\nchannels = 1\nfull_scale_volts = {volts:?}\n[amplifier.big]\n\
                 gain = {gain:?}\n{drive}\n[[tactor]]\nname = \"a\"\nchannel = 1\namplifier = \"big\"\n"
            );
            Rig::parse("r.toml", rig.as_bytes()).map(|_| ()).map_err(|problems| problems.to_string())
        };
        for (volts, gain) in [(1000.0, 1001.0), (1000.0, -1001.0), (1e-3, 0.9e-3)] {
            let told = of(volts, gain, "").unwrap_err();
            assert!(told.starts_with("r.toml:6") && told.contains("amplifier `big` makes"), "{told}");
        }
        assert_eq!(of(1000.0, -1000.0, ""), Ok(()));
        assert_eq!(of(1000.0, 1001.0, "drive = \"current\""), Ok(()));
    }
}
