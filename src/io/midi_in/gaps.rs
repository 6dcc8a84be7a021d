//! Periods that a JACK server has left out: what came by MIDI in them is lost, and no port says so.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jack::{AsyncClient, Client, ClientOptions, ClientStatus, Control, NotificationHandler};

use crate::live::board::Board;

/// Counts them, as long as it is there and the server runs.
pub(super) struct Gaps {
    client: Option<AsyncClient<Counter, ()>>,
    over: Arc<AtomicBool>,
}

struct Counter(Arc<Board>, Arc<AtomicBool>);

impl NotificationHandler for Counter {
    // SAFETY: JACK calls it where nothing but what is safe in a signal handler may be done: a flag is set.
    unsafe fn shutdown(&mut self, _: ClientStatus, _: &str) {
        self.1.store(true, Ordering::Release);
    }

    fn xrun(&mut self, _: &Client) -> Control {
        self.0.midi.gaps.add(1);
        Control::Continue
    }
}

impl Gaps {
    /// On the board from now on; `None` where no server answers.
    pub fn count(board: &Arc<Board>) -> Option<Self> {
        let (client, _) = Client::new("pacinian_gaps", ClientOptions::NO_START_SERVER).ok()?;
        let over = Arc::new(AtomicBool::new(false));
        let client = client.activate_async(Counter(Arc::clone(board), Arc::clone(&over)), ()).ok()?;
        Some(Self { client: Some(client), over })
    }

    /// Whether its server has ended: another may have come in its place.
    pub fn is_over(&self) -> bool {
        self.over.load(Ordering::Acquire)
    }

    /// Its server has ended, whether JACK has said so yet or not.
    pub fn server_ended(&self) {
        self.over.store(true, Ordering::Release);
    }
}

impl Drop for Gaps {
    fn drop(&mut self) {
        // JACK's library crashes where one takes leave of a server that has ended: the client stays.
        if self.is_over() {
            std::mem::forget(self.client.take());
        }
    }
}
