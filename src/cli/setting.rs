//! A control that the command line sets from the start on.

use super::failure::Failure;
use pacinian::graph::plan::LeftOut;
use pacinian::patch::Patch;
use pacinian::text::{Problem, Problems, Severity, nearest};
use serde::Serialize;
use std::collections::{HashMap, HashSet};
use std::str::FromStr;

/// `CONTROL=VALUE`: in place of the `default` that the patch gives the control.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setting {
    /// The control's name.
    pub control: String,
    /// Where it stands.
    pub value: f64,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let Some((control, value)) = word.split_once('=').filter(|(control, _)| !control.trim().is_empty())
        else {
            return Err("it must be a control and its value, such as strength=0.5".into());
        };
        match value.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Self { control: control.trim().into(), value }),
            _ => Err(format!(
                "`{value}` is no finite number: write it in full and without a unit, such as {}=1000 for 1 kHz",
                control.trim()
            )),
        }
    }
}

/// Sets controls of a patch. The rule is that of the patch's own `default`s: within the range or not at all.
///
/// # Errors
/// Of usage: for a control that the patch does not have, one that is set twice, and a value outside its range.
pub fn set(patch: &mut Patch, settings: &[Setting]) -> Result<(), Failure> {
    let places: HashMap<String, usize> =
        patch.controls.iter().enumerate().rev().map(|(at, control)| (control.name.clone(), at)).collect();
    let mut seen = HashSet::new();
    for Setting { control: name, value } in settings {
        if !seen.insert(name.as_str()) {
            return Err(Failure::usage(
                format!("control `{name}` is set twice"),
                format!("give --set {name}=VALUE once"),
            ));
        }
        let names = || patch.controls.iter().map(|c| c.name.as_str());
        let Some(&at) = places.get(name) else {
            let help = nearest::suggest(name, names())
                .unwrap_or_else(|| "a patch declares them with [control.NAME]".into());
            return Err(Failure::usage(format!("the patch has no control `{name}`"), help));
        };
        let control = &mut patch.controls[at];
        let [least, most] = control.range;
        if !(least..=most).contains(value) {
            let what =
                format!("control `{name}` cannot be set to {value:?}: its range is from {least} to {most}");
            let near = value.clamp(least, most);
            return Err(Failure::usage(what, format!("give a value within it, such as --set {name}={near}")));
        }
        control.default = *value;
    }
    Ok(())
}

/// "strength = 0.5, roughness = 2".
pub fn named(settings: &[Setting]) -> String {
    let named: Vec<String> = settings.iter().map(|s| format!("{} = {}", s.control, s.value)).collect();
    named.join(", ")
}

/// That nothing hears of a control that was set: warnings.
pub fn unheard(patch: &Patch, settings: &[Setting], left_out: &[LeftOut]) -> Option<Problems> {
    let all: HashSet<&str> = left_out.iter().map(|left| left.what.as_str()).collect();
    let named = |name: &str| all.contains(format!("control `{name}`").as_str());
    let list: Vec<Problem> = settings
        .iter()
        .filter(|setting| named(&setting.control))
        .map(|Setting { control, .. }| Problem {
            severity: Severity::Warning,
            ..Problem::of_file(format!("control `{control}` is set, and nothing that plays reads it"))
                .help("see `pacinian check` for what is left out".to_string())
        })
        .collect();
    (!list.is_empty()).then(|| patch.origin.problems(list))
}

#[cfg(test)]
mod tests {
    use super::Setting;

    #[test]
    fn what_is_no_setting_is_told() {
        let of = |word: &str| word.parse::<Setting>();
        assert_eq!(of("a=-1e-3"), Ok(Setting { control: "a".into(), value: -0.001 }));
        for word in ["", "a", "=1", "a=", "a=b", "a=nan", "a=inf", "a=1=2"] {
            assert!(of(word).is_err(), "{word}");
        }
    }
}
