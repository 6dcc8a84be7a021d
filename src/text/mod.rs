//! Reading what people write: problems that point at their line, tables whose keys are described once, nearest names.
//!
//! [`crate::patch`] and [`crate::rig`] stand on it. A file is parsed into a tree that keeps its places;
//! typed fields are taken out of a table by its description ([`field::Table`]), from which the JSON Schema is made as well.

pub(crate) mod cells;
pub(crate) mod document;
pub mod field;
pub(crate) mod measure;
pub mod nearest;
pub mod problem;
pub(crate) mod reader;
pub mod reference;
pub(crate) mod schema;
pub(crate) mod sink;

pub use problem::{Checked, Origin, Problem, Problems, Severity, Span};
pub use sink::Sink;

/// A sentence as it goes on behind a colon: "What it is called." becomes "what it is called".
pub(crate) fn lower(sentence: &str) -> String {
    let mut chars = sentence.trim_end_matches('.').chars();
    let first = chars.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
    first + chars.as_str()
}
