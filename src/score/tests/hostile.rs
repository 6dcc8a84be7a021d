//! Hostile numbers and shapes.

use proptest::prelude::{Just, Strategy, prop, prop_oneof, proptest};

use super::{all, beat, choice, event, every, jitter, nested, patch, pattern, refused, score, voice};
use crate::patch::{Event, Pattern, TimeBase, Voice};
use crate::score::unroll::Limits;
use crate::score::{HORIZON, What};

fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(5e-324),
        Just(1e-9),
        Just(1.0),
        Just(1e9),
        Just(1e18),
        Just(1e300),
        Just(f64::MAX)
    ]
}

fn above_zero() -> impl Strategy<Value = f64> {
    extreme().prop_map(|x| if x > 0.0 { x } else { 1e-30 })
}

proptest! {
    #[test]
    fn all_numbers_are_finite_and_in_order(
        events in prop::collection::vec((extreme(), extreme(), extreme(), extreme(), above_zero()), 1..5),
        rates in prop::collection::vec(above_zero(), 3),
        gains in prop::collection::vec(extreme(), 3),
        tempo in above_zero(),
        again in above_zero(),
        spread in extreme(),
        shuffle in prop_oneof![Just(true), Just(false)],
    ) {
        let events = events.into_iter().map(|(at, delay, level, duration, every)| Event {
            delay,
            repeat: super::every(every, u64::MAX),
            ..event(at, voice("b", Some(level), Some(duration), &[("depth", level)]))
        });
        let inner = Pattern {
            time: if (60.0 / tempo).is_finite() && 60.0 / tempo > 0.0 { TimeBase::Beats(tempo) } else { TimeBase::Seconds },
            rate: rates[0],
            gain: gains[0],
            shuffle,
            jitter: Some(jitter(spread, &[("level", 1.0), ("duration", 1.0), ("depth", 1.0)])),
            repeat: every(again, None),
            ..pattern("q", events.collect())
        };
        let deed = nested("q", gains[1], rates[1]);
        let outer = Pattern { rate: rates[2], gain: gains[2], ..pattern("p", vec![event(0.0, deed)]) };
        let mut last = 0.0;
        let mut score = score(&patch(vec![outer, inner]), &[(0, 0.0)], 1).unwrap();
        score.0.limits = Limits { patience: 10_000, at_once: 2000, permuted: 1000 };
        for timed in score.take(300) {
            // Too much at once is an error; anything else is well formed.
            let Ok(timed) = timed else { break };
            assert!(timed.at >= last && timed.at <= HORIZON);
            last = timed.at;
            let What::Play(note) = timed.what else { continue };
            assert!(note.level.is_finite() && (0.0..=HORIZON).contains(&note.duration));
            assert!(note.own.iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn a_billion_a_second_go_on() {
    let mut fast = beat(0.0);
    fast.repeat = every(1e-9, 1_000_000_000_000_000_000);
    let mut score = score(&patch(vec![pattern("p", vec![fast])]), &[(0, 1.0)], 0).unwrap();
    for k in 0..100_000 {
        assert_eq!(score.next().unwrap().unwrap().at, 1.0 + f64::from(k) * 1e-9);
    }
    assert_eq!(score.under_way(), 1);
}

#[test]
fn the_end_of_time() {
    let p = Pattern { repeat: every(4e8, None), ..pattern("p", vec![beat(0.0), beat(5e8), beat(1e12)]) };
    let mut score = score(&patch(vec![p]), &[(0, 0.0)], 0).unwrap();
    let times: Vec<f64> = score.by_ref().map(|t| t.unwrap().at).collect();
    assert_eq!(times, [0.0, 4e8, 5e8, 8e8, 9e8]);
    assert!(score.cut());
    assert_eq!(score.under_way(), 0);
}

#[test]
fn nothing_repeated_for_ever_ends() {
    let mut never = event(0.0, nested("q", 1.0, 1.0));
    never.repeat = every(1e-9, None);
    let p = Pattern {
        repeat: every(1e-9, None),
        ..pattern("p", vec![never.clone(), event(1.0, choice(&[(1.0, never.action)]))])
    };
    let q = Pattern { repeat: every(1e-9, None), ..pattern("q", Vec::new()) };
    let score = score(&patch(vec![p, q]), &[(0, 0.0), (1, 0.0)], 0).unwrap();
    assert_eq!(score.length(), Some(0.0));
    assert_eq!(score.count(), 0);
}

#[test]
fn a_tree_of_empty_patterns_costs_nothing() {
    let mut patterns: Vec<_> = (0..40)
        .map(|i| pattern(&format!("p{i}"), vec![event(0.0, nested(&format!("p{}", i + 1), 1.0, 1.0)); 100]))
        .collect();
    patterns.push(pattern("p40", Vec::new()));
    assert_eq!(all(&patch(patterns), 0), []);
}

#[test]
fn a_tree_too_large_to_write_out_is_lazy() {
    let deed = |i: i32| event(0.0, nested(&format!("p{}", i + 1), 1.0, 1.0));
    let mut patterns: Vec<_> = (0..60).map(|i| pattern(&format!("p{i}"), vec![deed(i); 100])).collect();
    patterns.push(pattern("p60", vec![beat(0.0); 3]));
    let mut score = score(&patch(patterns), &[(0, 0.0)], 0).unwrap();
    for i in 0..10_000 {
        assert_eq!(score.next().unwrap().unwrap().event, i % 3);
        assert!(score.under_way() <= 61);
    }
}

#[test]
fn what_does_not_get_on_is_an_error() {
    // Time stands still.
    let p = Pattern { rate: 1e300, repeat: every(1e-9, None), ..pattern("p", vec![beat(0.0)]) };
    let last = score(&patch(vec![p]), &[(0, 0.0)], 0).unwrap().last().unwrap();
    assert!(last.unwrap_err().what.contains("pattern `p` does not get on at"));
    // Almost never anything.
    let mut rare = event(0.0, choice(&[(1e-300, voice("a", None, None, &[])), (1.0, nested("q", 1.0, 1.0))]));
    rare.repeat = every(1e-9, None);
    assert!(
        refused(&patch(vec![pattern("p", vec![rare]), pattern("q", Vec::new())])).contains("does not get on")
    );
    // All within reach of jitter.
    let mut wide = beat(0.0);
    wide.repeat = every(1e-3, None);
    let p = Pattern { jitter: Some(jitter(1e8, &[])), ..pattern("p", vec![wide]) };
    assert!(refused(&patch(vec![p])).contains("under way"));
}

#[test]
fn what_cannot_be_played_is_refused() {
    let one = |e: Event| refused(&patch(vec![pattern("p", vec![beat(0.0), e])]));
    assert_eq!(
        one(event(f64::NAN, beat(0.0).action)),
        "event 2 of pattern `p`: `at` is NaN, and must be at least 0"
    );
    assert!(one(Event { delay: -1.0, ..beat(0.0) }).contains("`delay` is -1"));
    assert!(one(Event { repeat: every(0.0, 3), ..beat(0.0) }).contains("every 0"));
    assert!(one(Event { repeat: every(1.0, 0), ..beat(0.0) }).contains("0 times"));
    assert!(one(event(0.0, voice("zz", None, None, &[]))).contains("there is no voice `zz`"));
    assert!(
        one(event(0.0, voice("a", None, None, &[("depth", 1.0)]))).contains("voice `a` has no field `depth`")
    );
    assert!(one(event(0.0, voice("a", Some(f64::NAN), None, &[]))).contains("not a number"));
    assert!(one(event(0.0, nested("zz", 1.0, 1.0))).contains("there is no pattern `zz`"));
    assert!(one(event(0.0, nested("p", 1.0, 0.0))).contains("rate 0"));
    assert!(one(event(0.0, choice(&[]))).contains("add up to more than 0"));
    assert!(one(event(0.0, choice(&[(f64::INFINITY, beat(0.0).action)]))).contains("a weight is inf"));
    assert!(
        one(event(0.0, choice(&[(1.0, choice(&[(1.0, beat(0.0).action)]))]))).contains("cannot be a choice")
    );
    let whole = |p: Pattern| refused(&patch(vec![p]));
    assert!(whole(Pattern { rate: 0.0, ..pattern("p", Vec::new()) }).contains("rate is 0"));
    assert!(
        whole(Pattern { time: TimeBase::Beats(0.0), follows: false, ..pattern("p", Vec::new()) })
            .contains("tempo")
    );
    assert!(whole(Pattern { repeat: every(0.0, None), ..pattern("p", Vec::new()) }).contains("every 0"));
    assert!(
        whole(Pattern { jitter: Some(jitter(-1.0, &[])), ..pattern("p", Vec::new()) }).contains("jitter")
    );
    let p = patch(vec![pattern("p", vec![beat(0.0)])]);
    assert!(score(&p, &[(1, 0.0)], 0).is_err());
    assert!(score(&p, &[(0, -1.0)], 0).is_err());
    let mut wide = Voice::new("a", "out");
    wide.fields = (0..9).map(|i| (format!("f{i}"), 0.0)).collect();
    assert!(refused(&crate::patch::Patch { voices: vec![wide], ..p }).contains("9 fields"));
}

#[test]
fn circles_and_depths() {
    let chain = |n: i32| {
        let deed = |i: i32| vec![event(0.0, nested(&format!("p{}", i + 1), 1.0, 1.0))];
        let mut all: Vec<_> = (1..n).map(|i| pattern(&format!("p{i}"), deed(i))).collect();
        all.push(pattern(&format!("p{n}"), vec![beat(0.0)]));
        patch(all)
    };
    assert_eq!(all(&chain(64), 0).len(), 1);
    assert!(refused(&chain(65)).contains("nests more than 64 deep"));
    assert!(refused(&chain(100_000)).contains("nests more than 64 deep"));
    let to = |name: &str, of: &str| pattern(name, vec![beat(0.0), event(1.0, nested(of, 1.0, 1.0))]);
    assert!(refused(&patch(vec![to("p", "q"), to("q", "p")])).contains("contains itself"));
    assert!(refused(&patch(vec![to("p", "p")])).contains("pattern `p` contains itself"));
}
