//! Long text in lines of a screen.

use super::line::{Ink, Line};

/// A text in lines of so many columns, cut between words where that is possible, each behind so many blanks.
pub fn folded(text: &str, width: usize, indent: usize, ink: Ink) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let mut line = Line::default();
    let begin = |line: &mut Line| line.fill_to(indent);
    begin(&mut line);
    for word in text.split(' ') {
        let mut word = Line::of(ink, word).text();
        let gap = usize::from(line.width() > indent);
        if line.width() + gap + Line::of(ink, &word).width() > width + indent && line.width() > indent {
            lines.push(std::mem::take(&mut line));
            begin(&mut line);
        } else if gap > 0 {
            line.put(ink, " ");
        }
        // One that no line has room for is cut.
        while line.width() + Line::of(ink, &word).width() > width + indent && width > 1 {
            let mut room = width + indent - line.width();
            let fits = word.char_indices().find(|(_, c)| {
                let wide = Line::of(ink, c.encode_utf8(&mut [0; 4])).width();
                let over = wide > room;
                room = room.saturating_sub(wide);
                over
            });
            let at = fits.map_or(word.len(), |(at, _)| at);
            let rest = word.split_off(at);
            if at == 0 && line.width() == indent {
                break;
            }
            line.put(ink, &word);
            lines.push(std::mem::take(&mut line));
            begin(&mut line);
            word = rest;
        }
        line.put(ink, &word);
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::folded;
    use crate::cli::screen::line::Ink;

    #[test]
    fn text_is_folded_between_words_and_none_of_it_is_lost() {
        let text = "p.toml:9:14: error: node `s` of voice `hum`: there is no node type \"sinus\"";
        for width in [2, 5, 12, 30, 200] {
            let lines = folded(text, width, 3, Ink::Plain);
            assert!(lines.iter().all(|line| line.width() <= width + 3), "{width}");
            let back: String = lines.iter().map(|line| line.text().replace(' ', "")).collect();
            assert_eq!(back, text.replace(' ', ""), "{width}");
        }
        assert_eq!(
            folded("one two three", 8, 0, Ink::Plain).iter().map(|l| l.text()).collect::<Vec<_>>(),
            ["one two", "three"]
        );
        assert!(folded("手手手", 1, 0, Ink::Plain).len() < 5, "it comes to an end");
    }
}
