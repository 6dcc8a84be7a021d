//! A frame: a message and its CRC-32, little end first, as one run of COBS (Cheshire and Baker, 1999), and a 0.

/// The longest frame that is kept, without its 0. The knob's log messages take up to 269 bytes; a frame that is longer is dropped.
pub const LONGEST: usize = 512;

/// A message as a frame, with the 0 at its end.
pub fn pack(message: &[u8]) -> Vec<u8> {
    let mut bytes = message.to_vec();
    bytes.extend_from_slice(&crc32fast::hash(message).to_le_bytes());
    let mut frame = cobs::encode_vec(&bytes);
    frame.push(0);
    frame
}

/// The message in a frame, given without its 0.
pub fn unpack(frame: &[u8]) -> Result<Vec<u8>, Damaged> {
    let mut bytes = cobs::decode_vec(frame).map_err(|_| Damaged)?;
    // The knob takes nothing shorter either.
    let at = bytes.len().checked_sub(4).filter(|at| *at > 0).ok_or(Damaged)?;
    let sum = crc32fast::hash(&bytes[..at]).to_le_bytes();
    if bytes[at..] != sum {
        return Err(Damaged);
    }
    bytes.truncate(at);
    Ok(bytes)
}

/// It is no frame, or was damaged on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Damaged;

/// Frames that come piece by piece.
#[derive(Debug, Clone, Default)]
pub(super) struct Frames {
    held: Vec<u8>,
    too_long: bool,
}

impl Frames {
    /// Takes a byte; the frame that it ends. Two zeros have none between them.
    pub fn push(&mut self, byte: u8) -> Option<Result<Vec<u8>, Damaged>> {
        if byte != 0 {
            if self.held.len() == LONGEST {
                self.too_long = true;
            } else {
                self.held.push(byte);
            }
            return None;
        }
        let frame = match (std::mem::take(&mut self.too_long), self.held.is_empty()) {
            (true, _) => Some(Err(Damaged)),
            (false, true) => None,
            (false, false) => Some(unpack(&self.held)),
        };
        self.held.clear();
        frame
    }

    /// Forgets a frame that was begun.
    pub fn forget(&mut self) {
        self.held.clear();
        self.too_long = false;
    }
}

#[cfg(test)]
mod tests {
    use super::{Damaged, Frames, pack, unpack};

    #[test]
    fn a_frame_of_any_length_comes_back() {
        for length in 1..600 {
            for fill in [0, 1, 0xff] {
                let message: Vec<u8> = (0..length).map(|k| if fill == 1 { k as u8 } else { fill }).collect();
                let frame = pack(&message);
                assert_eq!(frame.iter().filter(|byte| **byte == 0).count(), 1);
                assert_eq!(unpack(&frame[..frame.len() - 1]), Ok(message));
            }
        }
    }

    #[test]
    fn damage_is_seen_and_what_follows_is_whole() {
        let mut frames = Frames::default();
        let mut frame = pack(&[8, 1, 16, 7]);
        frame[2] ^= 2;
        frame.extend(pack(&[8, 1]));
        frame.extend([5, 0, 0, 1, 2, 3, 0]);
        frame.extend([1; 2000]);
        frame.push(0);
        frame.extend(pack(&[9]));
        let all: Vec<_> = frame.iter().filter_map(|byte| frames.push(*byte)).collect();
        let bad = Err(Damaged);
        assert_eq!(all, [bad.clone(), Ok(vec![8, 1]), bad.clone(), bad.clone(), bad, Ok(vec![9])]);
        assert!(frames.held.capacity() <= 1024);
    }
}
