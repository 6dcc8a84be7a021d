//! A text under change. Neither reader nor writer of TOML keeps what ends a line, or what stands before all: here that is kept.

use toml_edit::DocumentMut;

use super::{EditError, parse};

/// What stands before a text in Unicode, if somebody's editor puts it there.
const BOM: char = '\u{feff}';

/// Its lines, and what ends each.
#[derive(Debug)]
pub(super) struct Text {
    marked: bool,
    bare: String,
    ends: Vec<&'static str>,
}

impl Text {
    pub fn of(source: &str) -> Self {
        let bare = source.strip_prefix(BOM).unwrap_or(source);
        let end = |line: &str| match line {
            _ if line.ends_with("\r\n") => "\r\n",
            _ if line.ends_with('\n') => "\n",
            _ => "",
        };
        Self {
            marked: bare.len() < source.len(),
            bare: bare.replace("\r\n", "\n"),
            ends: bare.split_inclusive('\n').map(end).collect(),
        }
    }

    /// What it says.
    pub fn document(&self) -> Result<DocumentMut, EditError> {
        parse(&self.bare)
    }

    /// One change, in lines that lie together; those that lie apart are changed one after the other.
    ///
    /// # Errors
    /// A text that is no TOML, and why it cannot be changed.
    pub fn change(
        &mut self,
        change: impl FnOnce(&mut DocumentMut) -> Result<(), EditError>,
    ) -> Result<(), EditError> {
        let mut document = self.document()?;
        change(&mut document)?;
        let after = document.to_string();
        let [before, now] = [&self.bare, &after].map(|text| lines(text).collect::<Vec<_>>());
        let most = before.len().min(now.len());
        let first = before.iter().zip(&now).take_while(|(a, b)| a == b).count();
        let same = before.iter().rev().zip(now.iter().rev()).take_while(|(a, b)| a == b).count();
        let behind = same.min(most - first);
        let usual = if self.ends.contains(&"\r\n") { "\r\n" } else { "\n" };
        // Lines that take the place of others end as those did, further ones as the line before.
        let mut ends = self.ends[..first].to_vec();
        for n in first..now.len() - behind {
            let old = self.ends[..before.len() - behind].get(n).copied();
            ends.push(old.or(ends.last().copied()).unwrap_or(usual));
        }
        ends.extend(&self.ends[before.len() - behind..]);
        // A last line that nothing ended stays one.
        let open = self.ends.last() == Some(&"");
        let count = ends.len();
        for (n, end) in ends.iter_mut().enumerate() {
            match n + 1 == count && open {
                true => *end = "",
                false if end.is_empty() => *end = usual,
                false => {}
            }
        }
        (self.bare, self.ends) = (after, ends);
        Ok(())
    }

    /// As it is now.
    pub fn finish(&self) -> String {
        let mark = self.marked.then_some(BOM);
        let lines = lines(&self.bare).zip(&self.ends).flat_map(|(line, end)| [line, end]);
        mark.into_iter().collect::<String>() + &lines.collect::<String>()
    }
}

/// Without what ends them.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split_inclusive('\n').map(|line| line.strip_suffix('\n').unwrap_or(line))
}

#[cfg(test)]
mod tests {
    use super::Text;

    fn with(source: &str, keys: &[(&str, i64)]) -> String {
        let mut text = Text::of(source);
        for (key, number) in keys {
            let put = |document: &mut toml_edit::DocumentMut| {
                super::super::value::put(document.as_table_mut(), key, (*number).into())
            };
            text.change(put).unwrap();
        }
        text.finish()
    }

    #[test]
    fn lines_end_as_they_did_and_new_ones_as_the_line_before() {
        let mixed = "\u{feff}a = 1\r\n# one\nb = 2\n\r\nc = \"\"\"x\r\ny\"\"\"\r\n# end";
        assert_eq!(with(mixed, &[]), mixed);
        assert_eq!(
            with(mixed, &[("a", 3), ("b", 4)]),
            mixed.replace("a = 1", "a = 3").replace("b = 2", "b = 4")
        );
        assert_eq!(with("a = 1\r\nb = 2\r\n", &[("c", 3), ("d", 4)]), "a = 1\r\nb = 2\r\nc = 3\r\nd = 4\r\n");
        assert_eq!(with("a = 1\n[t]\r\nb = 2\r\n", &[("c", 3)]), "a = 1\nc = 3\n[t]\r\nb = 2\r\n");
        assert_eq!(with("a = 1\r\nb = 2", &[("c", 3)]), "a = 1\r\nb = 2\r\nc = 3");
        assert_eq!(with("a = 1", &[("b", 2)]), "a = 1\nb = 2");
        assert_eq!(with("", &[("a", 1)]), "a = 1\n");
    }
}
