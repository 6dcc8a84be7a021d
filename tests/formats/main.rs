//! The two file formats: what is read, what is refused and in which words, and that nothing breaks the reader.

mod hostile;
mod motor;
mod patch;
mod rig;
mod schema;

use pacinian::text::Problems;

/// The lines of the problems with what they say, and help behind a bar.
fn told(problems: &Problems) -> Vec<(usize, String)> {
    let line = |p: &pacinian::text::Problem| p.span.as_ref().map_or(0, |s| problems.position(s.start).0);
    let text = |p: &pacinian::text::Problem| format!("{} | {}", p.what, p.help.as_deref().unwrap_or(""));
    problems.list.iter().map(|p| (line(p), text(p))).collect()
}

/// That the problems are these: line, fragment of what is said or of its help.
fn assert_told(source: &str, problems: &Problems, expected: &[(usize, &str)]) {
    let told = told(problems);
    assert_eq!(told.len(), expected.len(), "{source}\n{problems}");
    for ((line, text), (expected_line, fragment)) in told.iter().zip(expected) {
        assert!(text.contains(fragment), "wanted `{fragment}` for\n{source}\n{problems}");
        assert_eq!(line, expected_line, "{source}\n{problems}");
    }
}
