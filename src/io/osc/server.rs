//! A server: its socket, and the threads that receive and do what is asked.

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use super::announce::Announcer;
use super::arrivals::Arrivals;
use super::counts::Counts;
use super::endpoint::{BindError, Endpoint};
use super::listener::{Ends, Listener};
use super::names::Names;
use super::receiver::{self, LOOK};
use crate::live::signal::Handle;
use crate::patch::Patch;

/// A server that listens until it is dropped.
pub struct Server {
    address: SocketAddr,
    counts: Arc<Counts>,
    names: Sender<Names>,
    complaints: Receiver<String>,
    stop: Arc<AtomicBool>,
    arrivals: Arc<Arrivals>,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// Listens at `endpoint` for a session that plays `patch`. Without an announcer nobody can be told of markers and voices.
    ///
    /// # Errors
    /// As [`Endpoint::bind`], or a system that has no thread left.
    pub fn start(
        endpoint: Endpoint,
        handle: Handle,
        patch: &Patch,
        announcer: Option<Announcer>,
    ) -> Result<Self, BindError> {
        Self::of(endpoint.bind()?, endpoint, handle, patch, announcer)
    }

    /// The same on what [`Endpoint::bind`] gave, so that an address which cannot be had is known of before a session begins.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn of(
        socket: UdpSocket,
        endpoint: Endpoint,
        handle: Handle,
        patch: &Patch,
        announcer: Option<Announcer>,
    ) -> Result<Self, BindError> {
        let failed = |error: std::io::Error| BindError::of(endpoint.0, &error);
        let address = socket.local_addr().map_err(failed)?;
        socket.set_write_timeout(Some(LOOK)).map_err(failed)?;
        socket.set_read_timeout(Some(LOOK)).map_err(failed)?;
        let ((send, names), (complain, complaints)) = (channel(), channel());
        let socket = Arc::new(socket);
        let mut server = Self {
            address,
            counts: Arc::default(),
            names: send,
            complaints,
            stop: Arc::default(),
            arrivals: Arc::default(),
            threads: Vec::new(),
        };
        let (counts, arrivals) = (Arc::clone(&server.counts), Arc::clone(&server.arrivals));
        let receiver = receiver::Receiver {
            socket: Arc::clone(&socket),
            handle: handle.clone(),
            counts: Arc::clone(&counts),
            arrivals: Arc::clone(&arrivals),
            stop: Arc::clone(&server.stop),
        };
        let ends = Ends { socket, handle, announcer, counts, arrivals, to_come: names, complain };
        let listener = Listener::new(ends, Names::of(patch));
        let stopped = Arc::clone(&server.stop);
        let listen = move || listener.listen(&stopped);
        let thread = |name: &str| std::thread::Builder::new().name(name.into());
        // The one that is there ends with the server where there is no other.
        server.threads.push(thread("osc").spawn(listen).map_err(failed)?);
        server.threads.push(thread("osc in").spawn(|| receiver.receive()).map_err(failed)?);
        Ok(server)
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What came, and what became of it.
    pub fn counts(&self) -> &Arc<Counts> {
        &self.counts
    }

    /// What came to nothing since this was asked last, in a sentence for each address, of the first few; all of it is in [`Server::counts`].
    pub fn complaints(&self) -> impl Iterator<Item = String> {
        self.complaints.try_iter()
    }

    /// The session plays another patch from now on. Controls that it still has keep what is known of them; reports on controls end.
    pub fn follow(&self, patch: &Patch) {
        // Nobody hears it only where the thread has ended.
        let _ = self.names.send(Names::of(patch));
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        self.counts.crammed.add(self.arrivals.end() as u64);
        for thread in self.threads.drain(..) {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}
