//! The reader: checks the header against the file, then has `hound` decode.

use super::chunks::{Map, Stored, Trouble, map};
use crate::io::error::{FileError, FileErrorKind};
use crate::io::open::open;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Frames of all channels together that are decoded at a time.
const PIECE: usize = 1 << 16;
/// The most frames that are taken into memory.
const MOST_FRAMES: u64 = 1 << 28;

/// What a WAV file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WavInfo {
    /// At least one.
    pub channels: usize,
    /// Frames a second, at least one.
    pub rate: u32,
    /// At least one, and no more than the file has room for.
    pub frames: u64,
    /// Of a sample.
    pub bits: usize,
    /// Whether samples are floats.
    pub float: bool,
}

/// A WAV file to read: RIFF, RF64 or BW64; integers of 8 to 32 bits and floats of 32; one channel or more.
///
/// Samples come out with full scale ±1. Floats beyond that stay as they are.
#[derive(Debug)]
pub struct WavReader<R> {
    source: R,
    path: PathBuf,
    map: Map,
}

impl WavReader<BufReader<File>> {
    /// Opens a file and checks its header.
    ///
    /// # Errors
    /// When the file is missing, a folder or not allowed, and when its header is damaged, contradicts the file or names a
    /// format that cannot be read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        Self::new(BufReader::new(open(path)?), path)
    }
}

impl<R: Read + Seek> WavReader<R> {
    /// Reads from any source; errors call it `path`.
    ///
    /// # Errors
    /// As [`WavReader::open`].
    pub fn new(mut source: R, path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref().to_owned();
        let map = map(&mut source).map_err(|trouble| trouble.at(&path))?;
        Ok(Self { source, path, map })
    }

    /// What the file holds.
    pub fn info(&self) -> WavInfo {
        let Map { channels, rate, stored, frames, .. } = self.map;
        WavInfo { channels, rate, frames, bits: 8 * stored.bytes(), float: stored == Stored::Float }
    }

    /// The samples of one channel, counted from 1.
    ///
    /// # Errors
    /// When there is no such channel, when the file cannot be read or holds a sample that is no finite number, and when it
    /// has more than 2²⁸ frames (an hour and a half at 48 kHz) or more than there is memory for.
    pub fn channel(&mut self, channel: usize) -> Result<Vec<f32>, FileError> {
        self.check_channel(channel)?;
        let mut out = self.room()?;
        self.read(channel, u64::MAX, |x| {
            out.push(x);
            Ok(())
        })?;
        Ok(out)
    }

    /// Shows `take` the samples of one channel, counted from 1, of the first `frames` frames at most.
    ///
    /// # Errors
    /// As [`channel`](Self::channel), but for the number of frames; and what `take` says is wrong.
    pub fn read(
        &mut self,
        channel: usize,
        frames: u64,
        mut take: impl FnMut(f32) -> Result<(), String>,
    ) -> Result<(), FileError> {
        self.check_channel(channel)?;
        self.decode(frames, |frame, samples| {
            let x = samples[channel - 1];
            finite(x, frame, channel)?;
            take(x).map_err(Trouble::File)
        })
    }

    fn check_channel(&self, channel: usize) -> Result<(), FileError> {
        let channels = self.map.channels;
        if (1..=channels).contains(&channel) {
            return Ok(());
        }
        let have = if channels == 1 { "1 channel".into() } else { format!("{channels} channels") };
        Err(FileError::new(
            FileErrorKind::Malformed,
            format!(
                "`{}` has {have}, so there is no channel {channel}: choose one from 1 to {channels}",
                self.path.display()
            ),
        ))
    }

    /// The samples of all channels.
    ///
    /// # Errors
    /// As [`channel`](Self::channel).
    pub fn channels(&mut self) -> Result<Vec<Vec<f32>>, FileError> {
        let mut out = (0..self.map.channels).map(|_| self.room()).collect::<Result<Vec<_>, _>>()?;
        self.decode(u64::MAX, |frame, samples| {
            for (c, (out, &x)) in out.iter_mut().zip(samples).enumerate() {
                out.push(x);
                finite(x, frame, c + 1)?;
            }
            Ok(())
        })?;
        Ok(out)
    }

    /// For a channel.
    fn room(&self) -> Result<Vec<f32>, FileError> {
        if self.map.frames > MOST_FRAMES {
            let what = format!(
                "it has {} frames, and more than {MOST_FRAMES} are not taken into memory: cut it into shorter files",
                self.map.frames
            );
            return Err(Trouble::File(what).at(&self.path));
        }
        let mut room = Vec::new();
        room.try_reserve_exact(self.map.frames as usize).map_err(|_| {
            let what =
                format!("there is no memory for its {} frames: cut it into shorter files", self.map.frames);
            Trouble::File(what).at(&self.path)
        })?;
        Ok(room)
    }

    /// Shows `take` every frame, the samples of all channels side by side.
    ///
    /// # Errors
    /// When the file cannot be read, and what `take` says is wrong.
    pub fn each_frame(
        &mut self,
        mut take: impl FnMut(&[f32]) -> Result<(), String>,
    ) -> Result<(), FileError> {
        self.decode(u64::MAX, |_, samples| take(samples).map_err(Trouble::File))
    }

    /// Puts the samples of `frames` frames from `first` on into `to`, all channels side by side; fewer where the file ends.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn part(&mut self, first: u64, frames: usize, to: &mut Vec<f32>) -> Result<(), FileError> {
        to.clear();
        let end = first.saturating_add(frames as u64);
        let take = |_, samples: &[f32]| {
            to.extend_from_slice(samples);
            Ok(())
        };
        self.pieces(first, end, take).map_err(|trouble| trouble.at(&self.path))
    }

    /// Shows `take` every frame of the first so many.
    fn decode(
        &mut self,
        frames: u64,
        take: impl FnMut(u64, &[f32]) -> Result<(), Trouble>,
    ) -> Result<(), FileError> {
        self.pieces(0, frames, take).map_err(|trouble| trouble.at(&self.path))
    }

    /// `hound` gets each piece as a little file of its own with a header that is known to be right. So none of its limits on
    /// headers and lengths is met, and a piece is all that it can make of what it is given.
    fn pieces(
        &mut self,
        first: u64,
        end: u64,
        mut take: impl FnMut(u64, &[f32]) -> Result<(), Trouble>,
    ) -> Result<(), Trouble> {
        let Map { channels, stored, start, frames, .. } = self.map;
        let frames = frames.min(end);
        let block = channels * stored.bytes();
        let step = (PIECE / channels).max(1) as u64;
        let mut done = first.min(frames);
        self.source.seek(SeekFrom::Start(start + done * block as u64))?;
        let (mut piece, mut frame_of_samples) = (Vec::new(), Vec::with_capacity(channels));
        while done < frames {
            let size = (frames - done).min(step) as usize * block;
            plain_header(&mut piece, channels, stored, size);
            let head = piece.len();
            piece.resize(head + size, 0);
            self.source.read_exact(&mut piece[head..])?;
            let reader = hound::WavReader::new(piece.as_slice()).map_err(undecoded)?;
            let mut each = |x: f32| {
                frame_of_samples.push(x);
                if frame_of_samples.len() == channels {
                    take(done, &frame_of_samples)?;
                    frame_of_samples.clear();
                    done += 1;
                }
                Ok::<(), Trouble>(())
            };
            match stored {
                Stored::Float => {
                    reader.into_samples::<f32>().try_for_each(|x| each(x.map_err(undecoded)?))?
                }
                Stored::Integer(bytes) => {
                    let scale = 1.0 / f64::from(1_u32 << (8 * bytes - 1));
                    reader
                        .into_samples::<i32>()
                        .try_for_each(|x| each((f64::from(x.map_err(undecoded)?) * scale) as f32))?;
                }
            }
        }
        Ok(())
    }
}

fn undecoded(error: hound::Error) -> Trouble {
    Trouble::File(format!(
        "its samples do not decode ({error}): convert it, such as with `sox in.wav -b 24 out.wav`"
    ))
}

fn finite(x: f32, frame: u64, channel: usize) -> Result<(), Trouble> {
    if x.is_finite() {
        return Ok(());
    }
    let what = format!(
        "sample {frame} of channel {channel} is {x}, which is no number to play: write it again without"
    );
    Err(Trouble::File(what))
}

/// The shortest header that says how samples are stored. A rate of 1 Hz keeps its bytes a second within their field.
fn plain_header(out: &mut Vec<u8>, channels: usize, stored: Stored, size: usize) {
    let block = (channels * stored.bytes()) as u16;
    let tag: u16 = if stored == Stored::Float { 3 } else { 1 };
    out.clear();
    out.extend_from_slice(b"RIFF");
    out.extend_from_slice(&(36 + size as u32).to_le_bytes());
    out.extend_from_slice(b"WAVEfmt \x10\0\0\0");
    out.extend_from_slice(&tag.to_le_bytes());
    out.extend_from_slice(&(channels as u16).to_le_bytes());
    out.extend_from_slice(&1_u32.to_le_bytes());
    out.extend_from_slice(&u32::from(block).to_le_bytes());
    out.extend_from_slice(&block.to_le_bytes());
    out.extend_from_slice(&(8 * stored.bytes() as u16).to_le_bytes());
    out.extend_from_slice(b"data");
    out.extend_from_slice(&(size as u32).to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::WavReader;
    use crate::io::error::FileError;
    use crate::io::wav::{Encoding, WavSpec, WavWriter};
    use proptest::prelude::{Just, any, prop, prop_oneof, proptest};
    use std::io::Cursor;

    fn written(channels: usize, encoding: Encoding, frames: usize) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut file, WavSpec::new(channels, 8000, encoding)).unwrap();
        writer.write(&(0..channels * frames).map(|i| (i as f32 * 0.1).sin()).collect::<Vec<_>>()).unwrap();
        writer.finish().unwrap();
        file.into_inner()
    }

    /// A header by hand: the tail of the `fmt ` chunk after its 16 bytes, then the samples.
    fn by_hand(
        tag: u16,
        channels: u16,
        rate: u32,
        block: u16,
        bits: u16,
        tail: &[u8],
        samples: &[u8],
    ) -> Vec<u8> {
        let mut out = b"RIFF\0\0\0\0WAVEfmt ".to_vec();
        out.extend_from_slice(&(16 + tail.len() as u32).to_le_bytes());
        for field in [tag, channels] {
            out.extend_from_slice(&field.to_le_bytes());
        }
        out.extend_from_slice(&rate.to_le_bytes());
        out.extend_from_slice(&[0xAB; 4]);
        for field in [block, bits] {
            out.extend_from_slice(&field.to_le_bytes());
        }
        out.extend_from_slice(tail);
        out.extend_from_slice(b"data");
        out.extend_from_slice(&(samples.len() as u32).to_le_bytes());
        out.extend_from_slice(samples);
        out
    }

    fn read(file: &[u8]) -> Result<Vec<Vec<f32>>, FileError> {
        WavReader::new(Cursor::new(file), "x.wav")?.channels()
    }

    #[test]
    fn a_part_is_that_of_the_whole() {
        for (channels, frames) in [(1, 100_000), (3, 50_000)] {
            let bytes = written(channels, Encoding::F32, frames);
            let mut reader = WavReader::new(Cursor::new(bytes), "w").unwrap();
            let mut whole = Vec::new();
            let keep = |frame: &[f32]| {
                whole.extend_from_slice(frame);
                Ok(())
            };
            reader.each_frame(keep).unwrap();
            let mut part = vec![9.0];
            for (first, count) in
                [(0, 1), (7, 4096), (0, 99_999), (frames as u64 - 3, 10), (1 << 60, 5), (3, 0)]
            {
                reader.part(first, count, &mut part).unwrap();
                let from = (first as usize).min(frames);
                let to = (from + count).min(frames);
                assert_eq!(part, whole[from * channels..to * channels], "{first} {count}");
            }
        }
    }

    #[test]
    fn integers_of_every_width_have_the_same_full_scale() {
        let half: [(u16, &[u8]); 4] = [
            (8, &[0xC0, 0x40]),
            (16, &[0, 0x40, 0, 0xC0]),
            (24, &[0, 0, 0x40, 0, 0, 0xC0]),
            (32, &[0, 0, 0, 0x40, 0, 0, 0, 0xC0]),
        ];
        for (bits, samples) in half {
            let file = by_hand(1, 2, 11_025, bits / 4, bits, &[], samples);
            assert_eq!(read(&file).unwrap(), [[0.5], [-0.5]], "{bits} bits");
        }
        // 20 valid bits in 3 bytes stand at the top of them.
        let file = by_hand(1, 1, 11_025, 3, 20, &[], &[0, 0, 0x40]);
        assert_eq!(read(&file).unwrap(), [[0.5]]);
    }

    #[test]
    fn odd_chunks_unusual_lengths_and_trailing_rubbish_are_passed_over() {
        let mut file = by_hand(3, 1, 8000, 4, 32, &[2, 0, 9, 9], &2.5_f32.to_le_bytes());
        file.splice(12..12, *b"note\x03\0\0\0abc\0");
        file.extend_from_slice(b"junk");
        assert_eq!(read(&file).unwrap(), [[2.5]], "floats beyond full scale stay");
    }

    #[test]
    fn extensible_forms_are_what_their_identifier_says() {
        let read_as = |valid: u16, bits: u16, tag: u16, last: u8| {
            let mut tail = vec![22, 0];
            tail.extend([valid.to_le_bytes(), [0; 2], [0; 2], tag.to_le_bytes()].concat());
            tail.extend([0, 0, 0, 0, 0x10, 0, 0x80, 0, 0, 0xAA, 0, 0x38, 0x9B, last]);
            read(&by_hand(0xFFFE, 1, 8000, bits / 8, bits, &tail, &[0, 0, 0, 0x40][4 - bits as usize / 8..]))
        };
        for valid in [0, 20, 24] {
            assert_eq!(read_as(valid, 24, 1, 0x71).unwrap(), [[0.5]], "{valid}");
        }
        assert_eq!(read_as(32, 32, 3, 0x71).unwrap(), [[2.0]]);
        for (valid, tag, last, words) in [
            (25, 1, 0x71, "25 bits of each sample of 24 bits"),
            (24, 1, 0x72, "unknown identifier"),
            (24, 7, 0x71, "compressed"),
        ] {
            let error = read_as(valid, 24, tag, last).unwrap_err();
            assert!(error.message.contains(words), "{words}: {error}");
        }
    }

    #[test]
    fn damage_is_described() {
        let good = by_hand(1, 1, 8000, 2, 16, &[], &[1, 2, 3, 4]);
        let with = |at: usize, bytes: &[u8]| {
            let mut file = good.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            file
        };
        let nan = by_hand(3, 2, 8000, 8, 32, &[], &[[0; 4], f32::NAN.to_le_bytes()].concat());
        let cases: Vec<(Vec<u8>, &str)> = vec![
            (vec![], "0 bytes"),
            (b"RIFF".to_vec(), "4 bytes"),
            (with(0, b"OggS"), "no WAV file"),
            (with(0, b"RIFX"), "big-endian"),
            (with(8, b"AVI "), "no WAV file"),
            (with(16, &[2, 0]), "instead of 16 or more"),
            (with(16, &[255, 255]), "claims 65535 bytes"),
            (with(20, &[2, 0]), "compressed"),
            (with(20, &[0xFE, 0xFF]), "instead of 40"),
            (with(22, &[0, 0]), "0 channels"),
            (with(24, &[0, 0]), "0 Hz"),
            (with(32, &[255, 255]), "a frame has 65535 bytes"),
            (with(32, &[0, 0]), "a frame has 0 bytes"),
            (with(34, &[0, 0]), "integers of 0 bits"),
            (with(34, &[7, 0]), "integers of 7 bits"),
            (with(34, &[64, 0]), "integers of 64 bits"),
            (with(20, &[3, 0]), "floats of 16 bits"),
            (with(40, &[6, 0]), "promises 6 bytes of samples where the file has 4"),
            (with(40, &[255, 255, 255, 255]), "never filled in its length"),
            (with(40, &[3, 0]), "no whole number of frames"),
            (with(40, &[0, 0]), "no samples at all"),
            (with(36, b"DATA"), "no `data` chunk"),
            (with(12, b"tmf "), "no `fmt ` chunk"),
            (good[..good.len() - 1].to_vec(), "copy it again"),
            (good[..30].to_vec(), "copy it again"),
            (nan, "sample 0 of channel 2 is NaN"),
        ];
        for (file, words) in cases {
            let error = read(&file).expect_err(words);
            assert!(error.message.contains(words), "{words}: {error}");
            assert!(error.message.starts_with("`x.wav` cannot be read: "), "{error}");
            assert_eq!(error.exit_code(), 65, "{error}");
        }
        assert!(read(&good).is_ok());
    }

    /// A header that was not written again when the recording went on.
    #[test]
    fn samples_that_the_header_does_not_know_of_are_not_passed_over() {
        let samples: Vec<u8> = (0..80_000u32).map(|n| (n * 7) as u8 | 0x80).collect();
        let good = by_hand(1, 1, 8000, 2, 16, &[], &samples);
        let with = |riff: u32, data: u32| {
            let mut file = good.clone();
            file[4..8].copy_from_slice(&riff.to_le_bytes());
            file[40..44].copy_from_slice(&data.to_le_bytes());
            read(&file)
        };
        let whole = good.len() as u32 - 8;
        for (riff, data) in [(whole, 1000), (whole, 79_000), (1036, 1000), (0, 1000), (36, 0), (0, 0)] {
            let error = with(riff, data).expect_err("more than four seconds are not heard");
            assert!(error.message.contains("more was recorded than its header knows of"), "{error}");
        }
        // The tag of a player, what a killed program leaves, and a chunk that is one.
        assert!(with(whole, 80_000).is_ok() && with(32_036, 32_000).is_ok());
        let mut file = by_hand(1, 1, 8000, 2, 16, &[], &samples[..1000]);
        file.extend_from_slice(b"bext");
        file.extend_from_slice(&79_000_u32.to_le_bytes());
        file.extend_from_slice(&samples[1000..]);
        let size = file.len() as u32 - 8;
        file[4..8].copy_from_slice(&size.to_le_bytes());
        assert_eq!(read(&file).unwrap()[0].len(), 500);
    }

    #[test]
    fn a_file_of_endless_small_chunks_is_given_up() {
        let mut file = b"RIFF\0\0\0\0WAVE".to_vec();
        file.extend(b"none\0\0\0\0".repeat(100_000));
        assert!(read(&file).unwrap_err().message.contains("4096 chunks"));
    }

    proptest! {
        #[test]
        fn a_mutated_file_never_panics_and_never_grows(
            channels in 1_usize..5,
            encoding in prop_oneof![Just(Encoding::F32), Just(Encoding::I24), Just(Encoding::I16)],
            // Most of the hits within the header, where they hurt.
            hits in prop::collection::vec((prop_oneof![9 => 0_usize..160, 1 => 0_usize..4000], prop_oneof![any::<u8>(), Just(0), Just(255)]), 0..12),
            cut in prop_oneof![3 => Just(usize::MAX), 1 => 0_usize..400],
        ) {
            let mut file = written(channels, encoding, 37);
            for (at, byte) in hits {
                if let Some(slot) = file.get_mut(at) {
                    *slot = byte;
                }
            }
            file.truncate(cut);
            if let Ok(mut reader) = WavReader::new(Cursor::new(&file), "x.wav") {
                let info = reader.info();
                assert!(info.frames as u128 * (info.channels * info.bits / 8) as u128 <= file.len() as u128);
                if let Ok(all) = reader.channels() {
                    assert_eq!(all.len(), info.channels);
                    assert!(all.iter().all(|c| c.len() as u64 == info.frames && c.capacity() <= file.len()));
                    assert!(all.iter().flatten().all(|x| x.is_finite()));
                    assert_eq!(reader.channel(info.channels).unwrap(), all[info.channels - 1]);
                }
            }
        }

        #[test]
        fn rubbish_never_panics(file in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = read(&file);
            let _ = read(&[b"RIFF\0\0\0\0WAVE".as_slice(), &file].concat());
            let _ = read(&[b"RF64\0\0\0\0WAVEds64\x1c\0\0\0".as_slice(), &file].concat());
        }
    }
}
