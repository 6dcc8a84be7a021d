use super::{Inbox, Inlet, SHARE, queues};
use crate::live::signal::{Origin, Refused, Signal, Stamped};
use crate::live::stamp::Stamp;
use crate::live::way::{WAYS, Way};
use crate::midi::{Channel, Message};

fn on(note: u8) -> Signal {
    Signal::Midi(0, Message::NoteOn { channel: Channel::new(0).unwrap(), note, velocity: 1 })
}

fn off(note: u8) -> Signal {
    Signal::Midi(0, Message::NoteOff { channel: Channel::new(0).unwrap(), note, velocity: 64 })
}

fn send(inlet: &Inlet, stamp: Stamp, origin: Origin, signal: Signal) -> Result<u64, Refused> {
    inlet.send(stamp, Stamped { id: 0, stamp, origin, peer: None, pulls: 0, ahead: None, tag: None, signal })
}

fn key() -> Origin {
    Origin::Key("1".into())
}

/// What comes in one pass.
fn pass(inbox: &mut Inbox) -> Vec<(u64, Signal)> {
    inbox.begin();
    std::iter::from_fn(|| inbox.next().map(|stamped| (stamped.stamp.0, stamped.signal))).collect()
}

fn said(all: &[(u64, Signal)]) -> String {
    all.iter().map(|(stamp, signal)| format!("{stamp} {signal:?};")).collect()
}

#[test]
fn by_time_then_by_source_then_as_sent() {
    let (inlet, mut inbox) = queues();
    let osc = || Origin::Osc("/a".into(), "".into());
    for (stamp, origin, signal) in [
        (5, Origin::Program, Signal::Set("a".into(), 1.0)),
        (5, key(), Signal::Key(1)),
        (5, osc(), Signal::Osc("/a".into(), vec![])),
        (5, Origin::Program, Signal::MidiGone(1)),
        (4, Origin::Program, Signal::Set("b".into(), 1.0)),
        (3, osc(), Signal::Calm),
        (6, key(), Signal::Calm),
        (2, key(), Signal::Key(2)),
    ] {
        send(&inlet, Stamp(stamp), origin, signal).unwrap();
    }
    // What one way has sent keeps its order, whatever its stamps say.
    assert_eq!(
        said(&pass(&mut inbox)),
        "5 MidiGone(1);5 Osc(\"/a\", []);3 Calm;5 Key(1);5 Set(\"a\", 1.0);4 Set(\"b\", 1.0);6 Calm;2 Key(2);"
    );
    assert!(!inbox.is_over());
    drop(inlet);
    assert!(pass(&mut inbox).is_empty() && inbox.is_over());
}

/// A hundred thousand messages of MIDI that nobody takes: whoever else sends finds room, and of what MIDI itself says, what lets go is
/// done, behind what was taken, and once for each key.
#[test]
fn a_flood_takes_no_room_from_others_and_no_release_is_lost() {
    let (inlet, mut inbox) = queues();
    let (mut taken, mut refused) = (0, 0);
    for n in 0..100_000_u64 {
        match send(&inlet, Stamp(n), Origin::Program, on((n % 100) as u8)) {
            Ok(_) => taken += 1,
            Err(Refused::Busy) => refused += 1,
            Err(Refused::Ended) => panic!(),
        }
    }
    assert_eq!((taken, refused), (Way::Midi.capacity(), 100_000 - Way::Midi.capacity()));
    for _ in 0..1000 {
        for note in 0..128 {
            send(&inlet, Stamp(100_000), Origin::Program, off(note)).unwrap();
        }
        send(&inlet, Stamp(100_001), Origin::Program, Signal::MidiGone(7)).unwrap();
    }
    // A key that goes down again would come before it went up.
    assert_eq!(send(&inlet, Stamp(100_002), Origin::Program, on(3)), Err(Refused::Busy));
    send(&inlet, Stamp(50), key(), Signal::Key(9)).unwrap();
    send(&inlet, Stamp(60), Origin::Program, Signal::ReleaseAll).unwrap();
    send(&inlet, Stamp(70), Origin::Osc("/panic".into(), "".into()), Signal::Panic).unwrap();

    // Those are heard in the first pass, at their times.
    let first = pass(&mut inbox);
    assert_eq!(first.len(), SHARE + 3);
    assert!(matches!(
        (&first[51], &first[62], &first[73]),
        ((50, Signal::Key(9)), (60, Signal::ReleaseAll), (70, Signal::Panic))
    ));
    let mut rest = Vec::new();
    while rest.len() + first.len() < 3 + taken {
        rest.extend(pass(&mut inbox));
    }
    let mut last = Vec::new();
    loop {
        let more = pass(&mut inbox);
        if more.is_empty() {
            break;
        }
        assert!(more.len() <= SHARE);
        last.extend(more);
    }
    let mut all: Vec<_> = first.into_iter().chain(rest).chain(last).map(|(_, signal)| signal).collect();
    assert!(matches!(all.pop(), Some(Signal::MidiGone(7))));
    let debts = all.split_off(3 + taken);
    for note in 0..128_u8 {
        let ups = debts.iter().filter(|signal| format!("{signal:?}") == format!("{:?}", off(note))).count();
        assert!(ups >= 100, "{note}: {ups}");
    }
    assert_eq!(debts.iter().filter(|signal| matches!(signal, Signal::Midi(..))).count(), debts.len());
    // And there is room again.
    send(&inlet, Stamp(100_003), Origin::Program, on(3)).unwrap();
    assert_eq!(said(&pass(&mut inbox)).matches("NoteOn").count(), 1);
}

#[test]
fn what_is_meant_for_later_keeps_nothing_that_is_owed_waiting() {
    let (inlet, mut inbox) = queues();
    while send(&inlet, Stamp(5), key(), Signal::Key(1)).is_ok() {}
    let later = Stamped {
        id: 0,
        stamp: Stamp(1 << 60),
        origin: key(),
        peer: None,
        pulls: 0,
        ahead: None,
        tag: None,
        signal: Signal::Release(1),
    };
    inlet.send(Stamp(7), later).unwrap();
    send(&inlet, Stamp(6), key(), Signal::Release(2)).unwrap();
    let all: Vec<_> =
        std::iter::repeat_with(|| pass(&mut inbox)).take_while(|pass| !pass.is_empty()).flatten().collect();
    let owed: Vec<_> = all.iter().filter(|(_, signal)| matches!(signal, Signal::Release(_))).collect();
    assert_eq!(owed.iter().map(|(stamp, _)| *stamp).collect::<Vec<_>>(), [7, 7]);
}

/// What one thread sends is heard in its order, and every key ends up, however full the queue runs.
#[test]
fn every_key_that_went_down_goes_up() {
    let (inlet, mut inbox) = queues();
    let heard = std::thread::scope(|scope| {
        scope.spawn(move || {
            for n in 0..200_000_u32 {
                let note = (n / 2 % 128) as u8;
                let _ = send(
                    &inlet,
                    Stamp(u64::from(n)),
                    Origin::Program,
                    if n % 2 == 0 { on(note) } else { off(note) },
                );
            }
        });
        let (mut down, mut heard) = ([0_i64; 128], 0_u64);
        inbox.attend();
        while !inbox.is_over() {
            inbox.wait(std::time::Duration::from_millis(1));
            for (_, signal) in pass(&mut inbox) {
                heard += 1;
                match signal {
                    Signal::Midi(_, Message::NoteOn { note, .. }) => down[usize::from(note)] += 1,
                    // One too many is nothing to an instrument.
                    Signal::Midi(_, Message::NoteOff { note, .. }) => {
                        down[usize::from(note)] = (down[usize::from(note)] - 1).max(0);
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
        assert!(down.iter().all(|down| *down == 0), "{down:?}");
        heard
    });
    assert!(heard > 1000);
}

#[test]
fn who_sends_to_a_session_that_has_ended_is_told() {
    let (inlet, mut inbox) = queues();
    (0..3).for_each(|n| assert!(send(&inlet, Stamp(n), key(), Signal::Key(1)).is_ok()));
    send(&inlet, Stamp(0), Origin::Program, on(1)).unwrap();
    let mut left = [0; WAYS];
    (left[Way::Key as usize], left[Way::Midi as usize]) = (3, 1);
    assert_eq!(inbox.close(), left, "what nobody will hear");
    assert_eq!(send(&inlet, Stamp(0), Origin::Program, Signal::Panic), Err(Refused::Ended));
    let (inlet, inbox) = queues();
    drop(inbox);
    assert_eq!(send(&inlet, Stamp(0), Origin::Program, Signal::Panic), Err(Refused::Ended));
}

/// The gate is shut by the number of a panic before anybody takes it from its queue, so one that finds no room there keeps that number.
#[test]
fn a_panic_or_an_end_that_finds_no_room_keeps_its_number() {
    let (inlet, mut inbox) = queues();
    while send(&inlet, Stamp(5), Origin::Program, Signal::Set("a".into(), 1.0)).is_ok() {}
    let first = send(&inlet, Stamp(6), Origin::Program, Signal::Panic).unwrap();
    assert!(send(&inlet, Stamp(7), Origin::Program, Signal::Panic).unwrap() > first);
    let panics = |inbox: &mut Inbox| -> Vec<u64> {
        let mut ids = Vec::new();
        for _ in 0..Way::Program.capacity().div_ceil(SHARE) + 2 {
            inbox.begin();
            let is = |stamped: &Stamped| matches!(stamped.signal, Signal::Panic);
            ids.extend(std::iter::from_fn(|| inbox.next()).filter(is).map(|stamped| stamped.id));
        }
        ids
    };
    assert_eq!(panics(&mut inbox), [first]);
    // Where there is room again, each has its own.
    let next = send(&inlet, Stamp(8), Origin::Program, Signal::Panic).unwrap();
    assert_eq!(panics(&mut inbox), [next]);
    while send(&inlet, Stamp(9), Origin::Program, Signal::Set("a".into(), 1.0)).is_ok() {}
    let last = send(&inlet, Stamp(9), Origin::Program, Signal::Panic).unwrap();
    let end = send(&inlet, Stamp(9), Origin::Program, Signal::End).unwrap();
    let all: Vec<u64> = (0..Way::Program.capacity().div_ceil(SHARE) + 2)
        .flat_map(|_| {
            inbox.begin();
            let shuts = |stamped: &Stamped| matches!(stamped.signal, Signal::Panic | Signal::End);
            std::iter::from_fn(|| inbox.next()).filter(shuts).map(|stamped| stamped.id).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(all, [last, end]);
}
