use std::io::Cursor;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use pacinian::engine::task::{Task, Values};
use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::reader::Reader;
use pacinian::io::journal::remake::Recordings;
use pacinian::io::journal::replay::Replay;
use pacinian::io::journal::{Journal, Kind};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::schedule::Beat;

use super::{PATCH, folder, lines, recorded, reload, replayed, setting, until};

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
    let journal =
        Journal::create(&journal_path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
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
    let recorded = recorded(&recording);
    assert_eq!((written.frames * 3, again.len()), (recorded.len() as u64, recorded.len()));
    let different = recorded.iter().zip(&again).position(|(a, b)| a.to_bits() != b.to_bits());
    assert_eq!(different, None, "of {}", recorded.len());
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
