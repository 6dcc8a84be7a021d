//! What lies in a datagram: a message, or bundles of messages in bundles.
//!
//! Bundles are walked here and only messages are left to `rosc`, which would follow nested bundles and nested arrays as deep as they
//! go, and passes over what is broken in a bundle.

use rosc::{OscMessage, OscPacket};

use super::time::Tag;

/// Bundles within bundles, and arrays within arrays, at most.
pub const DEPTH: usize = 8;

/// Why nothing in a datagram is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unreadable {
    /// It is not OSC, is cut off, or has a type that OSC 1.0 does not have.
    Malformed,
    /// It is nested deeper than [`DEPTH`].
    Deep,
}

/// The messages of a datagram, in order, with the tag of the bundle each lies in. If a part of it cannot be read, nothing of it can.
///
/// # Errors
/// What cannot be read.
pub fn unpack(datagram: &[u8]) -> Result<Vec<(Tag, OscMessage)>, Unreadable> {
    let mut messages = Vec::new();
    walk(datagram, Tag::AT_ONCE, 0, &mut messages)?;
    Ok(messages)
}

fn walk(bytes: &[u8], tag: Tag, depth: usize, into: &mut Vec<(Tag, OscMessage)>) -> Result<(), Unreadable> {
    let Some(mut rest) = bytes.strip_prefix(b"#bundle\0") else {
        into.push((tag, message(bytes)?));
        return Ok(());
    };
    if depth == DEPTH {
        return Err(Unreadable::Deep);
    }
    let (own, after) = rest.split_first_chunk::<8>().ok_or(Unreadable::Malformed)?;
    let tag = tag.of_inner(Tag(u64::from_be_bytes(*own)));
    rest = after;
    while !rest.is_empty() {
        let (size, after) = rest.split_first_chunk::<4>().ok_or(Unreadable::Malformed)?;
        let size = u32::from_be_bytes(*size) as usize;
        let (element, after) = after.split_at_checked(size).ok_or(Unreadable::Malformed)?;
        walk(element, tag, depth + 1, into)?;
        rest = after;
    }
    Ok(())
}

fn message(bytes: &[u8]) -> Result<OscMessage, Unreadable> {
    if !bytes.starts_with(b"/") || !bytes.len().is_multiple_of(4) {
        return Err(Unreadable::Malformed);
    }
    let length = bytes.iter().position(|b| *b == 0).ok_or(Unreadable::Malformed)?;
    // The address with its padding; then the types.
    let types = bytes.get(length / 4 * 4 + 4..).unwrap_or_default();
    if types.is_empty() {
        // Senders from before OSC 1.0 leave the types out; without arguments it is clear what is meant.
        let addr = std::str::from_utf8(&bytes[..length]).map_err(|_| Unreadable::Malformed)?;
        return Ok(OscMessage { addr: addr.into(), args: Vec::new() });
    }
    if types[0] != b',' {
        return Err(Unreadable::Malformed);
    }
    let mut depth = 0_usize;
    for tag in types.iter().take_while(|tag| **tag != 0) {
        match tag {
            b'[' if depth == DEPTH => return Err(Unreadable::Deep),
            b'[' => depth += 1,
            b']' => depth = depth.checked_sub(1).ok_or(Unreadable::Malformed)?,
            _ => {}
        }
    }
    if depth != 0 {
        return Err(Unreadable::Malformed);
    }
    match rosc::decoder::decode_udp(bytes) {
        Ok(([], OscPacket::Message(message))) => Ok(message),
        _ => Err(Unreadable::Malformed),
    }
}

#[cfg(test)]
mod tests {
    use super::{DEPTH, Unreadable, unpack};
    use crate::io::osc::time::Tag;
    use proptest::prelude::{ProptestConfig, Strategy, any, prop, prop_oneof, proptest};
    use rosc::{OscArray, OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

    fn message(addr: &str, args: Vec<OscType>) -> OscPacket {
        OscPacket::Message(OscMessage { addr: addr.into(), args })
    }

    fn bundle(seconds: u32, content: Vec<OscPacket>) -> OscPacket {
        OscPacket::Bundle(OscBundle { timetag: OscTime { seconds, fractional: 1 }, content })
    }

    fn nested(depth: usize) -> OscPacket {
        (0..depth).fold(message("/a", vec![]), |inner, _| bundle(0, vec![inner]))
    }

    #[test]
    fn messages_in_order_with_their_tags() {
        let packet = bundle(
            9,
            vec![
                message("/a", vec![1.into()]),
                bundle(0, vec![message("/b", vec![])]),
                bundle(12, vec![message("/c", vec![]), bundle(10, vec![message("/d", vec![])])]),
                bundle(3, vec![]),
                message("/e", vec![0.5_f32.into(), "x".into()]),
            ],
        );
        let found = unpack(&encoder::encode(&packet).unwrap()).unwrap();
        let found: Vec<_> =
            found.iter().map(|(tag, m)| (tag.0 >> 32, m.addr.as_str(), m.args.len())).collect();
        assert_eq!(found, [(9, "/a", 1), (9, "/b", 0), (12, "/c", 0), (12, "/d", 0), (9, "/e", 2)]);
    }

    /// The examples of the specification (OSC 1.0, "Examples of OSC messages").
    #[test]
    fn as_the_specification_writes_them() {
        let one = |bytes: &[u8]| unpack(bytes).unwrap().remove(0).1;
        let found = one(b"/oscillator/4/frequency\0,f\0\0\x43\xdc\0\0");
        assert_eq!(
            (found.addr.as_str(), found.args),
            ("/oscillator/4/frequency", vec![OscType::Float(440.0)])
        );
        let found = one(
            b"/foo\0\0\0\0,iisff\0\0\0\0\x03\xe8\xff\xff\xff\xffhello\0\0\0\x3f\x9d\xf3\xb6\x40\xb5\xb2\x2d",
        );
        let wanted = vec![1000.into(), (-1).into(), "hello".into(), 1.234_f32.into(), 5.678_f32.into()];
        assert_eq!((found.addr.as_str(), found.args), ("/foo", wanted));
    }

    #[test]
    fn without_types_it_has_no_arguments() {
        for bytes in [&b"/ping\0\0\0"[..], b"/ab\0", b"/abc\0\0\0\0"] {
            let found = unpack(bytes).unwrap();
            assert_eq!((found.len(), found[0].0, found[0].1.args.len()), (1, Tag::AT_ONCE, 0), "{bytes:?}");
        }
        assert_eq!(unpack(b"/ab\0").unwrap()[0].1.addr, "/ab");
    }

    #[test]
    fn what_is_broken_is_refused_as_a_whole() {
        let whole =
            encoder::encode(&bundle(0, vec![message("/a", vec![]), message("/b", vec![1.into()])])).unwrap();
        assert_eq!(unpack(&whole).unwrap().len(), 2);
        for length in 0..whole.len() {
            // Between two elements a bundle may end.
            let fine = [16, 28].contains(&length);
            assert_eq!(unpack(&whole[..length]).is_ok(), fine, "{length}");
        }
        for bytes in [
            &b"a\0\0\0,\0\0\0"[..],
            b"/a\0\0,i\0\0",
            b"/a\0\0,\0\0\0more",
            b"/a\0\0i\0\0\0\0\0\0\0",
            b"/a\0\0,q\0\0",
            b"/a\0\0,]\0\0",
            b"/a\0\0,[[\0",
            b"/a\0\0,s\0\0\xff\xff\0\0",
            b"/\xff\0\0,\0\0\0",
            b"/\xff\0\0",
            b"/a\0\0,b\0\0\xff\xff\xff\xff",
            b"/abc",
            b"#bundle\0",
            b"#bundle\0\0\0\0\0\0\0\0\x01\xff\xff\xff\xff",
        ] {
            assert_eq!(unpack(bytes), Err(Unreadable::Malformed), "{bytes:?}");
        }
    }

    #[test]
    fn depth_is_bounded() {
        assert_eq!(unpack(&encoder::encode(&nested(DEPTH)).unwrap()).unwrap().len(), 1);
        assert_eq!(unpack(&encoder::encode(&nested(DEPTH + 1)).unwrap()), Err(Unreadable::Deep));
        // As deep as a datagram can hold.
        let mut bytes = b"/a\0\0,\0\0\0".to_vec();
        while bytes.len() + 20 < 65_000 {
            let size = (bytes.len() as u32).to_be_bytes();
            bytes = [b"#bundle\0\0\0\0\0\0\0\0\x01".as_slice(), &size, &bytes].concat();
        }
        assert_eq!(unpack(&bytes), Err(Unreadable::Deep));
        let arrays = |n: usize| {
            let mut bytes = [b"/a\0\0,".as_slice(), &vec![b'['; n], &vec![b']'; n], b"\0"].concat();
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            bytes
        };
        assert!(unpack(&arrays(DEPTH)).is_ok());
        assert_eq!(unpack(&arrays(DEPTH + 1)), Err(Unreadable::Deep));
        assert_eq!(unpack(&arrays(32_000)), Err(Unreadable::Deep));
    }

    fn argument() -> impl Strategy<Value = OscType> {
        let plain = prop_oneof![
            any::<i32>().prop_map(OscType::Int),
            any::<i64>().prop_map(OscType::Long),
            (-1e9_f32..1e9).prop_map(OscType::Float),
            (-1e9..1e9).prop_map(OscType::Double),
            any::<bool>().prop_map(OscType::Bool),
            "[a-z]{0,9}".prop_map(OscType::String),
            prop::collection::vec(any::<u8>(), 0..9).prop_map(OscType::Blob),
            any::<char>().prop_map(OscType::Char),
            prop::sample::select(vec![OscType::Nil, OscType::Inf]),
        ];
        plain.prop_recursive(3, 9, 3, |inner| {
            prop::collection::vec(inner, 0..3).prop_map(|content| OscType::Array(OscArray { content }))
        })
    }

    fn packet() -> impl Strategy<Value = OscPacket> {
        let plain = ("/[a-z/*{}]{0,12}", prop::collection::vec(argument(), 0..5))
            .prop_map(|(addr, args)| message(&addr, args));
        plain.prop_recursive(4, 12, 4, |inner| {
            (any::<u32>(), prop::collection::vec(inner, 0..4)).prop_map(|(s, content)| bundle(s, content))
        })
    }

    fn flat(packet: &OscPacket, into: &mut Vec<OscMessage>) {
        match packet {
            OscPacket::Message(message) => into.push(message.clone()),
            OscPacket::Bundle(bundle) => bundle.content.iter().for_each(|inner| flat(inner, into)),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn what_was_packed_is_unpacked(packet in packet()) {
            let mut wanted = Vec::new();
            flat(&packet, &mut wanted);
            let found = unpack(&encoder::encode(&packet).unwrap()).unwrap();
            assert_eq!(found.into_iter().map(|(_, message)| message).collect::<Vec<_>>(), wanted);
        }

        #[test]
        fn nothing_panics(bytes in prop::collection::vec(any::<u8>(), 0..200), packet in packet(), flips in prop::collection::vec((any::<usize>(), any::<u8>()), 0..6)) {
            let _ = unpack(&bytes);
            let _ = unpack(&[b"#bundle\0".as_slice(), &bytes].concat());
            let mut broken = encoder::encode(&packet).unwrap();
            for (at, value) in flips {
                let length = broken.len();
                broken[at % length] = value;
            }
            let _ = unpack(&broken);
        }
    }
}
