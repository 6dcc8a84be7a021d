//! Colours of a terminal.

/// Colours text, if it may.
#[derive(Debug, Clone, Copy)]
pub struct Paint(pub bool);

impl Paint {
    /// Headings and names.
    pub fn bold(self, text: &str) -> String {
        self.with("1", text)
    }
    /// What matters less.
    pub fn dim(self, text: &str) -> String {
        self.with("2", text)
    }
    /// Errors.
    pub fn red(self, text: &str) -> String {
        self.with("1;31", text)
    }
    /// Warnings.
    pub fn yellow(self, text: &str) -> String {
        self.with("33", text)
    }
    /// Success.
    pub fn green(self, text: &str) -> String {
        self.with("32", text)
    }

    fn with(self, code: &str, text: &str) -> String {
        if self.0 { format!("\x1b[{code}m{text}\x1b[0m") } else { text.into() }
    }
}
