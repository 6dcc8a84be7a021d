//! A line of the screen: pieces of text, each with its ink.

use std::fmt::Write;

use pacinian::text::problem;
use unicode_width::UnicodeWidthChar;

/// How a piece of text looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ink {
    /// As the terminal has it.
    #[default]
    Plain,
    /// What matters less.
    Dim,
    /// Names and headings.
    Bold,
    /// Keys, and what plays.
    Accent,
    /// All is well.
    Good,
    /// Near the limit.
    Warm,
    /// At the limit.
    Hot,
    /// What must not be overlooked.
    Alarm,
}

impl Ink {
    /// The code of SGR (ECMA-48) that sets it, from whatever was set.
    fn code(self, colours: bool) -> &'static str {
        match (self, colours) {
            (Self::Plain, _) => "0",
            (Self::Dim, _) => "0;2",
            (Self::Bold, _) => "0;1",
            (Self::Accent, true) => "0;1;36",
            (Self::Good, true) => "0;32",
            (Self::Warm, true) => "0;33",
            (Self::Hot, true) => "0;1;31",
            (Self::Alarm, true) => "0;1;97;41",
            (Self::Accent | Self::Hot, false) => "0;1",
            (Self::Good | Self::Warm, false) => "0",
            (Self::Alarm, false) => "0;1;7",
        }
    }
}

/// Marks above and below one character that are shown, at most.
const MARKS: u32 = 3;

/// A line that knows how wide it is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Line {
    pieces: Vec<(Ink, String)>,
    width: usize,
}

impl Line {
    /// With this text.
    pub fn of(ink: Ink, text: &str) -> Self {
        let mut line = Self::default();
        line.put(ink, text);
        line
    }

    /// Columns that it takes.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Adds text. What would move the cursor, turn the direction of writing or cannot be seen, is written as an escape.
    pub fn put(&mut self, ink: Ink, text: &str) {
        let (mut out, mut marks) = (String::new(), 0);
        for c in text.chars() {
            match c.width() {
                Some(0) if !is_hidden(c) => {
                    marks += 1;
                    if marks <= MARKS {
                        out.push(c);
                    }
                }
                Some(width) if !is_hidden(c) => {
                    marks = 0;
                    out.push(c);
                    self.width += width;
                }
                _ => {
                    marks = 0;
                    let escape = c.escape_default();
                    self.width += escape.len();
                    out.extend(escape);
                }
            }
        }
        match self.pieces.last_mut() {
            Some((last, piece)) if *last == ink => *piece += &out,
            _ if out.is_empty() => {}
            _ => self.pieces.push((ink, out)),
        }
    }

    /// Adds another line.
    pub fn join(&mut self, other: Self) {
        for (ink, text) in other.pieces {
            self.put(ink, &text);
        }
    }

    /// Blanks up to a column.
    pub fn fill_to(&mut self, width: usize) {
        self.fill_with(Ink::Plain, ' ', width);
    }

    /// A sign of one column again and again, up to a column.
    pub fn fill_with(&mut self, ink: Ink, sign: char, width: usize) {
        let missing = width.saturating_sub(self.width);
        self.put(ink, &String::from_iter(std::iter::repeat_n(sign, missing)));
    }

    /// No wider than that; where something is cut off, `mark` (one column) says so.
    #[must_use]
    pub fn clip(self, width: usize, mark: &str) -> Self {
        if self.width <= width {
            return self;
        }
        let room = width.saturating_sub(1);
        let mut line = Self::default();
        'all: for (ink, text) in &self.pieces {
            let mut kept = String::new();
            let mut used = line.width;
            for c in text.chars() {
                used += c.width().unwrap_or(0);
                if used > room {
                    line.put(*ink, &kept);
                    break 'all;
                }
                kept.push(c);
            }
            line.put(*ink, &kept);
        }
        if width > 0 {
            line.put(Ink::Dim, mark);
        }
        line
    }

    /// No wider than that, of one ink; where `mark` says that something is cut out, a third of it is the end, in which names differ.
    #[must_use]
    pub fn shorten(self, width: usize, mark: &str) -> Self {
        let Some((ink, text)) = self.pieces.first().filter(|_| self.width > width) else { return self };
        let (mut tail, mut used) = (text.len(), 0);
        for (at, c) in text.char_indices().rev() {
            used += c.width().unwrap_or(0);
            if used > width / 3 {
                break;
            }
            tail = at;
        }
        let (ink, tail) = (*ink, text.get(tail..).unwrap_or_default().to_string());
        let tail = Self::of(ink, &tail);
        let mut line = self.clip(width.saturating_sub(tail.width), mark);
        line.join(tail);
        line
    }

    /// What is read.
    pub fn text(&self) -> String {
        self.pieces.iter().map(|(_, text)| text.as_str()).collect()
    }

    /// The pieces.
    #[cfg(test)]
    pub fn pieces(&self) -> &[(Ink, String)] {
        &self.pieces
    }

    /// For a terminal.
    pub fn ansi(&self, colours: bool) -> String {
        let mut out = String::new();
        for (ink, text) in &self.pieces {
            // A string takes whatever it is given.
            let _ = write!(out, "\x1b[{}m{text}", ink.code(colours));
        }
        out + "\x1b[0m"
    }
}

/// Takes no room and is no mark either, or makes its neighbours take another, as variation selectors do.
fn is_hidden(c: char) -> bool {
    problem::is_hidden(c) || matches!(c, '\u{fe00}'..='\u{fe0f}')
}

/// Puts pieces beside each other, three blanks apart, as many in a line as there is room for.
pub fn flow(pieces: impl IntoIterator<Item = Line>, width: usize) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for piece in pieces {
        match lines.last_mut() {
            Some(line) if line.width() + 3 + piece.width() <= width => {
                line.fill_to(line.width() + 3);
                line.join(piece);
            }
            _ => {
                let mut line = Line::of(Ink::Plain, " ");
                line.join(piece);
                lines.push(line);
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::{Ink, Line};

    #[test]
    fn what_would_move_the_cursor_is_written_out() {
        let line = Line::of(Ink::Plain, "a\x1b[2Jb\n\u{202e}c\u{200d}\u{7f}\u{9b}");
        assert_eq!(line.text(), "a\\u{1b}[2Jb\\n\\u{202e}c\\u{200d}\\u{7f}\\u{9b}");
        assert_eq!(line.width(), line.text().len());
    }

    #[test]
    fn wide_characters_take_two_columns_and_marks_none() {
        assert_eq!(Line::of(Ink::Plain, "手首").width(), 4);
        assert_eq!(Line::of(Ink::Plain, "e\u{301}").width(), 1);
        let pile = "e".to_string() + &"\u{301}".repeat(1000);
        assert_eq!(Line::of(Ink::Plain, &pile).text().chars().count(), 4);
    }

    #[test]
    fn what_is_cut_off_leaves_a_mark() {
        let mut line = Line::of(Ink::Bold, "手首");
        line.put(Ink::Plain, "wrist");
        assert_eq!(line.clone().clip(9, "…").text(), "手首wrist");
        assert_eq!(line.clone().clip(8, "…").text(), "手首wri…");
        // A wide character is not cut in two.
        for (width, text) in [(4, "手…"), (3, "手…"), (2, "…"), (1, "…"), (0, "")] {
            let clipped = line.clone().clip(width, "…");
            assert_eq!(clipped.text(), text);
            assert!(clipped.width() <= width);
        }
    }

    #[test]
    fn ink_does_not_run() {
        let mut line = Line::of(Ink::Alarm, "stop");
        line.put(Ink::Plain, " go");
        assert_eq!(line.ansi(true), "\x1b[0;1;97;41mstop\x1b[0m go\x1b[0m");
        assert!(!line.ansi(false).contains("41"));
    }
}
