//! The keys of a table, described once: the reader checks by it, and the schema is made from it.

/// A kind of table.
#[derive(Debug)]
pub struct Table {
    /// Its name in the schema.
    pub name: &'static str,
    /// What it is, in one sentence.
    pub doc: &'static str,
    /// Its keys.
    pub fields: &'static [Field],
    /// What keys beyond those hold; `None` where there may be none.
    pub others: Option<&'static Field>,
}

/// A key of a table.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// The key.
    pub key: &'static str,
    /// What may stand there.
    pub form: Form,
    /// Whether it must be there.
    pub required: bool,
    /// SI unit, or "".
    pub unit: &'static str,
    /// One sentence.
    pub doc: &'static str,
}

/// What may stand at a key.
#[derive(Debug, Clone, Copy)]
pub enum Form {
    /// A string.
    Text,
    /// A number.
    Number {
        /// Where nothing is said.
        default: Option<f64>,
        /// The least allowed.
        least: f64,
        /// The most allowed.
        most: f64,
    },
    /// A whole number.
    Count {
        /// Where nothing is said.
        default: Option<u64>,
        /// The least allowed.
        least: u64,
        /// The most allowed.
        most: u64,
    },
    /// `true` or `false`, and what holds where nothing is said.
    Flag(bool),
    /// One of these words; the first holds where nothing is said.
    Word(&'static [&'static str]),
    /// A table.
    One(&'static Table),
    /// A list of tables.
    Many(&'static Table),
    /// Tables by name.
    Named(&'static Table),
    /// What has a reader and a definition of its own, by the name of the definition.
    Defined(&'static str),
}

impl Field {
    /// A key that may be absent.
    pub const fn new(key: &'static str, form: Form, unit: &'static str, doc: &'static str) -> Self {
        Self { key, form, required: false, unit, doc }
    }
    /// The same, but it must be there.
    #[must_use]
    pub(crate) const fn required(self) -> Self {
        Self { required: true, ..self }
    }
}

impl Form {
    /// A number with a default.
    pub(crate) const fn number(default: f64, least: f64, most: f64) -> Self {
        Self::Number { default: Some(default), least, most }
    }
    /// A number without one.
    pub(crate) const fn any_number(least: f64, most: f64) -> Self {
        Self::Number { default: None, least, most }
    }
    /// A whole number with a default.
    pub(crate) const fn count(default: u64, least: u64, most: u64) -> Self {
        Self::Count { default: Some(default), least, most }
    }
    /// A whole number without one.
    pub(crate) const fn any_count(least: u64, most: u64) -> Self {
        Self::Count { default: None, least, most }
    }
}

impl Table {
    /// The description of a key.
    pub(crate) fn field(&self, key: &str) -> Option<&'static Field> {
        self.fields.iter().find(|f| f.key == key)
    }
    /// Whether it is a whole file, in which a list of tables is written one by one.
    pub(super) fn is_file(&self) -> bool {
        self.field("format").is_some()
    }
    /// How to add what is missing, and what it is.
    pub(crate) fn to_add(&self, field: &Field) -> String {
        let (key, doc) = (field.key, super::lower(field.doc));
        let value = match field.form {
            Form::One(_) if self.is_file() => return format!("add [{key}]: {doc}"),
            Form::Defined("format") => return format!("add {key} = \"pacinian-{}/1\"", self.name),
            Form::Text => "\"...\"",
            Form::Word(words) => {
                return format!("add {key}, one of {}: {doc}", super::nearest::listed(words));
            }
            Form::One(_) | Form::Named(_) => "{ ... }",
            Form::Many(_) | Form::Defined("events") => "[...]",
            _ => "...",
        };
        format!("add {key} = {value}: {doc}")
    }
    /// A table of this kind such as may have been meant by a bare value: `{ at = 0.05 }`.
    pub(super) fn with(&self, value: &super::reader::At) -> String {
        let first = |wanted: fn(&Form) -> bool| self.fields.iter().find(|f| wanted(&f.form)).map(|f| f.key);
        let number = first(|form| matches!(form, Form::Number { .. }));
        let count = first(|form| matches!(form, Form::Count { .. })).filter(|_| value.count().is_some());
        match (number, count, value.number()) {
            (Some(number), Some(count), Some(_)) => {
                format!("{{ {number} = 0.5, {count} = {} }}", value.shown())
            }
            (Some(number), None, Some(_)) => format!("{{ {number} = {} }}", value.shown()),
            _ => format!("{{ {} = ... }}", self.keys().next().unwrap_or("KEY")),
        }
    }
    /// All keys.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.fields.iter().map(|f| f.key)
    }
}
