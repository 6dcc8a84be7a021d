//! Tactors that go by one name.

use super::{Output, OutputKind, Rig};
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::sink::Sink;
use crate::text::{Problem, Span};
use std::collections::{HashMap, HashSet};

/// A group, `[group.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// The names of its tactors, or of other outputs that sound.
    pub tactors: Vec<String>,
    /// Where it stands.
    pub span: Span,
}

/// Its keys.
pub(crate) static TABLE: Table = Table {
    name: "group",
    doc: "Tactors that go by one name: what is played there sounds on all of them, on each with its whole level.",
    fields: &[Field::new("tactors", Form::Defined("names"), "", "Their names.").required()],
    others: None,
};

pub(crate) fn read(name: &str, reader: &Reader) -> Group {
    let mut tactors = Vec::new();
    for value in reader.list("tactors") {
        match value.text() {
            Some(tactor) => tactors.push(tactor.into()),
            None => reader.wrong("tactors", &value, "it must be a list of names of tactors"),
        }
    }
    if tactors.is_empty() && reader.has("tactors") {
        let what = format!("{} has no tactor", reader.who);
        let help = "name them, tactors = [\"a\", \"b\"], or leave the group out".to_string();
        reader.sink.push(Problem::error(&reader.span, what).help(help));
    }
    Group { name: name.into(), tactors, span: reader.span.clone() }
}

impl Rig {
    /// What is wrong with groups: names that nothing has, that stand twice, or that a tactor has too.
    pub(super) fn check_groups(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        let outputs: HashMap<&str, &Output> = self.outputs.iter().map(|o| (o.name.as_str(), o)).collect();
        for group in &self.groups {
            if problems.len() >= Sink::MOST {
                break;
            }
            let error = |what: String| Problem::error(&group.span, what);
            if outputs.contains_key(group.name.as_str()) {
                let what = format!("group `{0}` has the name of the output `{0}`", group.name);
                problems.push(error(what).help("give the group another".to_string()));
            }
            let mut seen = HashSet::new();
            for name in &group.tactors {
                if !seen.insert(name) {
                    problems.push(
                        error(format!("group `{}` has `{name}` twice", group.name))
                            .help("name it once".to_string()),
                    );
                    break;
                }
                let problem = match outputs.get(name.as_str()) {
                    Some(output) if matches!(output.kind, OutputKind::Trigger { .. }) => error(format!(
                        "group `{}` has `{name}`, which is a trigger: it plays nothing",
                        group.name
                    ))
                    .help("leave it out".to_string()),
                    Some(_) => continue,
                    None => error(format!(
                        "group `{}` has `{name}`, and there is no tactor of that name",
                        group.name
                    ))
                    .help(suggest(name, outputs.keys().copied())),
                };
                problems.push(problem);
                break;
            }
        }
        problems
    }
}
