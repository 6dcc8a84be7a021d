//! One of several roots is stopped.

use super::{all, beat, choice, every, jitter, nested, patch, pattern, score, voice};
use crate::patch::{Event, Patch, Pattern};
use crate::score::Timed;

fn three() -> Patch {
    let inner = Pattern { shuffle: true, ..pattern("inner", vec![beat(0.0), beat(0.125), beat(0.5)]) };
    let calls = |at: f64| super::event(at, nested("inner", 0.5, 2.0));
    let first =
        Pattern { repeat: every(0.75, None), ..pattern("first", vec![beat(0.0), calls(0.25), calls(0.3)]) };
    let drawn = choice(&[(1.0, voice("a", Some(0.3), None, &[])), (2.0, voice("b", None, None, &[]))]);
    let second = Pattern {
        repeat: every(0.4, 20),
        jitter: Some(jitter(0.02, &[("level", 0.1)])),
        ..pattern("second", vec![super::event(0.1, drawn), Event { repeat: every(0.05, 3), ..beat(0.2) }])
    };
    let third =
        Pattern { repeat: every(0.5, 10), shuffle: true, ..pattern("third", vec![calls(0.0), beat(0.2)]) };
    patch(vec![first, second, third, inner])
}

const ROOTS: [(usize, f64); 3] = [(0, 0.0), (1, 0.3), (2, 0.1)];

/// So many events, without their serial numbers; before the `n`th a root is stopped.
fn some(stop: Option<(usize, usize)>) -> Vec<Timed> {
    let mut score = score(&three(), &ROOTS, 5).unwrap();
    let mut events = Vec::new();
    while events.len() < 300 {
        if let Some((_, root)) = stop.filter(|(n, _)| *n == events.len()) {
            score.stop(root);
            assert!(!score.plays(root));
        }
        let Some(timed) = score.next().transpose().unwrap() else { break };
        events.push(Timed { id: 0, ..timed });
    }
    events
}

#[test]
fn the_others_play_as_they_would_have() {
    let whole = some(None);
    assert_eq!(whole.len(), 300);
    for root in 0..ROOTS.len() {
        for n in [0, 1, 7, 40, 100] {
            let (stopped, kept) = (some(Some((n, root))), &whole[..n]);
            assert_eq!(stopped[..n], *kept);
            let others: Vec<_> = whole[n..].iter().filter(|timed| timed.root != root).cloned().collect();
            assert!(!others.is_empty() && stopped.len() >= n + others.len());
            assert_eq!(stopped[n..n + others.len()], others);
        }
    }
}

#[test]
fn what_plays_is_what_has_something_left() {
    let patch = Patch { patterns: three().patterns.split_off(1), ..three() };
    let mut score = score(&patch, &[(0, 0.0), (1, 1.0), (1, 2.0)], 1).unwrap();
    let mut last = [0; 3];
    let mut ended = [usize::MAX; 3];
    for number in 0.. {
        for (root, ended) in ended.iter_mut().enumerate().filter(|(_, ended)| **ended == usize::MAX) {
            if !score.plays(root) {
                *ended = number;
            }
        }
        let Some(timed) = score.next().transpose().unwrap() else { break };
        last[timed.root] = number + 1;
    }
    assert!(last.iter().all(|last| *last > 20));
    assert_eq!(ended, last, "each ends with its last event");
    assert!(all(&patch, 1).iter().all(|timed| timed.root == 0));
}
