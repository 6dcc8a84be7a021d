//! Who has asked to be told something again and again.

use std::net::SocketAddr;
use std::time::Duration;

use crate::live::stamp::Stamp;

/// So many senders may have subscriptions.
pub const MOST_PEERS: usize = 64;

/// So many subscriptions there may be.
pub const MOST: usize = 256;

/// Seconds until a subscription ends that is not renewed.
pub const LIFE: u64 = 60;

/// What is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The peaks of all channels.
    Meter,
    /// The value of a control.
    Control(usize),
}

/// All subscriptions.
#[derive(Debug, Default)]
pub struct Peers(Vec<Subscription>);

#[derive(Debug)]
struct Subscription {
    to: SocketAddr,
    what: What,
    every: Duration,
    next: Stamp,
    until: Stamp,
    /// Peaks since they were told last.
    peaks: Vec<f32>,
}

impl Peers {
    /// From now on `to` is told something `every` so often; if it is told that already, so often instead. Says whether there was room.
    pub fn subscribe(&mut self, to: SocketAddr, what: What, every: Duration, now: Stamp) -> bool {
        self.expire(now);
        let until = Stamp(now.0.saturating_add(LIFE * 1_000_000_000));
        let next = after(now, every);
        if let Some(known) = self.0.iter_mut().find(|s| s.to == to && s.what == what) {
            // A renewal does not put off what is due.
            if known.every != every {
                (known.every, known.next) = (every, next);
            }
            known.until = until;
            return true;
        }
        let mut others: Vec<SocketAddr> = self.0.iter().map(|s| s.to).filter(|other| *other != to).collect();
        others.sort_unstable();
        others.dedup();
        let room = self.0.len() < MOST && others.len() < MOST_PEERS;
        if room {
            self.0.push(Subscription { to, what, every, next, until, peaks: Vec::new() });
        }
        room
    }

    /// `to` is not told that any more.
    pub fn unsubscribe(&mut self, to: SocketAddr, what: What) {
        self.0.retain(|s| s.to != to || s.what != what);
    }

    /// Nobody is told anything about controls any more: their numbers have changed.
    pub fn forget_controls(&mut self) {
        self.0.retain(|s| s.what == What::Meter);
    }

    /// When the next report is due.
    pub fn next(&self) -> Option<Stamp> {
        self.0.iter().map(|s| s.next).min()
    }

    /// Gives all reports that are due. `peaks` fetches those since it was asked last, of all channels; everybody hears of each.
    pub fn tell(
        &mut self,
        now: Stamp,
        peaks: impl FnOnce() -> Vec<f32>,
        mut send: impl FnMut(SocketAddr, What, &[f32]),
    ) {
        self.expire(now);
        if self.0.iter().any(|s| s.what == What::Meter && s.next <= now) {
            let peaks = peaks();
            for s in self.0.iter_mut().filter(|s| s.what == What::Meter) {
                s.peaks.resize(peaks.len(), 0.0);
                s.peaks.iter_mut().zip(&peaks).for_each(|(most, peak)| *most = most.max(*peak));
            }
        }
        for s in self.0.iter_mut().filter(|s| s.next <= now) {
            send(s.to, s.what, &s.peaks);
            s.peaks.clear();
            // Nobody wants to hear later what was missed; but the beat is kept.
            s.next = match after(s.next, s.every) {
                next if next > now => next,
                _ => after(now, s.every),
            };
        }
    }

    fn expire(&mut self, now: Stamp) {
        self.0.retain(|s| s.until > now);
    }
}

fn after(stamp: Stamp, time: Duration) -> Stamp {
    Stamp(stamp.0.saturating_add(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)))
}

#[cfg(test)]
mod tests {
    use super::{MOST, MOST_PEERS, Peers, What};
    use crate::live::stamp::Stamp;
    use std::net::SocketAddr;
    use std::time::Duration;

    fn peer(port: usize) -> SocketAddr {
        SocketAddr::new([127, 0, 0, 1].into(), port as u16)
    }

    fn ms(ms: u64) -> Stamp {
        Stamp(ms * 1_000_000)
    }

    const TEN: Duration = Duration::from_millis(10);

    #[test]
    fn told_every_so_often_until_it_expires() {
        let mut peers = Peers::default();
        assert!(peers.subscribe(peer(1), What::Control(3), TEN, ms(0)));
        let mut told = Vec::new();
        for now in 0..70_000 {
            peers.tell(ms(now), Vec::new, |to, what, _| told.push((now, to, what)));
            if now == 5000 {
                // Renewed, and as often as before.
                assert!(peers.subscribe(peer(1), What::Control(3), TEN, ms(now)));
            }
        }
        assert_eq!(told.len(), 6499);
        assert!(told.iter().zip(1..).all(|(told, n)| *told == (10 * n, peer(1), What::Control(3))));
        assert_eq!(peers.next(), None);
    }

    #[test]
    fn everybody_hears_of_every_peak() {
        let mut peers = Peers::default();
        peers.subscribe(peer(1), What::Meter, TEN, ms(0));
        peers.subscribe(peer(2), What::Meter, 3 * TEN, ms(0));
        let mut told = Vec::new();
        for (now, peak) in [(10, 0.5), (20, 0.1), (30, 0.2), (60, 0.3)] {
            peers.tell(ms(now), || vec![peak], |to, _, peaks| told.push((now, to.port(), peaks.to_vec())));
        }
        let one = |now, to, peak| (now, to, vec![peak]);
        let wanted = [
            one(10, 1, 0.5),
            one(20, 1, 0.1),
            one(30, 1, 0.2),
            one(30, 2, 0.5),
            one(60, 1, 0.3),
            one(60, 2, 0.3),
        ];
        assert_eq!(told, wanted);
        peers.unsubscribe(peer(1), What::Meter);
        assert_eq!(peers.next(), Some(ms(90)));
    }

    #[test]
    fn room_for_so_many() {
        let mut peers = Peers::default();
        assert!((0..MOST_PEERS).all(|n| peers.subscribe(peer(n + 1), What::Meter, TEN, ms(0))));
        assert!(!peers.subscribe(peer(999), What::Meter, TEN, ms(0)));
        // One that is known may have more, up to the end.
        assert!((MOST_PEERS..MOST).all(|n| peers.subscribe(peer(1), What::Control(n), TEN, ms(1000))));
        assert!(!peers.subscribe(peer(1), What::Control(0), TEN, ms(0)));
        // When the others have expired there is room again.
        assert!(peers.subscribe(peer(999), What::Meter, TEN, ms(60_000)));
    }
}
