use cpal::SampleFormat;
use pacinian::io::device::choose::Wish;
use pacinian::io::device::keeper::Fate;
use pacinian::io::journal::{Journal, Kind};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::wav::{Encoding, WavSpec};

use super::scripted::{Make, Scripted, System};
use super::{PATCH, folder, lines, recorded, reload, replayed, setting, until};

/// A card of few bits, that is away for a moment: what is recorded is what it was given, and the journal plays that again.
#[test]
fn what_is_kept_of_a_card_of_few_bits_is_what_it_was_given() {
    let folder = folder("steps");
    for (format, bits, full) in [(SampleFormat::I16, 16.0, 32_768.0), (SampleFormat::I24, 24.0, 8_388_608.0)]
    {
        let (journal_path, recording) = (folder.join("s.jsonl"), folder.join("s.wav"));
        let card = Scripted::new(Make { outputs: vec![3], formats: vec![format], ..Make::default() });
        let device = Wish::Named("Card".into()).choose_among(&System::of(&[&card]).hosts()).unwrap();
        let first = reload(PATCH);
        let journal =
            Journal::create(&journal_path, setting(), &first.scene.plan, first.provenance.as_deref())
                .unwrap();
        let (is_told, becomes) = (journal.clone(), journal.clone());
        let (fates, told) = std::sync::mpsc::channel();
        let mut session = Session::start(Beginning {
            armed: true,
            record: true,
            audience: Box::new(move |told| is_told.told(&told)),
            fate: Box::new(move |fate| {
                becomes.fate(&fate);
                drop(fates.send(fate));
            }),
            ..Beginning::of(first, device)
        })
        .unwrap();
        let spec = WavSpec::new(3, 48_000, Encoding::F32);
        let recorder = Recorder::start(session.recording().unwrap(), &recording, spec).unwrap();
        until(&session, 24_000);
        card.is(|mood| mood.there = false);
        assert!(matches!(told.recv().unwrap(), Fate::Lost(_)));
        card.is(|mood| mood.there = true);
        assert_eq!(told.recv().unwrap(), Fate::Back);
        let back = session.board().frames.get();
        until(&session, back + 24_000);
        session.stop();
        let written = recorder.finish().unwrap();
        assert_eq!((session.board().unrecorded.get(), journal.finish().unwrap()), (0, 0));

        let recorded = recorded(&recording);
        assert_eq!(written.frames * 3, recorded.len() as u64);
        let steps: Vec<f64> = recorded.iter().map(|x| f64::from(*x) * full).collect();
        assert!(steps.iter().all(|x| x.fract() == 0.0), "{format}: something lies between two steps");
        assert!(steps.iter().any(|x| x.abs() > 0.2 * full));
        // What the card had before it went, from its first frame on, and what it had since, up to its last.
        let [before, since] = &card.stretches()[..] else { panic!("{}", card.opened()) };
        let gone = before.gone.unwrap();
        assert!(gone > 60_000 && before.samples[..gone] == steps[..gone], "{format}");
        let last = since.samples.iter().rposition(|x| *x != 0.0).unwrap();
        let kept = steps.iter().rposition(|x| *x != 0.0).unwrap();
        let first = since.samples.iter().position(|x| *x != 0.0).unwrap();
        assert!(since.samples[first..=last] == steps[kept - (last - first)..=kept], "{format}");

        let (again, met) = replayed(&journal_path);
        assert!(met.ended && met.lost == 0, "{met:?}");
        let different = recorded.iter().zip(&again).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!((different, again.len()), (None, recorded.len()), "{format}");
        let told: Vec<_> = lines(&journal_path).into_iter().filter(|l| l.kind == Kind::Steps).collect();
        assert_eq!(
            told.iter().map(|line| (line.frame, line.value)).collect::<Vec<_>>(),
            [(Some(0), Some(bits))]
        );
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
