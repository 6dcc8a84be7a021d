mod controls;
mod latency;

use std::sync::{Arc, Mutex};

use super::{Audience, Board, Conductor, Handle, Report, Signal, Stamped, Told};
use crate::engine::event::Event;
use crate::engine::exchange::exchange;
use crate::engine::turnover::{Turn, Turned};
use crate::graph::scene::{Options, Scene, scene};
use crate::live::callback::{Callback, Deed};
use crate::live::clock::Follower;
use crate::live::gate::Gate;
use crate::live::reload::Reload;
use crate::live::signal::Origin;
use crate::live::stamp::{Epoch, Stamp};
use crate::live::way::Way;
use crate::midi::{Channel, Message};
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
    reload_with(voices, "")
}

/// The same, and what else the file says.
fn reload_with(voices: &[&str], rest: &str) -> Box<Reload> {
    let (scene, patch, rig) = compiled_with(voices, rest);
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
    handle: Handle,
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
        let (mut conductor, handle) =
            Conductor::new(performer, director, rings, clock, Epoch::begin(), &board, audience);
        conductor.begin();
        let mut bench = Self { conductor, handle, callback, follower, reports, blocks: 0 };
        (0..500).for_each(|_| bench.block());
        bench
    }

    /// Nanoseconds at which the next block is asked for.
    fn next(&self) -> u64 {
        self.blocks * 2_000_000
    }

    fn block(&mut self) {
        self.block_of(96, self.next());
        self.blocks += 1;
    }

    /// The device asks for so many frames at that time.
    fn block_of(&mut self, frames: usize, nanoseconds: u64) {
        self.follower.callback(Stamp(nanoseconds), frames as u64);
        self.callback.process(&[], &mut vec![0.0; frames]);
    }

    /// So many blocks, each behind what the conductor has to do.
    fn turn(&mut self, blocks: u64) {
        for _ in 0..blocks {
            self.conductor.go_on();
            self.block();
        }
    }

    fn take(&mut self, nanoseconds: u64, signal: Signal) {
        self.take_as(0, nanoseconds, signal);
    }

    /// As the signal of a number.
    fn take_as(&mut self, id: u64, nanoseconds: u64, signal: Signal) {
        self.conductor.take(Stamped {
            id,
            stamp: Stamp(nanoseconds),
            origin: Origin::Program,
            peer: None,
            pulls: self.conductor.board.lever.pulls(),
            ahead: None,
            tag: None,
            signal,
        });
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

/// However long the past of a plan takes to be copied, and however soon one plan follows another: what comes meanwhile is on time.
#[test]
fn what_comes_while_a_plan_gets_ready_waits_for_none() {
    let slow = |voices: [&str; 2], gain: &str| {
        let echo = format!(
            "[voice.echo]\nstart = \"always\"\noutput = \"o\"\n[voice.echo.nodes]\ns = {{ type = \"sine\", frequency = 50 }}\n\
             d = {{ type = \"delay\", input = \"s\", time = 1, longest = 60 }}\no = {{ type = \"multiply\", inputs = [\"d\", {gain}] }}\n"
        );
        compiled_with(&voices, &echo)
    };
    let mut bench = Bench::of(slow(["a", "b"], "0.1"));
    // Two seconds and a half of one voice: eighty kilobytes, which is 64 KiB in the first block and the rest in the next.
    (0..750).for_each(|_| bench.block());
    let mut number = 0;
    let mut swaps = Vec::new();
    for (voices, gain) in [(["b", "a"], "0.2"), (["a", "b"], "0.3"), (["b", "a"], "0.4")] {
        let (scene, patch, rig) = slow(voices, gain);
        let files = Box::new(|_: &str| Err(Problem::of_file("none")));
        let now = bench.next();
        bench.take(now, Signal::Reload(Box::new(Reload { scene, patch, rig, files, provenance: None })));
        for _ in 0..10 {
            // In each block one, which is felt a block later.
            let arrived = bench.next();
            bench.block();
            bench.take(arrived + 900_000, Signal::Play(number, "a".into(), Note::default()));
            number += 1;
            bench.conductor.go_on();
            let swapped = |report: &Report| matches!(report.deed, Deed::Swap);
            swaps.push(bench.reports.lock().unwrap().iter().filter(|report| swapped(report)).count());
        }
    }
    // The first takes some blocks; the second waits until what was before the first has faded, and is out of date by then.
    assert_eq!(swaps[..2], [0, 0]);
    assert_eq!((swaps[9], swaps[19]), (1, 1));
    for _ in 0..60 {
        bench.block();
        bench.conductor.go_on();
    }
    let played = bench.played();
    let of_a: Vec<u32> = played.iter().map(|(.., instrument)| *instrument).collect();
    assert_eq!(played.len(), 30);
    assert!(played.iter().all(|(due, at, _)| due == at), "{played:?}");
    // It is the first instrument at first, and the second once the first plan has taken over.
    let change = of_a.iter().position(|instrument| *instrument == 1).unwrap();
    assert!((1..8).contains(&change) && of_a[change..].iter().all(|instrument| *instrument == 1), "{of_a:?}");
    let swaps = bench.reports.lock().unwrap().iter().filter(|r| matches!(r.deed, Deed::Swap)).count();
    assert_eq!(swaps, 2, "the last of those that waited");
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
    bench.conductor.go_on();
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
    // What was sent before the brake was pulled does not take it back.
    bench.handle.send(Signal::Calm).unwrap();
    bench.conductor.board.panic();
    bench.conductor.listen();
    sounding(&mut bench);
    assert!(bench.conductor.board.is_panicked() && bench.conductor.board.shut.get() == 1);
    bench.handle.send(Signal::Calm).unwrap();
    bench.conductor.listen();
    assert!(sounding(&mut bench) == 1 && !bench.conductor.board.is_panicked());
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

const KEYS: &str =
    "[[trigger]]\non = \"midi.note\"\nplay = \"a\"\n[[trigger]]\non = \"key.1\"\nplay = \"b\"\n";

fn midi(port: u16, note: u8, down: bool) -> Signal {
    let channel = Channel::new(0).unwrap();
    Signal::Midi(
        port,
        match down {
            true => Message::NoteOn { channel, note, velocity: 100 },
            false => Message::NoteOff { channel, note, velocity: 64 },
        },
    )
}

/// A port that floods the session while nothing is taken: a key of the computer, another program and a panic are heard in the next pass,
/// what was refused is counted with MIDI alone, and when the port is gone no voice goes on.
#[test]
fn a_flood_of_midi_keeps_nobody_out_and_holds_no_voice() {
    let mut bench = Bench::of(compiled_with(&["a", "b"], KEYS));
    let handle = bench.handle.clone();
    let mut refused = 0;
    for n in 0..100_000_u32 {
        let stamp = Stamp(bench.next() + u64::from(n));
        // Keys that go down again and again, and up; the first of all is never said to go up.
        refused += u64::from(handle.send_at(stamp, midi(0, (n % 100) as u8, n % 3 < 2)).is_err());
    }
    let by = Origin::Key("1".into());
    handle.from(by).send_at(Stamp(bench.next()), Signal::Key(1)).unwrap();
    handle.send_at(Stamp(bench.next()), Signal::Play(1, "b".into(), Note::default())).unwrap();
    handle.send_at(Stamp(bench.next() + 200_000), Signal::MidiGone(0)).unwrap();
    let board = Arc::clone(&bench.conductor.board);
    assert!(refused > 50_000);
    assert_eq!((board.refused.of(Way::Midi).get(), board.refused.get()), (refused, refused));
    bench.conductor.listen();
    let of_b = bench.played().iter().filter(|(.., instrument)| *instrument == 1).count();
    assert_eq!(of_b, 0, "the callback has not come yet");
    bench.block();
    let played = bench.played();
    assert_eq!(played.iter().filter(|(.., instrument)| *instrument == 1).count(), 2);
    // And all that MIDI has said, until the port is gone; meanwhile the ring to the callback overflows.
    (0..1000).for_each(|_| bench.conductor.listen());
    for _ in 0..2000 {
        bench.conductor.go_on();
        bench.block();
    }
    assert!(board.started.get() > 100);
    bench.handle.send_at(Stamp(bench.next()), Signal::ReleaseAll).unwrap();
    bench.conductor.listen();
    assert_eq!(bench.conductor.performer.held(), 0);
    assert_eq!(sounding_of_a(&mut bench), 0);
}

/// Voices of the keys that still sound, those that the program has played left out.
fn sounding_of_a(bench: &mut Bench) -> u64 {
    (0..100).for_each(|_| bench.block());
    bench.conductor.go_on();
    bench.conductor.board.voices.get()
}

/// More keys go up at once than the ring to the callback has room for, while the callback does not come.
#[test]
fn keys_that_go_up_are_heard_however_full_the_ring_is() {
    let mut bench = Bench::of(compiled_with(&["a", "b"], KEYS));
    let now = bench.next();
    for note in 0..8 {
        bench.take(now, midi(0, note, true));
    }
    (0..3).for_each(|_| bench.block());
    assert_eq!(bench.conductor.board.voices.get(), 8);
    for n in 0..20_000 {
        bench.take(now, Signal::Play(n, "a".into(), Note { duration: Some(0.001), ..Note::default() }));
    }
    for n in 0..2000 {
        // A note that is played in vain goes up, too.
        bench.take(now, midi(0, (n % 8) as u8, false));
        bench.take(now, midi(0, (n % 8) as u8 + 64, true));
    }
    let mut expected = 0;
    (0..500).for_each(|_| {
        bench.block();
        bench.conductor.go_on();
        expected += 1;
    });
    assert_eq!((bench.conductor.board.voices.get(), expected), (0, 500));
}

/// Voices that sound for a moment, one every millisecond, from two patterns that play from the beginning and one that is started.
const STEPS: &str = "[[trigger]]\non = \"start\"\nplay = \"low\"\n[[trigger]]\non = \"start\"\nplay = \"high\"\n\
    [pattern.low]\nrepeat = { every = 0.001 }\nevents = [{ at = 0, voice = \"a\", duration = 0.0001 }]\n\
    [pattern.high]\nrepeat = { every = 0.001 }\nevents = [{ at = 0.0005, voice = \"b\", duration = 0.0001 }, { at = 0.0005, marker = \"m\" }]\n\
    [pattern.later]\nrepeat = { every = 0.001 }\nevents = [{ at = 0, voice = \"a\", duration = 0.0001 }]\n";

/// What is sent 50 ms ahead is called off: of a pattern that is stopped at an instant, all that begins before has begun, and nothing else,
/// wherever in what was sent ahead, or beyond it, the instant lies; and of the others nothing is missing.
#[test]
fn nothing_of_a_pattern_begins_at_the_instant_at_which_it_stops_or_later() {
    for ahead_us in [250_u64, 1_700, 19_300, 43_100, 70_900] {
        let mut bench = Bench::of(compiled_with(&["a", "b"], STEPS));
        let board = Arc::clone(&bench.conductor.board);
        bench.turn(10);
        // One that was started and is stopped by its number.
        let at = bench.next() + 300_000;
        let until = at + 30_000_000 + ahead_us * 1000;
        bench.take(at, Signal::Start(5, "later".into()));
        bench.take(bench.next() + 1_000, Signal::StopNamed("low".into()));
        bench.turn(15);
        bench.take(until, Signal::Stop(5));
        bench.turn(60);
        let reports = bench.reports.lock().unwrap().clone();
        // Instants in seconds, and by which pattern: that of `b`, those of the beginning, that which was started.
        let frames = |at: crate::schedule::Instant| at.since(crate::schedule::Instant::default()) / 8000.0;
        let stop = reports.iter().rev().find_map(|report| match report.deed {
            Deed::Event { at, event: Event::Cancel(..), .. } => Some(frames(at)),
            _ => None,
        });
        let begin = reports.iter().find_map(|report| match report.deed {
            Deed::Event { due, event: Event::Play(play), .. } if play.id >> 32 == 1 => Some(frames(due)),
            _ => None,
        });
        let (Some(stop), Some(begin)) = (stop, begin) else { panic!("{ahead_us}") };
        assert!((stop - begin - (until - at) as f64 * 1e-9).abs() < 1e-6, "{ahead_us}: {}", stop - begin);
        let later = ((stop - begin) / 0.001).ceil() as u64;
        // `low` goes on for a block after the signal: all of it that lies before its stop.
        let clock = board.clock.get() as f64 / 8000.0;
        let low_stop = reports.iter().find_map(|report| match report.deed {
            Deed::Event { at, event: Event::Cancel(..), .. } => Some(frames(at)),
            _ => None,
        });
        let low = (low_stop.unwrap_or(f64::NAN) / 0.001).ceil() as u64;
        let high = ((clock - 0.0005) / 0.001).ceil() as u64;
        assert_eq!(board.started.get(), low + high + later, "{ahead_us}: {low} {high} {later}");
        assert_eq!(bench.conductor.board.dropped.get(), 0);
    }
}

/// Voices of 20 s from two patterns that play from the beginning, and one that is started.
const LONG: &str = "[[trigger]]\non = \"start\"\nplay = \"left\"\n[[trigger]]\non = \"start\"\nplay = \"right\"\n\
    [pattern.left]\nevents = [{ at = 0, voice = \"a\", duration = 20 }, { at = 0.1, voice = \"a\", duration = 20 }]\n\
    [pattern.right]\nevents = [{ at = 0, voice = \"b\", duration = 20 }]\n\
    [pattern.later]\nevents = [{ at = 0, voice = \"a\", duration = 0.05 }]\n";

/// A pattern plays until the last of its voices is released, and what it sounds is released where it is stopped; nothing else is.
#[test]
fn a_pattern_that_is_stopped_is_heard_no_more() {
    let mut bench = Bench::of(compiled_with(&["z", "a", "b"], LONG));
    let board = Arc::clone(&bench.conductor.board);
    let playing = |bench: &Bench| -> Vec<String> {
        bench.conductor.performer.patterns().map(|(_, name)| name.to_string()).collect()
    };
    bench.turn(200);
    assert_eq!((board.voices.get(), playing(&bench)), (3, vec!["left".into(), "right".into()]));
    bench.take(bench.next(), Signal::Start(5, "left".into()));
    bench.take(bench.next(), Signal::Start(6, "later".into()));
    bench.turn(20);
    assert_eq!((board.voices.get(), playing(&bench).len()), (5, 4));
    // That of 50 ms has ended by itself.
    bench.turn(80);
    assert_eq!(
        (board.voices.get(), playing(&bench)),
        (5, vec!["left".into(), "right".into(), "left".into()])
    );
    // By its number, and then by the name, which is that of the other patterns' run as well.
    bench.take(bench.next(), Signal::Stop(5));
    bench.turn(20);
    assert_eq!((board.voices.get(), playing(&bench)), (3, vec!["left".into(), "right".into()]));
    bench.take(bench.next(), Signal::StopNamed("left".into()));
    bench.turn(20);
    assert_eq!((board.voices.get(), playing(&bench)), (1, vec!["right".into()]));
    // Saved anew, without a voice that stood before its own.
    bench.take(bench.next(), Signal::Reload(reload_with(&["a", "b"], LONG)));
    bench.turn(60);
    assert_eq!((board.voices.get(), playing(&bench)), (1, vec!["right".into()]));
    bench.take(bench.next(), Signal::StopNamed("right".into()));
    bench.turn(20);
    assert_eq!((board.voices.get(), playing(&bench).len()), (0, 0));
}

/// One that always sounds is told of where it begins: with its patch, under the names of that; one that goes on is not told of again.
#[test]
fn what_always_sounds_is_told_of_where_it_begins() {
    let hum = |name: &str| {
        format!(
            "[voice.{name}]\nstart = \"always\"\noutput = \"s\"\n[voice.{name}.nodes]\ns = {{ type = \"sine\", frequency = 50 }}\n"
        )
    };
    let mut bench = Bench::of(compiled_with(&["a"], &hum("one")));
    bench.turn(1);
    for rest in [hum("two") + &hum("one"), hum("two")] {
        bench.handle.send(Signal::Reload(reload_with(&["a"], &rest))).unwrap();
        bench.conductor.listen();
        bench.turn(60);
    }
    let (mut swap, mut told) = (None, Vec::new());
    for report in bench.reports.lock().unwrap().iter() {
        match report.deed {
            Deed::Swap => swap = Some(report.frame),
            Deed::Turn(Turn { at, what: Turned::Began(play) }) => {
                // With the first frame that its plan gives.
                let due = swap.unwrap_or(0);
                assert!((due..due + 6).contains(&(at.sample * 6)), "{report:?} behind {swap:?}");
                told.push((swap.is_some(), play.instrument));
            }
            _ => {}
        }
    }
    assert_eq!(told, [(false, 1), (true, 1)]);
}

/// A voice that is meant for later and released before it begins ends where it begins.
#[test]
fn what_is_released_before_it_begins_does_not_sound_on() {
    let mut bench = Bench::new(&["a"]);
    let now = bench.next();
    bench.take(now + 15_000_000, Signal::Play(1, "a".into(), Note::default().duration(f64::INFINITY)));
    bench.take(now + 3_000_000, Signal::Release(1));
    bench.turn(30);
    assert_eq!(bench.played().len(), 1);
    bench.turn(200);
    assert_eq!(bench.conductor.board.voices.get(), 0, "nobody holds it");
}

/// A voice that is held is known by its number behind however many others, and of what had to be forgotten that is said.
#[test]
fn a_held_voice_is_released_behind_any_number_of_taps() {
    let mut bench = Bench::new(&["a", "b"]);
    let begin = bench.next();
    bench.take(begin, Signal::Play(1, "a".into(), Note::default().duration(f64::INFINITY)));
    for number in 0..20_000_u64 {
        bench.take(bench.next(), Signal::Play(2 + number, "b".into(), Note::default().duration(0.001)));
        if number % 50 == 0 {
            bench.turn(3);
        }
    }
    bench.turn(100);
    assert_eq!(bench.conductor.board.voices.get(), 1);
    bench.take(bench.next(), Signal::Release(1));
    bench.turn(100);
    assert_eq!(bench.conductor.board.voices.get(), 0);
}

/// What is meant for later and held when somebody lets go of all of it ends where it begins.
#[test]
fn what_has_yet_to_begin_is_let_go_of_with_all_else() {
    for all in [Signal::ReleaseAll, Signal::Panic] {
        let mut bench = Bench::new(&["a"]);
        let now = bench.next();
        bench.take(now + 15_000_000, Signal::Play(1, "a".into(), Note::default().duration(f64::INFINITY)));
        bench.take(now + 3_000_000, all);
        bench.turn(300);
        assert_eq!((bench.played().len(), bench.conductor.board.voices.get()), (1, 0));
    }
}
