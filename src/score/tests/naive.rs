//! The score against a naive one: everything written out at once by recursion, then sorted. All numbers are sums of few
//! powers of two, so both must agree to the bit.

use crate::space::spot::Spot;
use proptest::prelude::{BoxedStrategy, Just, Strategy, any, prop, prop_oneof, proptest};

use super::{event, nested, patch, pattern, score, voice};
use crate::patch::{Action, Event, Events, Patch, Place, Repeat, TimeBase};
use crate::score::{FIELDS, Note, What};

struct Naive<'a> {
    patch: &'a Patch,
    out: Vec<(f64, Vec<u64>, usize, What)>,
}

impl Naive<'_> {
    fn play(&mut self, index: usize, start: f64, rate: f64, gain: f64, path: &[u64]) {
        let pattern = &self.patch.patterns[index];
        let (rate, gain) = (rate * pattern.rate, gain * pattern.gain);
        let unit = match pattern.time {
            TimeBase::Seconds => 1.0,
            TimeBase::Beats(tempo) => 60.0 / tempo,
        };
        let Events::Inline(events) = &pattern.events else { unreachable!() };
        let once = Repeat { every: 1.0, times: Some(1) };
        let repeat = pattern.repeat.unwrap_or(once);
        for round in 0..repeat.times.unwrap() {
            let start = start + round as f64 * repeat.every * unit / rate;
            for (i, e) in events.iter().enumerate() {
                let repeat = e.repeat.unwrap_or(once);
                for k in 0..repeat.times.unwrap() {
                    let at = start + (e.at + e.delay + k as f64 * repeat.every) * unit / rate;
                    let path = [path, &[round, i as u64, k]].concat();
                    match &e.action {
                        Action::Pattern { pattern, gain: g, rate: r, .. } => {
                            let inner = self.patch.patterns.iter().position(|p| p.name == *pattern).unwrap();
                            self.play(inner, at, rate * r, gain * g, &path);
                        }
                        Action::Marker(name) => {
                            self.out.push((at, path, index, What::Marker(name.as_str().into())))
                        }
                        Action::Voice(play) => {
                            let voice = self.patch.voices.iter().position(|v| v.name == play.voice).unwrap();
                            let v = &self.patch.voices[voice];
                            let mut own = [0.0; FIELDS];
                            for (slot, (name, default)) in own.iter_mut().zip(&v.fields) {
                                let given = play.fields.iter().find(|s| s.name == *name);
                                *slot = given.map_or(*default, |s| s.value);
                            }
                            let place = match play.place.as_ref().or(v.place.as_ref()) {
                                Some(Place::Channel(n)) => *n,
                                _ => 0,
                            };
                            let level = play.level.unwrap_or(v.level) * gain;
                            let duration = play.duration.unwrap_or(v.duration) * unit / rate;
                            let note =
                                Note { voice, level, felt: None, duration, place: Spot::Row(place), own };
                            self.out.push((at, path, index, What::Play(note)));
                        }
                        Action::Choose(_) => unreachable!(),
                    }
                }
            }
        }
    }
}

fn eighths(most: u32) -> impl Strategy<Value = f64> {
    (0..=most).prop_map(|n| f64::from(n) / 8.0)
}

fn power() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.5), Just(1.0), Just(2.0)]
}

fn repeats() -> impl Strategy<Value = Option<Repeat>> {
    let some =
        (eighths(10), 1..4_u64).prop_map(|(every, n)| Some(Repeat { every: every + 0.125, times: Some(n) }));
    prop_oneof![3 => Just(None), 1 => some]
}

const NAMES: [&str; 4] = ["p", "q", "r", "s"];

fn action(pattern: usize) -> BoxedStrategy<Action> {
    let plain = voice("a", None, None, &[]);
    let level = eighths(16).prop_map(|l| voice("b", Some(l), None, &[("frequency", 40.0)]));
    let duration = eighths(40).prop_map(|d| voice("b", None, Some(d), &[("depth", 9.0)]));
    let placed = (1..20_u32).prop_map(|n| match voice("b", None, None, &[]) {
        Action::Voice(mut play) => {
            play.place = Some(Place::Channel(n));
            Action::Voice(play)
        }
        other => other,
    });
    let leaf = prop_oneof![Just(plain), level, duration, placed, Just(Action::Marker("m".into()))];
    if pattern + 1 == NAMES.len() {
        return leaf.boxed();
    }
    let inner = (pattern + 1..NAMES.len(), power(), power()).prop_map(|(p, g, r)| nested(NAMES[p], g, r));
    prop_oneof![2 => leaf, 1 => inner].boxed()
}

fn events(pattern: usize) -> impl Strategy<Value = Vec<Event>> {
    let one = (eighths(24), prop_oneof![3 => Just(0.0), 1 => eighths(24)], repeats(), action(pattern));
    let one = one.prop_map(|(at, delay, repeat, action)| Event { delay, repeat, ..event(at, action) });
    prop::collection::vec(one, 0..6)
}

pub(super) fn patches() -> impl Strategy<Value = Patch> {
    let one = |i: usize| {
        let tempo =
            prop_oneof![Just(TimeBase::Seconds), Just(TimeBase::Beats(120.0)), Just(TimeBase::Beats(30.0))];
        (events(i), tempo, repeats(), power(), power()).prop_map(move |(events, time, repeat, gain, rate)| {
            crate::patch::Pattern { time, repeat, gain, rate, ..pattern(NAMES[i], events) }
        })
    };
    (one(0), one(1), one(2), one(3)).prop_map(|(p, q, r, s)| patch(vec![p, q, r, s]))
}

proptest! {
    #[test]
    fn what_is_played_is_what_is_written(patch in patches(), second in eighths(40), seed in any::<u64>()) {
        let roots = [(0, 0.0), (1, second), (0, 0.0)];
        let mut naive = Naive { patch: &patch, out: Vec::new() };
        for (number, (index, start)) in (0..).zip(roots) {
            naive.play(index, start, 1.0, 1.0, &[number]);
        }
        let mut expected = naive.out;
        expected.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
        let score = score(&patch, &roots, seed).unwrap();
        let length = score.length().unwrap();
        let played: Vec<_> = score.map(Result::unwrap).collect();
        assert_eq!(played.len(), expected.len());
        let mut end = 0.0_f64;
        for (i, (is, (at, path, pattern, what))) in played.iter().zip(&expected).enumerate() {
            assert_eq!((is.at, is.id, is.pattern, is.event), (*at, i as u64, *pattern, path[path.len() - 2]));
            assert_eq!(&is.what, what);
            assert_eq!(is.drawn, None);
            end = end.max(at + if let What::Play(note) = what { note.duration } else { 0.0 });
        }
        assert_eq!(length, end);
    }
}
