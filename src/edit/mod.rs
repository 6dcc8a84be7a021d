//! Changes the text of patches and rigs, and leaves all else there as it is: comments, blanks, the order of the lines and what ends them.
//!
//! Each function takes a text and gives another, which was read again to see that it says what was meant; nothing here opens a file.
#![cfg_attr(
    feature = "io",
    doc = "[`crate::io::replace`] puts it in place of the old one, unless somebody has changed that meanwhile."
)]
//!
//! ```
//! use pacinian::edit;
//!
//! let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2   # white and green\n";
//! let after = edit::loop_latency(rig, 0.0031)?;
//! assert_eq!(after, format!("{rig}loop_latency = 0.0031\n"));
//! # Ok::<(), edit::EditError>(())
//! ```

mod bindings;
mod channels;
mod figures;
mod loop_latency;
mod text;
mod value;

pub use bindings::bindings;
pub use channels::channels;
pub use figures::{Entry, Given, figures, keys};
pub use loop_latency::loop_latency;

use crate::text::Problems;
use toml_edit::DocumentMut;

/// Why a text is left as it is.
#[derive(Debug, Clone, PartialEq)]
pub enum EditError {
    /// It is no TOML; what is wrong.
    Unreadable(String),
    /// Changed, it would be no patch or rig.
    Broken(Box<Problems>),
    /// What is to be changed is not there; what that is.
    Missing(String),
    /// It is there, and written in a way that cannot be changed here; what that is.
    Form(String),
}

impl std::fmt::Display for EditError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unreadable(why) => write!(f, "it cannot be read again ({why})"),
            Self::Broken(problems) => write!(f, "it would be broken ({problems})"),
            Self::Missing(what) => write!(f, "it has no {what}"),
            Self::Form(what) => write!(f, "its {what} is written in a way that cannot be changed here"),
        }
    }
}

impl std::error::Error for EditError {}

fn parse(source: &str) -> Result<DocumentMut, EditError> {
    source.parse().map_err(|error: toml_edit::TomlError| EditError::Unreadable(error.to_string()))
}

fn broken(problems: Problems) -> EditError {
    EditError::Broken(Box::new(problems))
}
