//! The JACK server whose ports they are: whether it has ended, and the periods that it has left out, since what came by MIDI in them is lost, and
//! no port says so.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jack::{AsyncClient, Client, ClientOptions, ClientStatus, Control, NotificationHandler};

use crate::live::board::Board;

/// A client of the server, as long as that runs.
pub(super) struct Server(Option<Watched>);

struct Watched {
    client: Option<AsyncClient<Watcher, ()>>,
    over: Arc<AtomicBool>,
}

struct Watcher {
    /// Where it counts what is left out.
    board: Option<Arc<Board>>,
    over: Arc<AtomicBool>,
}

impl NotificationHandler for Watcher {
    // SAFETY: JACK calls it where nothing but what is safe in a signal handler may be done: a flag is set.
    unsafe fn shutdown(&mut self, _: ClientStatus, _: &str) {
        self.over.store(true, Ordering::Release);
    }

    fn xrun(&mut self, _: &Client) -> Control {
        if let Some(board) = &self.board {
            board.midi.gaps.add(1);
        }
        Control::Continue
    }
}

impl Server {
    /// None is watched so far.
    pub fn new() -> Self {
        Self(None)
    }

    /// Whether the server that was there has ended since this was asked last. Where one answers and none is watched, it is watched from now on.
    pub fn has_ended(&mut self, answers: bool, board: Option<&Arc<Board>>) -> bool {
        let ended = self.0.as_ref().is_some_and(Watched::is_over);
        if ended {
            self.0 = None;
        }
        if answers && self.0.is_none() {
            self.0 = Watched::new(board.cloned());
        }
        ended
    }
}

impl Watched {
    fn new(board: Option<Arc<Board>>) -> Option<Self> {
        let (client, _) = Client::new("pacinian_watch", ClientOptions::NO_START_SERVER).ok()?;
        let over = Arc::new(AtomicBool::new(false));
        let watcher = Watcher { board, over: Arc::clone(&over) };
        let client = client.activate_async(watcher, ()).ok()?;
        Some(Self { client: Some(client), over })
    }

    fn is_over(&self) -> bool {
        self.over.load(Ordering::Acquire)
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        // JACK's library crashes where one takes leave of a server that has ended: the client stays.
        if self.is_over() {
            std::mem::forget(self.client.take());
        }
    }
}
