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
            (None, Model::Piezo) => Bounds { range: self.range(output, actuator), ..Bounds::default() },
            _ => Bounds { peak: limits.volts, ..Bounds::default() },
        };
        // What makes up for coupling leaves larger than it arrives; a drive keeps by itself to what its motor bears.
        if matches!(output.kind, OutputKind::Drive(_)) && !self.corners(output).hertz().is_empty() {
            bounds.peak = None;
        }
        bounds.full_scale = Some(full_scale);
        bounds.slew = least(actuator.value("max_slew"), self.charging(output, actuator));
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

    /// Between which volts, in terms of what leaves the device, a piezo stays between those that it bears.
    fn range(&self, output: &Output, piezo: &Actuator) -> Option<[f64; 2]> {
        let amplifier = output.amplifier.as_ref().and_then(|name| self.amplifier(name));
        let (bias, gain) = amplifier.map_or((0.0, 1.0), |amplifier| (amplifier.bias, amplifier.gain));
        let [low, high] = piezo.range()?.map(|volts| volts - bias);
        Some(if gain < 0.0 { [-high, -low] } else { [low, high] })
    }

    /// How fast a current charges a piezo, V/s: that which the amplifier gives, or the element bears.
    fn charging(&self, output: &Output, actuator: &Actuator) -> Option<f64> {
        let gives = output.amplifier.as_ref().and_then(|name| self.amplifier(name)?.max_amperes);
        let farads = actuator.value("capacitance").filter(|_| actuator.model == Model::Piezo)?;
        Some(least(gives, actuator.value("max_amperes"))? / farads)
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

fn least(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::min)
}

impl Actuator {
    /// Between which volts a piezo stays: as far below 0 as above, where `min_volts` is not known. `None` where neither is.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        let [low, high] = [self.value("min_volts"), self.most_volts()];
        let most = high.unwrap_or(f64::INFINITY);
        (low.is_some() || high.is_some()).then(|| [low.unwrap_or(-most), most])
    }

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

#[cfg(test)]
mod tests {
    use crate::rig::Rig;

    /// What a piezo bears, less what its amplifier gives at rest, the other way round where that turns it; and how fast a current charges it.
    #[test]
    fn a_piezo_keeps_to_its_range_and_to_what_charges_it() {
        let of = |amplifier: &str, piezo: &str| {
            let rig = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 2\n[amplifier.a]\n{amplifier}\n\
                 [actuator.x]\nmodel = \"piezo\"\n{piezo}\n[[tactor]]\nname = \"t\"\nchannel = 1\nactuator = \"x\"\namplifier = \"a\"\n"
            );
            let rig = Rig::parse("r.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
            rig.bounds(&rig.outputs[0]).unwrap()
        };
        let whole = "max_volts = 120\nmin_volts = -20\ncapacitance = 1e-6";
        assert_eq!(of("gain = 60", whole).range, Some([-20.0, 120.0]));
        assert_eq!(of("gain = 60\nbias = 50", whole).range, Some([-70.0, 70.0]));
        assert_eq!(of("gain = -60\nbias = 40", whole).range, Some([-80.0, 60.0]));
        assert_eq!(of("gain = 60", "rated_volts = 30").range, Some([-30.0, 30.0]));
        assert_eq!(of("gain = 60", "min_volts = -5").range, Some([-5.0, f64::INFINITY]));
        // 10 mA charge 1 uF by 10 kV a second.
        assert_eq!(of("gain = 60\nmax_amperes = 0.01", whole).slew, Some(1e4));
        let both = format!("{whole}\nmax_amperes = 0.005\nmax_slew = 4e3");
        assert_eq!(of("gain = 60\nmax_amperes = 0.01", &both).slew, Some(4e3));
        assert_eq!(of("gain = 60", whole).slew, None);
        assert_eq!((of("gain = 60", whole).peak, of("gain = 60", whole).full_scale), (None, Some(120.0)));
    }
}
