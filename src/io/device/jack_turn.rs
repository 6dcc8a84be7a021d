//! Who opens a client of JACK's library, and when: one after the other.
//!
//! A program's clients share a table in the library. Where their server has ended, the first that is opened then frees all others, whoever still holds
//! them (`JackLibGlobals::Init` of JACK 2): nobody opens one until all that are dead are let go of. And a client hears a moment late that another has
//! gone, and takes that one's place out of use, which by then may be the next one's: who comes to stay lets that moment pass.
//!
//! ALSA's plug-in for JACK opens clients, too, and tells nobody that their server has ended: where MIDI goes through JACK and looks for it just then, the
//! plug-in's client is freed before it is closed.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use cpal::ErrorKind;

use super::failure::{DeviceError, Trouble};
use super::hosts::JACK;
use super::list::Found;

/// Only one at a time.
static TURN: Mutex<()> = Mutex::new(());

/// Clients that stay.
static HELD: Mutex<Vec<Held>> = Mutex::new(Vec::new());

/// The number of the next client that stays.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// Clients of lower numbers are of a server that has ended.
static DEAD: AtomicU64 = AtomicU64::new(0);

/// So long somebody may take to let go of a client of a server that has ended.
const PATIENCE: Duration = Duration::from_secs(2);

/// Within this, clients have heard that another has gone.
const REST: Duration = Duration::from_millis(50);

/// From one look at who still holds one to the next.
const LOOK: Duration = Duration::from_millis(5);

struct Held {
    number: u64,
    /// Has whoever holds it look whether it is dead.
    call: Box<dyn Fn() + Send>,
}

/// While there is one, nobody else opens a client.
pub(crate) struct Turn {
    _turn: MutexGuard<'static, ()>,
}

/// A client that stays, for as long as this is kept: let go of it first.
pub(crate) struct Stay {
    number: u64,
    held: Arc<AtomicBool>,
}

/// What a client that stays is told by its server's end.
#[derive(Clone)]
pub(crate) struct End {
    held: Arc<AtomicBool>,
}

/// To open a client and close it at once; `None` where somebody holds one that is dead.
pub(crate) fn turn() -> Option<Turn> {
    let turn = Turn { _turn: TURN.lock().unwrap_or_else(PoisonError::into_inner) };
    let begin = Instant::now();
    while call_the_dead() {
        if begin.elapsed() > PATIENCE {
            return None;
        }
        std::thread::sleep(LOOK);
    }
    Some(turn)
}

/// To open one that stays. `call` is called, from any thread, where it is dead and in the way.
pub(crate) fn stay(call: impl Fn() + Send + 'static) -> Option<(Turn, Stay)> {
    let turn = turn()?;
    std::thread::sleep(REST);
    let number = NEXT.fetch_add(1, Ordering::SeqCst);
    held().push(Held { number, call: Box::new(call) });
    Some((turn, Stay { number, held: Arc::new(AtomicBool::new(true)) }))
}

/// Whether a device of ALSA is a plug-in that opens a client of JACK's library, by what it is called.
pub(super) fn is_plugin(id: &str) -> bool {
    id.strip_prefix("alsa:").is_some_and(|name| name.contains(JACK))
}

/// The same for a stream of a device; `None` where that is not JACK's.
///
/// # Errors
/// Somebody holds a client that is dead.
pub(super) fn stream(found: &Found) -> Result<Option<(Turn, Stay)>, DeviceError> {
    if found.host() != JACK && !is_plugin(&found.id) {
        return Ok(None);
    }
    let dead = || DeviceError::new(Trouble::Other, "JACK has ended, and its clients here are not closed yet");
    stay(|| {}).ok_or_else(dead).map(Some)
}

/// Tells of a stream's errors, and of its server's end.
pub(super) fn heard(
    stay: Option<&Stay>,
    mut tell: impl FnMut(cpal::Error) + Send + 'static,
) -> impl FnMut(cpal::Error) + Send + 'static {
    let end = stay.map(Stay::end);
    move |error| {
        if let Some(end) = end.as_ref().filter(|_| error.kind() == ErrorKind::DeviceNotAvailable) {
            end.tell();
        }
        tell(error);
    }
}

/// Whether there are any.
fn call_the_dead() -> bool {
    let dead = DEAD.load(Ordering::SeqCst);
    held().iter().filter(|held| held.number < dead).map(|held| (held.call)()).count() > 0
}

fn held() -> MutexGuard<'static, Vec<Held>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Stay {
    /// For the library's callback.
    pub fn end(&self) -> End {
        End { held: Arc::clone(&self.held) }
    }

    /// Whether its server has ended, whichever of its clients has been told.
    #[cfg(any(test, all(feature = "midi-jack", target_os = "linux")))]
    pub fn is_dead(&self) -> bool {
        self.number < DEAD.load(Ordering::SeqCst)
    }
}

impl Drop for Stay {
    fn drop(&mut self) {
        self.held.store(false, Ordering::SeqCst);
        held().retain(|held| held.number != self.number);
    }
}

impl End {
    /// The server has ended. It neither blocks nor allocates.
    pub fn tell(&self) {
        // Of one that nobody holds any more it says nothing of those that there are now.
        if self.held.load(Ordering::SeqCst) {
            DEAD.fetch_max(NEXT.load(Ordering::SeqCst), Ordering::SeqCst);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{is_plugin, stay, turn};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    #[test]
    fn plug_ins_of_alsa_are_known_by_their_names() {
        assert!(is_plugin("alsa:jack") && is_plugin("alsa:jackcard"));
        assert!(!is_plugin("jack:output") && !is_plugin("alsa:hw:CARD=Device,DEV=0"));
    }

    /// All in one, as the table is one.
    #[test]
    fn nobody_opens_one_until_the_dead_are_let_go_of() {
        let (called, calls) = channel();
        let call = move || _ = called.send(());
        let (first, midi) = stay(call).unwrap();
        drop(first);
        let (second, card) = stay(|| {}).unwrap();
        drop(second);
        // While the server runs, anybody may.
        drop(turn().unwrap());
        assert!(!midi.is_dead() && !card.is_dead());
        // One is told, and both are dead.
        let end = card.end();
        end.tell();
        assert!(midi.is_dead() && card.is_dead());
        drop(card);
        assert!(turn().is_none(), "the other is held");
        assert!(calls.try_iter().count() > 1, "and called");
        let letting_go = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(200));
            drop(midi);
        });
        let (next, again) = stay(|| {}).unwrap();
        assert!(letting_go.is_finished());
        drop(next);
        // What the first one hears late is not about this one.
        end.tell();
        assert!(!again.is_dead() && turn().is_some());
    }
}
