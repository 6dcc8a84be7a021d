//! What a session heard, from its recording, as it is played again.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use super::digest::Digest;
use crate::io::error::{FileError, FileErrorKind};
use crate::io::open::open;
use crate::io::wav::WavReader;

/// A recording of what was heard, read as it is needed.
#[derive(Debug)]
pub(super) struct Recorded {
    /// `None`: its session was cut off before it had written a sample.
    reader: Option<WavReader<BufReader<File>>>,
    path: PathBuf,
    frames: u64,
    channels: usize,
    part: Vec<f32>,
    /// Frames read, and what they were.
    read: u64,
    digest: Digest,
}

impl Recorded {
    /// Opens it for a session of `rate` (Hz) that listened to so many channels.
    ///
    /// # Errors
    /// A file that cannot be read, and one of another rate or with other channels.
    pub(super) fn open(path: PathBuf, rate: f64, channels: usize) -> Result<Self, FileError> {
        let (part, digest) = (Vec::new(), Digest::new());
        let reader = match WavReader::open(&path) {
            Err(_) if has_only_begun(&path) => {
                return Ok(Self { reader: None, path, frames: 0, channels, part, read: 0, digest });
            }
            reader => reader?,
        };
        let info = reader.info();
        if info.channels != channels || f64::from(info.rate) != rate {
            let what = format!(
                "it has {} channels at {} Hz, and the session listened to {channels} at {rate} Hz",
                info.channels, info.rate
            );
            return Err(another(&path, &what));
        }
        let frames = info.frames;
        Ok(Self { reader: Some(reader), path, frames, channels, part, read: 0, digest })
    }

    /// The next frames; silence behind the end. Gives how many of them are that.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn next(&mut self, frames: usize, to: &mut Vec<f32>) -> Result<u64, FileError> {
        self.fetch(frames)?;
        to.clear();
        to.extend_from_slice(&self.part);
        let missing = frames - self.part.len() / self.channels.max(1);
        to.resize(frames * self.channels, 0.0);
        Ok(missing as u64)
    }

    fn fetch(&mut self, frames: usize) -> Result<(), FileError> {
        match &mut self.reader {
            Some(reader) => reader.part(self.read, frames, &mut self.part)?,
            None => self.part.clear(),
        }
        self.read += (self.part.len() / self.channels.max(1)) as u64;
        self.digest.samples(&self.part);
        Ok(())
    }

    /// Whether it is the one that was kept: of so many frames, with that digest.
    ///
    /// # Errors
    /// A recording that is another one, or a part of it.
    pub(super) fn check(mut self, frames: u64, sha256: &str) -> Result<(), FileError> {
        if self.frames != frames {
            let what = format!("it has {} frames, and {frames} were recorded", self.frames);
            return Err(another(&self.path, &what));
        }
        while self.read < self.frames {
            self.fetch(4096)?;
        }
        let now = self.digest.finish();
        if now != sha256 {
            let what = format!("the SHA-256 of its samples is {now}, and {sha256} was recorded");
            return Err(another(&self.path, &what));
        }
        Ok(())
    }
}

/// More bytes than the header of a recording has.
const HEADER: u64 = 4096;

/// Whether a file is the beginning of a recording, of which no sample has been written yet: its header, or a part of that.
fn has_only_begun(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let header = open(path).and_then(|file| {
        let read = file.take(HEADER).read_to_end(&mut bytes);
        read.map_err(|error| FileError::reading(path, &error))
    });
    header.is_ok_and(|length| {
        let data = bytes.windows(4).position(|word| word == b"data");
        (length as u64) < HEADER
            && (bytes.is_empty() || bytes.starts_with(b"RIFF"))
            && data.is_none_or(|data| bytes.len() <= data + 8)
    })
}

fn another(path: &Path, why: &str) -> FileError {
    let what = format!("`{}` is not what the session heard: {why}", path.display());
    FileError::new(FileErrorKind::Malformed, what)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::{Digest, Recorded};
    use crate::io::wav::{Encoding, WavSpec, WavWriter};

    fn file(name: &str, frames: &[f32]) -> PathBuf {
        let path = std::env::temp_dir().join(format!("pacinian-recorded-{name}-{}.wav", std::process::id()));
        let mut wav = WavWriter::create(&path, WavSpec::new(2, 48_000, Encoding::F32)).unwrap();
        wav.write(frames).unwrap();
        wav.finish().unwrap();
        path
    }

    #[test]
    fn it_is_read_piece_by_piece_and_known_again() {
        let frames: Vec<f32> = (0..20_000).map(|n| (n % 977) as f32 / 1000.0).collect();
        let path = file("pieces", &frames);
        let mut digest = Digest::new();
        digest.samples(&frames);
        let sha256 = digest.finish();
        let open = || Recorded::open(path.clone(), 48_000.0, 2).unwrap();
        let (mut recorded, mut all, mut piece) = (open(), Vec::new(), Vec::new());
        let missing: Vec<u64> = [4096, 100, 4096, 4000, 7]
            .map(|n| {
                let missing = recorded.next(n, &mut piece).unwrap();
                assert_eq!(piece.len(), 2 * n);
                all.extend_from_slice(&piece);
                missing
            })
            .into();
        assert_eq!(missing, [0, 0, 0, 2292, 7]);
        assert!(all[..20_000] == frames && all[20_000..].iter().all(|x| *x == 0.0));
        recorded.check(10_000, &sha256).unwrap();
        // What the session did not get to counts as well.
        open().check(10_000, &sha256).unwrap();
        let said = |checked: Result<(), crate::io::error::FileError>| checked.unwrap_err().message;
        assert!(said(open().check(10_001, &sha256)).contains("it has 10000 frames, and 10001 were recorded"));
        assert!(said(open().check(10_000, &"0".repeat(64))).contains("SHA-256"));
        for (rate, channels) in [(44_100.0, 2), (48_000.0, 1)] {
            let said = Recorded::open(path.clone(), rate, channels).unwrap_err().message;
            assert!(said.contains("it has 2 channels at 48000 Hz"), "{said}");
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn one_that_was_cut_off_before_its_first_sample_is_silence() {
        let path = file("begun", &[0.25; 2]);
        let bytes = std::fs::read(&path).unwrap();
        let data = bytes.windows(4).position(|word| word == b"data").unwrap();
        let mut piece = Vec::new();
        for length in [0, 8, data, data + 8] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            let mut recorded = Recorded::open(path.clone(), 48_000.0, 2).unwrap();
            assert_eq!((recorded.next(3, &mut piece).unwrap(), piece.as_slice()), (3, &[0.0; 6][..]));
            let said = recorded.check(1, "").unwrap_err().message;
            assert!(said.contains("it has 0 frames, and 1 were recorded"), "{said}");
        }
        // What has more than a header and no sample is no beginning of one.
        for other in [&b"something else"[..], &[b"RIFF", &[0; 8000][..]].concat()] {
            std::fs::write(&path, other).unwrap();
            assert!(Recorded::open(path.clone(), 48_000.0, 2).is_err());
        }
        std::fs::remove_file(&path).unwrap();
    }

    /// A hole in the file stands for hours.
    #[cfg(target_os = "linux")]
    #[test]
    fn hours_need_no_memory() {
        let path = file("hours", &[0.25; 2]);
        let mut bytes = std::fs::read(&path).unwrap();
        let frames = (1_u32 << 28) + 10;
        let data = bytes.windows(4).position(|word| word == b"data").unwrap() + 4;
        bytes[data..data + 4].copy_from_slice(&(8 * frames).to_le_bytes());
        std::fs::write(&path, &bytes).unwrap();
        let length = bytes.len() as u64 - 8 + 8 * u64::from(frames);
        let riff = (length - 8) as u32;
        bytes[4..8].copy_from_slice(&riff.to_le_bytes());
        std::fs::write(&path, &bytes).unwrap();
        std::fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap();
        let mut recorded = Recorded::open(path.clone(), 48_000.0, 2).unwrap();
        let mut piece = Vec::new();
        assert_eq!(recorded.next(3, &mut piece).unwrap(), 0);
        assert_eq!(piece, [0.25, 0.25, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(u64::from(frames), recorded.frames);
        std::fs::remove_file(&path).unwrap();
    }
}
