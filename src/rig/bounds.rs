//! What the actuator on an output bears, in terms of what leaves the device there.

use super::{Actuator, Drive, Model, Output, OutputKind, Rig};
use crate::actuator::protect::bounds::{Actuator as Moves, Bounds, Rms, Unit};
use crate::actuator::protect::budget::Bears;
use crate::actuator::thermal::{COPPER, Cooling};

/// Seconds over which a mean square is held to what an actuator bears for long.
const LONG: f64 = 1.0;

impl Rig {
    /// What its actuator bears; `None` where nothing is known of it that would hold anything back.
    pub fn bounds(&self, output: &Output) -> Option<Bounds> {
        if !matches!(output.kind, OutputKind::Vibration | OutputKind::Raw | OutputKind::Drive(_)) {
            return None;
        }
        let actuator = self.actuator(output.actuator.as_ref()?)?;
        let full_scale = self.volts_per_sample(output)?;
        let limits = actuator.limits();
        let coil = actuator.coil().ok();
        let mut bounds = match (&coil, actuator.model) {
            (Some(plant), _) => Bounds::coil(plant, &limits, full_scale, LONG),
            (None, Model::RumbleMotor) if !matches!(output.kind, OutputKind::Drive(_)) => {
                match actuator.rumble_motor() {
                    // It cannot follow what vibrates, and only gets hot of it.
                    Ok(motor) => Bounds { peak: limits.volts, ..Bounds::motor(&motor, full_scale, 1.0) },
                    Err(_) => Bounds { peak: limits.volts, ..Bounds::default() },
                }
            }
            _ => Bounds { peak: limits.volts, ..Bounds::default() },
        };
        // What makes up for coupling leaves larger than it arrives; a drive keeps by itself to what its motor bears.
        if matches!(output.kind, OutputKind::Drive(_)) && !self.corners(output).hertz().is_empty() {
            bounds.peak = None;
        }
        bounds.full_scale = Some(full_scale);
        bounds.slew = actuator.value("max_slew");
        if let Some(most) = actuator.value("max_rms_volts") {
            bounds.rms = Some(Rms { most, unit: Unit::Volts, seconds: LONG });
        }
        if let (None, Some(ohms)) = (&coil, actuator.value("resistance")) {
            bounds.actuator = Moves::Resistance(ohms);
        }
        bounds.heat = actuator.cooling();
        let nothing =
            Bounds { full_scale: bounds.full_scale, actuator: bounds.actuator, ..Bounds::default() };
        (bounds != nothing).then_some(bounds)
    }

    /// What the motor of a drive bears for long, where what leaves the device is no voltage at its terminals: behind a bridge or a rectifier, or at a
    /// current. `None` for any other output, and where nothing is known of that.
    pub fn bears(&self, output: &Output) -> Option<Bears> {
        let OutputKind::Drive(_) = output.kind else { return None };
        let amplifier = self.amplifier(output.amplifier.as_ref()?)?;
        let actuator = self.actuator(output.actuator.as_ref()?)?;
        let rms = actuator.value("max_rms_volts").map(|most| [most, LONG]);
        let bears = Bears { heat: actuator.cooling(), rms };
        (amplifier.drive != Drive::Voltage && bears != Bears::default()).then_some(bears)
    }
}

impl Actuator {
    /// How it sheds its heat, where that is known.
    pub fn cooling(&self) -> Option<Cooling> {
        Some(Cooling {
            resistance: self.value("resistance")?,
            rise: COPPER,
            to_housing: self.value("winding_to_housing")?,
            to_air: self.value("housing_to_air")?,
            winding_time: self.value("winding_time")?,
            housing_time: self.value("housing_time")?,
            most: self.value("max_heating")?,
        })
    }
}
