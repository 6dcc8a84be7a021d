//! From bytes to a tree that keeps its places.

use toml::de::DeTable;

use super::problem::{Checked, Problem, Problems};
use super::reader::At;
use super::sink::Sink;

/// The most bytes a file may have.
pub const MAX_BYTES: usize = 16 << 20;
/// How deep tables and lists may nest; also how many parts a dotted key may have.
pub const MAX_DEPTH: usize = 64;

/// The text of a file, if it is text, small enough and nested little enough for the parser.
///
/// # Errors
/// Says which of them it is not.
pub fn text(bytes: &[u8]) -> Result<&str, Problem> {
    if bytes.len() > MAX_BYTES {
        return Err(Problem::of_file(format!(
            "the file has {:.1} MiB, the most is {} MiB",
            bytes.len() as f64 / f64::from(1 << 20),
            MAX_BYTES >> 20
        ))
        .help("put long lists of events into an events file: events = \"NAME.csv\"".to_string()));
    }
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let at = e.valid_up_to();
        let line = bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1;
        Problem::of_file(format!("the file is not text: byte {at}, in line {line}, is not UTF-8"))
            .help("save it as UTF-8".to_string())
    })?;
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        return Err(Problem::of_file("the file is empty"));
    }
    match too_deep(text) {
        Some(at) => {
            Err(Problem::error(&(at..at + 1), format!("tables and lists nest deeper than {MAX_DEPTH} here")))
        }
        None => Ok(text),
    }
}

/// The tree of a text that has passed [`text`].
///
/// # Errors
/// Every place at which it is not TOML.
pub fn parse(text: &str) -> Result<DeTable<'_>, Vec<Problem>> {
    let (document, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(document.into_inner());
    }
    let mut problems: Vec<(usize, Problem)> = Vec::new();
    for error in &errors {
        let span = error.span();
        let at = span.as_ref().map_or(0, |s| s.start.min(text.len()));
        let help = advice(text, at);
        // A recovering parser stumbles more than once over the same mistake: of a line, and of lists of tables that are
        // written as tables, the first says it.
        let line = text.as_bytes()[..at].iter().filter(|b| **b == b'\n').count();
        // Where a list is written as tables, all its keys stand there twice.
        let twice = error.message().starts_with("duplicate key");
        let is_list = |p: &Problem| p.help.as_ref().is_some_and(|help| help.contains("[["));
        let known = |(l, p): &(usize, Problem)| *l == line || (twice && is_list(p));
        if problems.iter().any(known) {
            continue;
        }
        let what = format!("this is not TOML: {}", error.message().lines().collect::<Vec<_>>().join(", "));
        problems.push((line, Problem { span, ..Problem::of_file(what).help(help) }));
        if problems.len() >= MAX_SYNTAX {
            break;
        }
    }
    Err(problems.into_iter().map(|(_, problem)| problem).collect())
}

/// What to do about a mistake of syntax at a byte, where it is one of those that people make.
fn advice(text: &str, at: usize) -> Option<String> {
    let begin = text.get(..at)?.rfind('\n').map_or(0, |b| b + 1);
    let line = text.get(begin..)?.lines().next().unwrap_or("");
    if let Some(name) = line.trim().strip_prefix('[').and_then(|rest| rest.strip_suffix(']'))
        && LISTS.contains(&name.trim())
    {
        return Some(format!("write [[{0}]] instead of [{0}], before each", name.trim()));
    }
    if line.contains(['“', '”', '„', '‘', '’']) {
        return Some("texts stand in straight quotes: \"...\"".into());
    }
    // A word without quotes behind `=`.
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '/');
    let before = line.get(..at - begin)?.trim_end_matches(is_word);
    let word: String = line.get(before.len()..)?.chars().take_while(|c| is_word(*c)).collect();
    let is_value = before.trim_end().ends_with(['=', '[', ',']) && word.starts_with(char::is_alphabetic);
    (is_value && !line.trim_start().starts_with('[')).then(|| format!("texts stand in quotes: \"{word}\""))
}

/// Lists of tables, which people write as tables.
const LISTS: [&str; 3] = ["trigger", "tactor", "output"];

/// Reads a whole file of a format, such as "pacinian-patch/1": text, then TOML, then `read`.
///
/// # Errors
/// All problems of the first of these steps that finds an error.
pub fn read<T>(
    name: &str,
    bytes: &[u8],
    format: &str,
    read: impl for<'a> FnOnce(&'a DeTable<'a>, &'a Sink) -> T,
) -> Result<Checked<T>, Problems> {
    let fail = |source: &str, list| {
        let mut problems = Problems { file: name.into(), source: source.into(), list };
        problems.sort();
        problems
    };
    let source = text(bytes).map_err(|p| {
        // Only a problem that has a place has lines to show.
        let source = if p.span.is_some() { std::str::from_utf8(bytes).unwrap_or("") } else { "" };
        fail(source, vec![p])
    })?;
    let document = parse(source).map_err(|list| fail(source, list))?;
    let sink = Sink::default();
    if let Some(value) = document.get("format").map(At::new)
        && let Some(problem) = check_format(name, &value, format)
    {
        // What an unknown version means, nobody knows: its other keys are not looked at.
        if problem.is_error() {
            return Err(fail(source, vec![problem]));
        }
        sink.push(problem);
    }
    let value = read(&document, &sink);
    let warnings = sink.into_problems(name, source);
    if warnings.has_errors() { Err(warnings) } else { Ok(Checked { value, warnings }) }
}

/// What is wrong with the version of a file, where `format` can be read.
fn check_format(name: &str, value: &At, format: &str) -> Option<Problem> {
    let span = value.span();
    let help = format!("write format = \"{format}\"");
    let Some(text) = value.text() else {
        return Some(
            Problem::error(&span, format!("`format` is {}; it must be a string", value.shown())).help(help),
        );
    };
    if text == format {
        return None;
    }
    let (kind, known) = format.split_once('/').unwrap_or((format, "1"));
    let Some((found, version)) = text.split_once('/') else {
        return Some(
            Problem::error(&span, format!("`format` is \"{text}\"; it must be \"{format}\"")).help(help),
        );
    };
    let other = match (found, kind) {
        ("pacinian-rig", "pacinian-patch") => Some((
            "this is a rig, and a patch is wanted here",
            format!("give it to --rig: pacinian check PATCH --rig {name}"),
        )),
        ("pacinian-patch", "pacinian-rig") => Some((
            "this is a patch, and a rig is wanted here",
            format!("a patch is given without --rig: pacinian check {name} --rig RIG"),
        )),
        _ => None,
    };
    if let Some((what, help)) = other {
        return Some(Problem::error(&span, what).help(help));
    }
    if found != kind {
        return Some(
            Problem::error(&span, format!("this is a \"{found}\" file; a \"{kind}\" is wanted here"))
                .help(help),
        );
    }
    let (major, minor) = version.split_once('.').map_or((version, Some("0")), |(a, b)| (a, Some(b)));
    let minor: Option<u32> = minor.and_then(|m| m.parse().ok());
    match (major == known, minor) {
        (true, Some(0)) => None,
        (true, Some(_)) => Some(
            Problem::warning(
                &span,
                format!("the file is of version {version}, this program knows version {known}"),
            )
            .help("what is new in it may be refused as unknown".to_string()),
        ),
        _ => Some(
            Problem::error(
                &span,
                format!(
                    "version {version} of \"{kind}\" is unknown to this program, which knows version {known}"
                ),
            )
            .help("use a newer pacinian, or write the file for this version".to_string()),
        ),
    }
}

/// After so many errors of syntax the rest says little.
const MAX_SYNTAX: usize = 20;

/// The first byte at which brackets outside strings and comments, or a dotted key, go too deep. Linear, and knows just
/// enough of TOML to skip strings; the parser says what is wrong with one that does not end.
fn too_deep(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut depth, mut dots, mut at) = (0usize, 0usize, 0usize);
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'#' => at = end_of(bytes, at, b"\n", false),
            b'"' | b'\'' => {
                let escapes = byte == b'"';
                let long = [byte; 3];
                at = if bytes[at..].starts_with(&long) {
                    end_of(bytes, at + 3, &long, escapes)
                } else {
                    end_of(bytes, at + 1, &[byte], escapes)
                };
                continue;
            }
            b'[' | b'{' => {
                (depth, dots) = (depth + 1, 0);
            }
            b']' | b'}' => {
                (depth, dots) = (depth.saturating_sub(1), 0);
            }
            b'.' => dots += 1,
            b'=' | b',' | b'\n' => dots = 0,
            _ => {}
        }
        if depth > MAX_DEPTH || dots >= MAX_DEPTH {
            return Some(at);
        }
        at += 1;
    }
    None
}

/// The byte behind the next `end`; a short string also ends with its line.
fn end_of(bytes: &[u8], mut at: usize, end: &[u8], escapes: bool) -> usize {
    while at < bytes.len() {
        if escapes && bytes[at] == b'\\' {
            at += 2;
        } else if bytes[at..].starts_with(end) {
            return at + end.len();
        } else if end.len() == 1 && bytes[at] == b'\n' {
            return at;
        } else {
            at += 1;
        }
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::{MAX_BYTES, MAX_DEPTH, parse, text};

    #[test]
    fn refuses_what_is_no_text() {
        let what = |bytes: &[u8]| text(bytes).unwrap_err().what;
        assert!(what(b"").contains("empty"));
        assert!(what(b" \n\t\n").contains("empty"));
        assert!(what(b"a = 1\nb = \"\xff\"").contains("byte 11, in line 2, is not UTF-8"));
        assert!(what(&vec![b' '; MAX_BYTES + 1]).contains("16.0 MiB"));
    }

    #[test]
    fn refuses_deep_nesting_before_it_reaches_the_parser() {
        for deep in ["[".repeat(10_000), "{a=".repeat(10_000), format!("{}b = 1", "a.".repeat(10_000))] {
            assert!(
                text(format!("x = {deep}").as_bytes()).unwrap_err().what.contains("deeper"),
                "{:.9}",
                deep
            );
        }
        let deep = |n: usize| format!("x = {}{}", "[".repeat(n), "]".repeat(n));
        assert!(parse(text(deep(MAX_DEPTH).as_bytes()).unwrap()).is_ok());
        assert!(text(deep(MAX_DEPTH + 1).as_bytes()).is_err());
        let brackets = "[".repeat(1000);
        for quoted in [
            format!("x = \"\\\"{brackets}\""),
            format!("x = '{brackets}'"),
            format!("x = \"\"\"\n{brackets}\"\"\""),
            format!("x = 1 # {brackets}"),
        ] {
            assert!(parse(text(quoted.as_bytes()).unwrap()).is_ok(), "{quoted:.20}");
        }
    }

    #[test]
    fn the_first_error_of_a_line_is_enough() {
        let of = |text: &str| parse(text).unwrap_err();
        let comma = of(
            "[pattern.p]\nevents = [{ at = 0, voice = \"a\" } { at = 1, voice = \"b\", level = 1 } { at = 2 }]\n",
        );
        assert_eq!(comma.len(), 1, "{comma:?}");
        assert!(comma[0].what.contains("missing comma"), "{comma:?}");
        let tactors =
            of("[tactor]\nname = 1\n[tactor]\nname = 2\nchannel = 1\n[tactor]\nname = 3\nchannel = 2\n");
        assert_eq!(tactors.len(), 1, "{tactors:?}");
        assert_eq!(tactors[0].help.as_deref(), Some("write [[tactor]] instead of [tactor], before each"));
    }

    #[test]
    fn texts_without_their_quotes_are_told_so() {
        for (text, help) in [
            ("place = t1", "texts stand in quotes: \"t1\""),
            ("x = [{ at = 0, place = front-left, level = 1 }]", "texts stand in quotes: \"front-left\""),
            ("x = { type = sine }", "texts stand in quotes: \"sine\""),
            ("x = “tap”", "texts stand in straight quotes: \"...\""),
        ] {
            let problems = parse(text).unwrap_err();
            assert_eq!(problems[0].help.as_deref(), Some(help), "{text}: {problems:?}");
        }
        assert_eq!(parse("x = ").unwrap_err()[0].help, None);
    }

    #[test]
    fn reports_every_error_of_syntax() {
        let problems = parse("a = \nb = 2\nc = = 3\n").unwrap_err();
        assert!(problems.len() >= 2, "{problems:?}");
    }
}
