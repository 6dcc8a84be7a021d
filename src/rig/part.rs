//! Real actuators that ship with pacinian, with the origin of every figure.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::actuator::Model;
use super::quantity;
use crate::text::field::Field;

/// A part.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name, by which rigs find it.
    pub name: &'static str,
    /// What it is called by people.
    pub title: String,
    /// What it is.
    pub model: Model,
    /// Its figures, by their keys.
    pub values: BTreeMap<&'static str, Value>,
    /// Where they were found.
    pub sources: Vec<Source>,
}

/// A figure of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// SI units.
    pub value: f64,
    /// How one came to know it.
    pub origin: Origin,
    /// Where from, or how.
    pub from: String,
}

/// How one came to know a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Origin {
    /// Its maker says it.
    DataSheet,
    /// Somebody else measured it and published that.
    Measured,
    /// It follows from others.
    Derived,
    /// Nobody measured it: it is usual for such parts.
    Assumed,
}

impl Origin {
    /// All, the surest first.
    pub const ALL: [Self; 4] = [Self::DataSheet, Self::Measured, Self::Derived, Self::Assumed];

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::DataSheet => "data-sheet",
            Self::Measured => "measured",
            Self::Derived => "derived",
            Self::Assumed => "assumed",
        }
    }
}

/// Where figures of a part were found.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// What it is.
    pub title: String,
    /// Its address; `None`: it has none that one could open.
    pub url: Option<String>,
}

/// All of them, in the order of their names.
pub fn all() -> &'static [Part] {
    static PARTS: LazyLock<Vec<Part>> =
        LazyLock::new(|| FILES.iter().filter_map(|(name, text)| read(name, text).ok()).collect());
    &PARTS
}

/// The part of a name.
pub fn find(name: &str) -> Option<&'static Part> {
    all().iter().find(|part| part.name == name)
}

/// All figures that parts and actuators have, in the order in which one fills them in.
pub fn fields() -> impl Iterator<Item = &'static Field> {
    static FIELDS: [Field; quantity::COUNT] = quantity::FIELDS;
    FIELDS.iter()
}

/// Whether actuators of a model have a figure.
pub fn has(model: Model, key: &str) -> bool {
    let place = quantity::FIELDS.iter().position(|field| field.key == key);
    place.is_some_and(|place| quantity::MODELS[place].is_empty() || quantity::MODELS[place].contains(&model))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    title: String,
    model: String,
    values: BTreeMap<String, f64>,
    origin: BTreeMap<String, String>,
    #[serde(default)]
    source: Vec<Source>,
}

fn read(name: &'static str, text: &str) -> Result<Part, String> {
    let file: File = toml::from_str(text).map_err(|e| format!("{name}: {e}"))?;
    let model = Model::of_word(&file.model).ok_or_else(|| format!("{name}: no model `{}`", file.model))?;
    let mut values = BTreeMap::new();
    for (key, value) in file.values {
        let field = quantity::field(&key).ok_or_else(|| format!("{name}: no figure `{key}`"))?;
        let told = file.origin.get(&key).ok_or_else(|| format!("{name}: `{key}` has no origin"))?;
        let (word, from) = told.split_once(": ").unwrap_or((told, ""));
        let origin = Origin::ALL.into_iter().find(|origin| origin.word() == word);
        let origin = origin.ok_or_else(|| format!("{name}: `{key}` has the origin `{word}`"))?;
        values.insert(field.key, Value { value, origin, from: from.into() });
    }
    Ok(Part { name, title: file.title, model, values, sources: file.source })
}

macro_rules! parts {
    ($($name:literal),* $(,)?) => {
        const FILES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../rigs/parts/", $name, ".toml")))),*];
    };
}

parts! {
    "actronika-hfba121238",
    "coin-10mm",
    "constar-vc2039",
    "dayton-bct-3",
    "eai-c-mf",
    "jinlong-c1030b028f",
    "precision-microdrives-304-002",
    "precision-microdrives-305-000",
    "precision-microdrives-310-103",
    "tdk-powerhap-1313h018v120",
    "tectonic-teax09c005-8",
    "tectonic-teax14c02-8",
    "vybronics-vg0832013d",
    "vybronics-vg0840001d",
    "vybronics-vg1040003d",
    "vybronics-vz7al2b169208t",
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{FILES, Origin, all, find, read};
    use crate::rig::quantity;
    use crate::text::field::Form;

    /// Each can be read, is found by its name, keeps to the limits of its figures, and says where every one of them is from.
    #[test]
    fn parts_are_as_their_files_say() {
        for (name, text) in FILES {
            let part = read(name, text).unwrap_or_else(|why| panic!("{why}"));
            assert_eq!(find(name), Some(&part));
            for (key, value) in &part.values {
                let place = quantity::FIELDS.iter().position(|field| field.key == *key).unwrap();
                let Form::Number { least, most, .. } = quantity::FIELDS[place].form else { unreachable!() };
                assert!((least..=most).contains(&value.value), "{name}: {key} = {}", value.value);
                let of = quantity::MODELS[place];
                assert!(of.is_empty() || of.contains(&part.model), "{name}: {key} of {:?}", part.model);
                assert!(
                    !value.from.is_empty(),
                    "{name}: {key} is said to be {:?}, and not why",
                    value.origin
                );
            }
            let known = part.values.values().any(|value| value.origin <= Origin::Measured);
            assert_eq!(known, !part.sources.is_empty(), "{name}");
        }
        let names: Vec<&str> = all().iter().map(|part| part.name).collect();
        let sorted: BTreeSet<&str> = names.iter().copied().collect();
        assert_eq!(names, sorted.into_iter().collect::<Vec<_>>());
    }

    /// A file of a part that no line of the list names would be there for nobody.
    #[test]
    fn every_file_is_a_part() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("rigs/parts");
        let there: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        assert_eq!(there, FILES.iter().map(|(name, _)| (*name).to_string()).collect());
    }
}
