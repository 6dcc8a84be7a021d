//! What a recording tells, as a rig has it: which key each figure is, whether it goes into the rig, and what contradicts it there.

use super::Identify;
use super::target::Target;
use pacinian::actuator::drive::Drive;
use pacinian::actuator::identify::{Estimate, Identified};
use pacinian::rig::{Model, part};
use pacinian::text::field::Form;
use serde::Serialize;

/// A figure that is told.
#[derive(Debug, Clone, Serialize)]
pub struct Figure {
    /// The key of a rig, where it is one.
    pub name: &'static str,
    /// In `unit`, rounded to what the interval lets one know.
    pub value: f64,
    /// 95 %.
    pub interval: [f64; 2],
    /// SI.
    pub unit: &'static str,
    /// What the rig or the part says so far.
    pub before: Option<f64>,
    /// Whether a rig has such a key.
    pub is_key: bool,
    /// Why it does not go into the rig; null where it does.
    pub left_out: Option<String>,
}

/// A figure that is not told, and why not.
#[derive(Debug, Clone, Serialize)]
pub struct Lacking {
    pub name: &'static str,
    pub why: String,
}

/// What is seen of a motor from outside.
const OUTSIDE: [&str; 5] =
    ["time_constant", "speed_per_volt", "running_volts", "start_volts", "eccentric_per_mass"];
/// What it is made of, of which all of these must be known.
const INSIDE: [&str; 4] = ["resistance", "torque_constant", "inertia", "eccentric_moment"];
/// What else it is made of, of no use without those.
const BESIDE: [&str; 3] = ["viscous_friction", "coulomb_friction", "static_friction"];
/// What two masses differ by that are the same.
const SAME: f64 = 1e-6;
/// Digits of a value at least, and at most.
const DIGITS: [usize; 2] = [4, 8];

/// All that is told.
pub fn figures(all: &Identified, target: &Target) -> Vec<Figure> {
    let open = [("resonance", "open_resonance", "shorted_resonance"), ("q", "open_q", "shorted_q")];
    let of_open = [Model::VoiceCoil, Model::InertialMotor].contains(&target.model);
    let told = |name: &str| all.get(name).is_some();
    let mut figures: Vec<Figure> = all
        .told
        .iter()
        .map(|estimate| {
            // A rig has the resonance of springs and masses alone, with open terminals, but for a data sheet of an LRA.
            let renamed =
                open.iter().filter(|(_, open, _)| of_open && told(open)).find_map(|(key, open, shorted)| {
                    let name = if estimate.name == *open { *key } else { *shorted };
                    ([*open, *key].contains(&estimate.name)).then_some(name)
                });
            Figure::new(estimate, renamed.unwrap_or(estimate.name), target)
        })
        .collect();
    let missing = missing(all);
    for figure in figures.iter_mut().filter(|figure| figure.is_key) {
        figure.left_out = figure.why_not(target, &missing, of_open && !told("open_q"));
    }
    figures
}

/// What of a motor is missing for it to be known by what it is made of: all must be told, and nothing taken from a part.
fn missing(all: &Identified) -> Vec<&'static str> {
    INSIDE.into_iter().filter(|key| all.get(key).is_none()).collect()
}

/// What is known of a figure so far: of a coil whose springs or damping are known, the resonance and the quality are those that they make.
fn known(name: &str, target: &Target) -> Option<f64> {
    let made_by = [("resonance", "stiffness"), ("q", "damping")];
    let made = made_by.iter().any(|(key, by)| *key == name && target.value(by).is_some());
    let of_coil = [Model::VoiceCoil, Model::InertialMotor].contains(&target.model);
    if !(of_coil && made) {
        return target.value(name);
    }
    let pair = target.actuator.as_ref()?.coil().ok()?.resonance(Drive::Current)?;
    Some(if name == "q" { pair.q } else { pair.hertz })
}

impl Figure {
    fn new(estimate: &Estimate, name: &'static str, target: &Target) -> Self {
        let Estimate { value, interval, unit, .. } = *estimate;
        let field = part::fields().find(|field| field.key == name);
        Self {
            name,
            value: rounded(value, interval),
            interval: interval.map(|end| rounded(end, interval)),
            unit: field.map_or(unit, |field| if field.unit.is_empty() { "" } else { unit }),
            before: known(name, target),
            is_key: field.is_some(),
            left_out: None,
        }
    }

    fn why_not(&self, target: &Target, missing: &[&str], is_shorted: bool) -> Option<String> {
        if !part::has(target.model, self.name) {
            return Some(format!("a rig's {} has no such key", target.model.word()));
        }
        let field = part::fields().find(|field| field.key == self.name)?;
        if let Form::Number { least, most, .. } = field.form
            && !(least..=most).contains(&self.value)
        {
            return Some(format!("a rig's is from {least} to {most} {}", field.unit));
        }
        if target.is_motor() {
            let is_own = target.own.iter().any(|key| key == self.name);
            if missing.is_empty() && OUTSIDE.contains(&self.name) && !is_own {
                return Some("it follows from what the motor is made of, which is told".into());
            }
            let of_inside = INSIDE[1..].contains(&self.name) || BESIDE.contains(&self.name);
            if !missing.is_empty() && of_inside && !is_own {
                let help = if missing == ["eccentric_moment"] {
                    ": --mass KG and --acceleration-scale tell that"
                } else {
                    ""
                };
                return Some(format!("it would do nothing without {}{help}", missing.join(", ")));
            }
            return None;
        }
        let before =
            [("resonance", "stiffness"), ("q", "damping")].into_iter().find(|(key, _)| *key == self.name);
        if let Some((key, before)) = before
            && [Model::VoiceCoil, Model::InertialMotor].contains(&target.model)
            && target.own.iter().any(|own| own == before)
        {
            return Some(format!("{before} of the rig says the same: take it out for {key} to be written"));
        }
        if is_shorted && ["resonance", "q"].contains(&self.name) {
            return Some(
                "it is that of shorted terminals, a rig's of open ones: record the current as well".into(),
            );
        }
        let skin = ["skin_mass", "skin_stiffness", "skin_damping"];
        let touched = skin.iter().any(|key| target.value(key).is_some_and(|x| x != 0.0));
        (touched && ["resonance", "q"].contains(&self.name))
            .then(|| "the rig says what the skin adds, and this has it in it already".into())
    }

    /// Whether it goes into the rig.
    pub fn is_kept(&self) -> bool {
        self.is_key && self.left_out.is_none()
    }
}

/// What is not told, with what on the command line would tell it.
pub fn lacking(all: &Identified, asked: &Identify) -> Vec<Lacking> {
    let why = |name: &str, why: &str| {
        if why.contains("not calibrated") {
            return "nothing says what a sample of the acceleration is in m/s2: --acceleration-scale".into();
        }
        match name {
            "eccentric_moment" if asked.mass.is_none() => format!("{why}, and say it: --mass KG"),
            "force_factor" if asked.share.is_none() && why.contains("share") => format!("{why}: --share X"),
            _ => why.to_string(),
        }
    };
    all.untold
        .iter()
        .map(|untold| Lacking { name: untold.name, why: why(untold.name, &untold.why) })
        .collect()
}

/// What stands in the rig and does not go with what is written there, each in a sentence.
pub fn contradictions(figures: &[Figure], asked: &Identify, target: &Target) -> Vec<String> {
    let kept = |key: &str| figures.iter().find(|figure| figure.name == key && figure.is_kept());
    let own = &target.own;
    let has = |key: &&&str| own.iter().any(|own| own == **key);
    let mut said = Vec::new();
    let outer: Vec<&str> = OUTSIDE.into_iter().filter(|key| kept(key).is_some()).collect();
    if own.iter().any(|key| key == "torque_constant")
        && kept("torque_constant").is_none()
        && !outer.is_empty()
    {
        let inner = ["torque_constant", "inertia", "eccentric_moment"];
        let inner: Vec<&str> = inner.iter().chain(&BESIDE).filter(has).copied().collect();
        said.push(format!(
            "{} of the rig say how the motor is made, and go before {}: take them out, or the motor moves by them",
            inner.join(", "),
            outer.join(", ")
        ));
    }
    if let (Some(mass), Some(own)) = (asked.mass, target.own_value("mass"))
        && (mass / own - 1.0).abs() > SAME
    {
        said.push(format!(
            "mass of the rig is {own} kg, and --mass says {mass}: what is found here is of the latter, and how the motor shakes would be of the former"
        ));
    }
    let sheet = target.value("rated_acceleration").zip(target.value("rated_volts"));
    if let (Some((acceleration, volts)), Some(told)) = (sheet, kept("sensitivity"))
        && !(told.interval[0]..=told.interval[1]).contains(&(acceleration / volts))
    {
        said.push(format!(
            "rated_acceleration at rated_volts are {:.4} m/s2/V, and sensitivity is {}: on what it was measured here, test_mass says otherwise",
            acceleration / volts,
            told.value
        ));
    }
    said
}

/// So many digits that what is cut off is a twentieth of what the interval leaves open, at most.
fn rounded(value: f64, interval: [f64; 2]) -> f64 {
    let off = 0.05 * (interval[1] - interval[0]);
    let digits = if off > 0.0 && value != 0.0 {
        (value.abs() / off).log10().ceil().max(0.0) as usize
    } else {
        DIGITS[1]
    };
    format!("{value:.*e}", digits.clamp(DIGITS[0], DIGITS[1]) - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn a_value_has_the_digits_that_are_known() {
        assert_eq!(rounded(0.034_512_345_6, [0.0343, 0.0347]), 0.03451);
        assert_eq!(rounded(123.456_789, [100.0, 150.0]), 123.5);
        assert_eq!(rounded(-1.234_567_891_2e-9, [-1.234_567_9e-9, -1.234_567_8e-9]), -1.2345679e-9);
        assert_eq!((rounded(0.0, [0.0, 0.0]), rounded(5.0, [5.0, 5.0])), (0.0, 5.0));
    }
}
