use std::path::Path;

use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::reader::{Item, Reader};
use pacinian::io::journal::{Journal, Kind, Line};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::live::signal::{Origin, Signal};
use pacinian::midi::Message;
use pacinian::{Note, Place};

use super::{PATCH, folder, lines, recorded, reload, replayed, setting, until};

/// Lets a session play, moved by everything that can move it, and keeps it.
fn play(journal_path: &Path, recording: &Path) {
    let first = reload(PATCH);
    let journal =
        Journal::create(journal_path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
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
    // Where the last was stopped before its third event: one that nobody stops.
    until(&session, frame);
    handle.start("walk").unwrap();
    until(&session, frame + 9_600);
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

/// What came in and asked for a line.
fn cause_of<'a>(lines: &'a [Line], line: &Line) -> Option<&'a Line> {
    let id = line.cause?;
    let mut came = lines.iter().filter(|line| line.kind == Kind::In && line.id == Some(id));
    let first = came.next().unwrap_or_else(|| panic!("nothing came in that was number {id}"));
    assert_eq!(came.count(), 0, "numbers are one line's alone");
    Some(first)
}

#[test]
fn what_was_played_is_played_again_to_the_bit() {
    let folder = folder("bits");
    for ending in ["csv", "jsonl"] {
        let (journal, recording) = (folder.join(format!("s.{ending}")), folder.join("s.wav"));
        play(&journal, &recording);
        let recorded = recorded(&recording);
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
        // What always sounds stands there where it begins, and begins in a replay by itself: with the session; with a patch that takes over it goes on.
        let always: Vec<_> = lines.iter().filter(|line| line.source.as_deref() == Some("always")).collect();
        let [hum] = always[..] else { panic!("{always:?}") };
        assert_eq!((hum.kind, hum.name.as_deref(), hum.sample), (Kind::Voice, Some("hum"), Some(0)));
        assert!(
            hum.frame == Some(0) && hum.seconds.is_some() && hum.gains.as_deref().unwrap().starts_with("1=")
        );
        // Whoever lets a patch take over is known.
        let mut swaps = lines.iter().filter(|line| line.kind == Kind::Swap);
        let asked =
            |line| cause_of(&lines, line).is_some_and(|came| came.message.as_deref() == Some("reload"));
        assert!(swaps.all(asked));
        let drawn = lines.iter().filter(|line| line.pattern.as_deref() == Some("walk"));
        assert!(
            drawn.clone().any(|line| line.event == Some(2) && line.drawn == Some(2)),
            "as the patch counts"
        );
        // What was played leads back to what came in and asked for it, and that to whoever sent it.
        let cause = |line: &Line| cause_of(&lines, line);
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
