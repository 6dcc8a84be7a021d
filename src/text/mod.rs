//! Reading what people write: problems that point at their line, tables whose keys are described once, nearest names.
//!
//! [`crate::patch`] and [`crate::rig`] stand on it. A file is parsed into a tree that keeps its places
//! ([`document::parse`]); a [`reader::Reader`] takes typed fields out of a table by its description
//! ([`field::Table`]), from which [`schema`] makes the JSON Schema as well.

pub mod document;
pub mod field;
pub mod nearest;
pub mod problem;
pub mod reader;
pub mod schema;

pub use problem::{Checked, Origin, Problem, Problems, Severity, Span};
