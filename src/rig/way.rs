//! The way from a sample to an actuator: what it is worth there, and what does not get there.

use super::{Coupling, Drive, Output, Rig};
use crate::actuator::link::coupling::Corners;

impl Rig {
    /// Volts at the actuator of an output for a sample of 1.0, without its sign; `None` where that is not known, or something else than a
    /// voltage is imposed.
    pub fn volts_per_sample(&self, output: &Output) -> Option<f64> {
        let gain = match &output.amplifier {
            None => 1.0,
            Some(name) => {
                let amplifier = self.amplifier(name)?;
                (amplifier.drive == Drive::Voltage).then_some(amplifier.gain)?
            }
        };
        let volts = (self.device.full_scale_volts? * gain).abs();
        (volts > 0.0).then_some(volts)
    }

    /// Amperes there for a sample of 1.0, without their sign; `None` where that is not known, or something else than a current is imposed.
    pub fn amperes_per_sample(&self, output: &Output) -> Option<f64> {
        let amplifier = self.amplifier(output.amplifier.as_ref()?)?;
        let gain = (amplifier.drive == Drive::Current).then_some(amplifier.gain)?;
        let amperes = (self.device.full_scale_volts? * gain).abs();
        (amperes > 0.0).then_some(amperes)
    }

    /// What keeps steady voltages off the actuator of an output: the device's coupling, and the amplifier's. What is not known of lets them
    /// through.
    pub fn corners(&self, output: &Output) -> Corners {
        let amplifier = output.amplifier.as_ref().and_then(|name| self.amplifier(name));
        let corner = |coupling: Option<Coupling>| match coupling {
            Some(Coupling::HighPass(hertz)) => Some(hertz),
            Some(Coupling::Dc) | None => None,
        };
        Corners::of(corner(self.device.coupling), corner(amplifier.and_then(|amplifier| amplifier.coupling)))
    }
}
