//! What is drawn: choice, shuffle, jitter.

use super::{all, beat, choice, event, every, jitter, nested, note, patch, pattern, score, times, voice};
use crate::patch::{Action, Events, Pattern};
use crate::score::What;

fn marker(name: &str) -> Action {
    Action::Marker(name.into())
}

#[test]
fn a_choice_follows_its_weights() {
    let weights = [1.0, 2.0, 5.0];
    let mut one = event(
        0.0,
        choice(&[(1.0, marker("x")), (2.0, voice("a", None, None, &[])), (5.0, nested("q", 1.0, 1.0))]),
    );
    one.repeat = every(1.0, 40_000);
    let patch = patch(vec![pattern("p", vec![one]), pattern("q", vec![event(0.0, marker("q"))])]);
    let played = all(&patch, 11);
    assert_eq!(played.len(), 40_000);
    let which: Vec<usize> = played
        .iter()
        .map(|t| match (&t.what, t.drawn, t.pattern) {
            (What::Marker(m), Some(0), 0) if **m == *"x" => 0,
            (What::Play(_), Some(1), 0) => 1,
            (What::Marker(m), None, 1) if **m == *"q" => 2,
            _ => panic!("{t:?}"),
        })
        .collect();
    let count = |w: usize| which.iter().filter(|x| **x == w).count() as f64;
    let chi: f64 = (0..3).map(|w| (count(w) - 5000.0 * weights[w]).powi(2) / (5000.0 * weights[w])).sum();
    // Two degrees of freedom: above 23 once in 100,000.
    assert!(chi < 23.0, "{chi}");
    // One draw says nothing about the next.
    let pairs = which.windows(2).filter(|w| w[0] == 2 && w[1] == 2).count() as f64;
    let expected = 40_000.0 * (5.0_f64 / 8.0).powi(2);
    assert!((pairs - expected).abs() < 6.0 * expected.sqrt(), "{pairs} for {expected}");
}

#[test]
fn every_seed_playing_event_and_repetition_draws_anew() {
    let toss = || choice(&[(1.0, marker("x")), (1.0, marker("y"))]);
    let mut repeated = event(0.0, toss());
    repeated.repeat = every(0.125, 64);
    let several = (0..64).map(|i| event(f64::from(i) / 8.0, toss())).collect();
    let inner = pattern("q", vec![event(0.0, toss())]);
    let mut played = event(0.0, nested("q", 1.0, 1.0));
    played.repeat = every(0.125, 64);
    let rounds = Pattern { repeat: every(0.125, 64), ..pattern("p", vec![event(0.0, toss())]) };
    let ways = [pattern("p", vec![repeated]), pattern("p", several), pattern("p", vec![played]), rounds];
    let mut draws = Vec::new();
    for way in ways {
        let patch = patch(vec![way, inner.clone()]);
        for seed in [0, 1, 1 << 40] {
            let drawn: Vec<_> = all(&patch, seed).iter().map(|t| t.drawn).collect();
            assert_eq!(drawn.len(), 64);
            assert_eq!(drawn, all(&patch, seed).iter().map(|t| t.drawn).collect::<Vec<_>>());
            assert!(drawn.contains(&Some(0)) && drawn.contains(&Some(1)));
            draws.push(drawn);
        }
    }
    for (i, a) in draws.iter().enumerate() {
        assert!(draws[..i].iter().all(|b| a != b));
    }
}

#[test]
fn another_root_does_not_change_what_is_drawn() {
    let p = Pattern {
        jitter: Some(jitter(0.5, &[("level", 0.5)])),
        ..pattern("p", (0..20).map(|i| beat(f64::from(i))).collect())
    };
    let patch = patch(vec![p, pattern("q", (0..50).map(|i| beat(f64::from(i) / 3.0)).collect())]);
    let alone: Vec<_> = all(&patch, 5).into_iter().map(|t| (t.at, t.what)).collect();
    let both = score(&patch, &[(0, 0.0), (1, 0.0)], 5).unwrap().map(Result::unwrap);
    let both: Vec<_> = both.filter(|t| t.pattern == 0).map(|t| (t.at, t.what)).collect();
    assert_eq!(alone, both);
}

#[test]
fn a_shuffle_keeps_the_onsets_and_permutes_what_lands_on_them() {
    let onsets = [0.0, 0.5, 0.75, 2.0, 2.25, 3.0];
    let mut events: Vec<_> = onsets.iter().map(|at| beat(*at)).collect();
    events.reverse();
    let p = Pattern { shuffle: true, repeat: every(4.0, 500), ..pattern("p", events) };
    let played = all(&patch(vec![p]), 3);
    let mut seen = std::collections::HashSet::new();
    let mut first = [0.0_f64; 6];
    for (round, group) in played.chunks(6).enumerate() {
        let start = 4.0 * round as f64;
        assert_eq!(times(group), onsets.map(|at| start + at));
        let mut landed: Vec<u64> = group.iter().map(|t| t.event).collect();
        first[landed[0] as usize] += 1.0;
        seen.insert(landed.clone());
        landed.sort_unstable();
        assert_eq!(landed, [0, 1, 2, 3, 4, 5]);
    }
    assert_eq!(played.len(), 3000);
    // Of 720 permutations, 500 draws show some 360.
    assert!((300..420).contains(&seen.len()), "{}", seen.len());
    let expected = 500.0 / 6.0;
    let chi: f64 = first.iter().map(|c| (c - expected).powi(2) / expected).sum();
    // Five degrees of freedom: above 31 once in 100,000.
    assert!(chi < 31.0, "{chi}");
}

#[test]
fn a_shuffled_event_takes_its_delay_along() {
    let mut late = beat(0.0);
    late.delay = 0.25;
    let p =
        Pattern { shuffle: true, repeat: every(8.0, 50), ..pattern("p", vec![late, beat(1.0), beat(2.0)]) };
    let played = all(&patch(vec![p]), 3);
    for t in &played {
        assert_eq!(t.at.fract(), if t.event == 0 { 0.25 } else { 0.0 });
    }
    let lands = |at: f64| played.iter().filter(|t| t.event == 0 && t.at.rem_euclid(8.0) == at + 0.25).count();
    assert_eq!(lands(0.0) + lands(1.0) + lands(2.0), 50);
    assert!(lands(0.0) > 5 && lands(1.0) > 5 && lands(2.0) > 5);
}

#[test]
fn jitter_stays_within_its_bounds_and_fills_them() {
    let n = 2000_u32;
    let b = voice("b", Some(1.0), Some(0.5), &[]);
    let mut repeated = event(10.0, b.clone());
    repeated.repeat = every(1.0, u64::from(n));
    let events = vec![event(0.0, b.clone()), repeated, event(0.25, b)];
    let shares = jitter(3.0, &[("level", 0.5), ("duration", 1.0), ("depth", 0.25), ("unheard-of", 1.0)]);
    let p = Pattern { jitter: Some(shares), ..pattern("p", events) };
    let played = all(&patch(vec![p]), 9);
    assert_eq!(played.len(), n as usize + 2);
    assert!(played.windows(2).all(|w| w[0].at <= w[1].at));
    let moved: Vec<f64> = played.iter().filter(|t| t.event == 1).map(|t| t.at).collect();
    // Sorted, the kth is within the bounds of the kth unmoved.
    for (k, at) in moved.iter().enumerate() {
        assert!((at - 10.0 - k as f64).abs() <= 3.0);
    }
    let mean = moved.iter().enumerate().map(|(k, at)| at - 10.0 - k as f64).sum::<f64>() / f64::from(n);
    assert!(mean.abs() < 5.0 * 3.0 / (3.0 * f64::from(n)).sqrt());
    for t in played.iter().filter(|t| t.event != 1) {
        assert!((0.0..=3.25).contains(&t.at));
    }
    let spread = |value: &dyn Fn(&crate::score::Note) -> f64, low: f64, high: f64| {
        let all: Vec<f64> = played.iter().map(|t| value(note(t))).collect();
        let (least, most) = all.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        let margin = 0.02 * (high - low);
        assert!(
            low <= least && least < low + margin && high - margin < most && most <= high,
            "{least} {most}"
        );
        all
    };
    let levels = spread(&|n| n.level, 0.5, 1.5);
    let durations = spread(&|n| n.duration, 0.0, 1.0);
    spread(&|n| n.own[1], 2.25, 3.75);
    assert!(played.iter().all(|t| note(t).own[0] == 250.0));
    let product: f64 = levels.iter().zip(&durations).map(|(l, d)| (l - 1.0) * (d - 0.5)).sum();
    assert!(product.abs() < 5.0 / 12.0 * f64::from(n).sqrt(), "fields deviate each by itself");
}

#[test]
fn jitter_without_width_moves_nothing() {
    let p =
        Pattern { jitter: Some(jitter(0.0, &[("level", 0.5)])), ..pattern("p", vec![beat(0.0), beat(1.0)]) };
    let plain = Pattern { jitter: None, ..p.clone() };
    assert_eq!(times(&all(&patch(vec![p]), 1)), times(&all(&patch(vec![plain.clone()]), 1)));
    let Events::Inline(events) = plain.events else { panic!() };
    assert_eq!(events.len(), 2);
}
