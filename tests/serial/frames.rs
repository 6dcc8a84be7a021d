//! COBS, CRC-32 and varints, written anew for the devices of the tests.

/// CRC-32 as of zlib, bit by bit.
pub fn crc(bytes: &[u8]) -> u32 {
    let mut sum = !0_u32;
    for byte in bytes {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 };
        }
    }
    !sum
}

/// With the 0 at its end.
pub fn stuff(bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0];
    let mut at = 0;
    for byte in bytes {
        if *byte != 0 {
            out.push(*byte);
        }
        if *byte == 0 || out.len() - at == 255 {
            out[at] = (out.len() - at) as u8;
            at = out.len();
            out.push(0);
        }
    }
    out[at] = (out.len() - at) as u8;
    out.push(0);
    out
}

/// Without the 0 at its end.
pub fn unstuff(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let code = usize::from(bytes[at]);
        if code == 0 || at + code > bytes.len() {
            return None;
        }
        out.extend(&bytes[at + 1..at + code]);
        at += code;
        if code != 255 && at < bytes.len() {
            out.push(0);
        }
    }
    Some(out)
}

/// A message as a frame.
pub fn frame(message: &[u8]) -> Vec<u8> {
    stuff(&[message, &crc(message).to_le_bytes()].concat())
}

/// The message of a frame without its 0.
pub fn unframe(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut all = unstuff(bytes)?;
    let at = all.len().checked_sub(4).filter(|at| *at > 0)?;
    let right = crc(&all[..at]).to_le_bytes() == all[at..];
    all.truncate(at);
    right.then_some(all)
}

/// A varint.
pub fn varint(mut value: u64) -> Vec<u8> {
    let mut out = Vec::new();
    loop {
        let low = (value & 0x7f) as u8;
        value >>= 7;
        if value == 0 {
            out.push(low);
            return out;
        }
        out.push(low | 0x80);
    }
}

/// A field that holds bytes.
pub fn nested(field: u64, bytes: &[u8]) -> Vec<u8> {
    [varint(field << 3 | 2), varint(bytes.len() as u64), bytes.to_vec()].concat()
}

/// A field that holds a number, unless it is 0.
pub fn number(field: u64, value: i64) -> Vec<u8> {
    if value == 0 { Vec::new() } else { [varint(field << 3), varint(value as u64)].concat() }
}

/// A field that holds a float, unless it is 0.
pub fn float(field: u64, value: f32) -> Vec<u8> {
    if value == 0.0 { Vec::new() } else { [varint(field << 3 | 5), value.to_le_bytes().to_vec()].concat() }
}

/// A field.
#[derive(Debug, Clone)]
pub enum Field {
    Number(u64),
    Float(f32),
    Bytes(Vec<u8>),
}

fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    let mut shift = 0;
    loop {
        let (first, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(first & 0x7f).checked_shl(shift)?;
        shift += 7;
        if *first < 128 {
            return Some(value);
        }
    }
}

/// The fields of a message.
pub fn fields(mut bytes: &[u8]) -> Option<Vec<(u64, Field)>> {
    let mut out = Vec::new();
    while !bytes.is_empty() {
        let key = take_varint(&mut bytes)?;
        let field = match key % 8 {
            0 => Field::Number(take_varint(&mut bytes)?),
            2 => {
                let length = take_varint(&mut bytes)? as usize;
                let taken = bytes.get(..length)?;
                bytes = &bytes[length..];
                Field::Bytes(taken.to_vec())
            }
            5 => {
                let taken = bytes.get(..4)?;
                bytes = &bytes[4..];
                Field::Float(f32::from_le_bytes(taken.try_into().unwrap()))
            }
            _ => return None,
        };
        out.push((key / 8, field));
    }
    Some(out)
}

/// Bytes of their hexadecimal digits.
pub fn hex(digits: &str) -> Vec<u8> {
    (0..digits.len()).step_by(2).map(|k| u8::from_str_radix(&digits[k..k + 2], 16).unwrap()).collect()
}

/// Messages and frames as they were seen on the wire.
pub const SEEN: [(&str, &str); 5] = [
    ("080110071a00", "06080110071a05bfb18a8500"),
    ("080112020808", "0b0801120208083e43675f00"),
    (
        "080110082220280a35c2b8323e3d0000803f450000803f4dcdcc8c3f5208706163696e69616e",
        "0f080110082220280a35c2b8323e3d0104803f450116803f4dcdcc8c3f5208706163696e69616ee4d8188500",
    ),
    ("08011009220b28ffffffffffffffffff01", "1608011009220b28ffffffffffffffffff01ae7f274300"),
    (
        "0801222b080315000080be1a20280a35c2b8323e3d0000803f450000803f4dcdcc8c3f5208706163696e69616e2002",
        "080801222b080315010d80be1a20280a35c2b8323e3d0104803f450118803f4dcdcc8c3f5208706163696e69616e20020a24328000",
    ),
];

#[test]
fn both_sides_make_and_take_what_was_seen() {
    use pacinian::io::knob::smartknob::frame::{pack, unpack};
    assert_eq!(crc(b"123456789"), 0xcbf4_3926);
    for (message, wire) in SEEN {
        let (message, wire) = (hex(message), hex(wire));
        let inner = &wire[..wire.len() - 1];
        assert_eq!((frame(&message), pack(&message)), (wire.clone(), wire.clone()));
        assert_eq!((unframe(inner), unpack(inner).ok()), (Some(message.clone()), Some(message)));
    }
    // Runs of 254 and their neighbours, from one side to the other.
    for length in [1, 253, 254, 255, 256, 269, 508, 509, 600] {
        for fill in [0, 0x41] {
            let message = vec![fill; length];
            assert_eq!(unpack(&frame(&message)[..frame(&message).len() - 1]).ok(), Some(message.clone()));
            assert_eq!(unframe(&pack(&message)[..pack(&message).len() - 1]), Some(message));
        }
    }
}
