//! Illusions of motion: bursts of one event.

use super::super::{Places, Root, Score, Timed};
use super::{choice, jitter, no_files, note, pattern};
use crate::patch::{Action, Event, Events, Patch, Pattern, Place, TimeBase};
use crate::space::array::Array;
use crate::space::brush::Stroke;
use crate::space::path::{Path, Timing};
use crate::space::spot::Spot;
use crate::text::Problem;

/// 3 rows of 4 tactors, 1.5 m apart.
struct Grid(Array);

impl Places for Grid {
    fn spot(&mut self, place: Option<&Place>) -> Result<Spot, Problem> {
        match place {
            Some(Place::Position(point)) => Ok(Spot::Point(*point)),
            Some(Place::Channel(n)) => Ok(Spot::Row(*n)),
            Some(Place::Name(name)) => Err(Problem::of_file(format!("no {name}"))),
            _ => Ok(Spot::Row(0)),
        }
    }

    fn array(&self) -> Option<&Array> {
        Some(&self.0)
    }
}

fn grid() -> Array {
    let points: Vec<_> = (0..12).map(|n| [1.5 * f64::from(n % 4), 1.5 * f64::from(n / 4), 0.0]).collect();
    Array::new(&points).unwrap()
}

/// The events of one pattern, as a file has them.
fn events(written: &str) -> Vec<Event> {
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.a]\noutput = \"s\"\nvoices = 64\nnodes.s = {{ type = \"white\" }}\n\
         [pattern.p]\nevents = [{written}]\n"
    );
    let patch = Patch::parse("t.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    match patch.patterns.into_iter().next().unwrap().events {
        Events::Inline(events) => events,
        Events::File(..) => unreachable!(),
    }
}

fn played(patterns: Vec<Pattern>, seed: u64) -> Vec<Timed> {
    let patch = super::patch(patterns);
    let score = Score::of(&patch, Grid(grid()), &[Root::at(0, 0.0)], seed, no_files).unwrap();
    score.map(Result::unwrap).collect()
}

/// When each begins and how long it is, in ms.
fn spans(all: &[Timed]) -> Vec<(f64, f64)> {
    all.iter().map(|timed| (1e3 * timed.at, 1e3 * note(timed).duration)).collect()
}

fn near(a: &[(f64, f64)], b: &[(f64, f64)], within: f64) {
    assert_eq!(a.len(), b.len(), "{a:?} {b:?}");
    let close = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 - b.0).abs() < within && (a.1 - b.1).abs() < within;
    assert!(a.iter().zip(b).all(close), "{a:?} {b:?}");
}

/// Israr & Poupyrev's worked example.
const STROKE: &str = "{ at = 0.0, voice = \"a\", stroke = { path = [[1, 3], [4.5, 1]], over = 1.0 } }";
const PUBLISHED: [(f64, f64); 5] =
    [(0.0, 72.3918), (70.4654, 398.527), (245.294, 593.592), (482.543, 558.798), (708.659, 291.341)];

#[test]
fn a_stroke_is_the_published_one() {
    let all = played(vec![pattern("p", events(STROKE))], 0);
    near(&spans(&all), &PUBLISHED, 1e-3);
    let at = |timed: &Timed| match note(timed).place {
        Spot::Point(point) => point,
        other => panic!("{other:?}"),
    };
    let wanted = [[1.0, 3.0], [1.5, 2.714_285_714], [3.0, 1.857_142_857], [3.625, 1.5], [4.5, 1.0]];
    for (timed, wanted) in all.iter().zip(wanted) {
        let [x, y, z] = at(timed);
        assert!((x - wanted[0]).abs() < 1e-8 && (y - wanted[1]).abs() < 1e-8 && z == 0.0, "{:?}", at(timed));
    }
    assert!(all.iter().all(|timed| timed.event == 0 && timed.pattern == 0 && timed.drawn.is_none()));
    assert!(all.windows(2).all(|pair| pair[0].id + 1 == pair[1].id));
}

/// In beats, at a rate, twice: seconds stay seconds, and what lasts as long as its event counts in beats.
#[test]
fn a_stroke_takes_its_seconds_at_the_tempo_and_the_rate_of_its_pattern() {
    let stretched = "{ at = 1.0, voice = \"a\", duration = 2.0, stroke = { path = [[1, 3], [4.5, 1]] } }";
    for (written, begin) in [(STROKE.to_string(), 0.0), (stretched.to_string(), 0.5)] {
        let one = Pattern {
            // A beat is 1 s, and played at twice the speed half a second.
            time: TimeBase::Beats(60.0),
            rate: 2.0,
            ..pattern("p", events(&written))
        };
        let wanted: Vec<(f64, f64)> =
            PUBLISHED.iter().map(|(at, lasts)| (1e3 * begin + at, *lasts)).collect();
        near(&spans(&played(vec![one.clone()], 0)), &wanted, 1e-3);
        // Another that plays it faster has all of it faster.
        let outer = pattern("q", vec![super::event(0.0, super::nested("p", 1.0, 4.0))]);
        let quarter: Vec<(f64, f64)> = wanted.iter().map(|(at, lasts)| (at / 4.0, lasts / 4.0)).collect();
        near(&spans(&played(vec![outer, one], 0)), &quarter, 1e-3);
    }
}

#[test]
fn apparent_motion_and_the_rabbit_keep_their_times() {
    let apparent =
        "{ at = 0.5, voice = \"a\", level = 0.5, apparent = { places = [3, 1, [0, 1.5]], burst = 0.1 } }";
    let all = played(vec![pattern("p", events(apparent))], 0);
    near(&spans(&all), &[(500.0, 100.0), (579.3, 100.0), (658.6, 100.0)], 1e-9);
    let places: Vec<Spot> = all.iter().map(|timed| note(timed).place).collect();
    assert_eq!(places, [Spot::Row(3), Spot::Row(1), Spot::Point([0.0, 1.5, 0.0])]);
    assert!(all.iter().all(|timed| note(timed).level == 0.5));
    let whole = "{ at = 0, voice = \"a\", duration = 0.3379, apparent = { places = [1, 2, 3, 4] } }";
    near(
        &spans(&played(vec![pattern("p", events(whole))], 0)),
        &[0.0, 79.3, 158.6, 237.9].map(|at| (at, 100.0)),
        1e-9,
    );
    let rabbit =
        "{ at = 1, voice = \"a\", saltation = { places = [1, 2], taps = 3, interval = 0.06, tap = 0.004 } }";
    let all = played(vec![pattern("p", events(rabbit))], 0);
    near(&spans(&all), &[0.0, 60.0, 120.0, 180.0, 240.0, 300.0].map(|at| (1000.0 + at, 4.0)), 1e-9);
    let places: Vec<Spot> = all.iter().map(|timed| note(timed).place).collect();
    assert_eq!(places, [1, 1, 1, 2, 2, 2].map(Spot::Row));
}

/// What stands beside it goes on, in order of time.
#[test]
fn bursts_stand_among_other_events_and_repeat() {
    let beside = "{ at = 0.1, voice = \"a\", duration = 0.01, place = 9 }";
    let again = STROKE.replace("stroke", "repeat = { every = 0.5, times = 2 }, stroke");
    let all = played(vec![pattern("p", events(&format!("{beside}, {again}")))], 0);
    let mut wanted: Vec<(f64, f64)> =
        PUBLISHED.iter().flat_map(|&(at, d)| [(at, d), (at + 500.0, d)]).collect();
    wanted.push((100.0, 10.0));
    wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
    near(&spans(&all), &wanted, 1e-3);
}

/// All of it moves together, and its durations stay: they make the illusion.
#[test]
fn a_draw_moves_a_stroke_as_a_whole() {
    let written = STROKE.replace("at = 0.0", "at = 1.0");
    let drawn = Pattern {
        jitter: Some(jitter(0.5, &[("level", 0.5), ("duration", 0.9)])),
        ..pattern("p", events(&written))
    };
    let (mut begins, mut levels) = (Vec::new(), Vec::new());
    for seed in 0..5 {
        let all = played(vec![drawn.clone()], seed);
        let begin = 1e3 * all[0].at;
        let wanted: Vec<(f64, f64)> = PUBLISHED.iter().map(|(at, lasts)| (begin + at, *lasts)).collect();
        near(&spans(&all), &wanted, 1e-3);
        let level = note(&all[0]).level;
        assert!(all.iter().all(|timed| note(timed).level == level));
        begins.push(begin);
        levels.push(level);
    }
    assert!(begins.iter().all(|begin| (500.0..1500.0).contains(begin)) && begins[0] != begins[1]);
    assert!(levels[0] != levels[1]);
}

#[test]
fn a_choice_draws_a_stroke_whole() {
    let action = |written: &str| events(written).remove(0).action;
    let plain = action("{ at = 0, voice = \"a\", duration = 0.02 }");
    let both = choice(&[(1.0, plain), (1.0, action(STROKE))]);
    let mut seen = [0, 0];
    for seed in 0..40 {
        let all = played(vec![pattern("p", vec![super::event(0.0, both.clone())])], seed);
        let stroke = all[0].drawn == Some(1);
        assert_eq!(all.len(), if stroke { 5 } else { 1 });
        assert!(all.iter().all(|timed| timed.drawn == all[0].drawn));
        seen[usize::from(stroke)] += 1;
    }
    assert!(seen[0] > 5 && seen[1] > 5, "{seen:?}");
}

#[test]
fn its_length_is_known_and_what_is_stopped_ends() {
    let patch = super::patch(vec![pattern("p", events(STROKE))]);
    let of = |patch: &Patch| Score::of(patch, Grid(grid()), &[Root::at(0, 0.0)], 0, no_files);
    let mut score = of(&patch).unwrap();
    // The last but one burst is over after the last.
    assert!((score.length().unwrap() - 1.041_341).abs() < 1e-6);
    assert!(score.next().is_some() && score.plays(0));
    score.stop(0);
    assert!(score.next().is_none());
    // Where nobody knows the tactors, it is as long.
    let blind = Score::new(&patch, |_| Ok(Spot::Row(0)), &[(0, 0.0)], 0, no_files).unwrap();
    assert_eq!(blind.length(), Some(1.0));
    assert_eq!(blind.count(), 1);
}

#[test]
fn what_cannot_be_played_says_why() {
    let refused = |written: &str| {
        let patch = super::patch(vec![pattern("p", events(written))]);
        Score::of(&patch, Grid(grid()), &[Root::at(0, 0.0)], 0, no_files).err().expect("a problem")
    };
    let fast = refused("{ at = 0, voice = \"a\", duration = 0.03, stroke = { path = [[0, 0], [1, 0]] } }");
    assert!(fast.what.contains("`stroke` of voice `a`") && fast.span.is_some(), "{fast:?}");
    let short = refused("{ at = 0, voice = \"a\", duration = 0.1, apparent = { places = [1, 2, 3, 4] } }");
    assert!(short.what.contains("`apparent` of voice `a`"), "{short:?}");
    assert!(refused("{ at = 0, voice = \"a\", saltation = { places = [1, \"x\"] } }").what.contains("no x"));
}

/// What a stroke of any path comes to is what the brush says of it.
#[test]
fn a_stroke_is_that_of_the_brush() {
    let array = grid();
    for (points, seconds) in
        [([[0.1, 0.2, 0.0], [4.4, 2.9, 0.0]], 0.8), ([[4.5, 3.0, 0.0], [-1.0, 0.0, 0.0]], 3.0)]
    {
        let path = Path::new(&points, seconds, Timing::Linear).unwrap();
        let stroke = Stroke::new(&array, &path).unwrap();
        let [a, b] = points.map(|[x, y, _]| format!("[{x}, {y}]"));
        let written =
            format!("{{ at = 0, voice = \"a\", stroke = {{ path = [{a}, {b}], over = {seconds:?} }} }}");
        let all = played(vec![pattern("p", events(&written))], 0);
        let wanted: Vec<(f64, f64)> =
            stroke.bursts.iter().map(|b| (1e3 * b.start, 1e3 * b.seconds())).collect();
        near(&spans(&all), &wanted, 1e-9);
        assert!(matches!(all[0].what, super::What::Play(_)));
    }
}

/// That a plain event is read as one.
#[test]
fn a_plain_event_has_no_motion() {
    let plain = events("{ at = 0, voice = \"a\", place = 3 }");
    assert!(matches!(&plain[0].action, Action::Voice(play) if play.motion.is_none()));
}

#[test]
fn a_voice_that_asks_hears_which_burst_it_is() {
    let mut patch = super::patch(vec![
        pattern("q", vec![super::event(1.0, super::nested("p", 1.0, 2.0))]),
        pattern("p", events(STROKE)),
    ]);
    patch.voices[0].fields.extend([("burst".into(), 7.0), ("since".into(), 7.0), ("other".into(), 7.0)]);
    let names: Vec<&str> = patch.voices[0].fields.iter().map(|(name, _)| name.as_str()).collect();
    let slot = |wanted: &str| names.iter().position(|name| *name == wanted).unwrap();
    let (burst, since, other) = (slot("burst"), slot("since"), slot("other"));
    let score = Score::of(&patch, Grid(grid()), &[Root::at(0, 0.0)], 0, no_files).unwrap();
    for (k, timed) in score.map(Result::unwrap).enumerate() {
        let own = note(&timed).own;
        // In seconds as they pass, however fast it is played.
        assert!((own[since] - (timed.at - 1.0)).abs() < 1e-12 && (own[burst], own[other]) == (k as f64, 7.0));
        assert!((own[since] - 0.5e-3 * PUBLISHED[k].0).abs() < 1e-6);
    }
}
