use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::{Journal, Kind};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::{Beginning, Session};
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::live::conductor::Told;
use pacinian::live::signal::Signal;
use pacinian::midi::{Channel, Message};

use super::{PATCH, folder, lines, recorded, reload, replayed, setting, until};

const FLOOD: u32 = 100_000;

/// A hundred thousand messages in a second or two, while patches are taken over: all of it is in the journal, and is played again to the bit.
#[test]
fn a_flood_during_reloads_is_played_again_to_the_bit() {
    let folder = folder("flood");
    for ending in ["csv", "jsonl"] {
        let (path, recording) = (folder.join(format!("s.{ending}")), folder.join("s.wav"));
        let first = reload(PATCH);
        let journal =
            Journal::create(&path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
        let (hears, is_told) = (journal.clone(), journal.clone());
        let swaps = Arc::<AtomicU64>::default();
        let count = Arc::clone(&swaps);
        let mut session = Session::start(Beginning {
            block: Some(64),
            record: true,
            listener: Some(Box::new(move |event| hears.hear(event))),
            audience: Box::new(move |told| {
                count.fetch_add(u64::from(matches!(told, Told::Reloaded)), Ordering::Relaxed);
                is_told.told(&told);
            }),
            ..Beginning::of(first, Chosen::Virtual(None))
        })
        .unwrap();
        let ring = session.recording().unwrap();
        let recorder = Recorder::start(ring, &recording, WavSpec::new(3, 48_000, Encoding::F32)).unwrap();
        until(&session, 4_800);
        let channel = Channel::new(0).unwrap();
        for n in 0..FLOOD {
            // Every note ends, so that no more sound than there are keys.
            let note = (n / 2 % 128) as u8;
            let message = match n % 2 {
                0 => Message::NoteOn { channel, note, velocity: 100 },
                _ => Message::NoteOff { channel, note, velocity: 0 },
            };
            // What finds no room is counted, and let go of all the same.
            let _ = session.handle().send(Signal::Midi(0, message));
            if n % 25_000 == 12_500 {
                let other = PATCH.replace("frequency = 100", &format!("frequency = {}", 101 + n / 25_000));
                while session.handle().send(Signal::Reload(Box::new(reload(&other)))).is_err() {
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
            if n % 128 == 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        until(&session, session.board().frames.get() + 24_000);
        session.stop();
        let written = recorder.finish().unwrap();
        assert_eq!((written.frames, session.board().unrecorded.get()), (session.board().frames.get(), 0));
        let lost = journal.finish().unwrap();
        let came = lines(&path).iter().filter(|line| line.kind == Kind::In).count();
        println!("{ending}: {came} came, {lost} lines lost, {} reloads", swaps.load(Ordering::Relaxed));
        let (again, met) = replayed(&path);
        assert_eq!((met.lost, session.board().untold.get()), (0, 0), "{lost}");
        assert!(met.ended && met.swaps >= 1 && swaps.load(Ordering::Relaxed) >= 1, "{met:?}");
        let recorded = recorded(&recording);
        assert_eq!((met.frames * 3, again.len()), (recorded.len() as u64, recorded.len()));
        let different = recorded.iter().zip(&again).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(different, None, "of {}", recorded.len());
        let refused = session.board().refused.get();
        assert!(came as u64 + refused >= u64::from(FLOOD) && came > 10_000, "{came} came, {refused} refused");
        assert!(recorded.iter().any(|x| x.abs() > 0.3), "something was to be heard");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
