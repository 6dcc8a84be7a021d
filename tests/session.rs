//! A whole session on the virtual card: what is sent is played when it should be, stops when it must, and what takes over does so
//! without a gap.

#[path = "common/unbroken.rs"]
mod unbroken;

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::session::{Beginning, Session};
use pacinian::live::callback::{Deed, Report};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::signal::{Signal, Stamped};
use pacinian::node::asset::NoAssets;
use pacinian::{Note, Patch, Rig};
use ringbuf::HeapCons;
use ringbuf::traits::Consumer;

const HUM: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.hum]\nstart = \"always\"\noutput = \"s\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n[voice.tap]\noutput = \"o\"\nplace = \"t2\"\n[voice.tap.nodes]\n\
    s = { type = \"sine\", frequency = 250 }\ne = { type = \"envelope\", attack = 0.001, release = 0.005 }\n\
    o = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n";

fn reload(text: &str) -> Reload {
    reload_on(text, Rig::default_for(2))
}

fn reload_on(text: &str, rig: Rig) -> Reload {
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Reload::of(patch, rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"))
}

/// What was told, in words.
type Words = Arc<Mutex<Vec<String>>>;

fn start(text: &str) -> (Session, HeapCons<f32>, Words) {
    start_with(reload(text))
}

fn start_with(scene: Reload) -> (Session, HeapCons<f32>, Words) {
    start_in(64, scene)
}

/// In blocks of so many frames.
fn start_in(block: u32, scene: Reload) -> (Session, HeapCons<f32>, Words) {
    let words = Words::default();
    let heard = Arc::clone(&words);
    let audience = move |told: Told<'_>| {
        heard.lock().unwrap().push(match told {
            Told::Report(Report { deed: Deed::Event { at, due, event, .. }, .. }, _) => {
                format!("event {} {} {event:?}", at.sample, due.sample)
            }
            Told::Report(Report { frame, deed: Deed::Order(order, _) }, _) => {
                format!("Order({frame}, {order:?})")
            }
            Told::Report(report, _) => format!("{report:?}"),
            Told::Came(stamped) => format!("came {}", stamped.id),
            Told::Began(..) | Told::Reloading(..) | Told::Vain(..) => return,
            Told::Lost(port, _) => format!("lost {port}"),
            Told::Refused(problem, cause) => format!("refused {cause}: {problem}"),
            Told::Reloaded => "reloaded".into(),
            Told::Playing(_) => "playing".into(),
            Told::Kept(why, cause) => format!("kept {cause}: {why}"),
        });
    };
    let mut session = Session::start(Beginning {
        block: Some(block),
        record: true,
        audience: Box::new(audience),
        ..Beginning::of(scene, Chosen::Virtual(None))
    })
    .unwrap_or_else(|error| panic!("{error}"));
    let recording = session.recording().unwrap();
    (session, recording, words)
}

fn wait(what: &str, holds: impl Fn() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < Duration::from_secs(10), "{what} did not come");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Fetches what was recorded so far, a channel of two.
fn fetch(recording: &mut HeapCons<f32>, all: &mut Vec<f32>) {
    all.extend(recording.pop_iter());
}

fn channel(all: &[f32], number: usize) -> Vec<f32> {
    all.iter().skip(number).step_by(2).copied().collect()
}

#[test]
fn a_panic_ends_in_exact_zeros_within_its_ramp_and_holds_through_a_reload() {
    let (mut session, mut recording, words) = start(HUM);
    let mut all = Vec::new();
    wait("the ramp's end", || session.board().frames.get() > 12_000);
    session.handle().panic();
    wait("the gate", || session.board().shut.get() == 1);
    let shut = session.board().frames.get() as usize;
    session.handle().send(Signal::Reload(Box::new(reload(&HUM.replace("100", "150"))))).unwrap();
    session.handle().send(Signal::Arm(true)).unwrap();
    wait("the new patch", || words.lock().unwrap().iter().any(|w| w.contains("Swap")));
    wait("a while", || session.board().frames.get() > shut as u64 + 9600);
    session.stop();
    fetch(&mut recording, &mut all);
    let hum = channel(&all, 0);
    assert!(hum[10_000..12_000].iter().any(|x| x.abs() > 0.45));
    // The order was given before one of the frames; two milliseconds later nothing comes through.
    let latch =
        words.lock().unwrap().iter().find_map(|w| {
            w.strip_prefix("Order(").and_then(|w| w.strip_suffix(", Latch)")).map(str::to_string)
        });
    let latch: usize = latch.unwrap_or_else(|| panic!("{:?}", words.lock().unwrap())).parse().unwrap();
    let last = hum.iter().rposition(|x| *x != 0.0).unwrap();
    assert!(last < latch + 96, "{last} after {latch}");
    assert!(all[2 * (latch + 96)..].iter().all(|x| x.to_bits() == 0), "exact zeros, not small ones");
}

#[test]
fn calm_brings_it_back_and_the_voice_that_is_always_on() {
    let (mut session, mut recording, _) = start(HUM);
    wait("the ramp's end", || session.board().frames.get() > 10_000);
    session.handle().panic();
    wait("the gate", || session.board().shut.get() == 1);
    session.handle().send(Signal::Calm).unwrap();
    let from = session.board().frames.get();
    wait("a while", || session.board().frames.get() > from + 14_400);
    session.stop();
    let mut all = Vec::new();
    fetch(&mut recording, &mut all);
    let hum = channel(&all, 0);
    assert!(hum[from as usize + 9800..from as usize + 14_000].iter().any(|x| x.abs() > 0.45));
}

/// Else a journal would not have it, and a replay would play on where the output was shut.
#[test]
fn what_the_gate_does_last_is_told_however_long_blocks_are() {
    let (mut session, _recording, words) = start_in(65_536, reload(HUM));
    let from = session.board().frames.get();
    // The next one is 1.37 s later.
    wait("a block", || session.board().frames.get() > from);
    session.stop();
    let words = words.lock().unwrap();
    assert!(words.iter().any(|word| word.starts_with("Order(") && word.ends_with("Close)")), "{words:?}");
}

#[test]
fn what_plays_from_the_beginning_is_stopped_as_often_as_is_asked_for() {
    let beat = |name: &str| {
        format!(
            "{HUM}[[trigger]]\non = \"start\"\nplay = \"{name}\"\n[pattern.{name}]\nrepeat = {{ every = 0.02 }}\n\
             events = [{{ at = 0, voice = \"tap\", duration = 0.005 }}]\n"
        )
    };
    let (mut session, _recording, words) = start(&beat("a"));
    let played = || words.lock().unwrap().iter().filter(|word| word.contains("Play(")).count();
    for name in ["b", "c"] {
        let before = played();
        wait("the pattern", || played() > before + 3);
        session.handle().stop(0).unwrap();
        let from = session.board().frames.get();
        wait("its end", || session.board().frames.get() > from + 9_600);
        let before = played();
        let from = session.board().frames.get();
        wait("a while", || session.board().frames.get() > from + 9_600);
        assert_eq!(played(), before, "it plays on where {name} is next");
        session.handle().send(Signal::Reload(Box::new(reload(&beat(name))))).unwrap();
    }
    session.stop();
}

#[test]
fn what_is_played_comes_and_never_before_its_time() {
    let (mut session, mut recording, words) = start(HUM);
    wait("the ramp's end", || session.board().frames.get() > 10_000);
    let mut voices = Vec::new();
    for _ in 0..20 {
        std::thread::sleep(Duration::from_millis(21));
        voices.push(session.handle().play("tap", Note::default()).unwrap());
    }
    session.handle().play("tab", Note::default()).unwrap();
    voices.into_iter().for_each(|voice| session.handle().release(voice).unwrap());
    let from = session.board().frames.get();
    wait("a while", || session.board().frames.get() > from + 4800);
    session.stop();
    let words = words.lock().unwrap();
    let plays: Vec<&String> =
        words.iter().filter(|w| w.contains("Play") && w.contains("instrument: 1")).collect();
    assert_eq!(plays.len(), 20, "{words:?}");
    // It names the signal that it answers, the 21st.
    assert!(
        words.iter().any(|w| w.starts_with("refused 21: ") && w.contains("tab") && w.contains("tap")),
        "{words:?}"
    );
    // Where the machine stood still, one may be late; it is then played with the next sample, and never before its time.
    for play in &plays {
        let samples: Vec<u64> = play.split(' ').skip(1).take(2).map(|n| n.parse().unwrap()).collect();
        assert!(samples[0] >= samples[1], "{play}");
    }
    let mut all = Vec::new();
    fetch(&mut recording, &mut all);
    assert!(channel(&all, 1).iter().any(|x| x.abs() > 0.5));
}

#[test]
fn another_patch_takes_over_without_a_gap_or_a_jump() {
    let (mut session, mut recording, words) = start(HUM);
    let mut all = Vec::new();
    wait("the ramp's end", || session.board().frames.get() > 10_000);
    // A hundred times another voice beside the one that hums.
    for n in 0..100 {
        let text = HUM.replace("frequency = 250", &format!("frequency = {}", 200 + n));
        while session.handle().send(Signal::Reload(Box::new(reload(&text)))).is_err() {}
        let swaps = || words.lock().unwrap().iter().filter(|w| w.contains("deed: Swap")).count();
        wait("the new patch", || swaps() == n + 1);
        fetch(&mut recording, &mut all);
    }
    // Behind them the gate closes, and however busy the machine is, some blocks more come.
    let end = session.board().frames.get() as usize;
    session.stop();
    fetch(&mut recording, &mut all);
    let hum = channel(&all, 0);
    // The steepest step of a sine of 100 Hz and 0.5 at 48 kHz is 0.00654, and no swap makes a steeper one.
    let steepest = hum[9700..end].windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
    let at = hum.windows(2).position(|w| (w[1] - w[0]).abs() == steepest);
    assert!(steepest < 0.00656, "{steepest} at {at:?} of {end}");
    assert!(hum[9700..end].chunks(480).filter(|c| c.len() == 480).all(|c| c.iter().any(|x| x.abs() > 0.45)));
}

/// What leaves keeps to the rig's level, to the bit, while other rigs take over; on the way to another level, to the higher of both.
#[test]
fn nothing_is_beyond_the_level_of_the_rig_that_plays() {
    const WILD: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.loud]\nstart = \"always\"\noutput = \"s\"\n\
        [voice.loud.nodes]\ns = { type = \"pulse\", frequency = 90, amplitude = 40 }\n[voice.noise]\nstart = \"always\"\n\
        output = \"n\"\nplace = \"t2\"\nnodes.n = { type = \"white\", amplitude = 1e6 }\n";
    let at = |level: f64| {
        let mut rig = Rig::default_for(2);
        rig.device.max_level = level;
        reload_on(WILD, rig)
    };
    let levels = [0.3, 0.05, 0.7, 1.0 / 3.0, 0.1];
    let (mut session, mut recording, words) = start_with(at(levels[0]));
    let mut all = Vec::new();
    wait("the ramp's end", || session.board().frames.get() > 12_000);
    let swaps = || -> Vec<usize> {
        let words = words.lock().unwrap();
        let frame =
            |w: &String| w.strip_prefix("Report { frame: ")?.strip_suffix(", deed: Swap }")?.parse().ok();
        words.iter().filter_map(frame).collect()
    };
    for (n, level) in levels.iter().enumerate().skip(1) {
        session.handle().send(Signal::Reload(Box::new(at(*level)))).unwrap();
        wait("the other rig", || swaps().len() == n);
        // The limiter forgets in half a second how loud it was under a lower level.
        let from = session.board().frames.get();
        wait("a while", || session.board().frames.get() > from + 36_000);
        fetch(&mut recording, &mut all);
    }
    session.stop();
    fetch(&mut recording, &mut all);
    let swaps = swaps();
    let mut reached = [false; 5];
    for (n, frame) in all.chunks(2).enumerate() {
        let now = swaps.partition_point(|swap| *swap <= n);
        // 800 samples of the engine, and those frames of one that were given out before.
        let glides = now > 0 && n < swaps[now - 1] + 6 * 800 + 6;
        let most = if glides { levels[now - 1].max(levels[now]) } else { levels[now] };
        for x in frame {
            assert!(f64::from(x.abs()) <= most, "frame {n}: {x} beyond {most}, after {swaps:?}");
            reached[now] |= f64::from(x.abs()) > 0.9 * levels[now];
        }
    }
    assert_eq!(reached, [true; 5], "it is loud on every rig");
}

/// A hundred thousand messages as fast as they can be sent, by two threads, while patches are taken over: each is played or counted, and
/// what hums goes on as if nothing were.
#[test]
fn a_flood_of_midi_during_reloads_is_played_or_counted() {
    use pacinian::engine::event::Event;
    use pacinian::live::callback::Deed;
    use pacinian::midi::{Channel, Message};
    use std::sync::atomic::{AtomicU64, Ordering};

    let keys = format!("{HUM}[[trigger]]\non = \"midi.note\"\nplay = \"tap\"\n");
    let counts = Arc::new([const { AtomicU64::new(0) }; 4]);
    let count = Arc::clone(&counts);
    // What is refused is what came last.
    let mut begins = false;
    let mut session = Session::start(Beginning {
        block: Some(64),
        record: true,
        audience: Box::new(move |told| {
            if let Told::Came(Stamped { signal, .. }) = &told {
                begins = matches!(signal, Signal::Midi(_, Message::NoteOn { .. }));
            }
            let which = match told {
                Told::Came(_) if begins => 0,
                Told::Report(
                    pacinian::live::callback::Report {
                        deed: Deed::Event { event: Event::Play(_), .. }, ..
                    },
                    _,
                ) => 1,
                Told::Refused(..) if begins => 2,
                Told::Reloaded => 3,
                _ => return,
            };
            count[which].fetch_add(1, Ordering::Relaxed);
        }),
        ..Beginning::of(reload(&keys), Chosen::Virtual(None))
    })
    .unwrap();
    let watch = unbroken::Watch::start(session.recording().unwrap(), Arc::clone(session.board()));
    wait("the ramp's end", || session.board().frames.get() > 12_000);
    let (taken, refused) = std::thread::scope(|scope| {
        let flood = |port: u16| {
            let handle = session.handle().clone();
            move || {
                let channel = Channel::new(0).unwrap();
                let (mut taken, mut refused) = (0_u64, 0_u64);
                for n in 0..50_000_u32 {
                    // Every note ends, so that no more sound than there are keys.
                    let note = (n / 2 % 128) as u8;
                    let message = match n % 2 {
                        0 => Message::NoteOn { channel, note, velocity: 100 },
                        _ => Message::NoteOff { channel, note, velocity: 0 },
                    };
                    let on = u64::from(n % 2 == 0);
                    match handle.send(Signal::Midi(port, message)) {
                        Ok(()) => taken += on,
                        Err(_) => refused += 1,
                    }
                    if n % 256 == 0 {
                        std::thread::sleep(Duration::from_millis(2));
                    }
                }
                (taken, refused)
            }
        };
        let floods = [scope.spawn(flood(0)), scope.spawn(flood(1))];
        for n in 0..4 {
            // What hums goes on as it is.
            let other = keys.replace("frequency = 250", &format!("frequency = {}", 251 + n));
            while session.handle().send(Signal::Reload(Box::new(reload(&other)))).is_err() {
                std::thread::sleep(Duration::from_millis(1));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let [a, b] = floods.map(|flood| flood.join().unwrap());
        (a.0 + b.0, a.1 + b.1)
    });
    let of = |which: usize| counts[which].load(Ordering::Relaxed);
    let met = || of(1) + of(2) + session.board().dropped.get();
    wait("all of it", || of(0) == taken && met() >= taken);
    // All keys are up, however late they were: what is always on is all that sounds.
    wait("the last note's end", || session.board().voices.get() == 1);
    // More may not come of it.
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(met(), taken, "{} given to the engine, {} refused with a word", of(1), of(2));
    session.stop();
    watch.finish(session.board(), 0, 2, 0.5, 12_000, 64);
    assert_eq!(of(0), taken, "what was taken came");
    assert!(taken > 10_000 && of(1) > 1_000, "{taken} taken, {} played", of(1));
    assert!(session.board().refused.get() >= refused, "those that found no room");
    assert!(of(3) >= 1, "a patch took over meanwhile");
    assert_eq!(session.board().untold.get(), 0);
}

/// What plays from the beginning is stopped pattern by pattern, as what was started later, and stays so when the patch is saved anew.
#[test]
fn a_pattern_of_the_beginning_is_stopped_by_its_name() {
    let mut text = HUM.to_string();
    for (name, frequency) in [("low", 60), ("high", 200)] {
        text += &format!(
            "[[trigger]]\non = \"start\"\nplay = \"{name}\"\n[pattern.{name}]\nrepeat = {{ every = 0.05 }}\n\
             events = [{{ at = 0, voice = \"tap\", frequency = {frequency} }}]\n"
        );
    }
    let text = text.replace("frequency = 250", "frequency = \"event.frequency\"");
    let (mut session, _recording, words) = start(&text);
    let played = |frequency: &str| {
        let events = words.lock().unwrap();
        events.iter().filter(|w| w.starts_with("event") && w.contains(frequency)).count()
    };
    wait("both", || played("[60.0") > 2 && played("[200.0") > 2);
    session.handle().send(Signal::StopNamed("low".into())).unwrap();
    // What was sent ahead still comes.
    let high = played("[200.0");
    wait("the others", || played("[200.0") > high + 3);
    let low = played("[60.0");
    let stays = |what: &str| {
        let high = played("[200.0");
        wait(what, || played("[200.0") > high + 4);
        assert_eq!(played("[60.0"), low, "{what}");
    };
    stays("the next");
    session.handle().send(Signal::Reload(Box::new(reload(&text.replace("100", "150"))))).unwrap();
    wait("the new patch", || words.lock().unwrap().iter().any(|w| w.contains("Swap")));
    stays("those after it");
    session.handle().send(Signal::StopNamed("high".into())).unwrap();
    session.handle().send(Signal::Start(7, "low".into())).unwrap();
    wait("its return", || played("[60.0") > low + 2);
    session.stop();
}

/// However much is asked of the gate, that it is to close is heard.
#[test]
fn a_flood_of_orders_does_not_keep_the_gate_open() {
    let (mut session, mut recording, _) = start(HUM);
    wait("the ramp's end", || session.board().frames.get() > 12_000);
    let handle = session.handle().clone();
    let flood = std::thread::spawn(move || {
        let mut sent = 0_u32;
        while handle.send(Signal::Arm(true)) != Err(pacinian::live::signal::Refused::Ended)
            && sent < 5_000_000
        {
            sent += 1;
        }
    });
    std::thread::sleep(Duration::from_millis(100));
    // As a signal of the system does it.
    session.board().lever.closing().store(true, std::sync::atomic::Ordering::Relaxed);
    wait("the gate", || session.board().shut.get() == 1);
    let shut = session.board().frames.get();
    wait("a while", || session.board().frames.get() > shut + 4_800);
    session.stop();
    flood.join().unwrap();
    let mut all = Vec::new();
    fetch(&mut recording, &mut all);
    let last = all.iter().rposition(|x| *x != 0.0).unwrap() / 2;
    assert!(last > 10_000 && (last as u64) < shut, "{last} {shut}");
}

/// The output comes in slowly, and what plays from the beginning waits for it: the first is as strong as the second.
#[test]
fn the_first_that_is_felt_has_its_full_level() {
    let text = HUM.to_string()
        + "[[trigger]]\non = \"start\"\nplay = \"tap\"\nset = { duration = 0.05 }\nplace = 1\n\
           [[trigger]]\non = \"start\"\nplay = \"taps\"\n\
           [pattern.taps]\nevents = [{ at = 0, voice = \"tap\", duration = 0.05 }, { at = 0.3, voice = \"tap\", duration = 0.05 }]\n";
    let text = text.replace("start = \"always\"\n", "");
    let (mut session, mut recording, _) = start(&text);
    wait("both", || session.board().started.get() == 3 && session.board().voices.get() == 0);
    session.stop();
    let mut all = Vec::new();
    fetch(&mut recording, &mut all);
    let taps = channel(&all, 1);
    let first = taps.iter().position(|x| x.abs() > 0.1).unwrap();
    // The ramp of 200 ms, and the delay of the engine.
    assert!((9_600..9_900).contains(&first), "{first}");
    let peak = |part: &[f32]| part.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    let (one, other) = (peak(&taps[..first + 4_800]), peak(&taps[first + 9_600..]));
    assert!(one > 0.9 && (one - other).abs() < 0.01, "{one} {other}");
    assert!(peak(&channel(&all, 0)) > 0.9, "a trigger of the start waits as well");
}

/// A port that says that everything is reset: what it holds falls silent, in exact zeros within 5 ms where nothing else sounds; where something
/// does, that goes on, and what rings is below -60 dB of what was.
#[test]
fn a_port_that_is_reset_falls_silent_at_once() {
    use pacinian::midi::{Channel, Message};
    let key = "[voice.key]\noutput = \"o\"\nplace = \"t2\"\n[voice.key.nodes]\ns = { type = \"sine\", frequency = 250 }\n\
        e = { type = \"envelope\", attack = 0.001, release = 1.0 }\no = { type = \"multiply\", inputs = [\"s\", \"e\", 0.5] }\n\
        [[trigger]]\non = \"midi.note\"\nplay = \"key\"\n[voice.tap]";
    for alone in [true, false] {
        let start_word = if alone { "" } else { "start = \"always\"\n" };
        let text = HUM.replace("[voice.tap]", key).replace("start = \"always\"\n", start_word);
        let (mut session, mut recording, words) = start(&text);
        let first = Channel::new(0).unwrap();
        let say = |message| session.handle().send(Signal::Midi(0, message)).unwrap();
        say(Message::NoteOn { channel: first, note: 60, velocity: 127 });
        std::thread::sleep(Duration::from_millis(330));
        say(Message::Reset);
        wait("silence", || words.lock().unwrap().iter().any(|word| word.contains("Silence")));
        std::thread::sleep(Duration::from_millis(200));
        session.stop();
        let mut all = Vec::new();
        fetch(&mut recording, &mut all);
        let key = channel(&all, 1);
        let loud = key.iter().rposition(|x| x.abs() > 0.3).unwrap();
        // 5 ms, and half a period in which it need not have been loud.
        let rest = &key[loud + 240 + 96..];
        assert!(rest.len() > 2400);
        match alone {
            true => assert!(rest.iter().all(|x| *x == 0.0)),
            false => {
                assert!(rest.iter().all(|x| x.abs() < 0.5e-3));
                let hum = &channel(&all, 0)[loud..loud + 4800];
                assert!(
                    hum.chunks(960).all(|part| part.iter().any(|x| x.abs() > 0.4)),
                    "what is always on goes on"
                );
            }
        }
    }
}

/// A cable that had promised to stay (0xFE) and says nothing any more, or whose port vanishes: exact zeros within 5 ms, also of what is
/// always on and of what a pattern plays, until somebody opens the output.
#[test]
fn a_cable_that_is_lost_is_a_panic() {
    use pacinian::midi::{Channel, Message};
    let beat = "[pattern.beat]\nrepeat = { every = 0.1 }\nevents = [{ at = 0, voice = \"tap\", duration = 0.05 }]\n\
        [[trigger]]\non = \"midi.note\"\nplay = \"tap\"\n[[trigger]]\non = \"start\"\nplay = \"beat\"\n";
    let (first, text) = (Channel::new(0).unwrap(), format!("{HUM}{beat}"));
    for vanishes in [false, true] {
        let (mut session, mut recording, words) = start(&text);
        wait("the ramp's end", || session.board().frames.get() > 12_000);
        let say = |message| session.handle().send(Signal::Midi(5, message)).unwrap();
        say(Message::NoteOn { channel: first, note: 60, velocity: 127 });
        say(Message::ActiveSensing);
        let begun = Instant::now();
        match vanishes {
            true => session.handle().send(Signal::MidiGone(5)).unwrap(),
            false => {
                wait("the loss", || session.board().is_panicked());
                assert!(begun.elapsed() >= Duration::from_millis(300), "{:?}", begun.elapsed());
            }
        }
        wait("the gate", || session.board().shut.get() == 1);
        let shut = session.board().frames.get();
        // What plays and holds is over, so nothing comes back but what is always on.
        wait("a while", || session.board().frames.get() > shut + 9_600 && session.board().voices.get() == 0);
        assert_eq!(words.lock().unwrap().iter().filter(|word| *word == "lost 5").count(), 1);
        session.handle().send(Signal::Calm).unwrap();
        let from = session.board().frames.get();
        wait("its return", || session.board().frames.get() > from + 14_400);
        session.stop();
        let latch = words.lock().unwrap().iter().find_map(|w| {
            w.strip_prefix("Order(").and_then(|w| w.strip_suffix(", Latch)")).map(str::to_string)
        });
        let latch: usize = latch.unwrap().parse().unwrap();
        let mut all = Vec::new();
        fetch(&mut recording, &mut all);
        assert!(all[2 * (latch - 2_400)..2 * latch].iter().any(|x| x.abs() > 0.4), "it sounds up to there");
        let still = &all[2 * (latch + 240)..2 * from as usize];
        assert!(still.len() > 9_600 && still.iter().all(|x| x.to_bits() == 0), "exact zeros after 5 ms");
        let after = &all[2 * (from as usize + 9_800)..];
        assert!(
            after.iter().step_by(2).any(|x| x.abs() > 0.4)
                && after.iter().skip(1).step_by(2).all(|x| *x == 0.0)
        );
    }
}

/// Whoever listens may panic, or what computes: nothing sounds on, nothing is held, and the clock goes on.
#[test]
fn a_panic_of_somebody_elses_ends_in_silence() {
    struct Faulty;
    impl pacinian::engine::task::Task for Faulty {
        fn beat(&self) -> pacinian::schedule::Beat {
            pacinian::schedule::Beat::every(1)
        }
        fn run(&mut self, board: &mut dyn pacinian::engine::task::Values) {
            if board.clock() == 1600 {
                // As a panic, but without its words.
                std::panic::resume_unwind(Box::new("a task"));
            }
        }
    }
    for of_task in [false, true] {
        let ready = Arc::new(std::sync::atomic::AtomicBool::new(false));
        let (asked, fates) = (Arc::clone(&ready), Words::default());
        let told = Arc::clone(&fates);
        let mut session = Session::start(Beginning {
            block: Some(64),
            record: true,
            tasks: if of_task { vec![Box::new(Faulty)] } else { Vec::new() },
            audience: Box::new(move |_| {
                if asked.load(std::sync::atomic::Ordering::Relaxed) {
                    std::panic::resume_unwind(Box::new("an audience"));
                }
            }),
            fate: Box::new(move |fate| told.lock().unwrap().push(format!("{fate:?}"))),
            ..Beginning::of(reload(HUM), Chosen::Virtual(None))
        })
        .unwrap();
        let mut recording = session.recording().unwrap();
        let board = Arc::clone(session.board());
        wait("sound", || board.frames.get() > if of_task { 12_000 } else { 9_600 });
        if of_task {
            wait("the word", || fates.lock().unwrap().iter().any(|fate| fate.contains("panicked")));
        } else {
            ready.store(true, std::sync::atomic::Ordering::Relaxed);
            wait("the end", || session.handle().play("tap", Note::default()).is_err());
        }
        let frames = board.frames.get();
        wait("the clock", || board.frames.get() > frames + 2_400);
        let all: Vec<f32> = recording.pop_iter().collect();
        assert!(all.iter().any(|x| x.abs() > 0.4), "it sounded");
        if !of_task {
            assert!(all[all.len() - 2 * 1_200..].iter().all(|x| *x == 0.0), "exact zeros in the end");
        }
        session.stop();
    }
}
