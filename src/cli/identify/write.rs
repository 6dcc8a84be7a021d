//! Figures into the text of a rig, which stays as it is otherwise.

use super::figures::Figure;
use pacinian::text::problem::escaped;
use std::str::FromStr;
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// A figure as it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: &'static str,
    /// SI units.
    pub value: f64,
    /// What stands behind it.
    pub comment: String,
}

/// By which a comment of an earlier run is known.
const MARK: &str = "identified from";

impl Entry {
    /// With its interval, and where it is from.
    pub fn of(figure: &Figure, recording: &str) -> Self {
        let [least, most] = figure.interval.map(short);
        let unit = if figure.unit.is_empty() { String::new() } else { format!(" {}", figure.unit) };
        let comment = format!("{MARK} {}: {least} to {most}{unit} (95 %)", escaped(recording));
        Self { key: figure.name, value: figure.value, comment }
    }

    /// As one would write it.
    pub fn line(&self) -> String {
        format!("{} = {}", self.key, short(self.value))
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
    let document = DocumentMut::from_str(&String::from_utf8_lossy(rig)).ok();
    let table =
        document.as_ref().and_then(|document| document.get("actuator")?.get(actuator)?.as_table_like());
    table.map_or(Vec::new(), |table| table.iter().map(|(key, _)| key.to_string()).collect())
}

/// The text of a rig with figures under `[actuator.NAME]`, each with its comment. What somebody wrote behind a figure stays before that; the
/// comment of an earlier run gives way. A table of one line gets figures without comments, as there is no room for any.
///
/// # Errors
/// Says why it cannot be done.
pub fn with_figures(source: &str, actuator: &str, entries: &[Entry]) -> Result<String, String> {
    let mut document =
        DocumentMut::from_str(source).map_err(|error| format!("it cannot be read again ({error})"))?;
    let item = document.get_mut("actuator").and_then(|actuators| actuators.get_mut(actuator));
    let item =
        item.filter(|item| !item.is_none()).ok_or_else(|| format!("it has no [actuator.{actuator}]"))?;
    let is_inline = item.as_inline_table().is_some();
    for entry in entries {
        if is_inline
            && let Some(inline) = item.as_inline_table_mut().filter(|table| !table.contains_key(entry.key))
            && let Some((_, last)) = inline.iter_mut().last()
        {
            // The space before the end of the line belongs to the value that was the last.
            last.decor_mut().set_suffix("");
        }
        let table = item.as_table_like_mut().ok_or("its actuator is no table")?;
        put(table, entry, is_inline)?;
    }
    Ok(document.to_string())
}

fn put(table: &mut dyn TableLike, entry: &Entry, is_inline: bool) -> Result<(), String> {
    let mut value = Value::from_str(&short(entry.value)).map_err(|error| error.to_string())?;
    match table.get_mut(entry.key).map(|item| item.as_value_mut()) {
        Some(Some(old)) => {
            *value.decor_mut() = old.decor().clone();
            if !is_inline {
                let kept = old.decor().suffix().and_then(|suffix| suffix.as_str()).unwrap_or_default();
                let kept =
                    kept.find(MARK).map_or(kept, |at| &kept[..at]).trim_end_matches([' ', '\t', ';', '#']);
                let sign = if kept.trim().is_empty() { "  # " } else { "; " };
                value.decor_mut().set_suffix(format!("{kept}{sign}{}", entry.comment));
            }
            *old = value;
        }
        Some(None) => return Err(format!("its `{}` is no figure", entry.key)),
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

#[cfg(test)]
mod tests {
    use super::{Entry, keys, short, with_figures};

    fn entry(key: &'static str, value: f64, from: &str) -> Entry {
        Entry { key, value, comment: format!("identified from {from}: 1 to 2 (95 %)") }
    }

    const RIG: &str = "#:schema x\nformat = \"pacinian-rig/1\"  # mine\n[device]\nchannels = 1\n\n# The wrist.\n[actuator.coin]\npart = 'coin-10mm' # bought\n  \
        resonance   =  0xC8     # Hz; where it moves most\nq = 3.0\n\n# Others.\n[actuator.other]\nmodel = \"lra\"\n";

    #[test]
    fn figures_come_in_and_everything_else_stays() {
        let text = with_figures(
            RIG,
            "coin",
            &[
                entry("resonance", 201.5, "a.wav"),
                entry("inertia", 1.8e-9, "a.wav"),
                entry("q", 4.0, "a.wav"),
            ],
        )
        .unwrap();
        let due = RIG
            .replace("=  0xC8     # Hz; where it moves most", "=  201.5     # Hz; where it moves most; identified from a.wav: 1 to 2 (95 %)")
            .replace("q = 3.0\n", "q = 4.0  # identified from a.wav: 1 to 2 (95 %)\ninertia = 1.8e-9  # identified from a.wav: 1 to 2 (95 %)\n");
        assert_eq!(text, due);
        // Another run takes the place of the last.
        let again =
            with_figures(&text, "coin", &[entry("resonance", 199.0, "b.wav"), entry("q", 5.0, "b.wav")])
                .unwrap();
        let due = due.replace(
            "201.5     # Hz; where it moves most; identified from a.wav",
            "199.0     # Hz; where it moves most; identified from b.wav",
        );
        assert_eq!(
            again,
            due.replace("q = 4.0  # identified from a.wav", "q = 5.0  # identified from b.wav")
        );
        assert_eq!(keys(text.as_bytes(), "coin"), ["part", "resonance", "q", "inertia"]);
    }

    #[test]
    fn tables_of_one_line_get_figures_alone() {
        let rig = "actuator = { coin = { part = \"x\", q = 3 } } # here\n";
        let text =
            with_figures(rig, "coin", &[entry("q", 4.5, "a"), entry("resonance", 150.0, "a")]).unwrap();
        assert_eq!(text, "actuator = { coin = { part = \"x\", q = 4.5, resonance = 150.0 } } # here\n");
        let dotted = "actuator.coin.q = 3\n";
        assert_eq!(
            with_figures(dotted, "coin", &[entry("q", 4.0, "a")]).unwrap(),
            "actuator.coin.q = 4.0  # identified from a: 1 to 2 (95 %)\n"
        );
    }

    #[test]
    fn what_cannot_be_done_is_said() {
        assert!(with_figures("[", "coin", &[]).unwrap_err().contains("read again"));
        assert!(with_figures(RIG, "none", &[]).unwrap_err().contains("[actuator.none]"));
        assert!(with_figures("actuator.coin = 3\n", "coin", &[entry("q", 1.0, "a")]).is_err());
        assert_eq!([short(1e-9), short(200.0), short(0.0), short(2e7)], ["1e-9", "200.0", "0.0", "2e7"]);
    }
}
