//! Takes typed fields out of a table by its description; what is wrong with them goes to a [`Sink`].

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::field::{Field, Form, Table};
use super::measure;
use super::nearest::nearest;
use super::problem::{Problem, Span};
use super::sink::Sink;

/// A value and where it stands.
#[derive(Debug, Clone, Copy)]
pub struct At<'a> {
    /// The value.
    pub value: &'a DeValue<'a>,
    span: (usize, usize),
}

impl<'a> At<'a> {
    /// From the tree.
    pub fn new(value: &'a Spanned<DeValue<'a>>) -> Self {
        Self { value: value.get_ref(), span: (value.span().start, value.span().end) }
    }
    /// Where it stands.
    pub fn span(&self) -> Span {
        self.span.0..self.span.1
    }
    /// The number, if it is one, finite or not.
    pub fn number(&self) -> Option<f64> {
        match self.value {
            DeValue::Integer(i) => {
                let digits = i.as_str();
                match i128::from_str_radix(digits, i.radix()) {
                    Ok(n) => Some(n as f64),
                    Err(_) if i.radix() == 10 => digits.parse().ok(),
                    Err(_) => Some(f64::INFINITY),
                }
            }
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => None,
        }
    }
    /// The whole number, if it is one that is not negative.
    pub fn count(&self) -> Option<u64> {
        match self.value {
            DeValue::Integer(i) => u64::from_str_radix(i.as_str(), i.radix()).ok(),
            _ => None,
        }
    }
    /// The string, if it is one.
    pub fn text(&self) -> Option<&'a str> {
        self.value.as_str()
    }
    /// The table, if it is one.
    pub fn table(&self) -> Option<&'a DeTable<'a>> {
        self.value.as_table()
    }
    /// What stands in the list, if it is one.
    pub fn list(&self) -> Option<impl ExactSizeIterator<Item = At<'a>> + use<'a>> {
        self.value.as_array().map(|a| a.iter().map(At::new))
    }
    /// For people.
    pub fn shown(&self) -> String {
        match self.value {
            DeValue::String(s) if s.chars().count() > 40 => {
                format!("\"{}...\"", s.chars().take(40).collect::<String>())
            }
            DeValue::String(s) => format!("\"{s}\""),
            DeValue::Integer(i) => i.to_string(),
            DeValue::Float(f) => f.to_string(),
            DeValue::Boolean(b) => b.to_string(),
            DeValue::Datetime(_) => "a date".into(),
            DeValue::Array(list)
                if (1..=4).contains(&list.len()) && list.iter().all(|v| At::new(v).number().is_some()) =>
            {
                let numbers: Vec<String> = list.iter().map(|v| At::new(v).shown()).collect();
                format!("[{}]", numbers.join(", "))
            }
            DeValue::Array(_) => "a list".into(),
            DeValue::Table(_) => "a table".into(),
        }
    }
}

/// The entries of a table in the order of the file.
pub fn in_order<'a>(table: &'a DeTable<'a>) -> Vec<(&'a str, Span, At<'a>)> {
    let mut entries: Vec<(&Spanned<DeString>, At)> = table.iter().map(|(k, v)| (k, At::new(v))).collect();
    entries.sort_by_key(|(k, _)| k.span().start);
    entries.into_iter().map(|(k, v)| (k.get_ref().as_ref(), k.span(), v)).collect()
}

/// Reads one table.
#[derive(Debug)]
pub struct Reader<'a> {
    table: &'static Table,
    entries: &'a DeTable<'a>,
    /// Where to point when something is missing.
    pub span: Span,
    /// What the table is, for people: "voice `beat`".
    pub who: String,
    /// Where problems go.
    pub sink: &'a Sink,
}

impl<'a> Reader<'a> {
    /// Of a table; reports keys that it may not have and keys that it lacks.
    pub fn new(
        table: &'static Table,
        entries: &'a DeTable<'a>,
        span: Span,
        who: impl Into<String>,
        sink: &'a Sink,
    ) -> Self {
        let reader = Self { table, entries, span, who: who.into(), sink };
        // A key that is there under a slip of its name is told once, at the slip.
        let mut slips = Vec::new();
        for (key, value) in entries {
            if table.others.is_none() && table.field(key.get_ref()).is_none() {
                let word = key.get_ref();
                let span = key.span();
                let span = if span.is_empty() { value.span() } else { span };
                sink.unknown(&span, format!("{} has no key `{word}`", reader.who), word, table.keys());
                slips.extend(nearest(word, table.keys()).filter(|_| !sink.is_full()));
            }
        }
        let lacks = |f: &&Field| f.required && !entries.contains_key(f.key) && !slips.contains(&f.key);
        for field in table.fields.iter().filter(lacks) {
            let what = format!("{} lacks `{}`", reader.who, field.key);
            sink.push(Problem::error(&reader.span, what).help(table.to_add(field)));
        }
        reader
    }

    /// What stands at a key.
    pub fn at(&self, key: &str) -> Option<At<'a>> {
        debug_assert!(self.table.field(key).is_some(), "{} describes no {key}", self.table.name);
        self.entries.get(key).map(At::new)
    }
    /// Whether the table may have the key.
    pub fn describes(&self, key: &str) -> bool {
        self.table.field(key).is_some()
    }
    /// Whether the key is there.
    pub fn has(&self, key: &str) -> bool {
        self.at(key).is_some()
    }
    /// Entries beyond the described ones, in the order of the file.
    pub fn others(&self) -> Vec<(&'a str, Span, At<'a>)> {
        let mut entries = in_order(self.entries);
        entries.retain(|(key, ..)| self.table.field(key).is_none());
        entries
    }
    /// Where a key's value stands; the table, where it is absent.
    pub fn span_of(&self, key: &str) -> Span {
        self.at(key).map_or_else(|| self.span.clone(), |v| v.span())
    }
    /// That a key holds something else than it should.
    pub fn mistaken(&self, key: &str, value: &At, wanted: &str) {
        self.wrong(key, value, &format!("it must be {wanted}"));
    }
    /// What is wrong with what a key holds, in a sentence of its own.
    pub fn wrong(&self, key: &str, value: &At, why: &str) {
        self.sink.push(self.problem(key, value, why));
    }
    fn problem(&self, key: &str, value: &At, why: &str) -> Problem {
        Problem::error(&value.span(), format!("`{key}` of {} is {}; {why}", self.who, value.shown()))
    }
    /// The same as [`Reader::mistaken`] with advice.
    fn mistaken_help(&self, key: &str, value: &At, wanted: &str, help: Option<String>) {
        self.sink.push(self.problem(key, value, &format!("it must be {wanted}")).help(help));
    }

    /// The number at a key or its default; `None` where there is neither or it is wrong.
    pub fn number(&self, key: &str) -> Option<f64> {
        let Some(Field { form: Form::Number { default, least, most }, .. }) = self.table.field(key) else {
            debug_assert!(false, "{key} is no number");
            return None;
        };
        match self.at(key) {
            Some(value) => self.number_in(key, &value, *least, *most),
            None => *default,
        }
    }
    /// The number at a key or its default; where it is wrong, which has been reported, something to go on with.
    pub fn number_or_default(&self, key: &str) -> f64 {
        self.number(key).unwrap_or(match self.table.field(key).map(|f| &f.form) {
            Some(Form::Number { default: Some(default), .. }) => *default,
            Some(Form::Number { least, most, .. }) => 1f64.clamp(*least, *most),
            _ => 1.0,
        })
    }
    /// A number within a range.
    pub fn number_in(&self, key: &str, value: &At, least: f64, most: f64) -> Option<f64> {
        match value.number() {
            Some(x) if x.is_finite() && x >= least && x <= most => Some(x),
            Some(_) => {
                self.mistaken(key, value, &range(least, most));
                None
            }
            None => {
                let help = value.text().and_then(|text| measure::advice(key, text));
                let unit = self.table.field(key).map_or("", |f| f.unit);
                let wanted = if unit.is_empty() { "a number".into() } else { format!("a number in {unit}") };
                self.mistaken_help(key, value, &wanted, help);
                None
            }
        }
    }
    /// The whole number at a key or its default; `None` where there is neither or it is wrong.
    pub fn count(&self, key: &str) -> Option<u64> {
        let Some(Field { form: Form::Count { default, least, most }, .. }) = self.table.field(key) else {
            debug_assert!(false, "{key} is no count");
            return None;
        };
        let Some(value) = self.at(key) else { return *default };
        match value.count() {
            Some(n) if n >= *least && n <= *most => Some(n),
            _ => {
                let wanted = if *most == u64::MAX {
                    format!("a whole number from {least} up")
                } else {
                    format!("a whole number from {least} to {most}")
                };
                self.mistaken(key, &value, &wanted);
                None
            }
        }
    }
    /// The flag at a key or its default.
    pub fn flag(&self, key: &str) -> bool {
        let default = matches!(self.table.field(key).map(|f| &f.form), Some(Form::Flag(true)));
        match self.at(key) {
            Some(value) => value.value.as_bool().unwrap_or_else(|| {
                self.mistaken(key, &value, "true or false");
                default
            }),
            None => default,
        }
    }
    /// The string at a key.
    pub fn text(&self, key: &str) -> Option<&'a str> {
        let value = self.at(key)?;
        if value.text().is_none() {
            self.mistaken(key, &value, "a string");
        }
        value.text()
    }
    /// The place of the word at a key in its list; 0 where nothing is said.
    pub fn word(&self, key: &str) -> usize {
        let Some(Field { form: Form::Word(words), .. }) = self.table.field(key) else {
            debug_assert!(false, "{key} is no word");
            return 0;
        };
        self.at(key).and_then(|value| self.word_of(key, &value, words)).unwrap_or(0)
    }
    /// The place of a word in a list.
    pub fn word_of(&self, key: &str, value: &At, words: &[&str]) -> Option<usize> {
        let Some(text) = value.text() else {
            self.mistaken(key, value, &format!("a word: {}", super::nearest::listed(words)));
            return None;
        };
        let place = words.iter().position(|w| *w == text);
        if place.is_none() {
            let what = format!("`{key}` of {} cannot be \"{text}\"", self.who);
            self.sink.unknown(&value.span(), what, text, words.iter().copied());
        }
        place
    }
    /// The table at a key.
    pub fn table(&self, key: &str) -> Option<(&'a DeTable<'a>, Span)> {
        let value = self.at(key)?;
        let table = value.table();
        if table.is_none() {
            let help = match self.table.field(key).map(|f| &f.form) {
                Some(Form::One(inner)) => Some(format!("write {key} = {}", inner.with(&value))),
                Some(Form::Named(_)) => Some(format!("each has a name: [{key}.NAME]")),
                _ => None,
            };
            self.mistaken_help(key, &value, "a table", help);
        }
        table.map(|t| (t, value.span()))
    }
    /// A reader for the table at a key.
    pub fn one(&self, key: &str, who: impl Into<String>) -> Option<Reader<'a>> {
        let Some(Field { form: Form::One(table), .. }) = self.table.field(key) else {
            debug_assert!(false, "{key} is no table");
            return None;
        };
        let (entries, span) = self.table(key)?;
        Some(Reader::new(table, entries, span, who, self.sink))
    }
    /// What stands in the list at a key.
    pub fn list(&self, key: &str) -> Vec<At<'a>> {
        let Some(value) = self.at(key) else { return Vec::new() };
        match value.list() {
            Some(list) => list.collect(),
            None => {
                let many = matches!(self.table.field(key).map(|f| &f.form), Some(Form::Many(_)));
                let help = match (many, self.table.is_file()) {
                    (true, true) => Some(format!("write [[{key}]] before each")),
                    (true, false) => Some(format!("write {key} = [{{ ... }}, ...]")),
                    (false, _) => None,
                };
                self.mistaken_help(key, &value, "a list", help);
                Vec::new()
            }
        }
    }
    /// A reader for each table of the list at a key; `who` gets its number, from 1.
    pub fn many(&self, key: &str, who: impl Fn(usize) -> String) -> Vec<Reader<'a>> {
        let Some(Field { form: Form::Many(table), .. }) = self.table.field(key) else {
            debug_assert!(false, "{key} is no list of tables");
            return Vec::new();
        };
        let mut readers = Vec::new();
        for (i, value) in self.list(key).into_iter().enumerate() {
            match value.table() {
                Some(entries) => {
                    readers.push(Reader::new(table, entries, value.span(), who(i + 1), self.sink))
                }
                None => self.mistaken(key, &value, "a list of tables"),
            }
        }
        readers
    }
    /// A reader for each of the tables by name at a key, in the order of the file; names that are none are reported.
    pub fn named(&self, key: &str, word: &str) -> Vec<(String, Reader<'a>)> {
        let Some(Field { form: Form::Named(table), .. }) = self.table.field(key) else {
            debug_assert!(false, "{key} holds no tables by name");
            return Vec::new();
        };
        let mut readers = Vec::new();
        let entries = self.table(key).map(|(t, _)| in_order(t)).unwrap_or_default();
        // Keys where names should be: the name was forgotten, and nothing else that stands there says more.
        let is_key =
            |(name, _, value): &&(&str, Span, At)| value.table().is_none() && table.field(name).is_some();
        if let Some((_, span, _)) = entries.iter().find(is_key) {
            self.sink.error_help(
                span,
                format!("[{key}] lacks a name"),
                &format!("a {word} has a name: [{key}.NAME]"),
            );
            return readers;
        }
        for (name, span, value) in entries {
            let who = format!("{word} `{name}`");
            self.check_name(name, &span, &who);
            match value.table() {
                Some(entries) => {
                    let span = if value.span().is_empty() { span } else { value.span() };
                    readers.push((name.to_string(), Reader::new(table, entries, span, who, self.sink)));
                }
                None => self.mistaken(name, &value, "a table"),
            }
        }
        readers
    }
    /// That a name is one: a letter, then letters, digits, `_` and `-`.
    pub fn check_name(&self, name: &str, span: &Span, who: &str) {
        let mut chars = name.chars();
        let first = chars.next().is_some_and(|c| c.is_ascii_alphabetic());
        if !first || !chars.all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') || name.len() > 64 {
            self.sink.error_help(
                span,
                format!("the name of {who} cannot be used"),
                "a name is a letter, then letters, digits, `_` and `-`, 64 at most",
            );
        }
    }
}

/// "a number from 0 to 1", "a number from 0 up".
pub fn range(least: f64, most: f64) -> String {
    match (least > -LARGE, most < LARGE) {
        (true, true) => format!("a number from {least} to {most}"),
        (true, false) => format!("a number from {least} up"),
        (false, true) => format!("a number up to {most}"),
        (false, false) => "a finite number".into(),
    }
}

/// Limits from here on are not worth saying.
const LARGE: f64 = 1e12;
