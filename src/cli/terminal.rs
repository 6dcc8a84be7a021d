//! Where output goes, and whether it may be coloured.

use super::failure::Failure;
use super::paint::Paint;
use super::table::harmless;
use clap::{ColorChoice, ValueEnum};
use std::ffi::OsString;
use std::io::{ErrorKind, IsTerminal, Write};

/// When to colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum When {
    /// Where it makes sense.
    Auto,
    /// Whatever the output is.
    Always,
    /// Not at all.
    Never,
}

/// What is known of standard output and standard error.
#[derive(Debug, Clone, Copy)]
pub struct Terminal {
    /// Colours of standard output.
    pub out: Paint,
    /// Colours of standard error.
    pub err: Paint,
    /// Whether standard error is a terminal that can move its cursor.
    pub lively: bool,
    /// Whether problems are shown with their source.
    pub pictured: bool,
}

impl Terminal {
    /// From the wish of the command line and the surroundings.
    pub fn new(when: When, plain: bool) -> Self {
        let lookup = |name: &str| std::env::var(name).ok();
        let (out, err) = (std::io::stdout().is_terminal(), std::io::stderr().is_terminal());
        let dumb = lookup("TERM").as_deref() == Some("dumb");
        let forced = coloured(when, false, lookup);
        Self {
            out: Paint(coloured(when, out, lookup)),
            err: Paint(coloured(when, err, lookup)),
            lively: err && !dumb,
            pictured: !plain && ((err && !dumb) || forced),
        }
    }

    /// The same choice for the messages of clap.
    pub fn clap(&self) -> ColorChoice {
        if self.err.0 { ColorChoice::Always } else { ColorChoice::Never }
    }

    /// Writes to standard output; to a terminal, nothing that moves its cursor, whatever names of files and devices hold.
    ///
    /// # Errors
    /// When it cannot be written; quietly when nobody reads it any more.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        // What a program reads is not touched.
        let text = if out.is_terminal() { harmless(text, &['\n', '\t']) } else { text.into() };
        out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| match error.kind() {
            ErrorKind::BrokenPipe => Failure::unread(),
            _ => Failure::said(74, format!("standard output cannot be written ({error})")),
        })
    }

    /// Shows what was typed where the terminal does not, and takes it back: the only text that moves the cursor.
    pub fn echo(&self, text: &str) {
        let mut err = std::io::stderr().lock();
        let text = harmless(text, &['\u{8}']);
        let _ = err.write_all(text.as_bytes()).and_then(|()| err.flush());
    }

    /// Writes to standard error, as far as that is possible; nothing that moves a terminal's cursor.
    pub fn note(&self, text: &str) {
        let (text, mut err) = (harmless(text, &['\n', '\t']), std::io::stderr().lock());
        let _ = err.write_all(text.as_bytes()).and_then(|()| err.flush());
    }
}

/// The word of `--color`, before the command line is understood; what is wrong with it is said later.
pub fn wish(arguments: impl Iterator<Item = OsString>) -> When {
    let words: Vec<String> = arguments.map(|a| a.to_string_lossy().into_owned()).collect();
    let follows = words.windows(2).filter(|w| w[0] == "--color").map(|w| w[1].as_str());
    let word = words.iter().filter_map(|w| w.strip_prefix("--color=")).chain(follows).last();
    word.and_then(|w| When::from_str(w, false).ok()).unwrap_or(When::Auto)
}

/// Shows help, the version, or what is wrong with the command line; gives the exit code.
pub fn usage(error: &clap::Error) -> u8 {
    // A pipe that nobody reads any more is no reason to complain.
    let _ = error.print();
    if error.use_stderr() { 2 } else { 0 }
}

/// The flag comes first, then `NO_COLOR`, then `CLICOLOR_FORCE` and `FORCE_COLOR`, then the terminal.
fn coloured(when: When, terminal: bool, lookup: impl Fn(&str) -> Option<String>) -> bool {
    let says = |name| lookup(name).is_some_and(|value| !value.is_empty() && value != "0");
    match when {
        When::Always => true,
        When::Never => false,
        When::Auto if lookup("NO_COLOR").is_some_and(|value| !value.is_empty()) => false,
        When::Auto if says("CLICOLOR_FORCE") || says("FORCE_COLOR") => true,
        When::Auto => terminal && lookup("TERM").as_deref() != Some("dumb"),
    }
}

#[cfg(test)]
mod tests {
    use super::{When, coloured, wish};

    #[test]
    fn the_flag_then_no_color_then_force_then_the_terminal() {
        let ask = |when, terminal, set: &[(&str, &str)]| {
            coloured(when, terminal, |name| {
                set.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_string())
            })
        };
        let all = [("NO_COLOR", "1"), ("FORCE_COLOR", "1")];
        assert!(ask(When::Always, false, &all));
        assert!(!ask(When::Never, true, &all[1..]));
        assert!(!ask(When::Auto, true, &all));
        assert!(ask(When::Auto, false, &all[1..]));
        assert!(ask(When::Auto, false, &[("NO_COLOR", ""), ("CLICOLOR_FORCE", "1")]));
        assert!(!ask(When::Auto, false, &[("CLICOLOR_FORCE", "0")]));
        assert!(ask(When::Auto, true, &[]));
        assert!(!ask(When::Auto, true, &[("TERM", "dumb")]));
        assert!(!ask(When::Auto, false, &[]));
    }

    #[test]
    fn the_wish_is_found_before_the_command_line_is_read() {
        let of = |words: &[&str]| wish(words.iter().map(Into::into));
        assert_eq!(of(&["pacinian", "check", "--color", "never"]), When::Never);
        assert_eq!(of(&["pacinian", "--color=always", "chekc"]), When::Always);
        assert_eq!(of(&["pacinian", "--color", "purple"]), When::Auto);
        assert_eq!(of(&["pacinian", "--color"]), When::Auto);
    }
}
