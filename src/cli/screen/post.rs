//! The way from the threads of a session to who shows what they say. It never makes them wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::time::Instant;

use pacinian::io::device::keeper::Fate;
use pacinian::io::midi_in::PortNews;
use pacinian::live::callback::{Deed, Report};
use pacinian::live::conductor::Told;
use pacinian::live::gate::Order;
use pacinian::performer::Heard;

use super::happened::{Happened, Mood};

/// Events that may wait to be shown.
const WAITING: usize = 1 << 10;

/// How things stand; none of it may get lost.
#[derive(Debug)]
pub enum State {
    /// The device is gone, or back.
    Device(Fate),
    /// Full level, or not.
    Armed(bool),
    /// These patterns play.
    Playing(Vec<String>),
}

/// Where threads of a session put what they say.
#[derive(Debug, Clone)]
pub struct Post {
    events: SyncSender<Happened>,
    states: Sender<State>,
    missed: Arc<AtomicU64>,
    begin: Instant,
}

/// Where it is fetched.
#[derive(Debug)]
pub struct PostBox {
    events: Receiver<Happened>,
    states: Receiver<State>,
    missed: Arc<AtomicU64>,
    begin: Instant,
}

/// A post that begins now.
pub fn post() -> (Post, PostBox) {
    let (events, event) = sync_channel(WAITING);
    let (states, state) = channel();
    let (missed, begin) = (Arc::<AtomicU64>::default(), Instant::now());
    let post = Post { events, states, missed: Arc::clone(&missed), begin };
    (post, PostBox { events: event, states: state, missed, begin })
}

impl Post {
    fn put(&self, happened: Happened) {
        if self.events.try_send(happened).is_err() {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn say(&self, mood: Mood, text: impl Into<String>) {
        self.put(Happened::new(self.begin.elapsed().as_secs_f64(), mood, text));
    }

    fn state(&self, state: State) {
        // Where nobody fetches any more, the session is over.
        let _ = self.states.send(state);
    }

    /// For the listener of a session.
    pub fn hear(&self, heard: &Heard<'_>) {
        self.put(Happened::heard(heard));
    }

    /// For its audience.
    pub fn told(&self, told: Told<'_>) {
        match told {
            Told::Report(Report { deed: Deed::Order(Order::Gain(gain)), .. }, _) => {
                self.state(State::Armed(*gain >= 1.0));
            }
            Told::Report(..) | Told::Began(..) | Told::Came(..) | Told::Reloading(_) => {}
            Told::Refused(problem) => self.say(Mood::Bad, problem.to_string()),
            Told::Playing(playing) => {
                self.state(State::Playing(playing.iter().map(|(_, name)| (*name).into()).collect()));
            }
            // Whoever sent it says so.
            Told::Reloaded | Told::Kept(_) => {}
        }
    }

    /// For what becomes of the device that is listened to.
    pub fn input_fate(&self, fate: Fate) {
        match fate {
            Fate::Lost(why) => self
                .say(Mood::Bad, format!("the input device is gone ({why}); it is silence until it is back")),
            Fate::Back => self.say(Mood::Good, "the input device is back"),
            Fate::Moved => self.say(Mood::Bad, "the system moved the input to another device"),
            Fate::Said(what) => self.say(Mood::Bad, format!("input: {what}")),
        }
    }

    /// For what becomes of the device.
    pub fn fate(&self, fate: Fate) {
        self.state(State::Device(fate));
    }
}

impl Post {
    /// For what becomes of ports of MIDI.
    pub fn port(&self, news: &PortNews) {
        match news {
            PortNews::Opened(name) => self.say(Mood::Good, format!("MIDI from {name}")),
            PortNews::Gone(name) => {
                self.say(Mood::Bad, format!("the MIDI port {name} is gone; its notes are released"))
            }
            PortNews::None(why) => self.say(Mood::Bad, format!("no MIDI: {why}")),
            PortNews::Refused(name, why) => {
                self.say(Mood::Bad, format!("the MIDI port {name} cannot be opened: {why}"))
            }
        }
    }
}

impl PostBox {
    /// What happened since this was asked last.
    pub fn events(&self) -> impl Iterator<Item = Happened> {
        self.events.try_iter().take(WAITING)
    }

    /// How things came to stand since.
    pub fn states(&self) -> impl Iterator<Item = State> {
        self.states.try_iter()
    }

    /// Events that found no room.
    pub fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }

    /// Seconds since the beginning.
    pub fn elapsed(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::{Happened, Mood, State, WAITING, post};
    use pacinian::io::device::keeper::Fate;

    #[test]
    fn nobody_waits_and_nothing_is_lost_silently() {
        let (post, fetch) = post();
        for n in 0..3 * WAITING {
            post.put(Happened::new(n as f64, Mood::Usual, "x"));
            post.fate(Fate::Back);
        }
        assert_eq!(fetch.events().count() as u64 + fetch.missed(), 3 * WAITING as u64);
        assert!(fetch.missed() > 0);
        let states = fetch.states().filter(|s| matches!(s, State::Device(Fate::Back))).count();
        assert_eq!(states, 3 * WAITING);
        drop(fetch);
        post.fate(Fate::Back);
        post.say(Mood::Bad, "nobody is there");
    }
}
