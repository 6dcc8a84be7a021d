//! What a rig knows of its outputs by calibration.

use super::Calibration;
use crate::perception::calibration::Per;
use crate::perception::site::{Site, THENAR};
use crate::rig::{Drive, Output, OutputKind, Rig};
use crate::text::Problem;
use crate::text::nearest::suggest;

impl Rig {
    /// The calibration of that name.
    pub fn calibration(&self, name: &str) -> Option<&Calibration> {
        self.calibrations.iter().find(|calibration| calibration.name == name)
    }

    /// The calibration of an output.
    pub fn calibration_of(&self, output: &Output) -> Option<&Calibration> {
        self.calibration(output.calibration.as_ref()?)
    }

    /// Where on the body an output sits: as it says, else as its calibration does, else on the thenar.
    pub fn site_of(&self, output: &Output) -> &'static Site {
        output.site.or_else(|| self.calibration_of(output)?.site).unwrap_or(THENAR)
    }

    /// Volts, amperes or full scales at the tactor of an output for a sample of 1.0, as its calibration counts them.
    ///
    /// # Errors
    /// Why that is not known.
    pub fn per_sample(&self, output: &Output, calibration: &Calibration) -> Result<f64, Problem> {
        let per = calibration.unit.per;
        let amplifier = output.amplifier.as_ref().and_then(|name| self.amplifier(name));
        let gain = match (per, amplifier.map(|amplifier| (amplifier.drive, amplifier.gain))) {
            (Per::FullScale, _) => return Ok(1.0),
            (Per::Volt, None) => 1.0,
            (Per::Volt, Some((Drive::Voltage, gain))) | (Per::Ampere, Some((Drive::Current, gain))) => gain,
            _ => {
                let what = format!(
                    "calibration `{}` of `{}` is in {}, which its amplifier does not impose",
                    calibration.name, output.name, calibration.unit_word
                );
                let help = match per {
                    Per::Ampere => "amperes come from an amplifier with drive = \"current\"",
                    _ => "volts come from an amplifier with drive = \"voltage\", or from none",
                };
                return Err(Problem::error(&output.span, what).help(help.to_string()));
            }
        };
        let Some(volts) = self.device.full_scale_volts else {
            let what = format!(
                "calibration `{}` of `{}` is in {}, and nothing says how many volts full scale is",
                calibration.name, output.name, calibration.unit_word
            );
            let help =
                "measure `full_scale_volts` of the device, or calibrate over full scale: um/FS".to_string();
            return Err(Problem::error(&output.span, what).help(help));
        };
        let amount = (volts * gain).abs();
        if amount > 0.0 {
            return Ok(amount);
        }
        let what = format!("nothing gets through the amplifier to `{}`, which is calibrated", output.name);
        Err(Problem::error(&output.span, what).help("give the amplifier a `gain` above 0".to_string()))
    }

    /// What is wrong with the calibration of an output, and what is doubtful.
    pub(in crate::rig) fn calibrated(&self, output: &Output) -> Option<Problem> {
        let name = output.calibration.as_ref()?;
        let Some(calibration) = self.calibration(name) else {
            let what = format!("output `{}` has a calibration `{name}`, which is not there", output.name);
            let help = suggest(name, self.calibrations.iter().map(|calibration| calibration.name.as_str()))
                .unwrap_or_else(|| format!("describe it under [calibration.{name}]"));
            return Some(Problem::error(&output.span, what).help(help));
        };
        if !matches!(output.kind, OutputKind::Vibration | OutputKind::Raw) {
            let what = format!(
                "output `{}` is of kind {}; what vibrates is calibrated",
                output.name,
                output.kind.word()
            );
            return Some(Problem::error(&output.span, what).help("leave `calibration` out".to_string()));
        }
        if let Err(problem) = self.per_sample(output, calibration) {
            return Some(problem);
        }
        let (sits, measured) = (output.site?, calibration.site?);
        (sits != measured).then(|| {
            let what = format!(
                "`{}` sits on the {} and was calibrated on the {}: other skin loads a tactor otherwise",
                output.name, sits.word, measured.word
            );
            Problem::warning(&output.span, what).help(format!("calibrate it on the {}", sits.word))
        })
    }
}
