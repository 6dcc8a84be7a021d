//! The JACK server whose ports they are: whether it has ended, which ports are there anew, and the periods that it has left out, since what came by
//! MIDI in them is lost, and no port says so.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use jack::{AsyncClient, Client, ClientOptions, ClientStatus, Control, NotificationHandler, PortId};

use crate::live::board::Board;

/// A client of the server, as long as that runs.
pub(super) struct Server(Option<Watched>);

struct Watched {
    client: Option<AsyncClient<Watcher, ()>>,
    over: Arc<AtomicBool>,
    anew: Arc<Mutex<Vec<String>>>,
}

/// Ports that are noted from one look to the next, at most.
const NOTED: usize = 4096;

struct Watcher {
    /// Where it counts what is left out.
    board: Option<Arc<Board>>,
    over: Arc<AtomicBool>,
    /// Ports that have come since that was asked last.
    anew: Arc<Mutex<Vec<String>>>,
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

    fn port_registration(&mut self, client: &Client, port: PortId, is_registered: bool) {
        let name = client.port_by_id(port).filter(|_| is_registered).and_then(|port| port.name().ok());
        let mut anew = self.anew.lock().unwrap_or_else(PoisonError::into_inner);
        if anew.len() < NOTED {
            anew.extend(name);
        }
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

    /// Ports that have come since this was asked last. One that had come before was gone meanwhile, and what was connected to it is not any more.
    pub fn anew(&self) -> Vec<String> {
        let Some(watched) = &self.0 else { return Vec::new() };
        std::mem::take(&mut *watched.anew.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Watched {
    fn new(board: Option<Arc<Board>>) -> Option<Self> {
        let (client, _) = Client::new("pacinian_watch", ClientOptions::NO_START_SERVER).ok()?;
        let over = Arc::new(AtomicBool::new(false));
        let anew = Arc::<Mutex<Vec<String>>>::default();
        let watcher = Watcher { board, over: Arc::clone(&over), anew: Arc::clone(&anew) };
        let client = client.activate_async(watcher, ()).ok()?;
        Some(Self { client: Some(client), over, anew })
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
