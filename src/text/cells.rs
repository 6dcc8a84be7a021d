//! Lines of comma-separated files.

use super::Span;

/// A cell of a line, and where it stands in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cell {
    pub text: String,
    pub span: Span,
}

/// The cells of a line: divided by commas, and as one likes in double quotes, two of them for one within.
///
/// # Errors
/// What is wrong with the quotes.
pub(crate) fn cells(line: &str) -> Result<Vec<Cell>, String> {
    let mut cells = Vec::new();
    let mut rest = line;
    loop {
        rest = rest.trim_start();
        let start = line.len() - rest.len();
        let mut cell = String::new();
        if let Some(mut quoted) = rest.strip_prefix('"') {
            loop {
                let Some((text, behind)) = quoted.split_once('"') else {
                    return Err("a quote does not end on its line".into());
                };
                cell.push_str(text);
                match behind.strip_prefix('"') {
                    Some(more) => {
                        cell.push('"');
                        quoted = more;
                    }
                    None => {
                        rest = behind.trim_start();
                        break;
                    }
                }
            }
            if !rest.is_empty() && !rest.starts_with(',') {
                return Err("a comma is missing behind a quote".into());
            }
        } else {
            let end = rest.find(',').unwrap_or(rest.len());
            let (text, behind) = rest.split_at(end);
            cell.push_str(text.trim_end());
            rest = behind;
        }
        let end = start + line[start..line.len() - rest.len()].trim_end().len();
        cells.push(Cell { text: cell, span: start..end });
        match rest.strip_prefix(',') {
            Some(more) => rest = more,
            None => return Ok(cells),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::cells;

    #[test]
    fn quotes_are_taken_off() {
        let line = "a,\"b,\"\"c\"\" \" , d,";
        let read = cells(line).unwrap();
        assert_eq!(read.iter().map(|c| c.text.as_str()).collect::<Vec<_>>(), ["a", "b,\"c\" ", "d", ""]);
        let stand: Vec<&str> = read.iter().map(|c| &line[c.span.clone()]).collect();
        assert_eq!(stand, ["a", "\"b,\"\"c\"\" \"", "d", ""]);
        assert!(cells("\"a\"b").is_err());
    }
}
