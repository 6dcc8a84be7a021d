//! Datagrams that the system dropped because they came faster than they were received.

use std::net::{IpAddr, SocketAddr};

/// How many, on a socket that is bound to `local`; `None` where the system does not tell.
pub(super) fn dropped(local: SocketAddr) -> Option<u64> {
    let table = if local.is_ipv4() { "/proc/net/udp" } else { "/proc/net/udp6" };
    find(&std::fs::read_to_string(table).ok()?, local)
}

/// In a table as Linux shows it: local address in the second column, drops in the last.
fn find(table: &str, local: SocketAddr) -> Option<u64> {
    // Addresses stand there in words of the machine's order.
    let words = |bytes: &[u8]| -> String {
        bytes
            .chunks_exact(4)
            .map(|w| format!("{:08X}", u32::from_ne_bytes([w[0], w[1], w[2], w[3]])))
            .collect()
    };
    let address = match local.ip() {
        IpAddr::V4(ip) => words(&ip.octets()),
        IpAddr::V6(ip) => words(&ip.octets()),
    };
    let wanted = format!("{address}:{:04X}", local.port());
    table.lines().find_map(|line| {
        let mut columns = line.split_whitespace();
        (columns.nth(1)? == wanted).then(|| columns.last()?.parse().ok())?
    })
}

#[cfg(test)]
mod tests {
    use super::{dropped, find};
    use std::net::UdpSocket;

    #[cfg(target_endian = "little")]
    #[test]
    fn as_the_table_has_it() {
        let table = "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer drops\n\
            104: 00000000:2328 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 24 2 0 5\n\
            105: 0100007F:2328 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 25 2 0 37\n\
            106: 00000000000000000000000001000000:0009 0:0 07 0:0 00:0 0     0        0 26 2 0 8\n";
        assert_eq!(find(table, "127.0.0.1:9000".parse().unwrap()), Some(37));
        assert_eq!(find(table, "0.0.0.0:9000".parse().unwrap()), Some(5));
        assert_eq!(find(table, "[::1]:9".parse().unwrap()), Some(8));
        assert_eq!(find(table, "127.0.0.1:9001".parse().unwrap()), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_nobody_receives_is_counted() {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let local = socket.local_addr().unwrap();
        let Some(0) = dropped(local) else {
            eprintln!("skipped: this system does not tell");
            return;
        };
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        for _ in 0..20_000 {
            sender.send_to(&[0; 64], local).unwrap();
        }
        socket.set_nonblocking(true).unwrap();
        let received = std::iter::from_fn(|| socket.recv_from(&mut [0; 64]).ok()).count() as u64;
        assert_eq!(received + dropped(local).unwrap(), 20_000);
        assert!(received < 20_000);
    }
}
