//! A look now and then at a device that is open, where its host does not tell that a stream is on another one now.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
#[cfg(all(feature = "pulseaudio", target_os = "linux"))]
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use super::hosts::Hosts;
use super::list::pulse;
use super::minder::SEARCH;
#[cfg(all(feature = "pulseaudio", target_os = "linux"))]
use super::pulse::streams::Streams;

/// Which way a stream goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// To a device.
    Out,
    /// From one.
    In,
}

/// Looks at one device.
#[derive(Debug, Default)]
pub(super) struct Watch {
    /// When it was looked at last; `None` where the host tells.
    last: Option<Instant>,
    /// Who looks, in a thread of its own: a server that does not answer holds up nobody else.
    looks: Option<Receiver<bool>>,
    #[cfg(all(feature = "pulseaudio", target_os = "linux"))]
    streams: Arc<Mutex<Streams>>,
}

impl Watch {
    /// PulseAudio moves streams, of a device that goes or because somebody wants it so, and cpal does not hear of it.
    pub fn of(id: &str) -> Self {
        Self { last: pulse(id).map(|_| Instant::now()), ..Self::default() }
    }

    /// Whether a look has come to that the device is away, or the stream is on another. What was looked at before is asked for at the next call.
    pub fn finds_away(&mut self, now: Instant, hosts: &Hosts, id: &str, way: Direction) -> bool {
        let (hosts, id) = (hosts.clone(), id.to_string());
        #[cfg(all(feature = "pulseaudio", target_os = "linux"))]
        let streams = Arc::clone(&self.streams);
        self.finds(now, move || {
            #[cfg(all(feature = "pulseaudio", target_os = "linux"))]
            if let Some(device) = pulse(&id)
                && streams.lock().unwrap_or_else(PoisonError::into_inner).left(way, device)
            {
                return true;
            }
            match way {
                Direction::Out => !hosts.has(&id),
                // That an input has gone, whoever listens hears from there.
                Direction::In => false,
            }
        })
    }

    fn finds(&mut self, now: Instant, is_away: impl FnOnce() -> bool + Send + 'static) -> bool {
        match self.looks.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return false,
            Some(answer) => {
                self.looks = None;
                return answer == Ok(true);
            }
            None => {}
        }
        if self.last.is_some_and(|last| now.saturating_duration_since(last) >= SEARCH) {
            self.last = Some(now);
            let (tell, looks) = channel();
            let look = move || {
                // Who has forgotten it does not wait.
                let _ = tell.send(is_away());
            };
            // Where there is no thread for it, the next look will do.
            self.looks = std::thread::Builder::new().name("look".into()).spawn(look).ok().map(|_| looks);
        }
        false
    }

    /// What was looked at is no more.
    pub fn forget(&mut self) {
        self.looks = None;
        // Whoever looks may not be done for long.
        #[cfg(all(feature = "pulseaudio", target_os = "linux"))]
        {
            self.streams = Arc::default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Watch;
    use std::time::{Duration, Instant};

    #[test]
    fn a_look_that_does_not_come_to_an_end_holds_up_nobody() {
        let (begin, mut watch) = (Instant::now(), Watch::of("pulseaudio:glove"));
        let later = |ms: u64| begin + Duration::from_millis(1000 + ms);
        let (answer, asked) = std::sync::mpsc::channel::<bool>();
        assert!(!watch.finds(later(0), move || asked.recv() == Ok(true)));
        assert!((1..50).all(|n| !watch.finds(later(200 * n), || panic!("one looks already"))));
        answer.send(true).unwrap();
        let mut found = (0..5000).map(|n| {
            std::thread::sleep(Duration::from_millis(1));
            watch.finds(later(20_000 + n), || false)
        });
        assert!(found.any(|found| found));
        // What was asked for before it was back is of no more use.
        assert!(!watch.finds(later(40_000), || true));
        std::thread::sleep(Duration::from_millis(20));
        watch.forget();
        assert!(!watch.finds(later(40_010), || true), "it is not due again");
        let mut tells = Watch::of("pipewire:glove");
        assert!((0..50).all(|n| !tells.finds(later(200 * n), || panic!("the host tells"))));
    }
}
