//! What was left out, and why: for people and for programs.

use super::table::Table;
use pacinian::graph::plan::{LeftOut, Why};
use serde::Serialize;

/// Something left out.
#[derive(Debug, Serialize)]
pub struct Left {
    what: String,
    why: String,
}

/// What was left out, for programs.
pub fn left_out(list: &[LeftOut]) -> Vec<Left> {
    list.iter().map(|l| Left { what: l.what.clone(), why: l.why.to_string() }).collect()
}

/// What was left out, as lines; outputs that nothing feeds in one.
pub fn left_out_text(list: &[LeftOut]) -> String {
    let mut table = Table::default();
    let unfed: Vec<&str> = list.iter().filter_map(unfed).collect();
    let mut told = unfed.len() < 2;
    for left in list {
        if unfed.len() < 2 || self::unfed(left).is_none() {
            table.row([left.what.clone(), left.why.to_string()]);
        } else if !told {
            told = true;
            table.row([format!("outputs {}", ranges(&unfed)), "nothing feeds them".into()]);
        }
    }
    table.text()
}

/// The name of an output that nothing feeds.
fn unfed(left: &LeftOut) -> Option<&str> {
    let name = left.what.strip_prefix("output `").and_then(|rest| rest.strip_suffix('`'));
    name.filter(|_| left.why == Why::NeverFed)
}

/// "`t3` to `t8`, `top`": three names or more that count up are told by their ends.
pub(super) fn ranges(names: &[&str]) -> String {
    let split = |name: &str| {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        Some((stem.to_string(), name[stem.len()..].parse::<u64>().ok()?))
    };
    let mut runs: Vec<Vec<&str>> = Vec::new();
    for name in names {
        let follows = |run: &Vec<&str>| {
            let last = run.last().and_then(|last| split(last));
            last.zip(split(name)).is_some_and(|((a, m), (b, n))| a == b && m.checked_add(1) == Some(n))
        };
        match runs.last_mut().filter(|run| follows(run)) {
            Some(run) => run.push(name),
            None => runs.push(vec![name]),
        }
    }
    let shown = |run: &Vec<&str>| match run.as_slice() {
        [first, _, .., last] => format!("`{first}` to `{last}`"),
        few => few.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
    };
    runs.iter().map(shown).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::{left_out_text, ranges};
    use pacinian::graph::plan::{LeftOut, Why};

    #[test]
    fn outputs_that_nothing_feeds_are_told_in_one_line() {
        let left = |what: &str, why| LeftOut { what: what.into(), why };
        let mut list = vec![left("node `a`", Why::Pruned)];
        list.extend((3..=8).map(|n| left(&format!("output `t{n}`"), Why::NeverFed)));
        list.push(left("trigger `key.1`", Why::NotYet));
        let text = left_out_text(&list);
        assert_eq!(text.lines().count(), 3, "{text}");
        let line = text.lines().nth(1).unwrap_or_default();
        assert_eq!(
            line.split_whitespace().collect::<Vec<_>>().join(" "),
            "outputs `t3` to `t8` nothing feeds them"
        );
        assert!(left_out_text(&list[..2]).contains("output `t3`"), "one alone is told as it is");
    }

    #[test]
    fn names_that_count_up_are_told_by_their_ends() {
        assert_eq!(ranges(&["t1", "t2", "t4", "t5", "t6", "top"]), "`t1`, `t2`, `t4` to `t6`, `top`");
        assert_eq!(ranges(&["a1", "b2", "9", "10", "11"]), "`a1`, `b2`, `9` to `11`");
        assert_eq!(ranges(&["t99999999999999999999", "t18446744073709551615"]).matches('`').count(), 4);
    }
}
