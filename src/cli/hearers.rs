//! Who hears what a session does: its journal, those who listen over OSC, and the screen or the lines of a log.

use std::sync::mpsc::Sender;

use pacinian::io::device::keeper::Fate;
use pacinian::io::journal::Journal;
use pacinian::io::osc::announce::Announcer;
use pacinian::live::conductor::Told;
use pacinian::performer::{Heard, Listener};

use super::screen::Post;

/// All who hear of a session.
#[derive(Clone)]
pub struct Hearers {
    /// Its journal, if it has one.
    pub journal: Option<Journal>,
    /// Those who listen over OSC, if somebody may.
    pub announcer: Option<Announcer>,
    /// The screen, or the lines of a log.
    pub post: Post,
}

impl Hearers {
    /// Hears of events.
    pub fn listener(self) -> Listener {
        Box::new(move |event: &Heard<'_>| {
            self.journal.iter().for_each(|journal| journal.hear(event));
            self.announcer.iter().for_each(|announcer| announcer.hear(event));
            self.post.hear(event);
        })
    }

    /// Hears of what the callback and the conductor have done; what became of a reload goes to `verdict`.
    pub fn audience(self, verdict: Sender<Result<(), String>>) -> Box<dyn FnMut(Told<'_>) + Send> {
        Box::new(move |what| {
            self.journal.iter().for_each(|journal| journal.told(&what));
            self.announcer.iter().for_each(|announcer| announcer.told(&what));
            // Nobody waits for it where nothing is watched.
            match &what {
                Told::Reloaded => drop(verdict.send(Ok(()))),
                Told::Kept(why, _) => drop(verdict.send(Err((*why).to_string()))),
                _ => {}
            }
            self.post.told(what);
        })
    }

    /// Hears of what happens to the device that is listened to.
    pub fn input_fate(self) -> Box<dyn FnMut(Fate) + Send> {
        Box::new(move |what| {
            self.journal.iter().for_each(|journal| journal.input_fate(&what));
            self.post.input_fate(what);
        })
    }

    /// Hears of what happens to the device.
    pub fn fate(self) -> Box<dyn FnMut(Fate) + Send> {
        Box::new(move |what| {
            self.journal.iter().for_each(|journal| journal.fate(&what));
            self.post.fate(what);
        })
    }
}
