//! An actuator's resonance taken out of what is felt, by its own model.

use super::{Actuator, Drive, Model, Output, OutputKind, Rig};
use crate::actuator::coil::equaliser::{Equaliser, Motion, Wish};
use crate::actuator::coil::limits::Limits;
use crate::actuator::coil::resonance::Resonance;
use crate::actuator::drive::Drive as Imposed;
use crate::text::Problem;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

/// What is to be left of a resonance: `even_out` of an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Even {
    /// Where the resonance goes, Hz; `None`: where it is.
    pub resonance: Option<f64>,
    /// Its quality.
    pub q: f64,
    /// The most by which anything in the band is raised or lowered, dB.
    pub most_db: f64,
    /// The band that matters, Hz.
    pub band: [f64; 2],
}

/// Its keys.
pub static TABLE: Table = Table {
    name: "even",
    doc: "What is to be left of the actuator's resonance.",
    fields: &[
        Field::new(
            "resonance",
            Form::any_number(1.0, 1000.0),
            "Hz",
            "Where the resonance goes; it stays where it is where nothing is said.",
        ),
        Field::new(
            "q",
            Form::number(0.7, 0.3, 50.0),
            "",
            "Its quality then: at 0.7 nothing stands out. What is felt at the resonance becomes weaker as the quality does: the volts for a quick beginning are what the volts for more would be.",
        ),
        Field::new(
            "most_db",
            Form::number(12.0, 0.5, 40.0),
            "dB",
            "The most by which anything in the band is raised, or lowered within an octave of the resonance. A resonance moves with the skin, and what was far raised or cut then errs by as much.",
        ),
        Field::new("low", Form::number(20.0, 0.5, 900.0), "Hz", "The band that matters, from here."),
        Field::new("high", Form::number(1000.0, 2.0, 1000.0), "Hz", "To here."),
    ],
    others: None,
};

/// Reads it, of an actuator of a model that has a coil.
pub(super) fn read(of: &Reader, model: Model) -> Option<Even> {
    let reader = of.one("even_out", format!("even_out of {}", of.who))?;
    if !matches!(model, Model::VoiceCoil | Model::InertialMotor | Model::Lra) {
        let what = format!("{} is of model {}, which has no resonance to even out", of.who, model.word());
        let help = "`even_out` is for models voice-coil, inertial-motor and lra; `equaliser` takes filters of your own";
        reader.sink.push(Problem::error(&of.span_of("even_out"), what).help(help.to_string()));
        return None;
    }
    let even = Even {
        resonance: reader.number("resonance"),
        q: reader.number_or_default("q"),
        most_db: reader.number_or_default("most_db"),
        band: [reader.number_or_default("low"), reader.number_or_default("high")],
    };
    if even.band[0] >= even.band[1] {
        let what =
            format!("{}: `low` is {}, but must be below `high`, {}", reader.who, even.band[0], even.band[1]);
        reader.sink.error(&reader.span_of("low"), what);
        return None;
    }
    Some(even)
}

impl Rig {
    /// The equaliser of an output's actuator: its own pole pair taken away, another put in the place, as far as amplifier and actuator bear
    /// it. `None` where the rig asks for none, or the output is none for vibration.
    ///
    /// Where the device's volts are not known, neither is what the actuator gets: then only `most_db` holds it back.
    ///
    /// # Errors
    /// A figure of the actuator that is missing or cannot be.
    pub fn evened(&self, output: &Output) -> Option<Result<Equaliser, Problem>> {
        if output.kind != OutputKind::Vibration {
            return None;
        }
        let actuator = self.actuator(output.actuator.as_ref()?)?;
        let even = actuator.even_out?;
        Some(self.even(output, actuator, &even))
    }

    fn even(&self, output: &Output, actuator: &Actuator, even: &Even) -> Result<Equaliser, Problem> {
        let plant = actuator.coil().map_err(|lack| lack.of(actuator))?;
        let amplifier = output.amplifier.as_ref().and_then(|name| self.amplifier(name));
        let imposes = match amplifier.map(|amplifier| amplifier.drive) {
            Some(Drive::Current) => Imposed::Current,
            _ => Imposed::Voltage,
        };
        let gain = amplifier.map_or(1.0, |amplifier| amplifier.gain.abs());
        let level = self.device.full_scale_volts.map(|volts| volts * gain * self.max_level(output));
        let limits = match level {
            Some(_) => actuator.limits().within(
                amplifier.and_then(|amplifier| amplifier.max_volts),
                amplifier.and_then(|amplifier| amplifier.max_amperes),
            ),
            None => Limits::default(),
        };
        let cannot = |what: String| {
            let what = format!("the resonance of actuator `{}` cannot be evened out: {what}", actuator.name);
            Problem::error(&actuator.span, what)
        };
        let own = plant.resonance(imposes).ok_or_else(|| cannot("without a spring it has none".into()))?;
        let motion = match actuator.model {
            Model::VoiceCoil => Motion::Displacement,
            _ => Motion::Acceleration,
        };
        let wish = Wish {
            motion,
            target: Resonance { hertz: even.resonance.unwrap_or(own.hertz), q: even.q },
            band: even.band,
            level: level.filter(|level| *level > 0.0).unwrap_or(1.0),
            most_change: even.most_db,
            limits,
        };
        Equaliser::design(&plant, imposes, &wish).map_err(|fault| cannot(fault.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use crate::actuator::coil::equaliser::Limited;
    use crate::rig::Rig;

    /// What an amplifier gives at most holds the equaliser back, also where the actuator itself bears more or says nothing.
    #[test]
    fn an_amplifiers_most_volts_hold_it_back() {
        let evened = |volts: &str, level: f64| {
            let text = format!(
                "format = \"pacinian-rig/1\"\ntitle = \"T\"\n[device]\nchannels = 1\nfull_scale_volts = {level}\n[amplifier.board]\ngain = 1.0\n{volts}\n\
                 [actuator.it]\nmodel = \"voice-coil\"\nresistance = 8.0\nforce_factor = 2.0\nmoving_mass = 0.004\nresonance = 160.0\nq = 3.0\n\
                 even_out = {{ resonance = 400.0, most_db = 30.0 }}\n[[tactor]]\nname = \"t\"\nchannel = 1\namplifier = \"board\"\nactuator = \"it\"\n"
            );
            let rig = Rig::parse("rig", text.as_bytes()).unwrap().value;
            rig.evened(&rig.outputs[0]).unwrap().unwrap()
        };
        let free = evened("", 1.0);
        assert_eq!(free.limited, None, "{free:?}");
        let held = evened("max_volts = 2.0", 1.0);
        assert_eq!(held.limited, Some(Limited::Volts), "{held:?}");
        // It boosts by what is left of the volts, and no more.
        assert!(held.boost < free.boost && (held.boost - 20.0 * 2f64.log10()).abs() < 0.1, "{held:?}");
        assert_eq!(evened("max_volts = 200.0", 1.0), free);
    }
}
