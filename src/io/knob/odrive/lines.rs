//! Bytes into lines.

/// The longest line that is kept. Answers are cut at 64 bytes.
pub(super) const LONGEST: usize = 128;

/// Lines that come piece by piece. One that is too long is dropped up to its end.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    held: Vec<u8>,
    too_long: bool,
}

/// A piece of what came.
#[derive(Debug, PartialEq)]
pub(super) enum Piece {
    /// A line without its end.
    Line(Vec<u8>),
    /// The end of one that was too long.
    TooLong,
}

impl Lines {
    /// Nothing yet.
    pub fn new() -> Self {
        Self { held: Vec::with_capacity(LONGEST), too_long: false }
    }

    /// Takes a byte; the line that it ends. Empty ones are none, as a line may end with two bytes.
    pub fn push(&mut self, byte: u8) -> Option<Piece> {
        if matches!(byte, b'\n' | b'\r') {
            let piece = match (std::mem::take(&mut self.too_long), self.held.is_empty()) {
                (true, _) => Some(Piece::TooLong),
                (false, true) => None,
                (false, false) => Some(Piece::Line(self.held.clone())),
            };
            self.held.clear();
            return piece;
        }
        if self.held.len() == LONGEST {
            self.too_long = true;
        } else {
            self.held.push(byte);
        }
        None
    }

    /// Forgets a line that was begun; whether there was one.
    pub fn forget(&mut self) -> bool {
        let begun = !self.held.is_empty();
        self.held.clear();
        std::mem::take(&mut self.too_long) || begun
    }
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Lines, Piece};

    #[test]
    fn lines_end_where_they_end() {
        let mut lines = Lines::new();
        let long = vec![b'x'; 10 * LONGEST];
        let text = [b"ab\r\n\r\nc\n", &long[..], b"\nd\re"].concat();
        let pieces: Vec<Piece> = text.iter().filter_map(|byte| lines.push(*byte)).collect();
        let line = |text: &str| Piece::Line(text.into());
        assert_eq!(pieces, [line("ab"), line("c"), Piece::TooLong, line("d")]);
        assert!(lines.forget() && !lines.forget());
        assert!(lines.held.capacity() <= 2 * LONGEST);
    }
}
