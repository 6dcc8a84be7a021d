//! Where OSC is listened for, and why it cannot be.

use std::fmt;
use std::io::{Error, ErrorKind};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::str::FromStr;

/// An address of this machine and a UDP port on it; port 0 is any that is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Endpoint(pub SocketAddr);

/// Bytes of datagrams that may wait to be heard: some ten thousand of them.
#[cfg(unix)]
const BUFFER: usize = 1 << 23;

impl FromStr for Endpoint {
    type Err = String;

    /// `127.0.0.1:9000`, `[::1]:9000`, `localhost:9000`; `9000` alone is loopback, which other machines cannot reach.
    fn from_str(text: &str) -> Result<Self, String> {
        let local = |port: &str| Some(SocketAddr::new(Ipv4Addr::LOCALHOST.into(), port.parse().ok()?));
        text.parse()
            .ok()
            .or_else(|| local(text))
            .or_else(|| local(text.strip_prefix("localhost:")?))
            .map(Self)
            .ok_or_else(|| {
                "give a port, 9000, or an address with one: 127.0.0.1:9000, 0.0.0.0:9000, [::1]:9000".into()
            })
    }
}

impl Endpoint {
    /// Whether other machines reach it.
    pub fn is_open(&self) -> bool {
        !self.0.ip().is_loopback()
    }

    /// Listens there.
    ///
    /// # Errors
    /// A port that is taken, or that the system does not give; an address that this machine does not have.
    pub fn bind(&self) -> Result<UdpSocket, BindError> {
        let socket = UdpSocket::bind(self.0).map_err(|error| BindError::of(self.0, &error))?;
        // A system that gives less than it is asked for drops more of a burst, which is counted.
        #[cfg(unix)]
        let _ = rustix::net::sockopt::set_socket_recv_buffer_size(&socket, BUFFER);
        Ok(socket)
    }
}

/// Why OSC cannot be listened for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BindError {
    /// What happened, where.
    pub what: String,
    /// What to do about it.
    pub help: String,
    /// The exit code of a program that ends for it, as `sysexits.h` has them.
    pub exit_code: u8,
}

impl BindError {
    pub(super) fn of(at: SocketAddr, error: &Error) -> Self {
        let port = at.port();
        let (exit_code, why, help) = match error.kind() {
            ErrorKind::AddrInUse => (
                75,
                "another program listens there".into(),
                format!(
                    "give another port: --osc {}",
                    SocketAddr::new(at.ip(), port.checked_add(1).unwrap_or(9000))
                ),
            ),
            ErrorKind::PermissionDenied => (
                77,
                "the system does not allow it".into(),
                format!("give a port from 1024 on: --osc {}", SocketAddr::new(at.ip(), port.max(9000))),
            ),
            ErrorKind::AddrNotAvailable => (
                69,
                "this machine does not have that address".into(),
                format!(
                    "for this machine alone: --osc {port}; for all that can reach it: --osc {}",
                    open(at)
                ),
            ),
            _ => (71, error.to_string(), format!("try --osc {port}, which is loopback")),
        };
        Self { what: format!("OSC cannot be listened for on {at}: {why}"), help, exit_code }
    }
}

fn open(at: SocketAddr) -> SocketAddr {
    SocketAddr::new(IpAddr::V4(Ipv4Addr::UNSPECIFIED), at.port())
}

impl fmt::Display for BindError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.what, self.help)
    }
}

impl std::error::Error for BindError {}

#[cfg(test)]
mod tests {
    use super::{BindError, Endpoint};
    use std::io::{Error, ErrorKind};

    #[test]
    fn a_bare_port_is_loopback() {
        for (text, shown, open) in [
            ("9000", "127.0.0.1:9000", false),
            ("localhost:9000", "127.0.0.1:9000", false),
            ("127.0.0.1:9000", "127.0.0.1:9000", false),
            ("0.0.0.0:9000", "0.0.0.0:9000", true),
            ("[::1]:9", "[::1]:9", false),
            ("[::]:9", "[::]:9", true),
        ] {
            let endpoint: Endpoint = text.parse().unwrap();
            assert_eq!((endpoint.0.to_string(), endpoint.is_open()), (shown.into(), open));
        }
        for text in ["", "x", "65536", "-1", "127.0.0.1", ":9000", "host:9000", "localhost:"] {
            assert!(text.parse::<Endpoint>().unwrap_err().contains("0.0.0.0:9000"), "{text}");
        }
    }

    #[test]
    fn errors_say_where_and_what_to_do() {
        let any: Endpoint = "0".parse().unwrap();
        let taken = any.bind().unwrap();
        let there = Endpoint(taken.local_addr().unwrap());
        let error = there.bind().unwrap_err();
        assert!(
            error.what.contains(&there.0.to_string()) && error.what.contains("another program"),
            "{error}"
        );
        assert!(error.help.contains("--osc 127.0.0.1:"), "{error}");
        assert_eq!(error.exit_code, 75);
        // An address for documentation (RFC 5737), which no machine has.
        let error = "192.0.2.1:9000".parse::<Endpoint>().unwrap().bind().unwrap_err();
        assert_eq!(error.exit_code, 69, "{error}");
        assert!(error.help.contains("--osc 9000;") && error.help.contains("0.0.0.0:9000"), "{error}");
        let error = BindError::of("127.0.0.1:80".parse().unwrap(), &Error::from(ErrorKind::PermissionDenied));
        assert_eq!(error.help, "give a port from 1024 on: --osc 127.0.0.1:9000");
        assert_eq!(error.exit_code, 77);
    }
}
