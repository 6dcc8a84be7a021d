//! Periods that a JACK server has left out: what came by MIDI in them is lost, and no port says so.

use std::sync::Arc;

use jack::{AsyncClient, Client, ClientOptions, Control, NotificationHandler};

use crate::live::board::Board;

/// Counts them, as long as it is there and the server runs.
pub(super) struct Gaps {
    _client: AsyncClient<Counter, ()>,
}

struct Counter(Arc<Board>);

impl NotificationHandler for Counter {
    fn xrun(&mut self, _: &Client) -> Control {
        self.0.midi.gaps.add(1);
        Control::Continue
    }
}

impl Gaps {
    /// On the board from now on; `None` where no server answers.
    pub fn count(board: &Arc<Board>) -> Option<Self> {
        let (client, _) = Client::new("pacinian_gaps", ClientOptions::NO_START_SERVER).ok()?;
        let client = client.activate_async(Counter(Arc::clone(board)), ()).ok()?;
        Some(Self { _client: client })
    }
}
