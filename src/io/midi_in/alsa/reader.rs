//! The thread that fetches what the sequencer has.

use std::os::fd::RawFd;
use std::sync::{Arc, PoisonError};

use alsa::Direction;
use alsa::poll::{self, Descriptors, Flags, pollfd};
use alsa::seq::{Addr, Connect, Event, EventType, Input, MidiEvent, Seq};
use rustix::io::Errno;

use super::super::bell::Bell;
use super::Ears;
use super::times::Times;
use crate::live::board::Board;

/// What it has.
pub(super) struct Reader {
    pub seq: Seq,
    pub queue: Option<i32>,
    /// Where everything comes in.
    pub inlet: Addr,
    pub ears: Ears,
    pub bell: Arc<Bell>,
    pub board: Option<Arc<Board>>,
}

/// The controller that lets all keys of a channel go.
const ALL_NOTES_OFF: u8 = 123;

/// Errors in a row after which the client is given up, and another opened.
const MANY: usize = 16;

/// The longest message that is no system exclusive, in bytes: a controller of 14 bits by parameter number is four messages.
const LONGEST: usize = 16;

impl Reader {
    /// Fetches until `end` is closed, or the sequencer does not answer any more.
    pub fn read(self, end: RawFd) {
        let Ok(coder) = MidiEvent::new(0) else { return };
        coder.enable_running_status(false);
        let Ok(mut all) = (&self.seq, Some(Direction::Capture)).get() else { return };
        all.push(pollfd { fd: end, events: Flags::IN.bits(), revents: 0 });
        let mut input = self.seq.input();
        let mut errors = 0;
        while errors < MANY {
            let ready = poll::poll(&mut all, -1);
            if all.last().is_some_and(|end| end.revents != 0) {
                return;
            }
            let fetched = match ready {
                Ok(_) => self.fetch(&mut input, &coder),
                Err(error) if is(&error, Errno::INTR) => Ok(()),
                Err(error) => Err(error),
            };
            errors = fetched.map_or(errors + 1, |()| 0);
        }
    }

    /// Fetches what is there.
    fn fetch(&self, input: &mut Input<'_>, coder: &MidiEvent) -> alsa::Result<()> {
        let times = Times::now(&self.seq, self.queue);
        loop {
            match input.event_input() {
                Ok(event) => self.hear(event, coder, &times),
                Err(error) if is(&error, Errno::AGAIN) => return Ok(()),
                // It dropped what waited, since more came than was fetched.
                Err(error) if is(&error, Errno::NOSPC) => self.release(),
                // A kind of event that the library does not know.
                Err(error) if is(&error, Errno::NOTSUP) => {
                    self.board.iter().for_each(|board| board.midi.skipped.add(1));
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Keys may have gone up in what was dropped: all of them do.
    fn release(&self) {
        self.board.iter().for_each(|board| board.midi.gaps.add(1));
        let now = std::time::Instant::now();
        let mut ears = self.ears.lock().unwrap_or_else(PoisonError::into_inner);
        for ear in &mut *ears {
            (0xB0..=0xBF).for_each(|channel| ear.line.hear(&[channel, ALL_NOTES_OFF, 0], now));
        }
        drop(ears);
        self.bell.ring();
    }

    fn hear(&self, mut event: Event<'_>, coder: &MidiEvent, times: &Times) {
        match event.get_type() {
            EventType::PortStart | EventType::PortExit | EventType::PortChange | EventType::ClientExit => {
                self.bell.ring();
            }
            EventType::PortSubscribed | EventType::PortUnsubscribed => {
                // Everybody's connections are announced; the kernel tells us of ours.
                let ours = |link: &Connect| link.dest == self.inlet && event.get_dest() == self.inlet;
                let Some(link) = event.get_data::<Connect>().filter(ours) else { return };
                let begins = event.get_type() == EventType::PortSubscribed;
                let mut ears = self.ears.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(ear) = ears.iter_mut().find(|ear| ear.addr == link.sender) {
                    ear.lost |= !begins && ear.settled;
                    ear.settled |= begins;
                }
                drop(ears);
                self.bell.ring();
            }
            _ => {
                let mut bytes = [0; LONGEST];
                let (source, at) = (event.get_source(), times.of(event.get_time()));
                let length = match event.get_ext() {
                    Some(_) => None,
                    // What is no MIDI is nothing.
                    None => Some(coder.decode(&mut bytes, &mut event).unwrap_or(0)),
                };
                let said = match length {
                    Some(length) => bytes.get(..length).unwrap_or_default(),
                    None if event.get_type() == EventType::Sysex => event.get_ext().unwrap_or_default(),
                    None => return,
                };
                if said.is_empty() {
                    return;
                }
                let mut ears = self.ears.lock().unwrap_or_else(PoisonError::into_inner);
                // What another sent that had this address before is not its own.
                match ears.iter_mut().find(|ear| ear.addr == source && ear.settled && !ear.lost) {
                    Some(ear) => ear.line.hear(said, at),
                    // Sent past all connections, to this client alone.
                    None => self.board.iter().for_each(|board| board.midi.skipped.add(1)),
                }
            }
        }
    }
}

fn is(error: &alsa::Error, errno: Errno) -> bool {
    error.errno().abs() == errno.raw_os_error()
}
