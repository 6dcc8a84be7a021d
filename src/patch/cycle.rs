//! Cycles in a graph of names, found without recursion.

use std::collections::HashSet;

/// After so many cycles the rest says little.
const MOST: usize = 20;

/// Cycles of a graph whose nodes are `0..edges.len()`; each is a list of nodes of which every one has an edge to the next and
/// the last to the first. Finds at least one where there is any, and no two that begin or end at the same node.
pub(crate) fn cycles(edges: &[Vec<usize>]) -> Vec<Vec<usize>> {
    #[derive(Clone, Copy, PartialEq)]
    enum Seen {
        Not,
        Open,
        Done,
    }
    let mut seen = vec![Seen::Not; edges.len()];
    let mut told = HashSet::new();
    let mut found = Vec::new();
    // The way from the root to where the search stands: a node and how many of its edges are done.
    let mut way: Vec<(usize, usize)> = Vec::new();
    for root in 0..edges.len() {
        if seen[root] != Seen::Not {
            continue;
        }
        seen[root] = Seen::Open;
        way.push((root, 0));
        while let Some((node, done)) = way.last_mut() {
            let node = *node;
            let Some(&next) = edges[node].get(*done) else {
                seen[node] = Seen::Done;
                way.pop();
                continue;
            };
            *done += 1;
            match seen[next] {
                Seen::Not => {
                    seen[next] = Seen::Open;
                    way.push((next, 0));
                }
                Seen::Open if !told.contains(&next) && !told.contains(&node) => {
                    let begin = way.iter().rposition(|(n, _)| *n == next).unwrap_or(0);
                    let cycle: Vec<usize> = way[begin..].iter().map(|(n, _)| *n).collect();
                    told.extend(cycle.iter().copied());
                    found.push(cycle);
                    if found.len() >= MOST {
                        return found;
                    }
                }
                Seen::Open | Seen::Done => {}
            }
        }
    }
    found
}

/// "`a` reads `b`, which reads `a`" as a chain: "a → b → a", shortened in the middle where it is long.
pub(crate) fn chain<'a>(cycle: &[usize], name: impl Fn(usize) -> &'a str) -> String {
    const SHOWN: usize = 24;
    let mut names: Vec<String> = cycle.iter().map(|&i| name(i).to_string()).collect();
    names.extend(cycle.first().map(|&i| name(i).to_string()));
    if names.len() > SHOWN {
        let hidden = names.len() - SHOWN;
        names.splice(SHOWN / 2..SHOWN / 2 + hidden, [format!("({hidden} more)")]);
    }
    names.join(" → ")
}

#[cfg(test)]
mod tests {
    use super::{chain, cycles};

    #[test]
    fn finds_cycles_and_nothing_else() {
        assert!(cycles(&[vec![1, 2], vec![2], vec![]]).is_empty(), "a diamond is no cycle");
        assert_eq!(cycles(&[vec![0]]), [vec![0]]);
        assert_eq!(cycles(&[vec![1], vec![2], vec![1]]), [vec![1, 2]]);
        assert_eq!(cycles(&[vec![1], vec![0], vec![3], vec![2]]).len(), 2);
    }

    #[test]
    fn long_chains_need_no_stack() {
        let mut edges: Vec<Vec<usize>> = (0..200_000).map(|i| vec![i + 1]).collect();
        edges.push(vec![]);
        assert!(cycles(&edges).is_empty());
        edges[200_000] = vec![0];
        let found = cycles(&edges);
        assert_eq!(found[0].len(), 200_001);
        assert!(chain(&found[0], |_| "n").contains("(199978 more)"));
        assert_eq!(chain(&[0, 1], |i| ["a", "b"][i]), "a → b → a");
    }
}
