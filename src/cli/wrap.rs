//! Lines for a terminal, broken between words.

use super::screen::tty;
use std::io::IsTerminal;
use unicode_width::UnicodeWidthStr;

/// What stands between things that belong together within.
const APART: &str = "   ";

/// A text for standard error: where that is a terminal, in lines that fit it, all behind so many blanks but the first.
pub fn wrapped(text: &str, indent: usize) -> String {
    let width = tty::size().filter(|_| std::io::stderr().is_terminal());
    width.map_or(text.into(), |(width, _)| broken(text, usize::from(width), indent))
}

/// In lines of so many columns, the first of which begins behind as many blanks as the others have. What three blanks hold apart is not
/// broken itself, as far as that goes.
fn broken(text: &str, width: usize, indent: usize) -> String {
    let room = width.saturating_sub(indent + 1).max(1);
    let mut lines: Vec<String> = Vec::new();
    for (number, part) in text.split(APART).enumerate() {
        let whole = lines.last().map_or(0, |line| line.width()) + APART.len() + part.width() <= room;
        if number > 0 && whole {
            lines.iter_mut().last().into_iter().for_each(|line| *line += &format!("{APART}{part}"));
            continue;
        }
        lines.push(String::new());
        for word in part.split(' ') {
            let line = lines.last().map_or(0, |line| line.width());
            if line > 0 && line + 1 + word.width() > room {
                lines.push(word.into());
            } else if let Some(last) = lines.last_mut() {
                *last += if line > 0 { " " } else { "" };
                *last += word;
            }
        }
    }
    lines.join(&format!("\n{}", " ".repeat(indent)))
}

#[cfg(test)]
mod tests {
    use super::broken;

    #[test]
    fn lines_are_broken_between_words_and_rather_between_things() {
        assert_eq!(broken("one two three", 9, 0), "one two\nthree");
        assert_eq!(broken("one two three", 80, 0), "one two three");
        assert_eq!(
            broken("y: yes   n: it was nothing   q: end", 21, 2),
            "y: yes\n  n: it was nothing\n  q: end"
        );
        let keys = super::super::walk::KEYS;
        for width in [20, 40, 79, 80, 132] {
            let text = broken(keys, width, 5);
            assert!(text.lines().all(|line| line.chars().count() < width), "{width}:\n{text}");
            let words = |text: &str| text.split_whitespace().map(String::from).collect::<Vec<_>>();
            assert_eq!(words(&text), words(keys));
        }
    }
}
