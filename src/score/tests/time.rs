//! Order, laziness, lengths.

use crate::space::spot::Spot;
use proptest::prelude::{Just, any, prop, proptest};

use super::naive::patches;
use super::{all, beat, event, every, jitter, nested, note, patch, pattern, score, times};
use crate::patch::{Events, Pattern, TimeBase};

proptest! {
    #[test]
    fn time_never_goes_back_and_the_seed_decides_all(
        mut patch in patches(),
        shuffles in prop::collection::vec(any::<bool>(), 4),
        spreads in prop::collection::vec(0.0..3.0_f64, 4),
        tempo in 1.0..400.0_f64,
        rate in 0.1..10.0_f64,
        every in 0.01..3.0_f64,
        seed in Just(1_u64),
    ) {
        for (i, p) in patch.patterns.iter_mut().enumerate() {
            p.shuffle = shuffles[i];
            p.jitter = (spreads[i] > 1.0).then(|| jitter(spreads[i] - 1.0, &[("level", 0.5), ("duration", 1.0)]));
        }
        patch.patterns[1].time = TimeBase::Beats(tempo);
        patch.patterns[2].rate = rate;
        patch.patterns[0].repeat = super::every(every, None);
        let roots = [(0, 0.3), (1, 0.0)];
        let played: Vec<_> = score(&patch, &roots, seed).unwrap().take(3000).map(Result::unwrap).collect();
        assert!(played.windows(2).all(|w| w[0].at <= w[1].at && w[0].id + 1 == w[1].id));
        assert!(played.first().is_none_or(|t| t.at >= 0.0 && t.id == 0));
        let again: Vec<_> = score(&patch, &roots, seed).unwrap().take(3000).map(Result::unwrap).collect();
        assert_eq!(played, again);
    }
}

#[test]
fn a_million_events_need_one_cursor() {
    let n = 1_000_000_u32;
    // In an order that is not that of time: 7 and a million have no common factor.
    let events = (0..n).map(|i| beat(f64::from((u64::from(i) * 7 % 1_000_000) as u32) / 1024.0)).collect();
    let patch = patch(vec![pattern("p", events)]);
    let mut score = score(&patch, &[(0, 0.0)], 0).unwrap();
    assert_eq!(score.length(), Some(f64::from(n - 1) / 1024.0 + 0.125));
    for i in 0..n {
        assert_eq!(score.next().unwrap().unwrap().at, f64::from(i) / 1024.0);
        assert!(score.under_way() <= 1);
    }
    assert!(score.next().is_none());
}

#[test]
fn a_million_events_at_once_come_in_the_order_of_the_file() {
    let patch = patch(vec![pattern("p", vec![beat(3.0); 1_000_000])]);
    let mut score = score(&patch, &[(0, 0.0)], 0).unwrap();
    for i in 0..1_000_000 {
        let timed = score.next().unwrap().unwrap();
        assert_eq!((timed.at, timed.event), (3.0, i));
        assert!(score.under_way() <= 1);
    }
}

#[test]
fn without_end() {
    let inner = pattern("inner", vec![beat(0.0), beat(0.25)]);
    let outer =
        Pattern { repeat: every(1.0, None), ..pattern("p", vec![event(0.5, nested("inner", 0.5, 2.0))]) };
    let patch = patch(vec![outer, inner]);
    let mut score = score(&patch, &[(0, 2.0)], 0).unwrap();
    assert_eq!(score.length(), None);
    for k in 0..100_000_u32 {
        for step in [0.0, 0.125] {
            let timed = score.next().unwrap().unwrap();
            assert_eq!(timed.at, 2.5 + f64::from(k) + step);
            assert_eq!((note(&timed).level, note(&timed).duration), (0.5, 0.0625));
            assert!(score.under_way() < 5);
        }
    }
}

#[test]
fn thousands_of_plays_of_a_pattern_share_it() {
    let inner = pattern("inner", (0..1000).map(|i| beat(f64::from(i))).collect());
    let mut outer = event(0.0, nested("inner", 1.0, 1.0));
    outer.repeat = every(0.5, 5000);
    let patch = patch(vec![pattern("p", vec![outer]), inner]);
    let score = score(&patch, &[(0, 0.0)], 0).unwrap();
    assert_eq!(score.length(), Some(2499.5 + 999.125));
    assert_eq!(score.map(Result::unwrap).filter(|t| t.at.fract() == 0.0).count(), 2_500_000);
}

#[test]
fn only_what_is_under_way_is_held() {
    // Each round lasts 10 s, so 20 overlap.
    let inner =
        Pattern { repeat: every(0.5, None), ..pattern("p", (0..=10).map(|i| beat(f64::from(i))).collect()) };
    let mut score = score(&patch(vec![inner]), &[(0, 0.0)], 0).unwrap();
    for _ in 0..50_000 {
        score.next().unwrap().unwrap();
        assert!(score.under_way() <= 23, "{}", score.under_way());
    }
}

#[test]
fn at_the_same_instant_the_file_decides_depth_first() {
    let named = |at, name: &str| event(at, crate::patch::Action::Marker(name.into()));
    let inner = pattern("inner", vec![named(0.0, "2a"), named(0.0, "2b"), named(1.0, "late")]);
    let events = vec![
        named(1.0, "4"),
        named(0.0, "1"),
        event(0.0, nested("inner", 1.0, 1.0)),
        named(0.0, "3"),
        named(1.0, "5"),
    ];
    let played = all(&patch(vec![pattern("p", events), inner]), 0);
    let names: Vec<_> = played.iter().map(|t| format!("{:?}", t.what).replace("Marker", "")).collect();
    // "late" is of the third event: after the first, before the last.
    assert_eq!(names.join(""), r#"("1")("2a")("2b")("3")("4")("late")("5")"#);
}

#[test]
fn lengths_are_not_guessed() {
    let known =
        |p: Pattern| score(&patch(vec![p, pattern("q", vec![beat(1.0)])]), &[(0, 0.0)], 0).unwrap().length();
    let one = || pattern("p", vec![beat(0.0), beat(1.0)]);
    assert_eq!(known(one()), Some(1.125));
    assert_eq!(known(pattern("p", Vec::new())), Some(0.0));
    assert_eq!(known(Pattern { shuffle: true, ..one() }), None);
    assert_eq!(known(Pattern { jitter: Some(jitter(0.0, &[("duration", 0.5)])), ..one() }), None);
    assert_eq!(known(Pattern { repeat: every(0.5, 3), ..one() }), Some(2.125));
    assert_eq!(known(Pattern { repeat: every(0.5, None), ..one() }), None);
    assert_eq!(known(Pattern { events: Events::File("x".into(), 0..0), ..one() }), None);
    assert_eq!(known(pattern("p", vec![event(0.5, nested("q", 1.0, 2.0))])), Some(0.5 + 1.125 / 2.0));
    assert_eq!(known(pattern("p", vec![event(0.0, super::choice(&[(1.0, nested("q", 1.0, 1.0))]))])), None);
    assert_eq!(known(pattern("p", vec![beat(2e9)])), None);
}

#[test]
fn tempo_counts_delay_repetition_and_durations_in_beats() {
    let mut b = event(1.0, super::voice("b", None, None, &[]));
    b.delay = 0.5;
    b.repeat = every(2.0, 3);
    let p = Pattern { time: TimeBase::Beats(30.0), follows: false, rate: 4.0, ..pattern("p", vec![b]) };
    let played = all(&patch(vec![p]), 0);
    assert_eq!(times(&played), [0.75, 1.75, 2.75]);
    assert!(
        played
            .iter()
            .all(|t| note(t).duration == 1.0 && note(t).level == 0.5 && note(t).place == Spot::Row(7))
    );
    assert_eq!(note(&played[0]).own, [250.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}
