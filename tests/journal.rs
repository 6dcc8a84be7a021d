//! What a session has played is played again from its journal, to the bit; and a journal that was tampered with is refused where it is
//! wrong.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use pacinian::engine::task::{Task, Values};
use pacinian::graph::scene::{Options, scene};
use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::reader::{Item, Reader};
use pacinian::io::journal::remake::Recordings;
use pacinian::io::journal::replay::{Met, Replay};
use pacinian::io::journal::{COLUMNS, Journal, Kind, Line, Setting, of_bytes};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::wav::{Encoding, WavReader, WavSpec};
use pacinian::live::provenance::{Provenance, RigText, Text};
use pacinian::live::reload::Reload;
use pacinian::live::signal::{Origin, Signal};
use pacinian::midi::Message;
use pacinian::node::asset::NoAssets;
use pacinian::schedule::Beat;
use pacinian::text::Problem;
use pacinian::{Note, Patch, Place, Rig};

/// Three tactors, one of them calibrated by a file.
const RIG: &str = r#"format = "pacinian-rig/1"
[device]
channels = 3
full_scale_volts = 1.0
[calibration.c]
date = 2026-03-14
method = "none, in a test"
area = 1e-4
unit = "um/V"
table = "c.csv"
[[tactor]]
name = "t1"
channel = 1
position = [0.0, 0.0]
[[tactor]]
name = "t2"
channel = 2
position = [0.04, 0.0]
calibration = "c"
[[tactor]]
name = "t3"
channel = 3
position = [0.08, 0.0]
"#;
const TABLE: &str = "frequency,output\n20,60\n150,21\n400,3\n";

fn rig() -> Rig {
    let mut rig = Rig::parse("r.toml", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    rig.calibrations[0].take(TABLE).unwrap();
    rig
}

const PATCH: &str = r#"format = "pacinian-patch/1"
title = "t"
[control.strength]
default = 0.8
range = [0.0, 1.0]
smoothing = 0.02
[shared.nodes]
sway = { type = "lfo", rate = 23 }
[voice.hum]
start = "always"
output = "s"
[voice.hum.nodes]
s = { type = "sine", frequency = 100, amplitude = 0.1 }
[voice.tap]
output = "o"
place = "t2"
voices = 6
[voice.tap.defaults]
frequency = 120
bite = 0.5
[voice.tap.nodes]
s = { type = "sine", frequency = "event.frequency" }
n = { type = "white", amplitude = "event.bite" }
m = { type = "add", inputs = ["s", "n"] }
e = { type = "envelope", attack = 0.001, release = 0.005 }
o = { type = "multiply", inputs = ["m", "e", "strength"] }
[pattern.walk]
jitter = { at = 0.01, level = 0.2 }
events = [
  { at = 0.0, voice = "tap", duration = 0.02, place = "t1", level = 0.5 },
  { at = 0.05, choose = [{ voice = "tap", duration = 0.03, place = "t3" }, { voice = "tap", duration = 0.01, frequency = 233 }] },
  { at = 0.07, voice = "tap", duration = 0.02, felt = 26 },
]
repeat = { every = 0.1 }
[[trigger]]
on = "midi.note"
play = "tap"
place = "t2"
[[trigger]]
on = "start"
play = "walk"
[[trigger]]
on = "node.sway falls 0.3"
play = "tap"
place = "t3"
hold = 0.05
set = { level = 0.3, duration = 0.01 }
"#;

fn reload(text: &str) -> Reload {
    let patch = Patch::parse("t.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = rig();
    let options = Options { rate: Some(48_000.0), live: true, seed: Some(7), ..Options::default() };
    let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    let files = Box::new(|_: &str| Err(Problem::of_file("no files here")));
    let provenance = Provenance {
        patch: Text { name: "t.toml".into(), sha256: of_bytes(text.as_bytes()), text: text.into() },
        rig: RigText::Text(Text {
            name: "r.toml".into(),
            sha256: of_bytes(RIG.as_bytes()),
            text: RIG.into(),
        }),
        tables: vec![Text { name: "c.csv".into(), sha256: of_bytes(TABLE.as_bytes()), text: TABLE.into() }],
        folder: ".".into(),
        allow_outside: false,
        files: Vec::new(),
        song: None,
        set: Vec::new(),
        notes: None,
        options: (&options).into(),
    };
    Reload {
        scene,
        patch: Arc::new(patch),
        rig: Arc::new(rig),
        files,
        provenance: Some(Arc::new(provenance)),
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("pacinian-journal-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn until(session: &Session, frame: u64) {
    let begin = Instant::now();
    while session.board().frames.get() < frame {
        assert!(begin.elapsed() < Duration::from_secs(30), "the card stands still");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Lets a session play, moved by everything that can move it, and keeps it.
fn play(journal_path: &Path, recording: &Path) {
    let first = reload(PATCH);
    let setting = Setting { device: "virtual".into(), armed: true, input: None, recording: None };
    let journal =
        Journal::create(journal_path, setting, &first.scene.plan, first.provenance.as_deref()).unwrap();
    let (hears, is_told) = (journal.clone(), journal.clone());
    let mut session = Session::start(Beginning {
        block: Some(64),
        record: true,
        listener: Some(Box::new(move |event| hears.hear(event))),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let ring = session.recording().unwrap();
    let recorder = Recorder::start(ring, recording, WavSpec::new(3, 48_000, Encoding::F32)).unwrap();
    let handle = session.handle().clone();
    let patches =
        [PATCH.replace("0.8", "0.5"), PATCH.replace("frequency = 100", "frequency = 130"), PATCH.into()];
    let (mut frame, mut held, mut walk) = (4_800, Vec::new(), 0);
    for step in 0..120_u64 {
        until(&session, frame);
        // Now and then much at once.
        frame += (step * step) % 1_000;
        let channel = pacinian::midi::Channel::new(0).unwrap();
        let note = 40 + (step % 40) as u8;
        match step % 12 {
            0 => held.push(handle.play("tap", Note::default().level(0.3)).unwrap()),
            1 => {
                let note = Note::default().field("frequency", 60.0 + step as f64 / 3.0).duration(0.03);
                let _ = handle.play("tap", note);
            }
            2 => handle.set("strength", (step % 7) as f64 / 6.0).unwrap(),
            3 => handle
                .by(&"Keys 49".into())
                .send(Signal::Midi(0, Message::NoteOn { channel, note, velocity: 90 }))
                .unwrap(),
            4 => handle
                .send(Signal::Midi(0, Message::NoteOff { channel, note: note - 1, velocity: 0 }))
                .unwrap(),
            5 => walk = handle.start("walk").unwrap(),
            6 => {
                let stop = Origin::Osc("/pattern/w*/stop".into(), "1".into());
                handle.from(stop).send(Signal::StopNamed("walk".into())).unwrap();
                handle.stop(walk).unwrap();
                handle.from(Origin::Key("x".into())).play("nap", Note::default()).unwrap();
            }
            7 => drop(held.pop().map(|number| handle.release(number))),
            8 => {
                let note = Note { place: Some(Place::Name("t3".into())), ..Note::default() };
                let _ = handle.play("tap", note.duration(0.01));
                let place = Some(Place::Position([0.03, 0.0, 0.0]));
                let _ = handle.play("tap", Note { place, ..Note::default() }.felt(18.5).duration(0.02));
            }
            9 if step % 24 == 9 => handle.send(Signal::Arm(step % 48 == 9)).unwrap(),
            9 => {
                let silence = Message::Controller { channel, number: 120, value: 0 };
                handle.send(Signal::Midi(0, silence)).unwrap();
            }
            10 if step % 36 == 10 => handle.panic(),
            11 if step % 36 == 11 => handle.send(Signal::Calm).unwrap(),
            _ => {}
        }
        if step % 40 == 20 {
            let text = &patches[(step / 40) as usize % patches.len()];
            handle.send(Signal::Reload(Box::new(reload(text)))).unwrap();
        }
        if step % 30 == 0 {
            journal.clock(session.clock().moment());
        }
    }
    until(&session, frame + 4_800);
    session.stop();
    let written = recorder.finish().unwrap();
    assert_eq!(written.frames, session.board().frames.get());
    assert_eq!(session.board().unrecorded.get(), 0);
    assert_eq!(journal.finish().unwrap(), 0);
    let Some(Item::Session(head)) = Reader::open(journal_path).unwrap().read().unwrap() else { panic!() };
    assert!(
        (head.delay - session.delay().total()).abs() < 1e-8 && (head.rate, head.channels) == (48_000.0, 3)
    );
}

/// All frames of a replay.
fn replayed(path: &Path) -> (Vec<f32>, Met) {
    let mut replay = Replay::open(path, Recordings::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut all = Vec::new();
    while let Some(frames) = replay.block().unwrap_or_else(|error| panic!("{error}")) {
        all.extend_from_slice(frames);
    }
    (all, replay.met())
}

fn lines(path: &Path) -> Vec<Line> {
    let mut reader = Reader::open(path).unwrap();
    let mut lines = Vec::new();
    while let Some(item) = reader.read().unwrap() {
        if let Item::Line(line) = item {
            lines.push(*line);
        }
    }
    lines
}

/// A task that takes a quarter more of the processor than a callback has time.
struct Greedy;

impl Task for Greedy {
    fn beat(&self) -> Beat {
        Beat::every(8)
    }
    fn name(&self) -> &str {
        "greedy"
    }
    fn rank(&self) -> u8 {
        9
    }
    fn run(&mut self, _: &mut dyn Values) {
        // A millisecond of sound.
        let begin = ThreadTime::now();
        while begin.elapsed() < Duration::from_micros(1_250) {
            std::hint::spin_loop();
        }
    }
}

/// What was let rest stands in the journal, at the sample from which it rested, and is let rest there again: it is the same to the bit.
#[test]
fn a_session_that_let_tasks_rest_is_played_again_to_the_bit() {
    let folder = folder("shed");
    let (journal_path, recording) = (folder.join("s.jsonl"), folder.join("s.wav"));
    let first = reload(PATCH);
    let setting = Setting { device: "virtual".into(), armed: true, input: None, recording: None };
    let journal =
        Journal::create(&journal_path, setting, &first.scene.plan, first.provenance.as_deref()).unwrap();
    let (hears, is_told) = (journal.clone(), journal.clone());
    let mut session = Session::start(Beginning {
        block: Some(64),
        record: true,
        tasks: vec![Box::new(Greedy)],
        listener: Some(Box::new(move |event| hears.hear(event))),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let ring = session.recording().unwrap();
    let recorder = Recorder::start(ring, &recording, WavSpec::new(3, 48_000, Encoding::F32)).unwrap();
    let greedy = Arc::clone(session.duties().iter().find(|duty| duty.name() == "greedy").unwrap());
    let begin = Instant::now();
    while !greedy.is_resting() {
        assert!(begin.elapsed() < Duration::from_secs(30), "it never rests");
        std::thread::sleep(Duration::from_millis(1));
    }
    // And for a second without it.
    until(&session, session.board().frames.get() + 48_000);
    session.stop();
    let written = recorder.finish().unwrap();
    assert_eq!((written.frames, session.board().unrecorded.get()), (session.board().frames.get(), 0));
    assert_eq!(journal.finish().unwrap(), 0);
    // The meters are the first, and then it.
    let lines = lines(&journal_path);
    let shed: Vec<_> = lines.iter().filter(|line| line.kind == Kind::Shed).collect();
    let ranks: Vec<_> = shed.iter().map(|line| line.value.unwrap()).collect();
    assert_eq!(ranks[..2], [254.0, 8.0], "{ranks:?}");
    assert!(greedy.runs() > 0 && greedy.skipped() > 0);
    let (again, met) = replayed(&journal_path);
    assert!(met.ended && met.lost == 0, "{met:?}");
    let mut recorded = WavReader::open(&recording).unwrap();
    let mut same = 0;
    recorded
        .each_frame(|frame| {
            let other = &again[3 * same..3 * same + 3];
            assert!(frame.iter().zip(other).all(|(a, b)| a.to_bits() == b.to_bits()), "frame {same}");
            same += 1;
            Ok(())
        })
        .unwrap();
    assert_eq!((same as u64, again.len()), (written.frames, 3 * same));
    assert!(again.iter().any(|x| x.abs() > 0.3), "something was to be heard");
    // A decision that stands where nothing is computed any more is refused: it is read, and not passed over.
    let text = std::fs::read_to_string(&journal_path).unwrap();
    let line = text.lines().find(|line| line.contains("\"shed\"")).unwrap();
    let frame = format!("\"frame\":{}", shed[0].frame.unwrap());
    assert!(line.contains(&frame), "{line}");
    let late = text.replacen(line, "", 1).replacen("\n\n", "\n", 1);
    let mut late: Vec<&str> = late.lines().collect();
    late.insert(late.len() - 1, line);
    let mut replay =
        Replay::new(Reader::new(Cursor::new(late.join("\n").into_bytes()), "s.jsonl"), Recordings::default())
            .unwrap();
    let why = loop {
        match replay.block() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("it was passed over"),
            Err(why) => break why.to_string(),
        }
    };
    assert!(why.contains("has passed"), "{why}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_was_played_is_played_again_to_the_bit() {
    let folder = folder("bits");
    for ending in ["csv", "jsonl"] {
        let (journal, recording) = (folder.join(format!("s.{ending}")), folder.join("s.wav"));
        play(&journal, &recording);
        let mut recorded = Vec::new();
        let mut reader = WavReader::open(&recording).unwrap();
        reader
            .each_frame(|frame| {
                recorded.extend_from_slice(frame);
                Ok(())
            })
            .unwrap();
        let (again, met) = replayed(&journal);
        assert!(met.ended && met.lost == 0 && met.swaps == 3, "{met:?}");
        assert_eq!(met.frames * 3, recorded.len() as u64);
        let different = recorded.iter().zip(&again).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(different, None, "of {}", recorded.len());
        assert!(recorded.iter().any(|x| x.abs() > 0.3), "something was to be heard");

        // Everything that happened stands there, with its times.
        let lines = lines(&journal);
        for kind in [
            Kind::Voice,
            Kind::Release,
            Kind::ReleaseAll,
            Kind::Silence,
            Kind::Cancel,
            Kind::Control,
            Kind::Gate,
            Kind::Swap,
            Kind::In,
            Kind::Refused,
            Kind::Clock,
            Kind::End,
        ] {
            assert!(lines.iter().any(|line| line.kind == kind), "{kind:?}");
        }
        // How strongly something is felt stands there, with the gains that it came to.
        let felt = |wanted: f64| {
            lines.iter().find(|line| line.felt == Some(wanted)).unwrap_or_else(|| panic!("{wanted}"))
        };
        // 26 dB above 0.739 um (thenar, 1 cm2, 120 Hz) are 14.7 um, and the table has 23.6 um/V there; the band limit takes 0.14 dB.
        let gain: f64 =
            felt(26.0).gains.as_deref().and_then(|gains| gains.strip_prefix("2=")?.parse().ok()).unwrap();
        assert!((gain - 0.635).abs() < 0.002 && felt(26.0).level.is_some(), "{:?}", felt(26.0));
        assert_eq!(felt(18.5).gains.as_deref().unwrap().split(';').count(), 2);
        // What a node sets off stands there, under its own name, and is set off again without.
        let set_off: Vec<_> = lines.iter().filter(|line| line.source.as_deref() == Some("node")).collect();
        let seconds = met.frames as f64 / 48_000.0;
        // Of 23 a second, those that are not held back: every second.
        assert!((set_off.len() as f64 - 11.5 * seconds).abs() < 2.0, "{} in {seconds} s", set_off.len());
        for (n, line) in set_off.iter().enumerate() {
            assert_eq!((line.kind, line.pattern.as_deref()), (Kind::Voice, Some("node.sway falls 0.3")));
            assert_eq!((line.event, line.id), (Some(n as u64 + 1), Some(1 << 63 | n as u64)));
            assert_eq!((line.name.as_deref(), line.place.as_deref()), (Some("tap"), Some("t3")));
            assert!(line.frame.unwrap() as f64 <= line.sample.unwrap() as f64 * 6.0 + 6.0);
        }
        let drawn = lines.iter().filter(|line| line.pattern.as_deref() == Some("walk"));
        assert!(
            drawn.clone().any(|line| line.event == Some(2) && line.drawn == Some(2)),
            "as the patch counts"
        );
        // What was played leads back to what came in and asked for it, and that to whoever sent it.
        let cause = |line: &Line| {
            let id = line.cause?;
            let mut came = lines.iter().filter(|line| line.kind == Kind::In && line.id == Some(id));
            let first = came.next().unwrap_or_else(|| panic!("nothing came in that was number {id}"));
            assert_eq!(came.count(), 0, "numbers are one line's alone");
            Some(first)
        };
        let by = |kind: Kind, way: &str, starts: &str| {
            let of_kind = lines.iter().filter(move |line| line.kind == kind);
            of_kind.filter_map(cause).any(|came| {
                let said = came.message.as_deref().unwrap_or_default();
                came.source.as_deref() == Some(way) && said.starts_with(starts)
            })
        };
        assert!(by(Kind::Release, "program", "release"));
        assert!(by(Kind::Silence, "midi", "B0 78") && by(Kind::Voice, "program", "play"));
        assert!(by(Kind::Cancel, "osc", "1") && by(Kind::Control, "program", "set"));
        // Of what was started, not of what plays from the beginning.
        let started: Vec<_> = drawn.clone().filter_map(cause).collect();
        assert!(!started.is_empty() && started.iter().all(|came| came.message.as_deref() == Some("start")));
        let from_port = lines.iter().filter(|line| line.peer.as_deref() == Some("Keys 49"));
        assert!(from_port.clone().count() > 0 && from_port.clone().all(|line| line.kind == Kind::In));
        // Events leave the converter as far from each other as their samples are, on a card that keeps time to some milliseconds.
        let times = lines.iter().filter(|line| line.kind == Kind::Voice);
        let times: Vec<_> =
            times.map(|line| (line.sample.unwrap() as f64 / 8_000.0, line.seconds.unwrap())).collect();
        let (first, last) = (times[0], times[times.len() - 1]);
        assert!(
            last.0 - first.0 > 0.5 && ((last.1 - first.1) - (last.0 - first.0)).abs() < 0.3,
            "{first:?} {last:?}"
        );
        let mut latest = f64::NEG_INFINITY;
        for line in
            lines.iter().filter(|line| line.kind == Kind::Voice && line.source.as_deref() == Some("program"))
        {
            // Two milliseconds of delay behind its frame, on a card that keeps time to a few.
            let (seconds, frame) = (line.seconds.unwrap(), line.sample.unwrap() as f64 * 6.0);
            assert!(seconds >= latest - 1e-3 && line.utc.is_some());
            latest = seconds;
            assert!(
                line.frame.unwrap() as f64 <= frame + 6.0,
                "an event is given before its sample is computed"
            );
        }
        // Up to the frame of a clock's line all that was done is told before it.
        for (at, clock) in lines.iter().enumerate().filter(|(_, line)| line.kind == Kind::Clock) {
            let later = lines[at..].iter().filter(|line| line.kind.is_played());
            assert!(later.clone().all(|line| line.frame >= clock.frame), "{clock:?}");
        }
        assert!(lines.iter().any(|line| line.kind == Kind::Clock && line.frame > Some(24_000)));
        // By which way it came, as it came; and what became of it.
        let came = |source: &str, name: &str, message: &str| {
            lines.iter().position(|line| {
                let words =
                    [&line.source, &line.name, &line.message].map(|word| word.as_deref().unwrap_or(""));
                line.kind == Kind::In && words == [source, name, message]
            })
        };
        assert!(came("osc", "/pattern/w*/stop", "1").is_some());
        assert!(came("program", "walk", "start").is_some());
        let nap = &lines[came("key", "x", "play nap").unwrap() + 1];
        assert!(
            nap.kind == Kind::Refused && nap.message.as_ref().unwrap().contains("no voice called `nap`"),
            "{nap:?}"
        );
        assert!(lines.iter().any(
            |line| line.source.as_deref() == Some("midi") && line.message.as_deref() == Some("90 2B 5A")
        ));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A journal of a moment, as text.
fn short(name: &str) -> String {
    let folder = folder(name);
    let path = folder.join("s.jsonl");
    // Without what a node sets off: those lines are told, and not played.
    let first = reload(PATCH.split("[[trigger]]\non = \"node").next().unwrap_or_default());
    let setting = Setting { device: "virtual".into(), armed: true, input: None, recording: None };
    let journal = Journal::create(&path, setting, &first.scene.plan, first.provenance.as_deref()).unwrap();
    let is_told = journal.clone();
    let mut session = Session::start(Beginning {
        block: Some(64),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    until(&session, 9_600);
    journal.clock(session.clock().moment());
    until(&session, 14_400);
    session.stop();
    journal.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    text
}

/// What becomes of a journal: how it ends.
fn outcome(text: &str) -> Result<Met, String> {
    let reader = Reader::new(Cursor::new(text.as_bytes()), "s.jsonl");
    let mut replay = Replay::new(reader, Recordings::default()).map_err(|error| error.to_string())?;
    while replay.block().map_err(|error| error.to_string())?.is_some() {}
    Ok(replay.met())
}

#[test]
fn what_is_no_journal_any_more_is_refused_at_its_line() {
    let text = short("edited");
    let whole = outcome(&text).unwrap();
    assert!(whole.ended && whole.frames >= 9_600 && whole.events > 2, "{whole:?}");
    let refused = |text: &str, says: &str| match outcome(text) {
        Err(error) => assert!(error.contains(says), "`{error}` does not say `{says}`"),
        Ok(met) => panic!("it was played: {met:?}"),
    };
    let edited = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    refused("", "empty");
    refused("kind,frame\nend,3\n", "1: this is no journal");
    refused("{\"kind\":\"end\",\"frame\":3}\n", "1: this is no journal");
    refused(&edited("pacinian-journal/1", "pacinian-journal/2"), "reads `pacinian-journal/1`");
    refused(&edited("\"plan\":0", "\"plan\":-1"), "s.jsonl:2:");
    refused(&edited("frequency = 100", "frequency = 101"), "does not have the SHA-256 beside it");
    refused(&edited("\"channels\":3", "\"channels\":4"), "the session had 4 channels");
    refused(&edited("\"name\":\"tap\"", "\"name\":\"nap\""), "no voice called `nap`");
    refused(&edited("\"place\":\"t", "\"place\":\"q"), "there is no output `q");
    refused(&edited("\"fraction\":0.", "\"fraction\":7."), "from 0 to below 1");
    refused(&edited("\"source\":\"pattern\"", "\"source\":\"nobody\""), "not from `nobody`");
    refused(&edited("\"kind\":\"end\",", "\"kind\":\"swap\","), "no plan was written down");
    let last = text.lines().count() + 1;
    let beyond = format!("{text}{}\n", text.lines().nth(3).unwrap());
    refused(&beyond, &format!("s.jsonl:{last}: something follows the end"));
    // Each in one short sentence that says what to do, whatever stands there.
    let voice = text.lines().find(|line| line.contains("\"voice\"")).unwrap();
    for (from, to) in [
        ("\"level\":", "\"level\":1e300,\"x\":"),
        ("\"duration\":", "\"duration\":-1e300,\"x\":"),
        ("\"fields\":{", "\"fields\":{\"bogus\":1,"),
        ("\"frame\":", &format!("\"frame\":{}", "9".repeat(100_000))),
        ("\"frame\":", "\"frame\":-"),
        ("\"source\":\"", &format!("\"source\":\"{}", "x".repeat(100_000))),
        ("\"name\":\"", &format!("\"name\":\"{}", "y".repeat(100_000))),
        ("\"kind\":\"voice", "\"kind\":\"voise"),
        ("}", ""),
    ] {
        assert!(voice.contains(from), "{from}");
        let error = outcome(&text.replacen(voice, &voice.replacen(from, to, 1), 1)).unwrap_err();
        assert!(
            error.starts_with("s.jsonl:") && error.ends_with("play the journal as it was written"),
            "{error}"
        );
        assert!(error.len() < 500 && !error.contains(['\n', '\r']) && !error.contains("line 1"), "{error}");
    }
    let first = text.lines().position(|line| line.contains("\"voice\"")).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    let line = lines.remove(first);
    lines.insert(lines.len() - 1, line);
    refused(&(lines.join("\n") + "\n"), "has passed");
    // Without its end it is played as far as it goes, be it within a line.
    let half = &text[..text.len() - 40];
    let met = outcome(half).unwrap();
    assert!(!met.ended && met.frames <= whole.frames, "{met:?}");
    // What the writer could not keep up with is known.
    let met =
        outcome(&edited("{\"kind\":\"end\"", "{\"kind\":\"lost\",\"value\":3}\n{\"kind\":\"end\"")).unwrap();
    assert_eq!(met.lost, 3);
}

#[test]
fn a_journal_that_breaks_off_is_played_up_to_the_last_that_it_tells_of() {
    let text = short("broken");
    let clock = text.lines().position(|line| line.contains("\"clock\"")).unwrap();
    let until: Vec<&str> = text.lines().take(clock + 1).collect();
    let Line { frame, .. } = serde_json::from_str(until[clock]).unwrap();
    let met = outcome(&(until.join("\n") + "\n")).unwrap();
    assert!(!met.ended && met.frames == frame.unwrap() && met.frames > 4_800, "{met:?} {frame:?}");
    // A voice that is there from the beginning sounds all that time.
    let reader = Reader::new(Cursor::new(until.join("\n") + "\n"), "s.jsonl");
    let mut replay = Replay::new(reader, Recordings::default()).unwrap();
    let mut loud = 0;
    while let Some(frames) = replay.block().unwrap() {
        loud += frames.iter().filter(|x| x.abs() > 0.01).count();
    }
    assert!(loud > 1000, "{loud}");
    // Nothing comes behind the end, however often one asks.
    assert!(replay.block().unwrap().is_none() && replay.met().frames == met.frames);
}

#[test]
fn a_journal_cannot_ask_for_more_than_a_session_has() {
    let text = short("greedy");
    let refused = |text: &str, says: &str| match outcome(text) {
        Err(error) => assert!(error.contains(says), "`{error}` does not say `{says}`"),
        Ok(met) => panic!("it was played: {met:?}"),
    };
    let with = |line: &str| {
        let end = text.find("{\"kind\":\"end\"").unwrap();
        format!("{}{line}{}", &text[..end], &text[end..])
    };
    refused(&with("{\"kind\":\"end\",\"frame\":18446744073709551615}\n"), "hours after all");
    refused(&with("{\"kind\":\"clock\",\"frame\":9000000000}\n"), "52.1 hours after all");
    refused(&text.replacen("\"gain\":1.0", "\"gain\":1e30", 1), "from 0 to 1, not 1e30;");
    refused(&text.replacen("\"gain\":1.0", "\"gain\":-1.0", 1), "from 0 to 1, not -1");
    let plan = text.lines().nth(1).unwrap();
    refused(&with(&format!("{plan}\n").repeat(100)), "plans wait here");
    let lost = "{\"kind\":\"lost\",\"value\":1e300}\n";
    assert_eq!(outcome(&with(&lost.repeat(3))).unwrap().lost, u64::MAX);
}

#[test]
fn bytes_of_any_kind_are_no_reason_to_panic() {
    let text = short("hostile");
    let mut state = 1_u64;
    for _ in 0..300 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..3 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (state >> 33) as usize % bytes.len();
            bytes[at] = (state >> 20) as u8;
        }
        let mut reader = Reader::new(Cursor::new(&bytes), "s");
        while let Ok(Some(_)) = reader.read() {}
        // What can still be played is played, a second of it at most.
        if let Ok(mut replay) = Replay::new(Reader::new(Cursor::new(&bytes), "s"), Recordings::default()) {
            while replay.met().frames < 48_000 && matches!(replay.block(), Ok(Some(_))) {}
        }
    }
}

#[test]
fn the_document_explains_every_column_and_kind() {
    let text = include_str!("../docs/journal.md");
    for word in COLUMNS.iter().filter(|column| **column != "kind") {
        assert!(text.contains(&format!("`{word}`")), "{word}");
    }
    for kind in Kind::ALL {
        assert!(text.contains(&format!("`{}`", kind.word())), "{kind:?}");
    }
}
