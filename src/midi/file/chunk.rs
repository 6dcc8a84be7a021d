//! The chunks of a file: four letters, a length, and so many bytes.

use crate::text::Problem;

use super::Warnings;
use super::map::Division;

/// Where the chunks stand, and how far they have been read.
#[derive(Debug)]
pub(super) struct Chunks<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// The bytes of a chunk, and where in the file they begin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk<'a> {
    pub at: usize,
    pub bytes: &'a [u8],
    /// Whether the file ends before it does.
    pub cut: bool,
}

/// What the first chunk says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Header {
    pub format: u8,
    pub tracks: u16,
    pub division: Division,
}

/// A chunk as it stands in the file, with the length that it claims.
struct Raw<'a> {
    name: &'a [u8],
    claimed: usize,
    chunk: Chunk<'a>,
}

fn no_midi_file(what: &str) -> Problem {
    Problem::error(&(0..0), format!("byte 0: {what}"))
        .help("give a Standard MIDI File, whose first letters are MThd".to_string())
}

impl<'a> Chunks<'a> {
    /// Of a file, also in a RIFF wrapper.
    pub fn open(bytes: &'a [u8]) -> Result<Self, Problem> {
        if !bytes.starts_with(b"RIFF") {
            return Ok(Self { bytes, at: 0 });
        }
        if bytes.get(8..12) != Some(b"RMID") {
            return Err(no_midi_file("a RIFF file with something other than MIDI in it"));
        }
        // Little-endian chunks, each padded to an even length.
        let mut at = 12;
        while let Some(length) = bytes.get(at + 4..at + 8).and_then(|b| b.try_into().ok()) {
            let length = u32::from_le_bytes(length) as usize;
            let end = (at + 8).saturating_add(length);
            if bytes.get(at..at + 4) == Some(b"data") {
                return Ok(Self { bytes: bytes.get(..end.min(bytes.len())).unwrap_or(bytes), at: at + 8 });
            }
            at = end.saturating_add(length % 2).min(bytes.len());
        }
        Err(no_midi_file("a RIFF file without a chunk `data`"))
    }

    fn next_chunk(&mut self) -> Option<Raw<'a>> {
        let head = self.bytes.get(self.at..self.at.checked_add(8)?)?;
        let (name, length) = head.split_at(4);
        let claimed = u32::from_be_bytes(length.try_into().ok()?) as usize;
        let at = self.at + 8;
        self.at = at.saturating_add(claimed).min(self.bytes.len());
        let bytes = self.bytes.get(at..self.at)?;
        Some(Raw { name, claimed, chunk: Chunk { at, bytes, cut: bytes.len() < claimed } })
    }

    /// The first chunk. It may be longer than its six bytes; the rest is for later versions of the format.
    pub fn header(&mut self, warnings: &mut Warnings) -> Result<Header, Problem> {
        let at = self.at;
        let raw = self.next_chunk().filter(|raw| raw.name == b"MThd");
        let raw = raw.ok_or_else(|| no_midi_file("this is no Standard MIDI File"))?;
        let Some([f0, f1, t0, t1, d0, d1]) = raw.chunk.bytes.first_chunk::<6>().copied() else {
            let what = format!("byte {}: the header has {} bytes instead of 6", at, raw.chunk.bytes.len());
            return Err(
                Problem::error(&(at..at), what).help("the file was cut short; get it anew".to_string())
            );
        };
        if raw.chunk.cut {
            cut_short(&raw, warnings);
        }
        let format = u16::from_be_bytes([f0, f1]);
        let (0..=2, Ok(format)) = (format, u8::try_from(format)) else {
            let what = format!("byte {}: the file has format {format}, and there are 0, 1 and 2", at + 8);
            let help = "export it as format 0 or 1".to_string();
            return Err(Problem::error(&(at + 8..at + 10), what).help(help));
        };
        let division = Division::new([d0, d1])
            .map_err(|what| {
                let what = format!("byte {}: {what}", at + 12);
                Problem::error(&(at + 12..at + 14), what)
            })
            .map_err(|problem| {
                problem.help("export it with ticks per quarter note, such as 480".to_string())
            })?;
        Ok(Header { format, tracks: u16::from_be_bytes([t0, t1]), division })
    }

    /// The next track; chunks of other kinds are skipped, as the specification asks.
    pub fn next_track(&mut self, warnings: &mut Warnings) -> Option<Chunk<'a>> {
        loop {
            let at = self.at;
            let Some(raw) = self.next_chunk() else {
                let left = self.bytes.len() - at.min(self.bytes.len());
                if left > 0 {
                    let what = format!("byte {at}: {left} bytes at the end are no whole chunk");
                    warnings.push(at, what, "the file may have been cut short: get it anew");
                    self.at = self.bytes.len();
                }
                return None;
            };
            if raw.chunk.cut {
                cut_short(&raw, warnings);
            }
            if raw.name == b"MTrk" {
                return Some(raw.chunk);
            }
        }
    }
}

fn cut_short(raw: &Raw<'_>, warnings: &mut Warnings) {
    let (at, there) = (raw.chunk.at - 8, raw.chunk.bytes.len());
    let name: String = raw.name.iter().map(|b| char::from(*b)).collect();
    let what =
        format!("byte {at}: the chunk `{name}` claims {} bytes, and the file has {there} more", raw.claimed);
    warnings.push(at, what, "the file was cut short: get it anew; what is there is used");
}
