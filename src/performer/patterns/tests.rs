use super::super::staged::{self, HEAD, VOICE};
use super::super::whence::Whence;
use super::{AT_ONCE, MOST_RUNS, Outlet, Performer, When};
use crate::engine::event::{Event, Source};
use crate::schedule::Instant;

/// Keeps what it is sent: when, and how loud. It has endless room.
#[derive(Default)]
struct Kept(u64, Vec<(f64, f64)>);

impl Outlet for Kept {
    fn clock(&self) -> u64 {
        self.0
    }
    fn room(&self, _: Source) -> usize {
        1 << 20
    }
    fn send(&mut self, at: Instant, _: Source, event: Event) -> bool {
        if let Event::Play(play) = event {
            self.1.push((at.since(Instant::default()) / 8000.0, play.level));
        }
        true
    }
}

fn performer(patterns: &str) -> Performer {
    staged::performer(&format!("{HEAD}{VOICE}{patterns}"), 1)
}

fn saved(performer: &mut Performer, patterns: &str) {
    staged::save(performer, &format!("{HEAD}{VOICE}{patterns}"), 1);
}

const QUIET: &str = "[pattern.none]\nevents = [{ at = 0, voice = \"v\", level = 0.5 }]\n";

fn pattern(name: &str, every: f64, level: f64) -> String {
    format!(
        "[pattern.{name}]\nrepeat = {{ every = {every} }}\nevents = [{{ at = 0, voice = \"v\", level = {level} }}]\n"
    )
}

/// Hours later, ids begin anew: what is stopped then stops nothing that has played since.
#[test]
fn a_run_that_plays_on_keeps_its_ids() {
    let mut performer = performer(&format!("{QUIET}{}", pattern("p", 1.0, 1.0)));
    let at = When::of_seconds(0.5, 8000.0);
    let long = performer.start_pattern(at, "p").unwrap();
    let ids = |serial| Whence::HERE.of_run(serial, 0);
    let same = (long + 1..).find(|serial| ids(*serial) == ids(long)).unwrap();
    performer.started = same - 2;
    let after: Vec<u64> = (0..3).map(|_| performer.start_pattern(at, "p").unwrap()).collect();
    assert_eq!(after, [same - 1, same + 1, same + 2]);
    assert!(after.iter().all(|serial| ids(*serial) != ids(long)));
}

#[test]
fn too_many_patterns_are_turned_away_in_words_and_counted() {
    let mut performer = performer(&format!("{QUIET}{}", pattern("p", 1.0, 1.0)));
    let before = performer.patterns().count();
    let at = When::of_seconds(0.5, 8000.0);
    let mut last = 0;
    let mut refused = 0;
    for _ in 0..2000 {
        match performer.start_pattern(at, "p") {
            Ok(serial) => last = serial,
            Err(problem) => {
                assert!(problem.what.contains("256 patterns play already"), "{problem}");
                assert!(problem.help.is_some());
                refused += 1;
            }
        }
    }
    let playing = performer.patterns().count() - before;
    assert!(playing <= MOST_RUNS && playing + 1 >= MOST_RUNS, "{playing}");
    assert_eq!(performer.take_turned_away(), refused);
    assert_eq!((refused as usize + playing, performer.take_turned_away()), (2000, 0));
    // Where one goes, there is room for one.
    assert!(performer.stop_pattern(When::of_seconds(0.0, 8000.0), last, &mut Kept::default()));
    assert!(performer.start_pattern(at, "p").is_ok());
    assert!(performer.start_pattern(at, "p").is_err());
}

/// Two that begin by themselves, and one whose repetitions are too close to get anywhere: it ends, is told of each time, and nothing else does.
#[test]
fn a_pattern_that_does_not_get_on_ends_alone_and_is_told_of_each_time() {
    let bad = "[pattern.bad]\nrepeat = { every = 1e-6 }\nevents = [{ at = 30, voice = \"v\" }]\n\
        [pattern.other]\nrepeat = { every = 1e-6 }\nevents = [{ at = 30, voice = \"v\" }]\n";
    let start = "[[trigger]]\non = \"start\"\nplay = \"p\"\n[[trigger]]\non = \"start\"\nplay = \"bad\"\n";
    let (mut performer, mut kept) =
        (performer(&format!("{}{bad}{start}", pattern("p", 0.5, 1.0))), Kept::default());
    // It is after two seconds that too many of its events wait.
    assert_eq!(performer.feed(24_000, &mut kept), None);
    assert_eq!(kept.1.iter().map(|(at, _)| *at).collect::<Vec<_>>(), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
    let told = |performer: &mut Performer| -> Vec<String> {
        performer.take_troubles().into_iter().map(|(problem, _)| problem.what).collect()
    };
    assert!(matches!(&told(&mut performer)[..], [one] if one.contains("pattern `bad`")));
    for name in ["other", "bad"] {
        performer.start_pattern(When::of_seconds(2.0, 8000.0), name).unwrap();
        performer.feed(40_000, &mut kept);
        assert!(matches!(&told(&mut performer)[..], [one] if one.contains(&format!("pattern `{name}`"))));
    }
    assert_eq!(performer.patterns().map(|(_, name)| name).collect::<Vec<_>>(), ["p"]);
    assert!(performer.trouble().unwrap().what.contains("`bad`"), "the first");
}

/// Forty deep, each of which plays the next without end and at once: millions of steps until it gives up.
#[test]
fn what_takes_many_steps_keeps_nobody_waiting() {
    let deep: String = (0..40)
        .map(|n| {
            let every = "repeat = { every = 1e-6, times = 1000000000 }";
            format!("[pattern.p{n}]\nevents = [{{ at = 0, pattern = \"p{}\", {every} }}]\n", n + 1)
        })
        .collect();
    let last = "[pattern.p40]\nevents = [{ at = 1, voice = \"v\" }]\n";
    let start = "[[trigger]]\non = \"start\"\nplay = \"p\"\n";
    let text = format!("{}{deep}{last}{start}", pattern("p", 0.25, 1.0));
    let (mut performer, mut kept) = (performer(&text), Kept::default());
    let serial = performer.start_pattern(When::of_seconds(0.0, 8000.0), "p0").unwrap();
    for turn in 1..=10 {
        assert!(!performer.feed_some(2000 * turn, &mut kept), "it is on its way");
        assert_eq!(kept.1.len() as u64, turn, "the other goes on");
    }
    assert!(performer.plays(serial));
    assert!(performer.stop_pattern(When::of_seconds(0.0, 8000.0), serial, &mut kept));
    assert!(performer.feed_some(22_000, &mut kept) && performer.take_troubles().is_empty());
}

/// However much there is, little is done at once, and in the end the same as if it had been done at once.
#[test]
fn what_is_fed_in_parts_is_what_is_fed_at_once() {
    let text = format!("{}{}", pattern("a", 0.0001, 1.0), pattern("b", 0.00013, 0.5));
    let play = |parts: bool| {
        let (mut performer, mut kept) = (performer(&text), Kept::default());
        performer.start_pattern(When::of_seconds(0.01, 8000.0), "b").unwrap();
        let mut calls = 0;
        if parts {
            loop {
                let before = kept.1.len();
                let done = performer.feed_some(8000, &mut kept);
                assert!(kept.1.len() - before <= AT_ONCE);
                calls += 1;
                if done {
                    break;
                }
            }
        } else {
            assert_eq!(performer.feed(8000, &mut kept), None);
        }
        (kept.1, calls)
    };
    let ((all, _), (parts, calls)) = (play(false), play(true));
    assert!(all.len() > 17_000 && calls > 30, "{} in {calls}", all.len());
    assert_eq!(all, parts);
}

/// A pattern that has long been playing when its file is saved takes its place little by little, and nothing else waits for it.
#[test]
fn what_has_much_to_leave_out_keeps_nobody_waiting() {
    let mut performer = performer(&pattern("a", 0.001, 1.0));
    let mut kept = Kept::default();
    performer.feed(80_000, &mut kept);
    kept.0 = 80_000;
    saved(&mut performer, &pattern("a", 0.001, 0.5));
    performer.start_pattern(When::of_seconds(10.0, 8000.0), "a").unwrap();
    kept.1.clear();
    let mut calls = 0;
    // It has 10,000 to leave out, and time goes on meanwhile.
    while !performer.feed_some(kept.0 + 400, &mut kept) {
        kept.0 += 8;
        calls += 1;
    }
    assert!(calls >= 10_000 / AT_ONCE, "{calls}");
    performer.feed(81_600, &mut kept);
    // Of each millisecond: what was started meanwhile, and from some time on both.
    let mut of_each = [0; 200];
    for (at, level) in &kept.1 {
        assert_eq!(*level, 0.5);
        of_each[((at - 10.0) * 1000.0).round() as usize] += 1;
    }
    let both = of_each.iter().position(|count| *count == 2).unwrap();
    assert!((calls - 1..calls + 2).contains(&both), "{both} after {calls}");
    assert!(of_each[..both].iter().all(|count| *count == 1), "{of_each:?}");
    assert!(of_each[both..].iter().all(|count| *count == 2), "{of_each:?}");
}

/// A pattern that has said all, and whose voice still sounds when its file is saved, is taken up with little work and waited for no more.
#[test]
fn what_only_sounds_on_keeps_nobody_waiting() {
    let text = |level: f64| {
        format!(
            "[[trigger]]\non = \"start\"\nplay = \"a\"\n[[trigger]]\non = \"start\"\nplay = \"b\"\n\
             [pattern.a]\nrepeat = {{ every = 0.001, times = 600 }}\nevents = [{{ at = 0, voice = \"v\", level = {level} }}]\n\
             [pattern.b]\nevents = [{{ at = 0, voice = \"v\", level = {level}, duration = 100 }}]\n"
        )
    };
    let (mut performer, mut kept) = (performer(&text(1.0)), Kept::default());
    performer.feed(16_000, &mut kept);
    kept.0 = 16_000;
    saved(&mut performer, &text(0.5));
    assert!((0..10).any(|_| performer.feed_some(kept.0 + 400, &mut kept)), "it comes to its end");
    let playing: Vec<_> = performer.patterns().map(|(_, name)| name.to_string()).collect();
    assert_eq!((playing, performer.is_over()), (vec!["b".to_string()], true));
}
