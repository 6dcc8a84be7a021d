//! The reference for people, from the same descriptions by which files are read and the schema is made.

use super::field::{Field, Form, Table};
use super::nearest::listed;

/// A part of a format, explained.
#[derive(Debug)]
pub struct Topic {
    /// What it is asked for by.
    pub name: &'static str,
    /// How it is written, where that is not plain from its name: `[voice.NAME]`.
    pub written: &'static str,
    /// What it is, in one sentence.
    pub doc: &'static str,
    /// More about it: paragraphs with an empty line between them; a line that begins with `- ` is an item of a list.
    pub text: &'static str,
    /// Its keys, and those of tables within it.
    pub tables: &'static [&'static Table],
    /// A few lines of a file.
    pub example: &'static str,
}

/// What stands where a form is defined elsewhere: the name of the definition, and what it is.
pub type Defined = &'static [(&'static str, &'static str)];

/// What may stand at a key, in words.
pub fn wanted(field: &Field, defined: Defined) -> String {
    let what = match &field.form {
        Form::Text => "text".into(),
        Form::Number { least, most, .. } => format!("number{}", limits(*least, *most)),
        Form::Count { least, most, .. } if *most == u64::MAX => format!("whole number, {least} or more"),
        Form::Count { least, most, .. } => {
            format!("whole number{}", limits(*least as f64, *most as f64))
        }
        Form::Flag(_) => "true or false".into(),
        Form::Word(words) => listed(words).replace(" and ", " or "),
        Form::One(table) => format!("a table: {}", table.name),
        Form::Many(table) => format!("a list of tables: {}", table.name),
        Form::Named(table) => format!("tables by name: {}", table.name),
        Form::Defined(name) => {
            defined.iter().find(|(n, _)| n == name).map_or_else(|| (*name).into(), |(_, what)| (*what).into())
        }
    };
    if field.unit.is_empty() { what } else { format!("{what} ({})", field.unit) }
}

/// What holds where nothing is said: "required", the default, or nothing, where the key's own sentence says it.
pub fn unsaid(field: &Field) -> String {
    if field.required {
        return "required".into();
    }
    match &field.form {
        Form::Number { default: Some(x), .. } => short(*x),
        Form::Count { default: Some(n), .. } => n.to_string(),
        Form::Flag(on) => on.to_string(),
        Form::Word(words) => words.first().map_or(String::new(), |word| format!("`{word}`")),
        _ => String::new(),
    }
}

/// The topic that a word stands for: its name, that of a table in it, or one of its keys.
pub fn find<'a>(topics: impl Iterator<Item = &'a Topic> + Clone, word: &str) -> Option<&'a Topic> {
    let named = topics.clone().find(|t| t.name == word);
    let within = || topics.clone().find(|t| t.tables.iter().any(|table| table.name == word));
    let key = || topics.clone().find(|t| t.tables.iter().any(|table| table.field(word).is_some()));
    named.or_else(within).or_else(key)
}

/// All words that [`find`] knows.
pub fn words<'a>(topics: impl Iterator<Item = &'a Topic>) -> Vec<&'a str> {
    let of = |t: &'a Topic| {
        let tables = t.tables.iter().flat_map(|table| table.keys().chain(std::iter::once(table.name)));
        std::iter::once(t.name).chain(tables)
    };
    topics.flat_map(of).collect()
}

/// A number as short as it can be told.
pub fn short(x: f64) -> String {
    let (plain, scientific) = (x.to_string(), format!("{x:e}"));
    let extreme = x != 0.0 && (x.abs() >= 1e5 || x.abs() < 1e-3);
    if extreme && scientific.len() < plain.len() { scientific } else { plain }
}

/// From here on a limit is there to keep sums finite, and not worth saying.
const LARGE: f64 = 1e6;

fn limits(least: f64, most: f64) -> String {
    match (least > -LARGE, most < LARGE) {
        (true, true) => format!(", {} to {}", short(least), short(most)),
        (true, false) if least == 0.0 => ", not negative".into(),
        (true, false) => format!(", {} or more", short(least)),
        (false, true) => format!(", at most {}", short(most)),
        (false, false) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Defined, find, short, unsaid, wanted, words};
    use crate::text::field::{Form, Table};
    use crate::{patch, rig};

    fn defined(table: &'static Table, known: Defined) {
        for field in table.fields.iter().chain(table.others) {
            if let Form::Defined(name) = field.form {
                assert!(known.iter().any(|(n, _)| *n == name), "{}.{}: {name}", table.name, field.key);
            }
        }
    }

    /// Tables that a table leads to, itself among them.
    fn reached(table: &'static Table, seen: &mut Vec<&'static str>) {
        if seen.contains(&table.name) {
            return;
        }
        seen.push(table.name);
        for field in table.fields {
            if let Form::One(t) | Form::Many(t) | Form::Named(t) = field.form {
                reached(t, seen);
            }
        }
    }

    #[test]
    fn every_table_of_both_formats_is_explained() {
        for (root, topics, known) in [
            (&patch::TABLE, patch::reference::TOPICS, patch::reference::DEFINED),
            (&rig::TABLE, rig::reference::TOPICS, rig::reference::DEFINED),
        ] {
            topics.iter().flat_map(|t| t.tables).for_each(|table| defined(table, known));
            let mut all = Vec::new();
            reached(root, &mut all);
            for name in all {
                assert!(
                    topics.iter().any(|t| t.tables.iter().any(|table| table.name == name)),
                    "no topic has {name}"
                );
            }
        }
    }

    #[test]
    fn every_kind_of_output_and_every_function_is_explained() {
        let text = |topics: &[super::Topic], name: &str| topics.iter().find(|t| t.name == name).unwrap().text;
        for (table, key) in [(&rig::output::TABLE, "kind"), (&rig::actuator::TABLE, "model")] {
            let Some(Form::Word(words)) = table.field(key).map(|f| &f.form) else { panic!("{key}") };
            for word in *words {
                let text = text(rig::reference::TOPICS, table.name);
                assert!(text.contains(&format!("- `{word}`")), "{} {word}", table.name);
            }
        }
        for (name, _) in patch::expr::FUNCTIONS {
            let text = text(patch::reference::TOPICS, "expression");
            assert!(text.contains(&format!("- `{name}(")), "{name}");
        }
        for (name, _) in patch::node::SHAPES {
            assert!(text(patch::reference::TOPICS, "point").contains(&format!("`{name}`")), "{name}");
        }
    }

    #[test]
    fn words_lead_to_their_topic() {
        let topics = || patch::reference::TOPICS.iter().chain(rig::reference::TOPICS);
        for (word, name) in [
            ("event", "event"),
            ("shuffle", "pattern"),
            ("weight", "event"),
            ("tail", "voice"),
            ("polarity", "tactor"),
        ] {
            assert_eq!(find(topics(), word).map(|t| t.name), Some(name), "{word}");
        }
        assert!(find(topics(), "colour").is_none());
        assert!(words(topics()).iter().all(|w| find(topics(), w).is_some()));
    }

    #[test]
    fn forms_are_said_in_words() {
        let said = |table: &Table, key: &str| {
            let field = table.field(key).unwrap();
            (wanted(field, patch::reference::DEFINED), unsaid(field))
        };
        let pair = |a: &str, b: &str| (a.to_string(), b.to_string());
        assert_eq!(said(&patch::pattern::TABLE, "time"), pair("`seconds` or `beats`", "`seconds`"));
        assert_eq!(said(&patch::pattern::TABLE, "shuffle"), pair("true or false", "false"));
        assert_eq!(said(&patch::event::TABLE, "at"), pair("number, not negative (s or beats)", "required"));
        assert_eq!(said(&patch::voice::TABLE, "voices"), pair("whole number, 1 to 4096", "8"));
        assert_eq!(said(&patch::voice::DEFAULTS, "duration").1, "0.1");
        assert_eq!(
            [768_000.0, 1e6, 0.25, 1e-6, 0.0, -4000.0].map(short),
            ["768000", "1e6", "0.25", "1e-6", "0", "-4000"]
        );
    }
}
