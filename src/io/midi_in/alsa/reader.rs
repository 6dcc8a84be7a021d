//! The thread that fetches what the sequencer has.

use std::io::PipeReader;
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, MutexGuard, PoisonError};
use std::time::Instant;

use alsa::Direction;
use alsa::poll::{self, Descriptors, Flags, pollfd};
use alsa::seq::{Addr, Connect, Event, EventType, Input, MidiEvent, Seq};
use rustix::io::Errno;

use super::super::bell::Bell;
use super::times::Times;
use super::{Ear, Ears};
use crate::live::board::Board;

/// What it has.
pub(super) struct Reader {
    pub seq: Seq,
    pub queue: Option<i32>,
    /// Where everything comes in.
    pub inlet: Addr,
    pub ears: Ears,
    /// Whether connections may have been lost that nobody has told of.
    pub doubt: Arc<AtomicBool>,
    /// Whether this has ended.
    pub over: Arc<AtomicBool>,
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
    pub fn read(self, end: PipeReader) {
        let Ok(coder) = MidiEvent::new(0) else { return };
        coder.enable_running_status(false);
        let Ok(mut all) = (&self.seq, Some(Direction::Capture)).get() else { return };
        all.push(pollfd { fd: end.as_raw_fd(), events: Flags::IN.bits(), revents: 0 });
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

    /// Keys may have gone up in what was dropped: all of them do. Ports may have gone as well.
    fn release(&self) {
        self.board.iter().for_each(|board| board.midi.gaps.add(1));
        let now = Instant::now();
        let mut ears = self.ears();
        for ear in &mut *ears {
            (0xB0..=0xBF).for_each(|channel| ear.line.hear(&[channel, ALL_NOTES_OFF, 0], now));
        }
        drop(ears);
        self.doubt.store(true, Ordering::Release);
        self.bell.ring();
    }

    fn ears(&self) -> MutexGuard<'_, Vec<Ear>> {
        self.ears.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn hear(&self, event: Event<'_>, coder: &MidiEvent, times: &Times) {
        match event.get_type() {
            EventType::PortStart | EventType::PortExit | EventType::PortChange | EventType::ClientExit => {
                self.bell.ring();
            }
            EventType::PortSubscribed | EventType::PortUnsubscribed => {
                // Everybody's connections are announced; the kernel tells us of ours.
                let ours = |link: &Connect| link.dest == self.inlet && event.get_dest() == self.inlet;
                let Some(link) = event.get_data::<Connect>().filter(ours) else { return };
                let begins = event.get_type() == EventType::PortSubscribed;
                if let Some(ear) = self.ears().iter_mut().find(|ear| ear.addr == link.sender) {
                    ear.lost |= !begins && ear.settled;
                    ear.settled |= begins;
                }
                self.bell.ring();
            }
            _ => self.pass_on(event, coder, times),
        }
    }

    /// Gives a message, or a piece of one, to whoever listens to its port.
    fn pass_on(&self, mut event: Event<'_>, coder: &MidiEvent, times: &Times) {
        let (source, at) = (event.get_source(), times.of(event.get_time()));
        let mut bytes = [0; LONGEST];
        let said = match (event.get_type(), event.get_ext().is_some()) {
            (EventType::Sysex, _) => event.get_ext().unwrap_or_default(),
            (_, true) => return,
            // What is no MIDI makes no bytes.
            (_, false) => {
                let length = coder.decode(&mut bytes, &mut event).unwrap_or(0);
                bytes.get(..length).unwrap_or_default()
            }
        };
        if said.is_empty() {
            return;
        }
        // What another sent that had this address before is not its own.
        match self.ears().iter_mut().find(|ear| ear.addr == source && ear.settled && !ear.lost) {
            Some(ear) => ear.line.hear(said, at),
            // Sent past all connections, to this client alone.
            None => self.board.iter().for_each(|board| board.midi.skipped.add(1)),
        }
    }
}

// However it ends.
impl Drop for Reader {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
    }
}

fn is(error: &alsa::Error, errno: Errno) -> bool {
    error.errno().abs() == errno.raw_os_error()
}
