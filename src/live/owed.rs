//! What lets go and found no room in its queue: kept as bits and counts, so that no flood can make it get lost.
//!
//! A key that goes up, a pedal, a voice that is released, a pattern that is stopped, a panic: to lose one would leave something
//! sounding. Whatever else a sender says may be refused and counted; these are noted in a place of fixed size in which each of them has
//! its own bit, and done when all that waited before them is.

use std::sync::atomic::{AtomicU8, AtomicU16, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, TryLockError};

use super::signal::{Signal, Stamped};
use super::stamp::Stamp;
use super::way::Way;
use crate::midi::sounding::MOST;
use crate::midi::{Channel, Message};
use crate::performer::PORTS;

/// Channels of a port, and keys of a channel.
const CHANNELS: usize = 16;
const KEYS: usize = 128;

/// Controllers that let go, in the order in which they are done: sustain and sostenuto at 0, reset of all controllers, all notes off, all
/// sound off.
const LETTING_GO: [u8; 5] = [64, 66, 121, 123, 120];

/// Numbers of voices and patterns that one way may owe: more than it can hold, which are those that the conductor remembers and those
/// that wait.
const NUMBERS: usize = 1 << 15;

/// Names of patterns.
const NAMES: usize = 1 << 10;

/// What needs no name.
const RELEASE_ALL: u32 = 1;
const STOP_FIRST: u32 = 1 << 1;
const DISARM: u32 = 1 << 2;
const TORQUE_OFF: u32 = 1 << 3;
const PANIC: u32 = 1 << 4;
const END: u32 = 1 << 5;

/// What a port owes beyond its keys.
const TRANSPORT_STOP: u8 = 1;
const RESET: u8 = 1 << 1;
const GONE: u8 = 1 << 2;

/// What one way owes. Any thread may add to it, and none waits for another.
#[derive(Debug)]
pub(super) struct Owed {
    /// How often something was noted, and up to which of those it is done.
    noted: AtomicU64,
    done: AtomicU64,
    /// When the last of it came.
    stamp: AtomicU64,
    ports: Box<[Port]>,
    /// Numbers, doubled, plus 1 for a pattern; 0 where there is none.
    numbers: Box<[AtomicU64]>,
    names: Box<[Mutex<Option<String>>]>,
    flags: AtomicU32,
    /// The numbers of the signals by which the brake was pulled, and by which the session ends; 0 for none.
    shut: [AtomicU64; 2],
}

/// What a port of MIDI owes.
#[derive(Debug)]
struct Port {
    /// How often each key goes up, as far as a byte counts: no more of it sound.
    keys: [[AtomicU16; KEYS]; CHANNELS],
    /// A bit a channel, for each of [`LETTING_GO`].
    controllers: [AtomicU16; LETTING_GO.len()],
    flags: AtomicU8,
}

impl Default for Port {
    fn default() -> Self {
        Self {
            keys: std::array::from_fn(|_| std::array::from_fn(|_| AtomicU16::new(0))),
            controllers: std::array::from_fn(|_| AtomicU16::new(0)),
            flags: AtomicU8::new(0),
        }
    }
}

impl Owed {
    /// Of a way, nothing.
    pub fn new(way: Way) -> Self {
        let (ports, numbers, names) = match way {
            Way::Midi => (PORTS, 0, 0),
            Way::Osc | Way::Program => (0, NUMBERS, NAMES),
            Way::Key => (0, way.capacity(), NAMES),
        };
        Self {
            noted: AtomicU64::new(0),
            done: AtomicU64::new(0),
            stamp: AtomicU64::new(0),
            ports: (0..ports).map(|_| Port::default()).collect(),
            numbers: (0..numbers).map(|_| AtomicU64::new(0)).collect(),
            names: (0..names).map(|_| Mutex::new(None)).collect(),
            flags: AtomicU32::new(0),
            shut: Default::default(),
        }
    }

    /// Whether anything is owed. What does not let go has to wait outside then, lest it came before what was said earlier.
    pub fn is_due(&self) -> bool {
        let done = self.done.load(Ordering::Acquire);
        self.noted.load(Ordering::Acquire) != done
    }

    /// Notes a signal that lets go. Says whether it did: not where it is none.
    pub fn note(&self, stamp: Stamp, signal: &Signal) -> bool {
        let noted = match signal {
            Signal::Midi(port, message) => self.port(*port).is_some_and(|port| port.note(*message)),
            Signal::MidiGone(port) => self.port(*port).is_some_and(|port| port.flag(GONE)),
            Signal::Release(number) => self.number(number << 1),
            Signal::Stop(0) => self.flag(STOP_FIRST),
            Signal::Stop(number) => self.number(number << 1 | 1),
            Signal::StopNamed(name) => self.name(name),
            Signal::ReleaseAll => self.flag(RELEASE_ALL),
            Signal::Panic => self.flag(PANIC),
            Signal::Arm(false) => self.flag(DISARM),
            Signal::Torque(false) => self.flag(TORQUE_OFF),
            Signal::End => self.flag(END),
            _ => false,
        };
        if noted {
            self.stamp.fetch_max(stamp.0, Ordering::Relaxed);
            self.noted.fetch_add(1, Ordering::AcqRel);
        }
        noted
    }

    /// Keeps the number of a signal that shuts the gate and is to be noted: the gate may be shut by that number already. Of several of a kind, the
    /// first.
    pub fn keep_number(&self, stamped: &Stamped) {
        if let Some(shut) = self.shut(&stamped.signal) {
            let _ = shut.compare_exchange(0, stamped.id, Ordering::AcqRel, Ordering::Acquire);
        }
    }

    /// Under which number such a signal was noted, if it was.
    pub fn take_number(&self, signal: &Signal) -> Option<u64> {
        Some(self.shut(signal)?.swap(0, Ordering::AcqRel)).filter(|number| *number > 0)
    }

    fn shut(&self, signal: &Signal) -> Option<&AtomicU64> {
        match signal {
            Signal::Panic => self.shut.first(),
            Signal::End => self.shut.last(),
            _ => None,
        }
    }

    /// Those of ports that nobody tells apart are one.
    fn port(&self, number: u16) -> Option<&Port> {
        self.ports.get(usize::from(number).min(PORTS - 1))
    }

    fn flag(&self, flag: u32) -> bool {
        self.flags.fetch_or(flag, Ordering::AcqRel);
        true
    }

    fn number(&self, entry: u64) -> bool {
        let begin = (entry.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize;
        (0..self.numbers.len()).any(|step| {
            let cell = &self.numbers[(begin + step) % self.numbers.len()];
            let is_there = |known: u64| known == entry;
            is_there(cell.load(Ordering::Acquire))
                || cell
                    .compare_exchange(0, entry, Ordering::AcqRel, Ordering::Acquire)
                    .map_or_else(is_there, |_| true)
        })
    }

    fn name(&self, name: &str) -> bool {
        // One that another thread has in its hands is passed over: nobody waits.
        self.names.iter().filter_map(|cell| cell.try_lock().ok()).any(|mut cell| match &*cell {
            Some(known) => known == name,
            None => {
                *cell = Some(name.into());
                true
            }
        })
    }

    /// Takes all that is owed and gives it to `each`, in the same order however it was noted. It is due until [`Owed::settle`] is told so.
    pub fn take(&self, each: &mut dyn FnMut(Stamp, Signal)) -> Taken {
        let done = self.done.load(Ordering::Acquire);
        let mut taken = Taken(self.noted.load(Ordering::Acquire));
        if taken.0 == done {
            return taken;
        }
        let stamp = Stamp(self.stamp.load(Ordering::Relaxed));
        for (number, port) in self.ports.iter().enumerate() {
            port.settle(number as u16, &mut |signal| each(stamp, signal));
        }
        let mut numbers: Vec<u64> =
            self.numbers.iter().map(|cell| cell.swap(0, Ordering::AcqRel)).filter(|n| *n != 0).collect();
        numbers.sort_unstable();
        for entry in numbers {
            let number = entry >> 1;
            each(stamp, if entry & 1 == 0 { Signal::Release(number) } else { Signal::Stop(number) });
        }
        let mut names = Vec::new();
        for cell in &self.names {
            match cell.try_lock() {
                Ok(mut cell) => names.extend(cell.take()),
                // Somebody looks what stands there, or writes: it stays due.
                Err(TryLockError::WouldBlock) => taken = Taken(done),
                Err(TryLockError::Poisoned(_)) => {}
            }
        }
        names.sort_unstable();
        names.into_iter().for_each(|name| each(stamp, Signal::StopNamed(name)));
        let flags = self.flags.swap(0, Ordering::AcqRel);
        let all = [
            (RELEASE_ALL, Signal::ReleaseAll),
            (STOP_FIRST, Signal::Stop(0)),
            (DISARM, Signal::Arm(false)),
            (TORQUE_OFF, Signal::Torque(false)),
            (PANIC, Signal::Panic),
            (END, Signal::End),
        ];
        all.into_iter().filter(|(flag, _)| flags & flag != 0).for_each(|(_, signal)| each(stamp, signal));
        taken
    }

    /// What was taken is owed no more; what was noted meanwhile still is.
    pub fn settle(&self, Taken(noted): Taken) {
        self.done.store(noted, Ordering::Release);
    }
}

/// Up to which of what was noted it was taken.
#[derive(Debug)]
#[must_use]
pub(super) struct Taken(u64);

impl Port {
    fn note(&self, message: Message) -> bool {
        match message {
            Message::NoteOff { channel, note, .. } | Message::NoteOn { channel, note, velocity: 0 } => {
                let key = &self.keys[channel.index()][usize::from(note) % KEYS];
                // No more of a key sound than so many.
                let more = |ups| (ups < MOST as u16).then_some(ups + 1);
                let _ = key.fetch_update(Ordering::AcqRel, Ordering::Acquire, more);
                true
            }
            Message::Controller { channel, number, value } => {
                // 124 to 127 let go of all notes as well.
                let number = if (123..=127).contains(&number) { 123 } else { number };
                let is_up = number >= 120 || value < 64;
                let place = LETTING_GO.iter().position(|known| *known == number).filter(|_| is_up);
                place.is_some_and(|place| {
                    self.controllers[place].fetch_or(1 << channel.index(), Ordering::AcqRel);
                    true
                })
            }
            Message::Stop => self.flag(TRANSPORT_STOP),
            Message::Reset => self.flag(RESET),
            _ => false,
        }
    }

    fn flag(&self, flag: u8) -> bool {
        self.flags.fetch_or(flag, Ordering::AcqRel);
        true
    }

    fn settle(&self, port: u16, each: &mut dyn FnMut(Signal)) {
        let mut say = |message: Message| each(Signal::Midi(port, message));
        let channels = || (0..CHANNELS as u8).filter_map(Channel::new);
        for channel in channels() {
            for (note, key) in self.keys[channel.index()].iter().enumerate() {
                for _ in 0..key.swap(0, Ordering::AcqRel) {
                    say(Message::NoteOff { channel, note: note as u8, velocity: 64 });
                }
            }
        }
        for (number, bits) in LETTING_GO.into_iter().zip(&self.controllers) {
            let bits = bits.swap(0, Ordering::AcqRel);
            for channel in channels().filter(|channel| bits >> channel.index() & 1 != 0) {
                say(Message::Controller { channel, number, value: 0 });
            }
        }
        let flags = self.flags.swap(0, Ordering::AcqRel);
        if flags & TRANSPORT_STOP != 0 {
            say(Message::Stop);
        }
        if flags & RESET != 0 {
            say(Message::Reset);
        }
        if flags & GONE != 0 {
            each(Signal::MidiGone(port));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{NUMBERS, Owed};
    use crate::live::signal::Signal;
    use crate::live::stamp::Stamp;
    use crate::live::way::Way;
    use crate::midi::{Channel, Message};

    fn settled(owed: &Owed) -> Vec<String> {
        let mut all = Vec::new();
        let taken = owed.take(&mut |stamp, signal| all.push(format!("{} {signal:?}", stamp.0)));
        owed.settle(taken);
        all
    }

    #[test]
    fn every_key_of_every_port_has_its_place() {
        let owed = Owed::new(Way::Midi);
        let mut expected = 0;
        for port in [0_u16, 1, 63] {
            for channel in (0..16).filter_map(Channel::new) {
                for note in 0..128 {
                    let off = Message::NoteOff { channel, note, velocity: 3 };
                    assert!(owed.note(Stamp(7), &Signal::Midi(port, off)));
                    expected += 1;
                }
            }
        }
        let channel = Channel::new(4).unwrap();
        let twice = Message::NoteOn { channel, note: 9, velocity: 0 };
        assert!(owed.note(Stamp(9), &Signal::Midi(1, twice)));
        for (number, value, lets_go) in
            [(64, 63, true), (64, 64, false), (66, 0, true), (120, 0, true), (126, 1, true), (7, 0, false)]
        {
            let message = Message::Controller { channel, number, value };
            assert_eq!(owed.note(Stamp(1), &Signal::Midi(0, message)), lets_go, "{number} {value}");
        }
        // As many as sound of one key, and no more.
        let up = Message::NoteOff { channel, note: 77, velocity: 0 };
        assert!((0..300).all(|_| owed.note(Stamp(1), &Signal::Midi(2, up))));
        for message in [Message::Clock, Message::Start, Message::NoteOn { channel, note: 9, velocity: 1 }] {
            assert!(!owed.note(Stamp(1), &Signal::Midi(0, message)));
        }
        // Ports beyond those that are told apart are the last.
        assert!(owed.note(Stamp(1), &Signal::MidiGone(900)));
        let all = settled(&owed);
        assert_eq!(all.len(), expected + 1 + 4 + 256 + 1);
        assert!(all.iter().all(|line| line.starts_with("9 ")));
        assert_eq!(all.last().unwrap(), "9 MidiGone(63)");
        assert!(!owed.is_due() && settled(&owed).is_empty());
    }

    #[test]
    fn voices_and_patterns_by_number_and_by_name() {
        let owed = Owed::new(Way::Osc);
        let numbers = NUMBERS as u64;
        for number in (1..=numbers).rev() {
            assert!(owed.note(Stamp(1), &Signal::Release(number)));
            assert!(owed.note(Stamp(1), &Signal::Release(number)), "once is enough");
        }
        assert!(!owed.note(Stamp(1), &Signal::Stop(1)), "more than there can be");
        let all = settled(&owed);
        assert_eq!((all.len() as u64, all[0].as_str()), (numbers, "1 Release(1)"));
        let signals = [
            Signal::End,
            Signal::Panic,
            Signal::StopNamed("b".into()),
            Signal::StopNamed("a".into()),
            Signal::StopNamed("b".into()),
            Signal::Stop(3),
            Signal::Stop(0),
            Signal::Release(4),
            Signal::Torque(false),
            Signal::Arm(false),
            Signal::ReleaseAll,
        ];
        assert!(signals.iter().all(|signal| owed.note(Stamp(2), signal)));
        for other in [Signal::Calm, Signal::Arm(true), Signal::Torque(true), Signal::Key(1)] {
            assert!(!owed.note(Stamp(2), &other), "{other:?}");
        }
        let words = settled(&owed).join(";").replace("2 ", "");
        assert_eq!(
            words,
            "Stop(3);Release(4);StopNamed(\"a\");StopNamed(\"b\");ReleaseAll;Stop(0);Arm(false);Torque(false);Panic;End"
        );
    }

    /// Else a key that goes down meanwhile could be heard behind its own going up.
    #[test]
    fn until_it_is_settled_it_is_due_and_so_is_what_was_added_meanwhile() {
        let owed = Owed::new(Way::Program);
        assert!(owed.note(Stamp(1), &Signal::Release(1)) && owed.note(Stamp(1), &Signal::ReleaseAll));
        let mut heard = 0;
        let taken = owed.take(&mut |_, _| {
            assert!(owed.is_due());
            // Where it was taken already, and where it was not.
            assert!(owed.note(Stamp(2), &Signal::Release(1)) && owed.note(Stamp(2), &Signal::ReleaseAll));
            heard += 1;
        });
        assert!(owed.is_due() && heard == 2);
        owed.settle(taken);
        assert!(owed.is_due());
        assert_eq!(settled(&owed).join(";"), "2 Release(1);2 ReleaseAll");
        assert!(!owed.is_due());
    }

    /// A name that somebody has in his hands meanwhile is owed all the same.
    #[test]
    fn a_name_that_cannot_be_looked_at_stays_due() {
        let owed = Owed::new(Way::Program);
        assert!(owed.note(Stamp(1), &Signal::StopNamed("p".into())));
        let held = owed.names[0].lock().unwrap();
        assert!(settled(&owed).is_empty() && owed.is_due());
        drop(held);
        assert_eq!(settled(&owed), ["1 StopNamed(\"p\")"]);
        assert!(!owed.is_due());
    }

    /// Whoever adds while it is settled finds it done at once or the next time.
    #[test]
    fn nothing_is_lost_between_threads() {
        let owed = Owed::new(Way::Program);
        let (mut heard, most) = (vec![false; 20_001], 20_000_u64);
        std::thread::scope(|scope| {
            let owed = &owed;
            let writer = scope.spawn(move || {
                (1..=most).for_each(|number| assert!(owed.note(Stamp(number), &Signal::Release(number))));
            });
            loop {
                let over = writer.is_finished();
                let taken = owed.take(&mut |_, signal| {
                    let Signal::Release(number) = signal else { panic!("{signal:?}") };
                    heard[number as usize] = true;
                });
                owed.settle(taken);
                if over {
                    break;
                }
            }
        });
        assert!(heard[1..].iter().all(|heard| *heard));
    }
}
