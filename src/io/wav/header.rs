//! All that stands before the samples: RIFF/WAVE, and RF64 (EBU Tech 3306, 2009) once a file outgrows it.
//!
//! `RIFF` `WAVE`, `JUNK` (or `ds64`), `fmt `, `fact` for all but the plain form, `LIST`/`INFO`, `data`. The length depends on the spec alone,
//! so a header can be rewritten in place at any time, also as RF64: the junk holds the room for `ds64`.

use super::{Encoding, WavSpec};
use crate::io::error::{FileError, FileErrorKind};

/// What is in a field of 32 bits when the true number stands in `ds64`.
const ELSEWHERE: u32 = u32::MAX;
/// The most that a RIFF may claim, in bytes after its first eight.
pub(super) const RIFF_LIMIT: u64 = ELSEWHERE as u64 - 1;

/// The tail that all format identifiers of Microsoft's `ksmedia.h` share.
pub(super) const GUID_TAIL: [u8; 14] =
    [0x00, 0x00, 0x00, 0x00, 0x10, 0x00, 0x80, 0x00, 0x00, 0xAA, 0x00, 0x38, 0x9B, 0x71];
const PCM: u16 = 1;
const IEEE_FLOAT: u16 = 3;
const EXTENSIBLE: u16 = 0xFFFE;

/// Refuses what no WAV file can hold.
pub(super) fn check(spec: &WavSpec) -> Result<(), FileError> {
    let misuse = |message: String| Err(FileError::new(FileErrorKind::Misuse, message));
    let most = (usize::from(u16::MAX) / spec.encoding.bytes())
        .min((u64::from(u32::MAX) / u64::from(spec.rate.max(1)) / spec.encoding.bytes() as u64) as usize);
    if spec.rate == 0 {
        return misuse("a WAV file needs a rate of at least 1 Hz, not 0: choose one such as 48000".into());
    }
    if spec.channels == 0 {
        return misuse("a WAV file needs at least one channel: give the rig an output".into());
    }
    if spec.channels > most {
        return misuse(format!(
            "a WAV file of {} at {} Hz holds at most {most} channels, not {}: spread the tactors over several files",
            spec.encoding, spec.rate, spec.channels
        ));
    }
    Ok(())
}

/// The header of a file of `frames` frames, with the name of its form and whether it is RF64.
pub(super) fn header(spec: &WavSpec, frames: u64, riff_limit: u64) -> (Vec<u8>, bool) {
    let (fmt, list) = (format_chunk(spec), info(spec));
    let data = frames * (spec.channels * spec.encoding.bytes()) as u64;
    let fact = if extensible(spec) { 12 } else { 0 };
    let length = 12 + 36 + fmt.len() + fact + list.len() + 8;
    let riff = length as u64 - 8 + data + data % 2;
    let large = riff > riff_limit;
    let field = |value: u64| if large { ELSEWHERE } else { value as u32 }.to_le_bytes();

    let mut out = Vec::with_capacity(length);
    out.extend_from_slice(if large { b"RF64" } else { b"RIFF" });
    out.extend_from_slice(&field(riff));
    out.extend_from_slice(b"WAVE");
    out.extend_from_slice(if large { b"ds64" } else { b"JUNK" });
    out.extend_from_slice(&28_u32.to_le_bytes());
    for value in [riff, data, frames] {
        out.extend_from_slice(&if large { value } else { 0 }.to_le_bytes());
    }
    // No table of further large chunks.
    out.extend_from_slice(&0_u32.to_le_bytes());
    out.extend_from_slice(&fmt);
    if fact > 0 {
        out.extend_from_slice(b"fact\x04\0\0\0");
        out.extend_from_slice(&u32::try_from(frames).unwrap_or(ELSEWHERE).to_le_bytes());
    }
    out.extend_from_slice(&list);
    out.extend_from_slice(b"data");
    out.extend_from_slice(&field(data));
    debug_assert_eq!(out.len(), length);
    (out, large)
}

/// The plain form serves up to two channels of 16 bits, which every program reads; the rest takes the extensible form.
fn extensible(spec: &WavSpec) -> bool {
    spec.channels > 2 || spec.encoding != Encoding::I16
}

fn format_chunk(spec: &WavSpec) -> Vec<u8> {
    let block = spec.channels * spec.encoding.bytes();
    let bits = 8 * spec.encoding.bytes() as u16;
    let extensible = extensible(spec);
    let tag = if spec.encoding == Encoding::F32 { IEEE_FLOAT } else { PCM };

    let mut out = b"fmt ".to_vec();
    out.extend_from_slice(&if extensible { 40_u32 } else { 16 }.to_le_bytes());
    out.extend_from_slice(&if extensible { EXTENSIBLE } else { tag }.to_le_bytes());
    out.extend_from_slice(&(spec.channels as u16).to_le_bytes());
    out.extend_from_slice(&spec.rate.to_le_bytes());
    out.extend_from_slice(&spec.rate.wrapping_mul(block as u32).to_le_bytes());
    out.extend_from_slice(&(block as u16).to_le_bytes());
    out.extend_from_slice(&bits.to_le_bytes());
    if extensible {
        out.extend_from_slice(&22_u16.to_le_bytes());
        out.extend_from_slice(&bits.to_le_bytes());
        // No loudspeaker positions: the channels are tactors, and a player that knows positions would mix them down.
        out.extend_from_slice(&0_u32.to_le_bytes());
        out.extend_from_slice(&tag.to_le_bytes());
        out.extend_from_slice(&GUID_TAIL);
    }
    out
}

/// Title, software and the names of the tactors, before the samples so that a file cut short has them too.
fn info(spec: &WavSpec) -> Vec<u8> {
    let names: Vec<String> =
        spec.tactors.iter().enumerate().map(|(i, name)| format!("{}: {}", i + 1, plain(name, 128))).collect();
    let mut body = b"INFO".to_vec();
    let texts = [
        (b"INAM", plain(&spec.title, 1024)),
        (b"ISFT", concat!("pacinian ", env!("CARGO_PKG_VERSION")).to_owned()),
        (b"ICMT", names.join("\n")),
    ];
    for (id, text) in texts {
        if text.is_empty() {
            continue;
        }
        body.extend_from_slice(id);
        body.extend_from_slice(&(text.len() as u32 + 1).to_le_bytes());
        body.extend_from_slice(text.as_bytes());
        body.push(0);
        if body.len() % 2 == 1 {
            body.push(0);
        }
    }
    let mut out = b"LIST".to_vec();
    out.extend_from_slice(&(body.len() as u32).to_le_bytes());
    out.extend_from_slice(&body);
    out
}

/// On one line, without the zero that ends a text, and of so many bytes at most: the header is written again every two seconds.
fn plain(text: &str, most: usize) -> String {
    let mut length = 0;
    let within = text.chars().take_while(|c| {
        length += c.len_utf8();
        length <= most
    });
    within.map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::{RIFF_LIMIT, check, header};
    use crate::io::wav::{Encoding, WavSpec};

    #[test]
    fn the_length_never_changes_and_is_even() {
        for (title, tactors) in [("", vec![]), ("walk", vec!["top".to_owned(), "left\nwrist".to_owned()])] {
            for encoding in [Encoding::F32, Encoding::I24, Encoding::I16] {
                let spec = WavSpec {
                    title: title.into(),
                    tactors: tactors.clone(),
                    ..WavSpec::new(3, 8000, encoding)
                };
                let (empty, small) = header(&spec, 0, RIFF_LIMIT);
                let (huge, large) = header(&spec, 1 << 40, RIFF_LIMIT);
                assert_eq!((empty.len(), small, large), (huge.len(), false, true));
                assert_eq!(empty.len() % 2, 0);
                let text = String::from_utf8_lossy(&empty).into_owned();
                assert_eq!(text.contains("1: top\n2: left wrist\0"), !title.is_empty());
            }
        }
    }

    #[test]
    fn long_names_are_cut_between_characters() {
        let spec = WavSpec {
            title: "µ".repeat(1_000_000),
            tactors: vec!["a".to_owned() + &"é".repeat(500); 2],
            ..WavSpec::new(2, 8000, Encoding::F32)
        };
        let (header, _) = header(&spec, 0, RIFF_LIMIT);
        assert!(header.len() < 1024 + 2 * 128 + 250, "{}", header.len());
        let text = String::from_utf8_lossy(&header).into_owned();
        assert!(text.contains(&("µ".repeat(512) + "\0")) && !text.contains(&"µ".repeat(513)));
        assert!(text.contains(&format!("1: a{}\n2: a", "é".repeat(63))));
    }

    #[test]
    fn the_last_file_that_fits_is_riff_and_the_next_is_not() {
        let spec = WavSpec::new(1, 8000, Encoding::I16);
        let overhead = header(&spec, 0, RIFF_LIMIT).0.len() as u64 - 8;
        let most = (RIFF_LIMIT - overhead) / 2;
        let (last, large) = header(&spec, most, RIFF_LIMIT);
        assert_eq!((&last[..4], large), (b"RIFF".as_slice(), false));
        assert_eq!(u64::from(u32::from_le_bytes([last[4], last[5], last[6], last[7]])), overhead + 2 * most);
        assert_eq!(header(&spec, most + 1, RIFF_LIMIT).0[..4], *b"RF64");
    }

    #[test]
    fn what_no_file_holds_is_refused() {
        for (channels, rate) in [(0, 8000), (1, 0), (16_384, 8000), (5_594, 192_000), (usize::MAX, 1)] {
            let error = check(&WavSpec::new(channels, rate, Encoding::F32)).unwrap_err();
            assert!(error.message.contains(": "), "{error}");
        }
        for (channels, rate) in [(1, 1), (4_096, 192_000), (16_383, 48_000)] {
            assert_eq!(check(&WavSpec::new(channels, rate, Encoding::F32)), Ok(()));
        }
    }
}
