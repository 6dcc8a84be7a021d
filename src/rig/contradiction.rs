//! Figures of an actuator that contradict each other.

use std::collections::BTreeMap;

use super::motor::Lack;
use super::{Actuator, Model, Output, Rig};
use crate::text::Problem;
use crate::text::reader::Reader;

/// What may not be more than another, both as a rig says them, and why.
const AT_MOST: [(&str, &str, &str); 3] = [
    ("rated_volts", "max_volts", "it bears what it is made for"),
    ("max_rms_volts", "max_volts", "no root mean square is more than its peak"),
    ("max_rms_amperes", "max_amperes", "no root mean square is more than its peak"),
];

/// Two ways to say the same, of which the first would count for nothing beside the second.
const EITHER: [(&str, &str); 2] = [("resonance", "stiffness"), ("q", "damping")];
/// How a motor is seen to move, which counts for nothing where a rig says what it is made of.
const OUTSIDE: [&str; 5] =
    ["time_constant", "speed_per_volt", "running_volts", "start_volts", "eccentric_per_mass"];

impl Actuator {
    /// That all is known which its model needs, and that it cannot be so.
    pub(super) fn contradiction(&self) -> Option<Problem> {
        let lack = match self.model {
            Model::RumbleMotor => self.rumble_motor().err(),
            Model::VoiceCoil | Model::InertialMotor | Model::Lra => self.coil().err(),
            Model::Generic | Model::Piezo => None,
        };
        match lack? {
            Lack::Figure(_) => None,
            fault @ Lack::Fault(_) => Some(fault.of(self)),
        }
    }
}

impl Rig {
    /// That an amplifier gives at rest what the actuator of an output does not bear.
    pub(super) fn biased(&self) -> Option<Problem> {
        let told = |output: &Output| {
            let amplifier = self.amplifier(output.amplifier.as_ref()?).filter(|a| a.bias != 0.0)?;
            let actuator = self.actuator(output.actuator.as_ref()?);
            let gives = format!("amplifier `{}` has a `bias` of {} V", amplifier.name, amplifier.bias);
            let piezo = actuator.filter(|actuator| actuator.model == Model::Piezo);
            let Some(piezo) = piezo else {
                let what = format!(
                    "{gives}, and what hangs on output `{}` is no piezo, which alone bears it",
                    output.name
                );
                return Some(Problem::error(&output.span, what).help("leave it out".to_string()));
            };
            let [low, high] = piezo.range()?;
            if (low..=high).contains(&amplifier.bias) {
                return None;
            }
            let what = format!("{gives}, and actuator `{}` bears {low} to {high} V", piezo.name);
            let help = "half of `max_volts` leaves as much room either way".to_string();
            Some(Problem::error(&amplifier.span, what).help(help))
        };
        self.outputs.iter().find_map(told)
    }
}

/// Tells of figures that a rig itself says and that cannot both be, or of which one would count for nothing.
pub(super) fn tell(reader: &Reader, model: Model, values: &BTreeMap<&'static str, f64>) {
    let sprung = [Model::VoiceCoil, Model::InertialMotor].contains(&model);
    for (idle, counts) in EITHER.into_iter().filter(|_| sprung) {
        if values.contains_key(idle) && values.contains_key(counts) {
            let what = format!(
                "{} has both `{idle}` and `{counts}`, which are two ways to say the same",
                reader.who
            );
            let help = format!("leave one of them out: `{counts}` would count, and `{idle}` for nothing");
            reader.sink.push(Problem::error(&reader.span_of(idle), what).help(help));
        }
    }
    if model == Model::RumbleMotor && values.contains_key("torque_constant") {
        let idle: Vec<&str> = OUTSIDE.into_iter().filter(|key| values.contains_key(key)).collect();
        if let Some(first) = idle.first() {
            let counts = if idle.len() == 1 { "counts" } else { "count" };
            let what = format!(
                "{}: `{}` {counts} for nothing beside `torque_constant`",
                reader.who,
                idle.join("`, `")
            );
            let help =
                "say what it is made of or how it is seen to move, not both: leave the one out".to_string();
            reader.sink.push(Problem::warning(&reader.span_of(first), what).help(help));
        }
    }
    for (less, more, why) in AT_MOST {
        let (Some(low), Some(high)) = (values.get(less), values.get(more)) else { continue };
        if low > high {
            let what =
                format!("{} has a `{more}` of {high}, which is less than its `{less}` of {low}", reader.who);
            let help = format!(
                "{why}: correct one of them; what leaves is also held by `max_level` and the amplifier's limits"
            );
            reader.sink.push(Problem::error(&reader.span_of(more), what).help(help));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::rig::Rig;

    fn told(actuator: &str, output: &str) -> Result<(), String> {
        let rig = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 5.0\ncoupling = \"dc\"\n\
             [amplifier.a]\ngain = 1.0\ncoupling = \"dc\"\n[actuator.x]\n{actuator}\n{output}"
        );
        Rig::parse("r.toml", rig.as_bytes()).map(|_| ()).map_err(|problems| problems.to_string())
    }

    const TACTOR: &str = "[[tactor]]\nname = \"t\"\nchannel = 1\nactuator = \"x\"\n";
    const LRA: &str = "model = \"lra\"\nresonance = 175\nq = 15\nrated_volts = 2\nrated_acceleration = 12\ntest_mass = 0.1\n\
                       slug_mass = 1.5e-3\nresistance = 25\n";

    /// Whatever hangs on it, a drive, a tactor or nothing: at its line, with the key and the limit, once.
    #[test]
    fn what_cannot_be_is_told_whatever_hangs_on_it() {
        let drive = |name: &str, channel: u32| {
            format!(
                "[[output]]\nkind = \"drive\"\nname = \"{name}\"\nchannel = {channel}\nactuator = \"x\"\namplifier = \"a\"\n"
            )
        };
        let both = drive("a", 1) + &drive("b", 2);
        let light = format!("{LRA}device_mass = 1e-3");
        let coin = "part = \"coin-10mm\"\nmass = 1e-5";
        let weak = "part = \"vybronics-vg0832013d\"\nrated_acceleration = 1e5";
        for (actuator, output, wanted) in [
            (&*light, "", "`device_mass` is 0.001, but must be above 0.0015"),
            (&light, TACTOR, "`device_mass` is 0.001, but must be above 0.0015"),
            (weak, TACTOR, "`rated_acceleration` is 100000, but must be at most"),
            (coin, TACTOR, "`mass` is 0.00001, but must be above"),
            (coin, &both, "`mass` is 0.00001, but must be above"),
        ] {
            let told = told(actuator, output).unwrap_err();
            let stands = told.starts_with("r.toml:9:") && told.contains("actuator `x` cannot be");
            assert!(stands && told.contains(wanted), "{told}");
            assert_eq!(told.matches(wanted).count(), 1, "{told}");
        }
        // What is merely not known is no contradiction.
        assert_eq!(told(&LRA.replace("q = 15\n", ""), TACTOR), Ok(()));
        assert_eq!(told(&format!("{LRA}device_mass = 2e-3"), TACTOR), Ok(()));
    }

    #[test]
    fn a_bias_is_for_piezos_that_bear_it() {
        let of = |actuator: &str, bias: f64| {
            let rig = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 1\n[amplifier.a]\ngain = 60\nbias = {bias:?}\n\
                 [actuator.x]\n{actuator}\n{TACTOR}amplifier = \"a\"\n"
            );
            Rig::parse("r.toml", rig.as_bytes()).map(|_| ()).map_err(|problems| problems.to_string())
        };
        let piezo = "part = \"tdk-powerhap-1313h018v120\"";
        assert_eq!(
            (of(piezo, 60.0), of(piezo, 120.0), of("part = \"eai-c-mf\"", 0.0)),
            (Ok(()), Ok(()), Ok(()))
        );
        let told = of(piezo, 130.0).unwrap_err();
        assert!(told.contains("`bias` of 130 V, and actuator `x` bears 0 to 120 V"), "{told}");
        let told = of("part = \"eai-c-mf\"", 1.0).unwrap_err();
        assert!(told.contains("`bias` of 1 V") && told.contains("is no piezo"), "{told}");
    }

    /// Of two ways to say the same one would count for nothing: both are named, at the line of that one.
    #[test]
    fn what_is_said_twice_is_refused() {
        let coil = |model: &str, more: &str| told(&format!("model = \"{model}\"\n{more}"), TACTOR);
        for model in ["voice-coil", "inertial-motor"] {
            for (idle, counts) in [("q = 3", "damping = 0.5"), ("resonance = 200", "stiffness = 3000")] {
                for both in [format!("{idle}\n{counts}"), format!("{counts}\n{idle}")] {
                    let said = coil(model, &both).unwrap_err();
                    let [a, b] = [idle, counts].map(|text| text.split(' ').next().unwrap());
                    let line = if both.starts_with(idle) { "r.toml:11:" } else { "r.toml:12:" };
                    assert!(said.contains(&format!("`{a}` and `{b}`")) && said.starts_with(line), "{said}");
                }
                assert_eq!((coil(model, idle), coil(model, counts)), (Ok(()), Ok(())));
            }
        }
        // What a part says gives way to what the rig says.
        assert_eq!(told("part = \"eai-c-mf\"\nq = 3", TACTOR), Ok(()));
        let motor = |more: &str| {
            let rig = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 5.0\n[actuator.x]\npart = \"coin-10mm\"\n{more}"
            );
            Rig::parse("r.toml", rig.as_bytes()).unwrap().warnings.to_string()
        };
        let said = motor("torque_constant = 1e-3\ntime_constant = 0.03\nstart_volts = 1\n");
        assert!(
            said.contains("`time_constant`, `start_volts` count for nothing beside `torque_constant`"),
            "{said}"
        );
        assert!(!motor("torque_constant = 1e-3\n").contains("for nothing"));
        assert!(!motor("time_constant = 0.03\n").contains("for nothing"));
    }

    #[test]
    fn limits_that_contradict_each_other_are_told_at_their_line() {
        let of = |more: &str| told(&format!("model = \"voice-coil\"\n{more}"), TACTOR);
        for (figures, limit, other) in [
            ("rated_volts = 3.0\nmax_volts = 2.9", "`max_volts` of 2.9", "`rated_volts` of 3"),
            ("max_rms_volts = 4.0\nmax_volts = 3.0", "`max_volts` of 3", "`max_rms_volts` of 4"),
            ("max_rms_amperes = 0.2\nmax_amperes = 0.1", "`max_amperes` of 0.1", "`max_rms_amperes` of 0.2"),
        ] {
            let told = of(figures).unwrap_err();
            assert!(told.starts_with("r.toml:12:") && told.contains(limit) && told.contains(other), "{told}");
        }
        assert_eq!(of("rated_volts = 3.0\nmax_volts = 3.0\nmax_rms_volts = 3.0"), Ok(()));
        // Less than a part is made for is a wish, and no contradiction.
        assert_eq!(told("part = \"coin-10mm\"\nmax_volts = 2.0", TACTOR), Ok(()));
    }
}
