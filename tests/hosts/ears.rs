//! Sessions that listen to a device while they play on another.

use std::f64::consts::TAU;
use std::time::Duration;

use cpal::{ErrorKind, SampleFormat};
use pacinian::io::device::choose::heard_among;
use pacinian::io::device::keeper::Fate;
use pacinian::io::session::{Beginning, Ear, Session};

use crate::scripted::{Make, Scripted, System};
use crate::{Fates, clock_goes_on, first_of_two, named, noting, reload, wait};

/// Passes on what the first channel of the input brings.
const LISTENS: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"i\"\n[voice.v.nodes]\n\
    i = { type = \"input\" }\n";

/// A session that passes on what an ear hears.
fn listening(card: &Scripted, ear: &Scripted) -> (Session, Fates) {
    let system = System::of(&[card, ear]);
    let fates = Fates::default();
    let device = heard_among(&system.hosts(), "Ear").unwrap();
    let beginning = Beginning {
        block: Some(64),
        input: Ear::Device { device, fate: noting(&fates) },
        armed: true,
        ..Beginning::of(reload(LISTENS, 2), named(&system, "Card").unwrap())
    };
    (Session::start(beginning).unwrap_or_else(|error| panic!("{error}")), fates)
}

/// Nothing is heard in blocks that are longer than what is heard at a time: that is refused, and not heard with a gap in each.
#[test]
fn blocks_too_long_to_listen_in_are_refused() {
    for (block, taken) in [(8_192, true), (8_193, false)] {
        let system = System::of(&[&Scripted::new(Make::default()), &ear(Make::default())]);
        let device = heard_among(&system.hosts(), "Ear").unwrap();
        let beginning = Beginning {
            block: Some(block),
            input: Ear::Device { device, fate: Box::new(|_| ()) },
            ..Beginning::of(reload(LISTENS, 2), named(&system, "Card").unwrap())
        };
        match Session::start(beginning) {
            Ok(mut session) => {
                session.stop();
                assert!(taken, "{block}");
            }
            Err(error) => assert!(!taken && error.to_string().contains("8192 at most"), "{block}: {error}"),
        }
    }
}

/// Whether what is heard was played in the last 25 ms.
fn sounds(card: &Scripted) -> bool {
    let all = card.latest().samples;
    all[all.len().saturating_sub(2 * 1_200)..].iter().any(|x| x.abs() > 0.4)
}

fn ear(make: Make) -> Scripted {
    let heard = |frame: u64, _: usize| (0.5 * (TAU * 200.0 * frame as f64 / 48_000.0).sin()) as f32;
    Scripted::new(Make { id: "ear", name: "Ear", outputs: vec![], inputs: vec![1], heard, ..make })
}

/// What is left of a tone of 200 Hz, fast by so many millionths, when the best one is taken out of each tenth of a second: the median
/// of shares of energy.
fn residue(signal: &[f64], fast: f64) -> f64 {
    let mut all: Vec<f64> = signal
        .chunks_exact(4_800)
        .map(|part| {
            let omega = TAU * 200.0 * (1.0 + fast * 1e-6) / 48_000.0;
            // Within a tenth of a second there are twenty periods, so that the two are as good as orthogonal.
            let (mut s, mut c, mut energy) = (0.0, 0.0, 0.0);
            for (n, x) in part.iter().enumerate() {
                let phase = omega * n as f64;
                (s, c, energy) = (s + x * phase.sin(), c + x * phase.cos(), energy + x * x);
            }
            1.0 - 2.0 * (s * s + c * c) / (part.len() as f64 * f64::max(energy, 1e-30))
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

#[test]
fn an_ear_on_a_fast_clock_with_blocks_of_any_length_is_heard() {
    // Gaps that the machine makes are counted; then it is tried again.
    for attempt in 0..5 {
        let card = Scripted::new(Make { blocks: vec![64, 200, 0, 7, 128], ..Make::default() });
        let ear = ear(Make {
            fast: 200.0,
            formats: vec![SampleFormat::I32],
            blocks: vec![1, 7, 0, 64, 150, 111, 0, 480, 64],
            ..Make::default()
        });
        let (mut session, fates) = listening(&card, &ear);
        wait("four seconds", || card.length() > 2 * 48_000 * 4);
        session.stop();
        let input = &session.board().input;
        let gaps = input.dry.get() + input.jumps.get() + input.lost.get();
        let played = first_of_two(&card.latest().samples);
        let late = &played[2 * 48_000..4 * 48_000 - 4_800];
        let rest = residue(late, 200.0);
        assert!(late.iter().any(|x| x.abs() > 0.45) && fates.lock().unwrap().is_empty());
        if rest < 0.02 && gaps <= 2 {
            return;
        }
        assert!(attempt < 4, "{rest} is left, {gaps} gaps");
    }
}

#[test]
fn an_ear_that_vanishes_is_silence_until_it_is_back_and_each_is_told_once() {
    let card = Scripted::new(Make::default());
    let ear = ear(Make::default());
    ear.is(|mood| mood.last_words = true);
    let (mut session, fates) = listening(&card, &ear);
    let silent = |card: &Scripted| {
        let all = card.latest().samples;
        all[all.len().saturating_sub(2 * 1_200)..].iter().all(|x| *x == 0.0)
    };
    // Gaps that it tells of are counted, and no loss.
    wait("sound", || sounds(&card));
    ear.is(|mood| mood.says.push_back(ErrorKind::Xrun));
    wait("the gap", || session.board().input.xruns.get() == 1);
    clock_goes_on(&session, 4_800);
    assert_eq!((ear.opened(), fates.lock().unwrap().len()), (1, 0));
    for n in 0..3 {
        wait("sound", || sounds(&card));
        ear.is(|mood| (mood.there, mood.lets_go) = (false, Duration::from_millis(100 * n)));
        wait("the loss", || fates.lock().unwrap().len() as u64 == 2 * n + 1);
        wait("silence", || silent(&card));
        clock_goes_on(&session, 4_800);
        ear.is(|mood| mood.there = true);
        wait("its return", || fates.lock().unwrap().len() as u64 == 2 * n + 2);
    }
    // It is there again, takes streams, and hears nothing: it is not said to be back.
    wait("sound", || sounds(&card));
    ear.is(|mood| (mood.there, mood.lets_go) = (false, Duration::ZERO));
    wait("the loss", || fates.lock().unwrap().len() == 7);
    let before = ear.opened();
    ear.is(|mood| (mood.there, mood.mute) = (true, true));
    wait("a second try", || ear.opened() == before + 2);
    ear.is(|mood| mood.mute = false);
    wait("sound", || sounds(&card));
    assert_eq!(card.opened(), 1, "what is played on has nothing to do with it");
    session.stop();
    let fates = fates.lock().unwrap();
    let words: Vec<&str> = fates
        .iter()
        .map(|fate| match fate {
            Fate::Lost(_) => "lost",
            Fate::Back => "back",
            Fate::Moved | Fate::Lowered => "moved",
            Fate::Said(_) => "said",
        })
        .collect();
    assert_eq!(words, ["lost", "back", "lost", "back", "lost", "back", "lost", "said", "back"], "{fates:?}");
    // Within what is heard there is no step: its own slope, and fades of 5 ms.
    let played = first_of_two(&card.latest().samples);
    let most = 0.5 * (TAU * 200.0 / 48_000.0) + 0.5 / 240.0;
    let step = played.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    assert!(step < 1.5 * most, "{step} of {most}");
}

/// A stream that is never done holds nothing up.
#[test]
fn what_an_ear_does_not_give_back_is_taken_from_it() {
    let card = Scripted::new(Make::default());
    let ear = ear(Make::default());
    let (mut session, fates) = listening(&card, &ear);
    wait("sound", || sounds(&card));
    ear.is(|mood| (mood.there, mood.hangs) = (false, true));
    wait("the loss", || fates.lock().unwrap().len() == 1);
    wait("silence", || !sounds(&card));
    ear.is(|mood| mood.there = true);
    wait("its return", || fates.lock().unwrap().len() == 2);
    ear.is(|mood| mood.hangs = false);
    wait("sound", || sounds(&card));
    let told = fates.lock().unwrap().clone();
    assert!(matches!(&told[..], [Fate::Lost(_), Fate::Back]), "{told:?}");
    session.stop();
}
