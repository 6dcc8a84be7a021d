//! Finds the two chunks that matter in a RIFF or RF64 file, believing nothing that the file cannot back.

use super::header::GUID_TAIL;
use crate::io::error::{FileError, FileErrorKind};
use std::io::{self, Read, Seek, SeekFrom};

/// Chunks before the samples that are looked at before the file is given up.
const MOST_CHUNKS: usize = 4096;
/// What is in a field of 32 bits when the true number stands in `ds64`, or was never written.
const ELSEWHERE: u32 = u32::MAX;
/// Seconds of samples of which a header may not know: as much as a program that is killed leaves behind if it brings its header up to
/// date every few seconds, as ours does.
const UNKNOWN: u64 = 4;

/// How the samples are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    /// Unsigned of 8 bits, else signed, of so many bytes.
    Integer(usize),
    /// IEEE float of 32 bits.
    Float,
}

impl Stored {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Integer(bytes) => bytes,
            Self::Float => 4,
        }
    }
}

/// Where the samples are and what they mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Map {
    pub channels: usize,
    pub rate: u32,
    pub stored: Stored,
    pub start: u64,
    pub frames: u64,
}

/// Either the system failed or the file is not what it says.
pub(super) enum Trouble {
    System(io::Error),
    File(String),
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::System(error)
    }
}

impl Trouble {
    pub(super) fn at(self, path: &std::path::Path) -> FileError {
        match self {
            Self::System(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                Self::File("it ends in the middle of a chunk: copy it again from where it came from".into())
                    .at(path)
            }
            Self::System(error) => FileError::reading(path, &error),
            Self::File(what) => FileError::new(
                FileErrorKind::Malformed,
                format!("`{}` cannot be read: {what}", path.display()),
            ),
        }
    }
}

fn file<T>(what: impl Into<String>) -> Result<T, Trouble> {
    Err(Trouble::File(what.into()))
}

/// Walks the chunks until format and samples are known.
pub(super) fn map<R: Read + Seek>(source: &mut R) -> Result<Map, Trouble> {
    let length = source.seek(SeekFrom::End(0))?;
    source.seek(SeekFrom::Start(0))?;
    if length < 12 {
        return file(format!(
            "it holds {length} bytes, too few for a WAV file: see whether it is the file you mean"
        ));
    }
    let form: [u8; 12] = bytes(source)?;
    match (&form[..4], &form[8..]) {
        (b"RIFF" | b"RF64" | b"BW64", b"WAVE") => {}
        (b"RIFX", _) => {
            return file("it is a big-endian WAV (RIFX): convert it, such as with `sox in.wav out.wav`");
        }
        _ => {
            return file("it is no WAV file (it does not begin with RIFF ... WAVE): convert it to WAV first");
        }
    }

    let (mut format, mut data, mut large) = (None::<Format>, None, None);
    let mut at = 12_u64;
    for _ in 0..MOST_CHUNKS {
        if let (Some(format), Some((start, size))) = (format, data) {
            let riff = u64::from(u32::from_le_bytes([form[4], form[5], form[6], form[7]])) + 8;
            // A RF64 file says elsewhere how long it is.
            let ends = large.map_or(riff, |(riff, _): (u64, u64)| riff.saturating_add(8)).min(length);
            let second = u64::from(format.rate).saturating_mul(format.block());
            // Where there seem to be none at all, a program may have been killed before it counted the first.
            let some = if size == 0 { second / 10 } else { second.saturating_mul(UNKNOWN) };
            behind(source, at, ends, length, some)?;
            return whole(format, start, size);
        }
        if at + 8 > length {
            return match (format, data) {
                (None, _) => {
                    file("it has no `fmt ` chunk, so its rate and channels are unknown: write it again")
                }
                _ => file(
                    "it has no `data` chunk, so no samples: write it again, or copy it again if it was cut short",
                ),
            };
        }
        source.seek(SeekFrom::Start(at))?;
        let head: [u8; 8] = bytes(source)?;
        let id = [head[0], head[1], head[2], head[3]];
        let word = u32::from_le_bytes([head[4], head[5], head[6], head[7]]);
        let (start, mut size) = (at + 8, u64::from(word));
        if &id == b"data" {
            if word == ELSEWHERE {
                match large {
                    Some((_, bytes)) => size = bytes,
                    None => {
                        return file(
                            "the program that wrote it never filled in its length (a streamed WAV): convert it, such as with `sox --ignore-length in.wav out.wav`",
                        );
                    }
                }
            }
            if size > length - start {
                return file(format!(
                    "its header promises {size} bytes of samples where the file has {}: copy it again, or mend it with `sox --ignore-length in.wav out.wav`",
                    length - start
                ));
            }
            data = data.or(Some((start, size)));
        } else if size > length - start {
            return file(format!(
                "its chunk `{}` at byte {at} claims {size} bytes where the file has {}: copy it again or write it again",
                id.escape_ascii(),
                length - start
            ));
        } else if &id == b"fmt " && format.is_none() {
            format = Some(read_format(source, size)?);
        } else if &id == b"ds64" && size >= 16 {
            large = Some((u64::from_le_bytes(bytes(source)?), u64::from_le_bytes(bytes(source)?)));
        }
        // Chunks begin at even places.
        at = start + size + size % 2;
    }
    file(format!("none of its first {MOST_CHUNKS} chunks holds samples: write it again"))
}

/// That what stands behind the samples, from byte `at` on, is none: up to where the file says that it `ends` there are chunks, and behind
/// that less than `some` bytes, such as a tag that some player has put there.
fn behind<R: Read + Seek>(
    source: &mut R,
    mut at: u64,
    ends: u64,
    length: u64,
    some: u64,
) -> Result<(), Trouble> {
    let samples = at;
    let more = |from: u64| {
        file(format!(
            "{} bytes follow the samples that its header promises, and are no chunk: more was recorded than its header knows of; mend it with `sox --ignore-length in.wav out.wav`",
            length - from
        ))
    };
    for _ in 0..MOST_CHUNKS {
        if at + 8 > ends {
            break;
        }
        source.seek(SeekFrom::Start(at))?;
        let head: [u8; 8] = bytes(source)?;
        let size = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        if !head[..4].iter().all(|c| (b' '..=b'~').contains(c)) || size > ends - at - 8 {
            return more(samples);
        }
        at += 8 + size + size % 2;
    }
    if length.saturating_sub(at.max(ends)) >= some.max(1) { more(ends.max(samples)) } else { Ok(()) }
}

/// That the samples are frames, and at least one.
fn whole(format: Format, start: u64, size: u64) -> Result<Map, Trouble> {
    let block = format.block();
    if size == 0 {
        return file("it holds no samples at all: record it again");
    }
    if !size.is_multiple_of(block) {
        return file(format!(
            "its {size} bytes of samples are no whole number of frames of {block} bytes: copy it again or write it again"
        ));
    }
    Ok(Map {
        channels: format.channels,
        rate: format.rate,
        stored: format.stored,
        start,
        frames: size / block,
    })
}

#[derive(Debug, Clone, Copy)]
struct Format {
    channels: usize,
    rate: u32,
    stored: Stored,
}

impl Format {
    /// Bytes of a frame.
    fn block(self) -> u64 {
        (self.channels * self.stored.bytes()) as u64
    }
}

fn read_format<R: Read>(source: &mut R, size: u64) -> Result<Format, Trouble> {
    if size < 16 {
        return file(format!("its `fmt ` chunk has {size} bytes instead of 16 or more: write it again"));
    }
    let f: [u8; 16] = bytes(source)?;
    let short = |at: usize| u16::from_le_bytes([f[at], f[at + 1]]);
    let (mut tag, channels, block, bits) = (short(0), short(2), short(12), short(14));
    let rate = u32::from_le_bytes([f[4], f[5], f[6], f[7]]);
    if tag == 0xFFFE {
        if size < 40 {
            return file(format!(
                "its extensible `fmt ` chunk has {size} bytes instead of 40: write it again"
            ));
        }
        let rest: [u8; 24] = bytes(source)?;
        tag = u16::from_le_bytes([rest[8], rest[9]]);
        if rest[10..] != GUID_TAIL {
            return file(
                "its samples are in a format of somebody's own (an unknown identifier in its header): convert it, such as with `sox in.wav -b 24 -e signed out.wav`",
            );
        }
        // 0 says nothing, and some programs write it.
        let valid = u16::from_le_bytes([rest[2], rest[3]]);
        if valid > bits {
            return file(format!(
                "its header says that {valid} bits of each sample of {bits} bits count: write it again"
            ));
        }
    }
    if channels == 0 {
        return file("its header says that it has 0 channels: write it again");
    }
    if rate == 0 {
        return file("its header says that it has a rate of 0 Hz: write it again");
    }
    let stored = match (tag, bits) {
        (1, 8..=32) => Stored::Integer(usize::from(bits.div_ceil(8))),
        (3, 32) => Stored::Float,
        (1 | 3, _) => {
            let kind = if tag == 1 { "integers" } else { "floats" };
            return file(format!(
                "its samples are {kind} of {bits} bits, where integers of 8 to 32 and floats of 32 can be read: convert it, such as with `sox in.wav -b 24 out.wav`"
            ));
        }
        _ => {
            return file(format!(
                "its samples are compressed (format {tag:#06x}): convert it, such as with `sox in.wav -b 24 -e signed out.wav`"
            ));
        }
    };
    let expected = usize::from(channels) * stored.bytes();
    if usize::from(block) != expected {
        return file(format!(
            "its header says that a frame has {block} bytes, where {channels} channels of {bits} bits make {expected}: write it again"
        ));
    }
    Ok(Format { channels: usize::from(channels), rate, stored })
}

fn bytes<const N: usize>(source: &mut impl Read) -> io::Result<[u8; N]> {
    let mut out = [0; N];
    source.read_exact(&mut out)?;
    Ok(out)
}
