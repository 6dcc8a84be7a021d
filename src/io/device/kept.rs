//! A host of which the program keeps one. PulseAudio's client lets go of its connection and its thread only when the server does, and of connections
//! a server has 64.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use cpal::traits::HostTrait;
use cpal::{Device, Host, HostId};

use super::list;
use super::minder::within;

/// So long a server may take to answer: what is asked has no end of its own.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);

/// Where streams are opened. Its thread is that of their callbacks, so that it is asked for nothing while they play.
static STREAMS: Kept = Kept(Mutex::new(None));

/// Where it is looked what is there.
static LOOKS: Kept = Kept(Mutex::new(None));

struct Kept(Mutex<Option<Arc<Host>>>);

/// The host to open streams at, if its server answers.
pub(super) fn host(id: HostId) -> Option<Arc<Host>> {
    STREAMS.ask(id, |host| host.devices().map(drop)).map(|(host, ())| host)
}

/// The device of that name, to open a stream on it, if it is there.
pub(super) fn device(id: HostId, name: &str) -> Option<Device> {
    let name = name.to_string();
    let find = move |host: &Host| Ok(host.devices()?.find(|device| list::id(device) == name));
    STREAMS.ask(id, find)?.1
}

/// Whether it is there.
pub(super) fn is_there(id: HostId, name: &str) -> bool {
    let name = name.to_string();
    let find = move |host: &Host| Ok(host.devices()?.any(|device| list::id(&device) == name));
    LOOKS.ask(id, find).is_some_and(|(_, there)| there)
}

impl Kept {
    /// What a question comes to, and whom it was asked; `None` where nobody answers.
    fn ask<T: Send + 'static>(
        &self,
        id: HostId,
        question: impl Fn(&Host) -> Result<T, cpal::Error> + Clone + Send + 'static,
    ) -> Option<(Arc<Host>, T)> {
        // One that was kept may be of a server that has died since.
        (0..2).find_map(|_| {
            let host = self.host(id)?;
            let (asked, question) = (Arc::clone(&host), question.clone());
            match within("asks", PATIENCE, move || question(&asked)) {
                Some(Ok(answer)) => Some((host, answer)),
                _ => {
                    self.forget(&host);
                    None
                }
            }
        })
    }

    fn host(&self, id: HostId) -> Option<Arc<Host>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.is_none() {
            *kept = cpal::host_from_id(id).ok().map(Arc::new);
        }
        kept.clone()
    }

    fn forget(&self, host: &Arc<Host>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.as_ref().is_some_and(|kept| Arc::ptr_eq(kept, host)) {
            *kept = None;
        }
    }
}
