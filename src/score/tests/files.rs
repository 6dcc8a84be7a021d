//! Events files.

use std::io::{BufRead, BufReader, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::{beat, event, every, nested, output, patch, pattern, times, voice};
use crate::patch::{Event, Events, Patch, Pattern};
use crate::score::{EventStream, MOST_HELD, Score};
use crate::text::Problem;

/// Lines `at,delay,voice`.
fn read(lines: impl BufRead + Send + 'static) -> EventStream<'static> {
    Box::new(lines.lines().map(|line| -> Result<Event, Problem> {
        let line = line.map_err(|e| Problem::of_file(e.to_string()))?;
        let mut cells = line.split(',');
        let mut number =
            || cells.next().and_then(|c| c.parse().ok()).ok_or(Problem::of_file(format!("bad line {line}")));
        let (at, delay) = (number()?, number()?);
        Ok(Event { delay, ..event(at, voice(cells.next().unwrap_or(""), None, None, &[])) })
    }))
}

fn file(name: &str) -> Pattern {
    Pattern { events: Events::File("f.csv".into(), 5..9), ..pattern(name, Vec::new()) }
}

fn play(patch: &Patch, text: &'static str) -> Result<Vec<crate::score::Timed>, Problem> {
    Score::new(patch, output, &[(0, 0.0)], 0, move |_| Ok(read(text.as_bytes())))?.collect()
}

#[test]
fn a_file_plays_as_if_it_stood_in_the_patch() {
    let text = "1,0.25,a\n0,0,a\n0.5,3,b\n1,0,b\n";
    let inline = [(1.0, 0.25, "a"), (0.0, 0.0, "a"), (0.5, 3.0, "b"), (1.0, 0.0, "b")];
    let inline = inline.map(|(at, delay, v)| Event { delay, ..event(at, voice(v, None, None, &[])) });
    for (shuffle, spread) in [(false, 0.0), (true, 0.0), (false, 1.0), (true, 1.0)] {
        let change = |p: Pattern| {
            let jitter = Some(super::jitter(spread, &[("level", 0.5)]));
            patch(vec![Pattern { shuffle, jitter, repeat: every(0.75, 5), ..p }])
        };
        let there = play(&change(file("p")), text).unwrap();
        assert_eq!(there, super::all(&change(pattern("p", inline.to_vec())), 0));
        assert_eq!(there.len(), 20);
    }
}

/// A million lines made as they are read; says how many bytes have been.
struct Endless {
    line: u64,
    left: Vec<u8>,
    read: Arc<AtomicUsize>,
}

impl Read for Endless {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        if self.left.is_empty() && self.line < 1_000_000 {
            // Every tenth is late by 2, which is 20 lines.
            let delay = if self.line.is_multiple_of(10) { 2.0 } else { 0.0 };
            self.left = format!("{},{delay},a\n", self.line as f64 / 8.0).into_bytes();
            self.line += 1;
        }
        let n = self.left.len().min(to.len());
        to[..n].copy_from_slice(&self.left[..n]);
        self.left.drain(..n);
        self.read.fetch_add(n, Ordering::Relaxed);
        Ok(n)
    }
}

#[test]
fn a_long_file_streams() {
    let (bytes, opened) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    let (read_bytes, opens) = (bytes.clone(), opened.clone());
    let open = move |path: &str| {
        assert_eq!(path, "f.csv");
        opens.fetch_add(1, Ordering::Relaxed);
        let lines = Endless { line: 0, left: Vec::new(), read: read_bytes.clone() };
        Ok(read(BufReader::with_capacity(256, lines)))
    };
    let p = Pattern { repeat: every(100_000.0, 2), ..file("p") };
    let mut score = Score::new(&patch(vec![p]), output, &[(0, 0.0)], 0, open).unwrap();
    assert_eq!(score.length(), None);
    assert_eq!(bytes.load(Ordering::Relaxed), 0, "a file is opened when it is played");
    let (mut last, mut count, mut late) = (0.0, 0, 0);
    for timed in &mut score {
        let timed = timed.unwrap();
        assert!(timed.at >= last);
        last = timed.at;
        count += 1;
        let unmoved = timed.event as f64 / 8.0;
        late += usize::from((timed.at - unmoved).rem_euclid(100_000.0) == 2.0);
        if count == 100_000 {
            let most = (100_000 + MOST_HELD + 100) * 16 + 512;
            assert!(bytes.load(Ordering::Relaxed) < most, "no more is read than is needed");
        }
    }
    assert_eq!((count, late), (2_000_000, 200_000));
    assert_eq!(opened.load(Ordering::Relaxed), 2);
}

#[test]
fn a_short_file_is_read_once() {
    let opened = Arc::new(AtomicUsize::new(0));
    let opens = opened.clone();
    let open = move |_: &str| {
        opens.fetch_add(1, Ordering::Relaxed);
        Ok(read("0,0,a\n".as_bytes()))
    };
    let patch = patch(vec![Pattern { repeat: every(1.0, 1000), ..file("p") }]);
    assert_eq!(Score::new(&patch, output, &[(0, 0.0)], 0, open).unwrap().count(), 1000);
    assert_eq!(opened.load(Ordering::Relaxed), 1);
}

#[test]
fn what_a_long_file_holds_back_is_bounded() {
    let open = |_: &str| {
        let lines = Endless { line: 0, left: Vec::new(), read: Arc::default() };
        Ok(read(BufReader::new(lines)))
    };
    let mut score = Score::new(&patch(vec![file("p")]), output, &[(0, 0.0)], 0, open).unwrap();
    for _ in 0..200_000 {
        score.next().unwrap().unwrap();
        assert!(score.under_way() <= 4, "{}", score.under_way());
    }
}

#[test]
fn bad_lines_are_named() {
    let p = || patch(vec![file("p")]);
    let what = |text| play(&p(), text).unwrap_err();
    assert!(what("0,0,a\nx,0,a\n").what.contains("bad line x"));
    assert!(what("0,0,a\n0,0,a\n0,0,zz\n").what.contains("event 3: there is no voice `zz`"));
    assert!(what("NaN,0,a\n").what.contains("event 1: `at`"));
    assert!(what("0,-1,a\n").what.contains("`delay`"));
    let missing =
        Score::new(&p(), output, &[(0, 0.0)], 0, super::no_files).unwrap().next().unwrap().unwrap_err();
    assert_eq!((missing.what.as_str(), missing.span), ("no f.csv", Some(5..9)));
}

#[test]
fn what_comes_before_a_bad_line_of_a_long_file_is_played() {
    let lines = (0..2 * MOST_HELD)
        .map(|i| if i == 2 * MOST_HELD - 1 { Err(Problem::of_file("bad")) } else { Ok(beat(1.0)) });
    let score =
        Score::new(
            &patch(vec![file("p")]),
            output,
            &[(0, 0.0)],
            0,
            move |_| Ok(Box::new(lines.clone()) as _),
        );
    let mut score = score.unwrap();
    let good = score.by_ref().take_while(Result::is_ok).count();
    assert_eq!(good, 2 * MOST_HELD - 1);
    assert!(score.next().is_none(), "after an error it ends");
}

/// Plays a file of twice as many lines as can be held, one a second, of which one is late by so many lines.
fn late_by(lines: usize) -> Vec<Result<crate::score::Timed, Problem>> {
    let n = 2 * MOST_HELD;
    let at = move |i: usize| match i {
        _ if i == n - 10 => n - 10 - lines,
        _ if i >= n - 10 - lines && i < n - 10 => i + 1,
        _ => i,
    };
    let open =
        move |_: &str| Ok(Box::new((0..n).map(move |i| Ok(beat(at(i) as f64)))) as EventStream<'static>);
    Score::new(&patch(vec![file("p")]), output, &[(0, 0.0)], 0, open).unwrap().collect()
}

#[test]
fn lines_of_a_long_file_may_be_a_window_late() {
    let played = late_by(MOST_HELD);
    assert_eq!(played.len(), 2 * MOST_HELD);
    for (i, timed) in played.iter().enumerate() {
        assert_eq!(timed.as_ref().unwrap().at, i as f64);
    }
    // One more: all before it is played, then it is named.
    let played = late_by(MOST_HELD + 1);
    let (last, good) = played.split_last().unwrap();
    assert_eq!(good.len(), 2 * MOST_HELD - 10);
    assert!(good.iter().all(Result::is_ok));
    let problem = last.as_ref().unwrap_err();
    assert!(problem.what.starts_with("f.csv, event 131063: `at` is 65525, but"), "{}", problem.what);
    assert_eq!(problem.span, Some(5..9));
}

#[test]
fn a_long_file_cannot_be_shuffled() {
    let open = |_: &str| Ok(Box::new((0..=MOST_HELD).map(|_| Ok(beat(0.0)))) as EventStream<'static>);
    let patch = patch(vec![Pattern { shuffle: true, ..file("p") }]);
    let problem = Score::new(&patch, output, &[(0, 0.0)], 0, open).unwrap().next().unwrap().unwrap_err();
    assert!(problem.what.contains("cannot shuffle more than 65536"), "{}", problem.what);
}

#[test]
fn an_empty_file_ends_even_what_repeats_it_for_ever() {
    let outer = |deed| Pattern { repeat: every(1e-6, None), ..pattern("p", vec![event(0.0, deed)]) };
    let mut again = event(0.0, nested("f", 1.0, 1.0));
    again.repeat = every(1e-6, None);
    for first in [
        outer(nested("f", 1.0, 1.0)),
        pattern("p", vec![again]),
        Pattern { repeat: every(1e-6, None), ..file("p") },
    ] {
        assert_eq!(play(&patch(vec![first, file("f")]), "").unwrap(), []);
    }
}

#[test]
fn a_file_that_plays_its_own_pattern_is_stopped() {
    let open =
        |_: &str| Ok(Box::new([Ok(event(0.0, nested("p", 1.0, 1.0)))].into_iter()) as EventStream<'static>);
    let problem = Score::new(&patch(vec![file("p")]), output, &[(0, 0.0)], 0, open)
        .unwrap()
        .next()
        .unwrap()
        .unwrap_err();
    assert!(problem.what.contains("more than 64 patterns deep"), "{}", problem.what);
}

#[test]
fn files_may_play_patterns_that_nothing_else_names() {
    let open =
        |_: &str| Ok(Box::new([Ok(event(1.0, nested("q", 1.0, 2.0)))].into_iter()) as EventStream<'static>);
    let patch = patch(vec![file("p"), pattern("q", vec![beat(1.0)])]);
    let played: Vec<_> =
        Score::new(&patch, output, &[(0, 0.0)], 0, open).unwrap().map(Result::unwrap).collect();
    assert_eq!(times(&played), [1.5]);
}

#[test]
fn a_patch_and_its_events_file_play_as_written() {
    let text = br#"
format = "pacinian-patch/1"
title = "Two"
[voice.a]
output = "tone"
defaults = { depth = 2.0 }
[voice.a.nodes]
tone = { type = "sine", frequency = "event.frequency" }
[pattern.p]
time = "beats"
tempo = 60
events = "f.csv"
repeat = { every = 4.0, times = 2 }
"#;
    let patch = Patch::parse("two.toml", text).unwrap_or_else(|p| panic!("{p}")).value;
    let open = |path: &str| {
        let lines = "at,voice,level,frequency\n1,a,0.5,60\n# later\n0.5,a,,\n";
        Ok(Box::new(crate::patch::EventsFile::new(path, lines.as_bytes(), None)?) as EventStream<'static>)
    };
    let played: Vec<_> =
        Score::new(&patch, output, &[(0, 0.0)], 0, open).unwrap().map(Result::unwrap).collect();
    assert_eq!(times(&played), [0.5, 1.0, 4.5, 5.0]);
    let played: Vec<_> = played.iter().map(|t| (super::note(t).level, super::note(t).own[0])).collect();
    assert_eq!(played, [(1.0, 250.0), (0.5, 60.0), (1.0, 250.0), (0.5, 60.0)]);
}
