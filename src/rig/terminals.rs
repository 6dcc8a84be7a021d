//! How what is wanted of a motor gets to its terminals, where that is not as it is: by the pulses of a bridge, or by a carrier and a rectifier.

use super::motor::Wiring;
use super::output::Turning;
use super::{Actuator, Amplifier, Coupling, Drive, Output, OutputKind, Rig};
use crate::actuator::driver::coast::{Coast, STANDS};
use crate::actuator::link::carrier::Carrier;
use crate::actuator::link::conduction::Conduction;
use crate::actuator::link::coupling::Corners;
use crate::actuator::link::pwm::Switching;
use crate::actuator::link::wave::HIGHEST;
use crate::actuator::motor::Parameters;
use crate::text::Problem;

/// What makes the volts at a motor's terminals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Terminals {
    /// Samples, as they are.
    Straight,
    /// Pulses.
    Bridge(Bridge),
    /// A carrier behind diodes: one way alone, and nothing brakes.
    Carrier(Carrier),
    /// Samples behind these corners: clicks alone.
    Coupled(Corners),
}

/// A bridge and its lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge {
    /// How it is switched.
    pub switching: Switching,
    /// The channel, from 0, that says which way.
    pub direction: u32,
}

/// A motor that nothing brakes must come to rest within so many seconds.
const ROLLS: f64 = 10.0;

impl Rig {
    /// That what vibrates would come out of a rectifier or a bridge as something else.
    pub(super) fn rectified(&self) -> Option<Problem> {
        let vibrating = self.outputs.iter().filter(|output| output.kind == OutputKind::Vibration);
        let (output, amplifier, why) = vibrating.into_iter().find_map(|output| {
            let amplifier = self.amplifier(output.amplifier.as_ref()?)?;
            let why = match amplifier.drive {
                Drive::Carrier(_) => "has a rectifier behind it: no vibration comes out of that",
                Drive::Bridge { .. } => {
                    "is a bridge, which knows on and off alone: no vibration goes into that"
                }
                Drive::Voltage | Drive::Current => return None,
            };
            Some((output, amplifier, why))
        })?;
        let what = format!(
            "output `{}` is for vibration, and its amplifier `{}` {why}",
            output.name, amplifier.name
        );
        let help =
            "a motor behind it is an [[output]] of kind = \"drive\"; for all else take another amplifier"
                .to_string();
        Some(Problem::error(&output.span, what).help(help))
    }

    /// A motor behind a bridge: pulses of its supply, as wide as what is wanted.
    pub(super) fn bridged(
        &self,
        output: &Output,
        turning: Turning,
        actuator: &Actuator,
        amplifier: &Amplifier,
        mut parameters: Parameters,
        period: u32,
    ) -> Result<Wiring, Problem> {
        let (name, supply) = (&output.name, amplifier.max_volts.unwrap_or(1.0));
        let Some(direction) = turning.direction else {
            let what = format!(
                "output `{name}` is behind the bridge `{}`, and which of its lines says which way is not known",
                amplifier.name
            );
            let help = "say on which channel that is: direction = 2".to_string();
            return Err(Problem::error(&output.span, what).help(help));
        };
        self.passes_steady(output, &Amplifier { coupling: Some(Coupling::Dc), ..amplifier.clone() })?;
        parameters.gravity = actuator.gravity(turning.tilt);
        let limit = actuator.most_volts().map_or(supply, |most| most.min(supply));
        let limit = limit.min(actuator.volts_of_amperes(amplifier, &parameters));
        let bridge =
            Bridge { switching: Switching { period, supply }, direction: direction.saturating_sub(1) };
        let wiring = Wiring {
            turning,
            parameters,
            is_current: false,
            per_sample: supply,
            limit,
            compliance: supply,
            terminals: Terminals::Bridge(bridge),
        };
        wiring.turns(output)
    }

    /// A motor behind a rectifier: what of a carrier gets through, on average. Coupling takes nothing of it but a little of its size.
    pub(super) fn carried(
        &self,
        output: &Output,
        turning: Turning,
        actuator: &Actuator,
        amplifier: &Amplifier,
        mut wiring: Wiring,
        carrier: Carrier,
    ) -> Result<Wiring, Problem> {
        let name = &output.name;
        let cannot =
            |what: String, help: &str| Err(Problem::error(&output.span, what).help(help.to_string()));
        if let Some(rate) = self.device.rate.filter(|rate| carrier.hertz > HIGHEST * rate) {
            return Err(too_high(output, carrier.hertz, rate));
        }
        if turning.look_ahead.is_some() {
            let what = format!(
                "output `{name}` has `look_ahead`, and behind the rectifier of `{}` nothing brakes its motor",
                amplifier.name
            );
            return cannot(
                what,
                "leave it out: the motor does what is played as it comes, and rolls out at the end",
            );
        }
        if output.inverted {
            let what = format!(
                "output `{name}` is turned upside down, and behind the rectifier of `{}` its motor turns one way alone",
                amplifier.name
            );
            return cannot(what, "leave `polarity` out; to turn it the other way, swap its wires");
        }
        let p = wiring.parameters;
        let rolls = Coast::new(&p).seconds(p.rated_speed(), STANDS * p.rated_speed());
        if rolls > ROLLS {
            let what = format!(
                "behind the rectifier of `{}` nothing brakes the motor of `{name}`, and by what is known of it it would not stand within {:.0} s",
                amplifier.name, ROLLS
            );
            return cannot(
                what,
                "say what its friction is: `coulomb_friction`, or `running_volts` where it is known from outside",
            );
        }
        let passes = self.corners(output).response(carrier.hertz).abs();
        wiring.per_sample = wiring.per_sample.abs() * passes;
        let amplitude =
            amplifier.max_volts.unwrap_or(f64::INFINITY).min(wiring.per_sample * self.max_level(output));
        let conduction = match Conduction::new(&carrier, p.electrical_time()) {
            Ok(conduction) => conduction,
            Err(fault) => {
                return cannot(
                    format!("the carrier of `{}` cannot be: {fault}", amplifier.name),
                    "correct it",
                );
            }
        };
        // What it can be given while it stands it can be given at any speed: turning, it takes away from the carrier, and keeps more than that.
        let most = conduction.mean(amplitude, 0.0);
        wiring.limit = actuator.most_volts().map_or(most, |bears| bears.min(most));
        wiring.limit = wiring.limit.min(actuator.volts_of_amperes(amplifier, &wiring.parameters));
        wiring.compliance = wiring.limit.max(f64::MIN_POSITIVE);
        wiring.terminals = Terminals::Carrier(carrier);
        wiring.turns(output)
    }
}

/// That a carrier does not fit a rate, Hz.
pub(crate) fn too_high(output: &Output, hertz: f64, rate: f64) -> Problem {
    let what = format!(
        "the carrier for the motor of `{}` has {hertz} Hz, and at {rate} Hz a device gives no more than {:.0} Hz",
        output.name,
        HIGHEST * rate
    );
    let help = "lower the amplifier's `carrier`, or raise the device's `rate`".to_string();
    Problem::error(&output.span, what).help(help)
}
