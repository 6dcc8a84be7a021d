//! Motors of knobs that ship with pacinian, with the origin of every figure.

use super::table::FIELDS;
use crate::rig::part::{Origin, Source, Value};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// A motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    /// Its name, by which rigs find it.
    pub name: &'static str,
    /// What it is called by people.
    pub title: String,
    /// Its figures, by their keys under `[knob]`.
    pub values: BTreeMap<&'static str, Value>,
    /// Where they were found.
    pub sources: Vec<Source>,
}

/// All of them, in the order of their names.
pub fn all() -> &'static [Motor] {
    static MOTORS: LazyLock<Vec<Motor>> =
        LazyLock::new(|| FILES.iter().filter_map(|(name, text)| read(name, text).ok()).collect());
    &MOTORS
}

/// The motor of a name.
pub fn find(name: &str) -> Option<&'static Motor> {
    all().iter().find(|motor| motor.name == name)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: String,
    values: BTreeMap<String, f64>,
    origin: BTreeMap<String, String>,
    source: Vec<Source>,
}

fn read(name: &'static str, text: &str) -> Result<Motor, String> {
    let file: File = toml::from_str(text).map_err(|e| format!("{name}: {e}"))?;
    let mut values = BTreeMap::new();
    for (key, value) in file.values {
        let field = FIELDS
            .iter()
            .find(|field| field.key == key)
            .ok_or_else(|| format!("{name}: no figure `{key}`"))?;
        let told = file.origin.get(&key).ok_or_else(|| format!("{name}: `{key}` has no origin"))?;
        let (word, from) = told.split_once(": ").unwrap_or((told, ""));
        let origin = Origin::ALL.into_iter().find(|origin| origin.word() == word);
        let origin = origin.ok_or_else(|| format!("{name}: `{key}` has the origin `{word}`"))?;
        values.insert(field.key, Value { value, origin, from: from.into() });
    }
    Ok(Motor { name, title: file.title, values, sources: file.source })
}

const FILES: &[(&str, &str)] = &[
    ("maxon-re25", include_str!("../../../rigs/knobs/maxon-re25.toml")),
    ("pittman-8693", include_str!("../../../rigs/knobs/pittman-8693.toml")),
];

#[cfg(test)]
mod tests {
    use super::{FIELDS, FILES, find, read};
    use crate::text::field::Form;

    #[test]
    fn motors_are_as_their_files_say() {
        for (name, text) in FILES {
            let motor = read(name, text).unwrap_or_else(|why| panic!("{why}"));
            assert_eq!(find(name), Some(&motor));
            for (key, value) in &motor.values {
                match FIELDS.iter().find(|field| field.key == *key).unwrap().form {
                    Form::Number { least, most, .. } => {
                        assert!((least..=most).contains(&value.value), "{name}: {key}")
                    }
                    Form::Count { .. } => assert!(value.value.fract() == 0.0, "{name}: {key}"),
                    _ => panic!("{name}: {key} is no figure"),
                }
                assert!(!value.from.is_empty(), "{name}: {key}");
            }
        }
    }

    /// Torque constants by short-circuit damping and by the stall at full supply (Hayward & MacLean 2007, table 1).
    #[test]
    fn one_row_agrees_with_itself_and_the_other_does_not() {
        let of = |name: &str| {
            let value = |key: &str| find(name).unwrap().values[key].value;
            let by_damping = (value("viscous_shorted") * value("resistance")).sqrt();
            let by_peak = value("peak_torque") * value("resistance") / value("supply");
            assert!((value("torque_constant") / by_damping - 1.0).abs() < 0.005, "{name}");
            by_damping / by_peak
        };
        assert!((of("pittman-8693") - 1.0).abs() < 0.05);
        assert!((of("maxon-re25") - 1.33).abs() < 0.01);
    }
}
