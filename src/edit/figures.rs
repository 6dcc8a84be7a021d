//! What is known of an actuator into the text of a rig.

use std::ops::Range;
use std::str::FromStr;

use serde::Serialize;
use toml_edit::{Item, TableLike, Value};

use super::text::Text;
use super::value::table;
use super::{EditError, broken};
use crate::rig::{Actuator, Rig};
use crate::text::problem::escaped;

/// What is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: &'static str,
    /// What it is.
    pub value: Given,
    /// What stands behind it.
    pub comment: String,
}

/// What a key is given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Given {
    /// A figure, SI units.
    Number(f64),
    /// A word.
    Word(&'static str),
}

/// What a comment of `pacinian identify` begins with, and ends with: between them are the recording and the interval, and only what has all of that in
/// its place gives way to that of another run.
const MARK: &str = "pacinian identify ";
const END: &str = " (95 %)";

impl Entry {
    /// A figure with its interval of 95 %, in `unit` of SI, and the recording that it is from.
    pub fn measured(key: &'static str, value: f64, interval: [f64; 2], unit: &str, recording: &str) -> Self {
        let [least, most] = interval.map(short);
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let comment = format!("{MARK}{}: {least} to {most}{unit}{END}", escaped(recording));
        Self { key, value: Given::Number(value), comment }
    }

    /// What was said to `pacinian identify`.
    pub fn given(key: &'static str, value: Given) -> Self {
        Self { key, value, comment: "given to pacinian identify".into() }
    }

    /// As one would write it.
    pub fn line(&self) -> String {
        format!("{} = {}", self.key, self.text())
    }

    /// The value as TOML has it.
    fn text(&self) -> String {
        match self.value {
            Given::Number(value) => short(value),
            Given::Word(word) => format!("\"{word}\""),
        }
    }

    /// Whether an actuator has it so.
    fn is_in(&self, actuator: &Actuator) -> bool {
        match self.value {
            Given::Number(value) => actuator.value(self.key) == Some(value),
            Given::Word(word) => self.key == "model" && actuator.model.word() == word,
        }
    }
}

/// A number as short as it is exact, as TOML has it.
fn short(value: f64) -> String {
    let text = if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{value:?}")
    };
    if text.contains(['.', 'e']) { text } else { text + ".0" }
}

/// The keys that an actuator of a rig has itself.
pub fn keys(rig: &[u8], actuator: &str) -> Vec<String> {
    let document = Text::of(&String::from_utf8_lossy(rig)).document().ok();
    let table =
        document.as_ref().and_then(|document| document.get("actuator")?.get(actuator)?.as_table_like());
    table.map_or(Vec::new(), |table| table.iter().map(|(key, _)| key.to_string()).collect())
}

/// The text of a rig with entries under `[actuator.NAME]`, each with its comment. What somebody wrote behind a figure stays before that; the
/// comment of an earlier run gives way. A table of one line gets figures without comments, as there is no room for any. Lines end as they
/// did, new ones as the line before.
///
/// # Errors
/// A text without that actuator, one whose value is none that could be changed, and one that is no rig then, not even a draft ([`Rig::draft`]).
pub fn figures(source: &str, actuator: &str, entries: &[Entry]) -> Result<String, EditError> {
    let text = changed(source, actuator, entries)?;
    // What will be read of it is what was meant.
    let read = Rig::draft("", text.as_bytes()).map_err(broken)?.value;
    let read = read.actuator(actuator);
    match read.is_some_and(|read| entries.iter().all(|entry| entry.is_in(read))) {
        true => Ok(text),
        false => Err(EditError::Form("actuator".into())),
    }
}

/// The same, whatever will be read of it.
fn changed(source: &str, actuator: &str, entries: &[Entry]) -> Result<String, EditError> {
    let mut text = Text::of(source);
    for entry in entries {
        text.change(|document| {
            let item = document.get_mut("actuator").and_then(|actuators| actuators.get_mut(actuator));
            let item = item
                .filter(|item| !item.is_none())
                .ok_or_else(|| EditError::Missing(format!("[actuator.{actuator}]")))?;
            let is_inline = item.as_inline_table().is_some();
            table(item, "actuator", |table| put(table, entry, is_inline))
        })?;
    }
    Ok(text.finish())
}

fn put(table: &mut dyn TableLike, entry: &Entry, is_inline: bool) -> Result<(), EditError> {
    let mut value =
        Value::from_str(&entry.text()).map_err(|_| EditError::Form(format!("`{}`", entry.key)))?;
    match table.get_mut(entry.key).map(|item| item.as_value_mut()) {
        Some(Some(old)) => {
            *value.decor_mut() = old.decor().clone();
            if !is_inline {
                let behind = old.decor().suffix().and_then(|suffix| suffix.as_str()).unwrap_or_default();
                value.decor_mut().set_suffix(said(behind, &entry.comment));
            }
            *old = value;
        }
        Some(None) => return Err(EditError::Form(format!("`{}`", entry.key))),
        None => {
            if !is_inline {
                value.decor_mut().set_prefix(" ");
                value.decor_mut().set_suffix(format!("  # {}", entry.comment));
            }
            table.insert(entry.key, Item::Value(value));
        }
    }
    Ok(())
}

/// What stands behind a value, with a comment: in place of that of an earlier run, else behind all that is there.
fn said(behind: &str, comment: &str) -> String {
    if let Some(own) = own(behind) {
        return format!("{}{comment}{}", &behind[..own.start], &behind[own.end..]);
    }
    let kept = behind.trim_end();
    match kept.trim_start() {
        "" => format!("  # {comment}"),
        "#" => format!("{kept} {comment}"),
        _ => format!("{kept}; {comment}"),
    }
}

/// Where in a comment one of `pacinian identify` is: MARK, recording, a colon, one number to another, a unit or none, END.
fn own(text: &str) -> Option<Range<usize>> {
    text.rmatch_indices(MARK).find_map(|(at, _)| {
        let rest = &text[at + MARK.len()..];
        let (_, interval) = rest[..rest.find(END)?].rsplit_once(": ")?;
        let (least, most) = interval.split_once(" to ")?;
        let is_number = |word: &str| word.parse::<f64>().is_ok();
        let whole = is_number(least) && is_number(most.split(' ').next()?);
        let begins = text[..at].ends_with("# ") || text[..at].ends_with("; ");
        (whole && begins).then(|| at..at + MARK.len() + rest.find(END).unwrap_or(0) + END.len())
    })
}

#[cfg(test)]
mod tests;
