//! Whether a datagram pulls the emergency brake, seen without unpacking what does not.

use super::address::{LONGEST, Pattern};
use super::message::{Ask, ask};
use super::names::Method;
use super::packet::{DEPTH, unpack};

/// The address of the brake.
pub const PANIC: &str = "/panic";

/// Characters of patterns that are looked at in a datagram at most. The brake by its own name costs none.
const STEPS: u64 = 20_000;

/// Whether something in a datagram closes the gate, as [`super::server::Server`] would find when it comes to it.
pub(super) fn is_pulled(datagram: &[u8]) -> bool {
    is_addressed(datagram, 0, &mut { STEPS })
        && unpack(datagram).is_ok_and(|messages| {
            let mut steps = STEPS;
            messages.iter().any(|(_, message)| {
                means(&message.addr, &mut steps) && ask(&Method::Panic, &message.args) == Ok(Ask::Panic)
            })
        })
}

/// Whether one of the messages in it has the address of the brake, whatever else is to be said of it.
fn is_addressed(bytes: &[u8], depth: usize, steps: &mut u64) -> bool {
    let Some(bundle) = bytes.strip_prefix(b"#bundle\0") else {
        let address = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
        return std::str::from_utf8(address).is_ok_and(|address| means(address, steps));
    };
    let Some(mut rest) = bundle.get(8..).filter(|_| depth < DEPTH) else { return false };
    while let Some((size, after)) = rest.split_first_chunk::<4>() {
        let Some((element, after)) = after.split_at_checked(u32::from_be_bytes(*size) as usize) else {
            break;
        };
        if is_addressed(element, depth + 1, steps) {
            return true;
        }
        rest = after;
    }
    false
}

/// Whether an address is that of the brake, or a pattern that it matches.
fn means(address: &str, steps: &mut u64) -> bool {
    if address == PANIC {
        return true;
    }
    // Most are told by their second letter.
    let may = matches!(address.as_bytes().get(1), Some(b'p' | b'?' | b'*' | b'[' | b'{'));
    if !may || *steps == 0 || address.len() > LONGEST || !address.contains(['?', '*', '[', '{']) {
        return false;
    }
    let mut taken = address.len() as u64;
    let found = Pattern::parse(address).is_some_and(|pattern| pattern.matches(PANIC, &mut taken));
    *steps = steps.saturating_sub(taken);
    found
}

#[cfg(test)]
mod tests {
    use super::{STEPS, is_pulled};
    use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

    fn message(addr: &str, args: Vec<OscType>) -> OscPacket {
        OscPacket::Message(OscMessage { addr: addr.into(), args })
    }

    fn bundle(content: Vec<OscPacket>) -> OscPacket {
        OscPacket::Bundle(OscBundle { timetag: OscTime { seconds: 0, fractional: 1 }, content })
    }

    fn pulls(packet: &OscPacket) -> bool {
        is_pulled(&encoder::encode(packet).unwrap())
    }

    #[test]
    fn by_its_name_or_a_pattern_pressed_and_not_let_go() {
        for addr in ["/panic", "/*", "/pan?c", "/{calm,panic}", "/[o-q]anic"] {
            assert!(pulls(&message(addr, vec![])), "{addr}");
            assert!(pulls(&message(addr, vec![1.0_f32.into()])), "{addr}");
            assert!(!pulls(&message(addr, vec![0.into()])), "{addr}");
            assert!(!pulls(&message(addr, vec!["now".into()])), "{addr}");
            let deep =
                (0..8).fold(message(addr, vec![]), |inner, _| bundle(vec![message("/a", vec![]), inner]));
            assert!(pulls(&deep), "{addr}");
            assert!(!pulls(&bundle(vec![deep])), "{addr}: nested too deeply");
        }
        for addr in ["/calm", "/panics", "/panic/", "/p", "/?", "/ping", "/{calm,arm}", "/[panic"] {
            assert!(!pulls(&message(addr, vec![])), "{addr}");
        }
    }

    #[test]
    fn of_what_cannot_be_read_nothing_is_done() {
        let whole =
            encoder::encode(&bundle(vec![message("/panic", vec![]), message("/a", vec![1.into()])])).unwrap();
        assert!(is_pulled(&whole));
        for length in 0..whole.len() {
            // Where it ends between two messages, it is whole.
            assert_eq!(is_pulled(&whole[..length]), length == 32, "{length}");
        }
        assert!(!is_pulled(b"/panic"));
        assert!(is_pulled(b"/panic\0\0"));
    }

    /// One by its name is found behind any number of patterns, however long they take.
    #[test]
    fn patterns_hide_nothing() {
        let costly = message(&format!("/p{}x", "*{a,}".repeat(48)), vec![]);
        let all: Vec<_> = (0..400).map(|_| costly.clone()).chain([message("/panic", vec![])]).collect();
        assert!(all.len() as u64 * 250 > STEPS && pulls(&bundle(all)));
    }
}
