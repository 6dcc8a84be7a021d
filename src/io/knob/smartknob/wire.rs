//! The wire format of Protocol Buffers, as far as it is needed: varints, 32-bit floats, and what has a length. Four small messages want less
//! than a generator would bring.

/// Writes fields in the order they are given. What is 0 or empty is left out, as proto3 has it.
#[derive(Debug, Default)]
pub(super) struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    /// `uint32`.
    pub fn unsigned(&mut self, field: u32, value: u32) {
        if value != 0 {
            self.varint(u64::from(field) << 3);
            self.varint(u64::from(value));
        }
    }

    /// `int32`: a negative one takes ten bytes.
    pub fn signed(&mut self, field: u32, value: i32) {
        if value != 0 {
            self.varint(u64::from(field) << 3);
            self.varint(i64::from(value) as u64);
        }
    }

    /// `float`.
    pub fn float(&mut self, field: u32, value: f32) {
        if value.to_bits() != 0 {
            self.varint(u64::from(field) << 3 | 5);
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
    }

    /// A message, which is written even where it is empty.
    pub fn message(&mut self, field: u32, bytes: &[u8]) {
        self.varint(u64::from(field) << 3 | 2);
        self.varint(bytes.len() as u64);
        self.bytes.extend_from_slice(bytes);
    }

    /// A string.
    pub fn text(&mut self, field: u32, text: &str) {
        if !text.is_empty() {
            self.message(field, text.as_bytes());
        }
    }

    /// `repeated int32`, packed.
    pub fn packed(&mut self, field: u32, values: &[i32]) {
        if !values.is_empty() {
            let mut inner = Self::default();
            values.iter().for_each(|value| inner.varint(i64::from(*value) as u64));
            self.message(field, &inner.bytes);
        }
    }

    /// What was written.
    pub fn done(self) -> Vec<u8> {
        self.bytes
    }
}

/// The value of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Value<'a> {
    Varint(u64),
    Fixed32([u8; 4]),
    Fixed64,
    Bytes(&'a [u8]),
}

impl<'a> Value<'a> {
    /// As `int32` or `uint32`, of which the lower bits count.
    pub fn number(self) -> Option<u64> {
        if let Self::Varint(value) = self { Some(value) } else { None }
    }

    /// As `float`.
    pub fn float(self) -> Option<f32> {
        if let Self::Fixed32(bytes) = self { Some(f32::from_le_bytes(bytes)) } else { None }
    }

    /// As a message or a string.
    pub fn bytes(self) -> Option<&'a [u8]> {
        if let Self::Bytes(bytes) = self { Some(bytes) } else { None }
    }
}

/// Reads fields, one after the other. `Err` where the bytes are no message.
#[derive(Debug, Clone)]
pub(super) struct Fields<'a> {
    rest: &'a [u8],
    broken: bool,
}

/// The bytes are no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Broken;

impl<'a> Fields<'a> {
    /// Of a message.
    pub fn of(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, broken: false }
    }

    /// Of packed numbers.
    pub fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for k in 0..10 {
            let byte = *self.rest.get(k)?;
            value |= u64::from(byte & 0x7f) << (7 * k);
            if byte < 0x80 {
                self.rest = &self.rest[k + 1..];
                return Some(value);
            }
        }
        None
    }

    fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(usize::try_from(count).ok()?)?;
        self.rest = rest;
        Some(taken)
    }

    fn field(&mut self) -> Option<(u32, Value<'a>)> {
        let key = self.varint()?;
        let field = u32::try_from(key >> 3).ok().filter(|field| *field != 0)?;
        let value = match key & 7 {
            0 => Value::Varint(self.varint()?),
            1 => self.take(8).map(|_| Value::Fixed64)?,
            2 => {
                let length = self.varint()?;
                Value::Bytes(self.take(length)?)
            }
            5 => Value::Fixed32(self.take(4)?.try_into().ok()?),
            _ => return None,
        };
        Some((field, value))
    }

    /// Whether there is nothing more.
    pub fn is_done(&self) -> bool {
        self.rest.is_empty()
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<(u32, Value<'a>), Broken>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() || self.broken {
            return None;
        }
        let field = self.field().ok_or(Broken);
        self.broken = field.is_err();
        Some(field)
    }
}

#[cfg(test)]
mod tests {
    use super::{Broken, Fields, Value, Writer};

    #[test]
    fn what_is_written_is_read() {
        let mut writer = Writer::default();
        writer.unsigned(1, 300);
        writer.signed(2, -1);
        writer.float(3, 0.5);
        writer.text(4, "ab");
        writer.packed(11, &[1, -2]);
        writer.unsigned(5, 0);
        let bytes = writer.done();
        assert_eq!(bytes[..3], [0x08, 0xac, 0x02]);
        let fields: Vec<_> = Fields::of(&bytes).map(Result::unwrap).collect();
        assert_eq!(fields[0], (1, Value::Varint(300)));
        assert_eq!(fields[1].1.number().map(|n| n as i32), Some(-1));
        assert_eq!(fields[2].1.float(), Some(0.5));
        assert_eq!(fields[3], (4, Value::Bytes(b"ab")));
        assert_eq!((fields[4].0, fields.len()), (11, 5));
    }

    #[test]
    fn what_is_no_message_ends() {
        for bytes in [
            &[0x80; 11][..],
            &[0x0a, 5, 1],
            &[0x0d, 1],
            &[0x00, 1],
            &[0x0b],
            &[0x08],
            &[0x0a, 0xff, 0xff, 0xff, 0xff, 0xff, 1],
        ] {
            let all: Vec<_> = Fields::of(bytes).collect();
            assert_eq!(all.last(), Some(&Err(Broken)), "{bytes:?}");
        }
    }
}
