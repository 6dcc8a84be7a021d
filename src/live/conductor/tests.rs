use std::sync::{Arc, Mutex};

use super::{Audience, Board, Conductor, Origin, Report, Signal, Stamped, Told};
use crate::engine::event::Event;
use crate::engine::exchange::exchange;
use crate::graph::scene::{Options, Scene, scene};
use crate::live::callback::{Callback, Deed};
use crate::live::clock::Follower;
use crate::live::gate::Gate;
use crate::live::reload::Reload;
use crate::live::stamp::{Epoch, Stamp};
use crate::node::asset::NoAssets;
use crate::patch::Patch;
use crate::performer::{Note, Performer};
use crate::rig::Rig;
use crate::text::Problem;

/// A voice of each name, in this order.
fn compiled(voices: &[&str]) -> (Scene, Arc<Patch>, Arc<Rig>) {
    compiled_with(voices, "")
}

/// The same, and what else the file says.
fn compiled_with(voices: &[&str], rest: &str) -> (Scene, Arc<Patch>, Arc<Rig>) {
    let mut text = String::from("format = \"pacinian-patch/1\"\ntitle = \"t\"\n");
    for name in voices {
        text += &format!(
            "[voice.{name}]\noutput = \"o\"\n[voice.{name}.nodes]\ns = {{ type = \"sine\", frequency = 100 }}\n\
             e = {{ type = \"envelope\", release = 0.01 }}\no = {{ type = \"multiply\", inputs = [\"s\", \"e\"] }}\n"
        );
    }
    text += rest;
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::default_for(1);
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    (scene, Arc::new(patch), Arc::new(rig))
}

fn reload(voices: &[&str]) -> Box<Reload> {
    let (scene, patch, rig) = compiled(voices);
    Box::new(Reload {
        scene,
        patch,
        rig,
        files: Box::new(|_| Err(Problem::of_file("none"))),
        provenance: None,
    })
}

/// A session whose device asks for 96 frames whenever the test says so, every 2 ms.
struct Bench {
    conductor: Conductor,
    callback: Callback,
    follower: Follower,
    reports: Arc<Mutex<Vec<Report>>>,
    blocks: u64,
}

impl Bench {
    fn new(voices: &[&str]) -> Self {
        Self::of(compiled(voices))
    }

    fn of((scene, patch, rig): (Scene, Arc<Patch>, Arc<Rig>)) -> Self {
        let (director, stagehand) = exchange(&scene.plan).unwrap();
        let files = Box::new(|_: &str| Err(Problem::of_file("none")));
        let performer = Performer::new(scene, patch, rig, files).unwrap();
        let board = Arc::new(Board::new(1));
        let (callback, rings) = Callback::new(stagehand, Gate::new(48_000.0, 1.0), Arc::clone(&board));
        let (follower, clock) = Follower::new(48_000.0, 96);
        let reports = Arc::<Mutex<Vec<Report>>>::default();
        let heard = Arc::clone(&reports);
        let audience: Audience = Box::new(move |told| {
            if let Told::Report(report, _) = told {
                heard.lock().unwrap().push(*report);
            }
        });
        let (mut conductor, _) =
            Conductor::new(performer, director, rings, clock, Epoch::begin(), &board, audience);
        conductor.begin();
        let mut bench = Self { conductor, callback, follower, reports, blocks: 0 };
        (0..500).for_each(|_| bench.block());
        bench
    }

    /// Nanoseconds at which the next block is asked for.
    fn next(&self) -> u64 {
        self.blocks * 2_000_000
    }

    fn block(&mut self) {
        self.follower.callback(Stamp(self.next()), 96);
        self.callback.process(&[], &mut [0.0; 96]);
        self.blocks += 1;
    }

    fn take(&mut self, nanoseconds: u64, signal: Signal) {
        self.conductor.take(Stamped { stamp: Stamp(nanoseconds), origin: Origin::Program, signal });
    }

    /// The voices that were played: instant in frames, due and effective, and instrument.
    fn played(&mut self) -> Vec<(f64, f64, u32)> {
        self.conductor.go_on();
        let frames = |at: crate::schedule::Instant| at.since(crate::schedule::Instant::default()) * 6.0;
        let play = |report: &Report| match &report.deed {
            Deed::Event { at, due, event: Event::Play(play), .. } => {
                Some((frames(*due), frames(*at), play.instrument))
            }
            _ => None,
        };
        self.reports.lock().unwrap().iter().filter_map(play).collect()
    }
}

#[test]
fn what_arrives_within_a_block_is_played_a_block_later_to_the_sample() {
    let mut bench = Bench::new(&["a"]);
    let mut expected = Vec::new();
    for n in 0..40_u64 {
        // Between the callback that came last and the next.
        let offset = 49_999 * n;
        let arrived = bench.next() - 2_000_000 + offset;
        bench.take(arrived, Signal::Play(n, "a".into(), Note::default()));
        let first = (bench.blocks - 1) * 96;
        expected.push(first as f64 + 96.0 + offset as f64 * 48e-6);
        bench.block();
    }
    let played = bench.played();
    assert_eq!(played.len(), 40);
    for ((due, at, _), expected) in played.iter().zip(expected) {
        assert!((due - expected).abs() < 0.1 && due == at, "{due}, {at} for {expected}");
    }
}

#[test]
fn what_is_meant_for_a_plan_reaches_that_plan() {
    let mut bench = Bench::new(&["a", "b"]);
    // The other way round, so that their numbers change places; and again, while the first still fades out.
    for (number, voices) in [(1, ["b", "a"]), (2, ["a", "b"]), (3, ["b", "a"])] {
        let now = bench.next();
        bench.take(now - 1_500_000, Signal::Play(10 * number, "a".into(), Note::default()));
        bench.take(now - 1_000_000, Signal::Reload(reload(&voices)));
        bench.take(now - 500_000, Signal::Play(10 * number + 1, "a".into(), Note::default()));
        (0..20).for_each(|_| bench.block());
        bench.conductor.go_on();
    }
    let reports = bench.reports.lock().unwrap().clone();
    let (mut plan, mut heard) = (0, Vec::new());
    for report in &reports {
        match &report.deed {
            Deed::Swap => plan += 1,
            Deed::Event { event: Event::Play(play), .. } => heard.push((plan, play.instrument)),
            _ => {}
        }
    }
    // Voice `a` is the first of the plans 0 and 2, and the second of 1 and 3.
    assert_eq!(heard, [(0, 0), (1, 1), (1, 1), (2, 0), (2, 0), (3, 1)]);
    assert_eq!(bench.conductor.board.dropped.get(), 0);
}

#[test]
fn of_two_patches_that_wait_the_later_plays() {
    let mut bench = Bench::new(&["a"]);
    for voices in [&["b"][..], &["c"], &["d"], &["e"]] {
        let now = bench.next();
        bench.take(now, Signal::Reload(reload(voices)));
    }
    for _ in 0..200 {
        bench.block();
        bench.conductor.go_on();
    }
    assert_eq!(bench.conductor.performer.patch().voices[0].name, "e");
}

const PATTERNS: &str = "[[trigger]]\non = \"start\"\nplay = \"none\"\n\
    [pattern.none]\nevents = [{ at = 0, voice = \"a\", level = 0 }]\n\
    [pattern.short]\nevents = [{ at = 0, voice = \"a\", duration = 0.001 }]\n\
    [pattern.dense]\nrepeat = { every = 0.0001 }\nevents = [{ at = 0, voice = \"a\", duration = 0.001 }]\n";

#[test]
fn numbers_of_patterns_that_have_ended_are_forgotten() {
    let mut bench = Bench::of(compiled_with(&["a"], PATTERNS));
    for n in 1..=200 {
        let now = bench.next();
        bench.take(now, Signal::Start(2 * n, "short".into()));
        bench.take(now, Signal::Start(2 * n + 1, "dense".into()));
        bench.take(now, Signal::StopNamed("dense".into()));
        (0..2).for_each(|_| bench.block());
        bench.conductor.go_on();
    }
    (0..100).for_each(|_| bench.block());
    bench.conductor.go_on();
    assert!(bench.conductor.patterns.len() <= 1, "{:?}", bench.conductor.patterns);
    // One that plays is kept, and stopped by its number.
    let now = bench.next();
    bench.take(now, Signal::Start(1000, "dense".into()));
    bench.conductor.go_on();
    assert_eq!(bench.conductor.performer.patterns().filter(|(serial, _)| *serial > 0).count(), 1);
    bench.take(now, Signal::Stop(1000));
    assert_eq!(bench.conductor.performer.patterns().filter(|(serial, _)| *serial > 0).count(), 0);
}

/// Whatever is started, a round of the conductor is short: it sends no more than so many events before it hears again.
#[test]
fn a_flood_of_starts_leaves_it_free_to_hear() {
    let mut bench = Bench::of(compiled_with(&["a"], PATTERNS));
    for n in 0..3000 {
        let now = bench.next();
        bench.take(now, Signal::Start(n, "dense".into()));
    }
    assert!(bench.conductor.board.refused.get() >= 3000 - 256);
    let room = |bench: &Bench| -> usize {
        bench.conductor.rings.cues.iter().map(ringbuf::traits::Observer::vacant_len).sum()
    };
    let before = room(&bench);
    bench.conductor.go_on();
    assert!((1..2000).contains(&(before - room(&bench))), "{}", before - room(&bench));
    assert!(bench.conductor.behind, "there is more to do");
    let now = bench.next();
    bench.take(now, Signal::Panic);
    bench.conductor.go_on();
    assert!(!bench.conductor.behind && bench.conductor.performer.patterns().count() == 0);
}

/// However they were silenced, and whatever was saved meanwhile, and never twice.
#[test]
fn voices_that_are_always_on_come_back_with_calm() {
    let always = |voices: &[&str]| {
        let rest: String = voices
            .iter()
            .map(|name| {
                format!(
                    "[voice.{name}]\noutput = \"s\"\nstart = \"always\"\nnodes.s = {{ type = \"sine\", frequency = 50 }}\n"
                )
            })
            .collect();
        compiled_with(&["a"], &rest)
    };
    let sounding = |bench: &mut Bench| {
        bench.conductor.go_on();
        (0..20).for_each(|_| bench.block());
        bench.conductor.board.voices.get()
    };
    let mut bench = Bench::of(always(&["hum"]));
    assert_eq!(sounding(&mut bench), 1);
    for silence in [Signal::ReleaseAll, Signal::Panic] {
        let now = bench.next();
        bench.take(now, silence);
        assert_eq!(sounding(&mut bench), 0);
        let now = bench.next();
        bench.take(now, Signal::Calm);
        bench.take(now, Signal::Calm);
        assert_eq!(sounding(&mut bench), 1);
    }
    let now = bench.next();
    bench.take(now, Signal::Panic);
    sounding(&mut bench);
    let (scene, patch, rig) = always(&["hum", "buzz"]);
    let files = Box::new(|_: &str| Err(Problem::of_file("none")));
    let now = bench.next();
    bench.take(now, Signal::Reload(Box::new(Reload { scene, patch, rig, files, provenance: None })));
    assert_eq!(sounding(&mut bench), 1, "the new one");
    let now = bench.next();
    bench.take(now, Signal::Calm);
    assert_eq!(sounding(&mut bench), 2);
}
