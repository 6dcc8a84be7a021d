//! `pacinian schema`.

use super::failure::Failure;
use super::terminal::Terminal;
use clap::{Args, ValueEnum};

/// Prints the JSON Schema of patches or rigs
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pacinian schema patch > patch.json\n\n\
    Editors that know TOML check and complete a patch whose first line is\n  #:schema ./patch.json")]
pub struct Schema {
    /// Of which format
    #[arg(value_enum)]
    format: Format,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// What is felt, and when
    Patch,
    /// Which tactor hangs on which channel
    Rig,
}

impl Schema {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let schema = match self.format {
            Format::Patch => pacinian::patch::schema(),
            Format::Rig => pacinian::rig::schema(),
        };
        terminal.print(&format!("{schema:#}\n"))
    }
}
