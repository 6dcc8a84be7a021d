//! The thread that receives: it stamps what comes, and pulls the brake where that is asked for, before anything else is done.

use std::io::ErrorKind;
use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use super::arrivals::{Arrival, Arrivals};
use super::brake;
use super::counts::Counts;
use super::rest::Rest;
use super::time::Tag;
use crate::io::device::priority;
use crate::live::signal::Handle;

/// The largest datagram of UDP.
const DATAGRAM: usize = 1 << 16;

/// It looks this often whether it is to stop.
pub(super) const LOOK: Duration = Duration::from_millis(50);

/// What the thread has.
pub(super) struct Receiver {
    pub socket: Arc<UdpSocket>,
    pub handle: Handle,
    pub counts: Arc<Counts>,
    pub arrivals: Arc<Arrivals>,
    pub stop: Arc<AtomicBool>,
}

impl Receiver {
    /// Receives until it is told to stop.
    pub fn receive(self) {
        priority::raise_feeding();
        let (mut space, mut rest) = (vec![0; DATAGRAM], Rest::default());
        let epoch = self.handle.epoch();
        while !self.stop.load(Ordering::Acquire) {
            let received = self.socket.recv_from(&mut space);
            let (now, wall) = (epoch.now(), SystemTime::now());
            match received {
                Ok((length, from)) => {
                    self.counts.datagrams.add(1);
                    let datagram = space.get(..length).unwrap_or_default();
                    let brakes = brake::is_pulled(datagram).then(|| self.handle.brake());
                    let (pulls, datagram) = (self.handle.board().lever.pulls(), Some(datagram.into()));
                    let arrival = Arrival { from, now, wall: Tag::of(wall), pulls, brakes, datagram };
                    let room = self.arrivals.add(arrival);
                    self.counts.crammed.add(u64::from(!room));
                    rest.after_one(now);
                }
                Err(error) => match error.kind() {
                    // Somebody who was answered does not listen any more; some systems say so here.
                    ErrorKind::WouldBlock
                    | ErrorKind::TimedOut
                    | ErrorKind::Interrupted
                    | ErrorKind::ConnectionReset
                    | ErrorKind::ConnectionRefused => {}
                    _ => {
                        self.counts.failed.add(1);
                        std::thread::sleep(LOOK);
                    }
                },
            }
        }
    }
}
