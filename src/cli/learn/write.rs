//! Bindings into the text of a patch, which stays as it is otherwise.

use super::source::Source;
use pacinian::Patch;
use pacinian::patch::{Bind, Mover};
use pacinian::text::problem::escaped;
use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value, value};

/// The text of a patch in which these controls are moved by these sources. A control that one binding moves already keeps its
/// range, curve and pick-up; others get a binding of their own.
///
/// # Errors
/// Says why it cannot be done. It is then left to the person.
pub fn with_bindings(source: &str, learnt: &[(String, Source)]) -> Result<String, String> {
    let mut document: DocumentMut =
        source.parse().map_err(|error| format!("it cannot be read again ({error})"))?;
    for (control, source) in learnt {
        let list = document.entry("bind").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        match list {
            Item::ArrayOfTables(tables) => {
                let known = only(tables.iter().map(|table| moves(table, control)));
                match known.and_then(|at| tables.get_mut(at)) {
                    Some(table) => put(table, source),
                    None => {
                        let mut table = Table::new();
                        fill(&mut table, control, source);
                        tables.push(table);
                    }
                }
            }
            Item::Value(Value::Array(tables)) => {
                let is_it =
                    |value: &Value| value.as_inline_table().is_some_and(|table| moves(table, control));
                let known = only(tables.iter().map(is_it));
                match known.and_then(|at| tables.get_mut(at)).and_then(Value::as_inline_table_mut) {
                    Some(table) => put(table, source),
                    None => {
                        let mut table = InlineTable::new();
                        fill(&mut table, control, source);
                        tables.push(table);
                    }
                }
            }
            _ => return Err("its `bind` is written in a way that cannot be changed here".into()),
        }
    }
    let text = document.to_string();
    // What will be read of it is what was meant.
    let patch =
        Patch::parse("", text.as_bytes()).map_err(|problems| format!("it would be broken ({problems})"))?;
    let is_there = |(control, source): &(String, Source)| {
        let from = Mover::parse(&source.from).ok();
        patch.value.binds.iter().any(|bind| {
            bind.control == *control && Some(&bind.from) == from.as_ref() && bind.channel == source.channel
        })
    };
    match learnt.iter().all(is_there) {
        true => Ok(text),
        false => Err("its `bind` is written in a way that cannot be changed here".into()),
    }
}

/// What a binding is moved by, for people.
pub fn moved_by(bind: &Bind) -> String {
    let from = match &bind.from {
        Mover::Controller(number) => format!("midi.controller {number}"),
        Mover::Bend => "midi.bend".into(),
        Mover::Pressure => "midi.pressure".into(),
        Mover::Osc(address) => format!("osc.{}", escaped(address)),
    };
    bind.channel.map_or(from.clone(), |channel| format!("{from} on channel {channel}"))
}

/// What becomes of the bindings that a control has in a patch once `source` moves it, for people.
pub fn replaced(patch: &Patch, control: &str, source: &Source) -> Option<String> {
    let old: Vec<&Bind> = patch.binds.iter().filter(|bind| bind.control == control).collect();
    match old.as_slice() {
        [] => None,
        [one]
            if Mover::parse(&source.from).is_ok_and(|from| from == one.from)
                && one.channel == source.channel =>
        {
            Some("as before".into())
        }
        [one] => Some(format!("instead of {}", moved_by(one))),
        several => {
            let all: Vec<String> = several.iter().map(|bind| moved_by(bind)).collect();
            Some(format!("beside {}", all.join(", ")))
        }
    }
}

/// The place of the only one, if there is only one.
fn only(which: impl Iterator<Item = bool>) -> Option<usize> {
    let mut found = which.enumerate().filter(|(_, is_it)| *is_it);
    found.next().filter(|_| found.next().is_none()).map(|(at, _)| at)
}

fn moves(table: &dyn TableLike, control: &str) -> bool {
    table.get("control").and_then(Item::as_str) == Some(control)
}

/// A new binding.
fn fill(table: &mut dyn TableLike, control: &str, source: &Source) {
    table.insert("from", value(source.from.as_str()));
    table.insert("control", value(control));
    put(table, source);
}

/// Another source for a binding, with the blanks and comments around the old one.
fn put(table: &mut dyn TableLike, source: &Source) {
    let mut set = |key: &str, new: Value| match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            let decor = old.decor().clone();
            *old = new;
            *old.decor_mut() = decor;
        }
        None => drop(table.insert(key, Item::Value(new))),
    };
    set("from", source.from.as_str().into());
    match source.channel {
        Some(channel) => set("channel", i64::from(channel).into()),
        None => drop(table.remove("channel")),
    }
    if source.springs && !table.contains_key("pickup") {
        table.insert("pickup", value(false));
    }
}

#[cfg(test)]
mod tests {
    use super::{Source, with_bindings};
    use pacinian::Patch;

    const PATCH: &str = "#:schema x\nformat = \"pacinian-patch/1\"\ntitle = \"t\"  # of these\n\n[control.a]\ndefault = 0.5\n\
        [control.b]\ndefault = 0.5\n\n# The wheel.\n[[bind]]\nfrom = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n\n\
        # What sounds.\n[voice.v]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 100, amplitude = \"a * b\" }\n# last\n";

    fn midi(from: &str, channel: u8, springs: bool) -> Source {
        Source { from: from.into(), channel: Some(channel), springs, shown: String::new() }
    }

    fn written(source: &str, learnt: &[(&str, Source)]) -> String {
        let learnt: Vec<_> =
            learnt.iter().map(|(control, source)| (control.to_string(), source.clone())).collect();
        with_bindings(source, &learnt).unwrap()
    }

    #[test]
    fn a_binding_that_is_there_hears_another_source_and_keeps_the_rest() {
        let text = written(PATCH, &[("a", midi("midi.controller 21", 3, false))]);
        let line =
            "from = \"midi.controller 21\"   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\nchannel = 3\n";
        assert_eq!(
            text,
            PATCH.replace("from = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n", line)
        );
        let back = written(&text, &[("a", Source::osc("/x", false))]);
        assert_eq!(back, PATCH.replace("'midi.bend'", "\"osc./x\""));
    }

    #[test]
    fn a_new_binding_stands_behind_the_others_or_at_the_end() {
        let text = written(PATCH, &[("b", midi("midi.bend", 1, true))]);
        for line in PATCH.lines() {
            assert!(text.contains(line), "{line} is gone from\n{text}");
        }
        let new = "[[bind]]\nfrom = \"midi.bend\"\ncontrol = \"b\"\nchannel = 1\npickup = false\n";
        assert!(text.contains(new), "{text}");
        let bare = PATCH.replace(
            "# The wheel.\n[[bind]]\nfrom = 'midi.bend'   # up\ncontrol = \"a\"\nrange = [0.1, 0.90]\n\n",
            "",
        );
        let two =
            written(&bare, &[("b", midi("midi.controller 7", 1, false)), ("a", Source::osc("/a", true))]);
        assert!(two.starts_with(bare.trim_end_matches("# last\n")) && two.contains("# last"), "{two}");
        let binds = Patch::parse("", two.as_bytes()).unwrap().value.binds;
        let told: Vec<_> = binds.iter().map(|b| (b.control.as_str(), b.channel, b.pickup)).collect();
        assert_eq!(told, [("b", Some(1), true), ("a", None, false)]);
        let inline = bare.replace(
            "\n[control.a]",
            "bind = [{ from = \"midi.bend\", control = \"a\" }] # here\n[control.a]",
        );
        let text = written(&inline, &[("a", Source::osc("/a", false)), ("b", Source::osc("/b", false))]);
        assert!(text.contains("bind = [{ from = \"osc./a\", control = \"a\" }, { from = \"osc./b\", control = \"b\" }] # here"), "{text}");
    }
}
