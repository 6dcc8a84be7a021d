//! Aligned text.

use pacinian::text::problem::is_hidden;
use std::borrow::Cow;

/// Rows of cells, the columns aligned to the left and two blanks apart, each line indented by two.
#[derive(Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Adds a row.
    pub fn row<I: IntoIterator<Item = S>, S: Into<String>>(&mut self, cells: I) {
        self.rows.push(cells.into_iter().map(|cell| plain(cell.into())).collect());
    }

    /// The lines.
    pub fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width =
            |c: usize| self.rows.iter().filter_map(|r| r.get(c)).map(|x| length(x)).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::from("  ");
            for (cell, width) in row.iter().zip(&widths) {
                line += cell;
                line += &" ".repeat(width - length(cell) + 2);
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

/// Characters of a cell that are shown, at most.
const MOST: usize = 300;

/// Whether it is a colour, or how thick or slanted letters are, as those are that stand here and in messages. Others may hide what stands behind them.
fn is_colour(code: &str) -> bool {
    let known = |part: &str| matches!(part.parse(), Ok(0..=4 | 22..=24 | 31..=36 | 39 | 91..=96_u8));
    code.split(';').all(|part| part.bytes().all(|c| c.is_ascii_digit()) && known(part))
}

/// A cell without what would break its line or move the cursor, colours aside, and not too long.
fn plain(cell: String) -> String {
    let cell = match cell.char_indices().nth(MOST) {
        Some((end, _)) => cell.get(..end).unwrap_or_default().to_string() + "...",
        None => cell,
    };
    harmless(&cell, &[]).into_owned()
}

/// Text without what a terminal would act on rather than show, colours aside and these characters.
pub fn harmless<'a>(text: &'a str, but: &[char]) -> Cow<'a, str> {
    let acts = |c: char| is_hidden(c) && !but.contains(&c);
    if !text.contains(acts) {
        return text.into();
    }
    let mut out = String::new();
    let mut rest = text;
    while let Some((at, c)) = rest.char_indices().find(|(_, c)| acts(*c)) {
        let (before, from) = rest.split_at(at);
        out += before;
        let colour = from.strip_prefix("\x1b[").and_then(|code| code.split_once('m')).map(|(code, _)| code);
        let colour = colour.filter(|code| is_colour(code));
        let length = colour.map_or(c.len_utf8(), |code| code.len() + 3);
        let (this, behind) = from.split_at(length);
        out += &if colour.is_some() { this.to_string() } else { c.escape_default().to_string() };
        rest = behind;
    }
    (out + rest).into()
}

/// Characters that take room.
fn length(text: &str) -> usize {
    let (mut count, mut hidden) = (0, false);
    for c in text.chars() {
        match (hidden, c) {
            (false, '\x1b') => hidden = true,
            (true, 'm') => hidden = false,
            (true, _) => {}
            (false, _) => count += 1,
        }
    }
    count
}

/// A whole number with its thousands apart.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A rate in hertz: whole where it is.
pub fn hertz(rate: f64) -> String {
    if rate.fract() == 0.0 && rate >= 0.0 { grouped(rate as u64) + " Hz" } else { format!("{rate:.3} Hz") }
}

/// "1 voice", "2 voices".
pub fn many(n: usize, word: &str) -> String {
    format!("{} {word}{}", grouped(n as u64), if n == 1 { "" } else { "s" })
}

/// Decibels of full scale.
pub fn dbfs(peak: f32) -> String {
    if peak > 0.0 { format!("{:.1} dBFS", 20.0 * f64::from(peak).log10()) } else { "silent".into() }
}

#[cfg(test)]
mod tests {
    use super::{Table, dbfs, grouped, harmless, hertz};
    use crate::cli::paint::Paint;

    #[test]
    fn columns_line_up_whatever_their_colour() {
        let mut table = Table::default();
        table.row(["a", "bb", "c"]);
        table.row(["\x1b[1määä\x1b[0m", "b", "c"]);
        table.row(["x"]);
        assert_eq!(table.text(), "  a    bb  c\n  \x1b[1määä\x1b[0m  b   c\n  x\n");
        let paint = Paint(true);
        for own in [paint.bold("a"), paint.dim("a"), paint.red("a"), paint.yellow("a"), paint.green("a")] {
            assert_eq!(harmless(&own, &[]), own);
        }
        assert_eq!(harmless("\x1b[36;1;4mp.toml:1:1", &[]), "\x1b[36;1;4mp.toml:1:1");
        for hides in ["8", "30", "97", "38;2;0;0;0", "40", "1;8", "", "-1", "+1", "300"] {
            assert_eq!(
                harmless(&format!("a\x1b[{hides}mb\x1b[2J"), &[]),
                format!("a\\u{{1b}}[{hides}mb\\u{{1b}}[2J")
            );
        }
    }

    #[test]
    fn numbers() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([hertz(48_000.0), hertz(7350.5)], ["48,000 Hz", "7350.500 Hz"]);
        assert_eq!([dbfs(1.0), dbfs(0.5), dbfs(0.0)], ["0.0 dBFS", "-6.0 dBFS", "silent"]);
    }
}
