//! What reaches a knob beside events is kept as well: worlds of a slow thread, and the patterns that it sets off.

use std::collections::BTreeMap;
use std::path::Path;

use pacinian::Rig;
use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::{Journal, Kind, Line};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::knob::local_model::model::{Contact, LocalModel};
use pacinian::knob::local_model::pending::Message;
use pacinian::live::provenance::RigText;
use pacinian::live::reload::Reload;
use pacinian::live::signal::Signal;

use super::{folder, lines, recorded, replayed, setting, staged, until};

/// What the knob does is heard: its torque and its angle as levels of a hum.
const PATCH: &str = r#"format = "pacinian-patch/1"
title = "t"
[knob.effects]
notches = { type = "detents", count = 24, torque = 0.004 }
[voice.hum]
output = "o"
start = "always"
nodes.o = { type = "sine", frequency = 150, amplitude = "0.1 + 3 * abs(knob.torque) + 0.1 * abs(knob.angle)" }
[voice.click]
voices = 16
output = "o"
place = 2
nodes.o = { type = "sine", frequency = 200, amplitude = "decay" }
nodes.decay = { type = "envelope", attack = 0.001, decay = 0.01, sustain = 0 }
[pattern.roll]
events = [{ at = 0.0, voice = "click", level = 0.5 }, { at = 0.03, voice = "click", level = 0.25 }]
[[trigger]]
on = "knob.detent"
play = "roll"
set = { gain = "min(1, speed / 10)" }
"#;

fn reload(text: &str) -> Reload {
    let options = Options { rate: Some(48_000.0), live: true, block: Some(64), ..Options::default() };
    staged(text, Rig::default_for(2), (RigText::Line { line: 2 }, Vec::new()), &options)
}

/// Plays for a second, while a slow thread sends a wall and kicks and the hand turns, with another patch from the middle on.
fn play(journal_path: &Path, recording: &Path) {
    let first = reload(PATCH);
    let journal =
        Journal::create(journal_path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
    let (hears, is_told) = (journal.clone(), journal.clone());
    let mut session = Session::start(Beginning {
        block: Some(64),
        record: true,
        link_knob: true,
        listener: Some(Box::new(move |event| hears.hear(event))),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    let mut slow = session.linked_knob().unwrap();
    let ring = session.recording().unwrap();
    let recorder = Recorder::start(ring, recording, WavSpec::new(2, 48_000, Encoding::F32)).unwrap();
    let mut most = 0.0_f64;
    for step in 0..40 {
        until(&session, 4_800 + 1_200 * step);
        let look = slow.look();
        most = most.max(look.torque.abs());
        let contact = Contact { angle: 0.5, below: false, stiffness: 0.02 + 0.002 * step as f64 };
        let range = (look.angle - 1.0, look.angle + 1.0);
        let torque = if step == 17 { f64::NAN } else { 0.001 * (step % 3) as f64 };
        let model =
            LocalModel { stamp: look.tick, torque, contact: Some(contact), range, ..LocalModel::FREE };
        slow.send(Message::new(model, if step % 5 == 0 { 2e-6 } else { 0.0 }));
        if step % 10 == 0 {
            let to = if step % 20 == 0 { 1.0 } else { -0.3 };
            session.handle().send(Signal::Set("hand".into(), to)).unwrap();
        }
        if step == 20 {
            let next = PATCH.replace("frequency = 150", "frequency = 170");
            session.handle().send(Signal::Reload(Box::new(reload(&next)))).unwrap();
        }
    }
    session.stop();
    assert!(most > 0.003, "the wall is felt: {most}");
    let written = recorder.finish().unwrap();
    assert_eq!((written.frames, session.board().unrecorded.get()), (session.board().frames.get(), 0));
    assert_eq!((journal.finish().unwrap(), session.board().untold.get()), (0, 0));
}

#[test]
fn a_slow_thread_and_what_a_knob_sets_off_are_played_again_to_the_bit() {
    let folder = folder("knob");
    for ending in ["csv", "jsonl"] {
        let (journal, recording) = (folder.join(format!("s.{ending}")), folder.join("s.wav"));
        play(&journal, &recording);
        let (again, met) = replayed(&journal);
        assert!(met.ended && met.lost == 0 && met.swaps == 1, "{met:?}");
        let heard = recorded(&recording);
        let differs = heard.iter().zip(&again).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!((differs, heard.len()), (None, again.len()), "{ending}");

        // It takes what the slow thread sent for that.
        let text = std::fs::read_to_string(&journal).unwrap();
        let is_model = |line: &&str| line.starts_with("model,") || line.contains("\"kind\":\"model\"");
        let without: Vec<&str> = text.lines().filter(|line| !is_model(line)).collect();
        let part = folder.join(format!("without.{ending}"));
        std::fs::write(&part, without.join("\n") + "\n").unwrap();
        assert!(replayed(&part).0 != again);

        let lines = lines(&journal);
        let models = lines.iter().filter(|line| line.kind == Kind::Model).count();
        assert!(models > 20, "{models}");
        assert!(lines.iter().any(|line| line.fields.contains_key("refused")));
        // Every voice of a pattern names the notch that asked for it, and is due as long after it as the pattern says; the block is 64 frames.
        let notches: BTreeMap<u64, &Line> = lines
            .iter()
            .filter(|line| line.source.as_deref() == Some("knob"))
            .map(|line| (line.id.unwrap(), line))
            .collect();
        assert!(notches.len() > 5, "{}", notches.len());
        assert!(notches.values().all(|line| line.name.as_deref() == Some("knob.detent")
            && line.message.as_deref() == Some("start roll")));
        let mut rolls = 0;
        for line in lines.iter().filter(|line| line.pattern.as_deref() == Some("roll")) {
            let notch = notches[&line.cause.unwrap()];
            let due = |line: &Line| line.due_sample.unwrap() as f64 + line.due_fraction.unwrap();
            let later = due(line) - due(notch) - if line.event == Some(1) { 0.0 } else { 240.0 };
            assert!(later.abs() < 1e-6, "{later}: {line:?} {notch:?}");
            rolls += 1;
        }
        assert!(rolls >= 2 * notches.len() - 4, "{rolls} {}", notches.len());
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
