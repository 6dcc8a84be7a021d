//! The writer: streams to a file that can be played at any time, also when the program is killed.

use super::WavSpec;
use super::encode::{Tally, encode};
use super::header::{RIFF_LIMIT, check, header};
use crate::io::error::FileError;
use crate::io::out::OutputFile;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes that are collected before the file is given them.
const BUFFER: usize = 256 << 10;
/// Seconds of sound after which the header is brought up to date.
pub const REFRESH: u64 = 2;

/// A WAV file being written, of any number of channels and any length.
///
/// The sink is written from its start. Every two seconds of sound the sizes in the header are brought up to date, so whatever
/// ends the program leaves a file that plays up to there. Past 4 GiB the file becomes RF64 in place.
///
/// Samples beyond full scale (±1) are clamped, unless they are figures ([`WavSpec::unbounded`]), and those that are not finite become 0;
/// both are counted. Integers are dithered, see [`WavSpec::seed`]; an integer file's topmost step stands for +1.0, which is not counted as
/// clipped.
///
/// [`finish`](Self::finish) tells of errors; a drop does the same work and cannot.
#[derive(Debug)]
pub struct WavWriter<W: Write + Seek> {
    sink: W,
    path: PathBuf,
    spec: WavSpec,
    riff_limit: u64,
    refresh: u64,
    buffer: Vec<u8>,
    interleaved: Vec<f32>,
    /// Bytes of samples that the sink has accepted.
    accepted: u64,
    /// Frames taken from the caller.
    frames: u64,
    refreshed: u64,
    header_length: u64,
    tally: Tally,
    state: State,
}

#[derive(Debug, Clone, PartialEq)]
enum State {
    Open,
    Failed(FileError),
    Closed,
}

/// What has been written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Written {
    /// Frames in the file.
    pub frames: u64,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Samples that were beyond full scale.
    pub clipped: u64,
    /// Samples that were not finite.
    pub non_finite: u64,
    /// Whether the file outgrew RIFF.
    pub rf64: bool,
}

impl WavWriter<OutputFile> {
    /// Makes the file, or replaces the one that is there, with an empty recording.
    ///
    /// # Errors
    /// When the path is a folder or cannot be written, and when no WAV file can be as `spec` says.
    pub fn create(path: impl AsRef<Path>, spec: WavSpec) -> Result<Self, FileError> {
        check(&spec)?;
        let file = OutputFile::create(&path)?;
        Self::on(file, path.as_ref().to_owned(), spec)
    }
}

impl<W: Write + Seek> WavWriter<W> {
    /// Writes to a sink of any kind. It is called "the output" in errors.
    ///
    /// # Errors
    /// When the sink refuses the header, and when no WAV file can be as `spec` says.
    pub fn new(sink: W, spec: WavSpec) -> Result<Self, FileError> {
        check(&spec)?;
        Self::on(sink, PathBuf::from("the output"), spec)
    }

    fn on(sink: W, path: PathBuf, spec: WavSpec) -> Result<Self, FileError> {
        let mut writer = Self {
            header_length: header(&spec, 0, RIFF_LIMIT).0.len() as u64,
            refresh: REFRESH * u64::from(spec.rate),
            sink,
            path,
            spec,
            riff_limit: RIFF_LIMIT,
            buffer: Vec::with_capacity(BUFFER),
            interleaved: Vec::new(),
            accepted: 0,
            frames: 0,
            refreshed: 0,
            tally: Tally::default(),
            state: State::Open,
        };
        writer.refresh_header().map_err(|error| writer.fail(&error))?;
        Ok(writer)
    }

    /// Turns to RF64 past so many bytes instead of at 4 GiB; more than that is not possible.
    pub fn riff_limit(mut self, bytes: u64) -> Self {
        self.riff_limit = bytes.min(RIFF_LIMIT);
        self
    }

    /// Brings the header up to date after so many frames instead of two seconds.
    pub fn refresh_every(mut self, frames: u64) -> Self {
        self.refresh = frames.max(1);
        self
    }

    /// Frames written so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Appends frames, the samples of a frame side by side.
    ///
    /// # Errors
    /// When the samples are no whole number of frames, and when the sink refuses more; after that, what it has accepted can be
    /// played, and every further call says the same.
    pub fn write(&mut self, interleaved: &[f32]) -> Result<(), FileError> {
        let channels = self.spec.channels;
        self.usable()?;
        if !interleaved.len().is_multiple_of(channels) {
            return Err(misuse(format!(
                "{} samples are no whole number of frames of {channels} channels: write whole frames",
                interleaved.len()
            )));
        }
        let block = channels * self.spec.encoding.bytes();
        let mut rest = interleaved;
        while !rest.is_empty() {
            let room = (BUFFER.saturating_sub(self.buffer.len()) / block).max(1);
            let due = (self.refreshed + self.refresh).saturating_sub(self.frames).max(1);
            let frames = room.min(rest.len() / channels).min(usize::try_from(due).unwrap_or(usize::MAX));
            let (now, later) = rest.split_at(frames * channels);
            let tally = encode(&self.spec, self.frames, now, &mut self.buffer);
            self.tally.clipped += tally.clipped;
            self.tally.non_finite += tally.non_finite;
            self.frames += frames as u64;
            rest = later;
            if self.frames >= self.refreshed + self.refresh {
                self.checkpoint()?;
            } else if self.buffer.len() + block > BUFFER {
                self.drain().map_err(|error| self.fail(&error))?;
            }
        }
        Ok(())
    }

    /// Appends frames, a slice for each channel.
    ///
    /// # Errors
    /// As [`write`](Self::write), and when the slices are not one for each channel, all of the same length.
    pub fn write_planar<S: AsRef<[f32]>>(&mut self, channels: &[S]) -> Result<(), FileError> {
        let frames = channels.first().map_or(0, |first| first.as_ref().len());
        if channels.len() != self.spec.channels || channels.iter().any(|c| c.as_ref().len() != frames) {
            return Err(misuse(format!(
                "{} slices do not make {} channels of one length: give one slice for each channel",
                channels.len(),
                self.spec.channels
            )));
        }
        // Small enough to stay in the cache between the two passes.
        let step = (4096 / channels.len()).max(1);
        let mut interleaved = std::mem::take(&mut self.interleaved);
        let mut result = Ok(());
        for start in (0..frames).step_by(step) {
            let end = frames.min(start + step);
            interleaved.clear();
            interleaved.resize((end - start) * channels.len(), 0.0);
            for (c, samples) in channels.iter().enumerate() {
                let slots = interleaved[c..].iter_mut().step_by(channels.len());
                for (slot, &sample) in slots.zip(&samples.as_ref()[start..end]) {
                    *slot = sample;
                }
            }
            result = self.write(&interleaved);
            if result.is_err() {
                break;
            }
        }
        self.interleaved = interleaved;
        result
    }

    /// Hands everything to the sink and brings the header up to date.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn checkpoint(&mut self) -> Result<(), FileError> {
        self.usable()?;
        self.drain().and_then(|()| self.refresh_header()).map_err(|error| self.fail(&error))
    }

    /// Completes the file.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn finish(mut self) -> Result<Written, FileError> {
        self.checkpoint()?;
        self.sink.flush().map_err(|error| self.fail(&error))?;
        self.state = State::Closed;
        let data = self.accepted + self.accepted % 2;
        Ok(Written {
            frames: self.frames,
            bytes: self.header_length + data,
            clipped: self.tally.clipped,
            non_finite: self.tally.non_finite,
            rf64: self.header_length - 8 + data > self.riff_limit,
        })
    }

    fn usable(&self) -> Result<(), FileError> {
        match &self.state {
            State::Failed(error) => Err(error.clone()),
            State::Open | State::Closed => Ok(()),
        }
    }

    fn drain(&mut self) -> io::Result<()> {
        let mut rest = self.buffer.as_slice();
        while !rest.is_empty() {
            match self.sink.write(rest) {
                Ok(0) => return Err(io::Error::from(io::ErrorKind::WriteZero)),
                Ok(n) => {
                    let n = n.min(rest.len());
                    self.accepted += n as u64;
                    rest = &rest[n..];
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.buffer.clear();
        Ok(())
    }

    /// Makes the file whole as far as it goes, then goes back to where the next samples belong.
    fn refresh_header(&mut self) -> io::Result<()> {
        if self.accepted % 2 == 1 {
            self.sink.write_all(&[0])?;
        }
        self.put_header(self.frames)?;
        self.sink.seek(SeekFrom::Start(self.header_length + self.accepted))?;
        self.refreshed = self.frames;
        Ok(())
    }

    fn put_header(&mut self, frames: u64) -> io::Result<()> {
        self.sink.seek(SeekFrom::Start(0))?;
        self.sink.write_all(&header(&self.spec, frames, self.riff_limit).0)
    }

    /// Saves what the sink has accepted: the room for the header is there even when the disk is full.
    fn fail(&mut self, error: &io::Error) -> FileError {
        let error = FileError::writing(&self.path, error);
        let block = (self.spec.channels * self.spec.encoding.bytes()) as u64;
        let mut frames = self.accepted / block;
        if frames * block % 2 == 1 {
            // There may be no room for the pad.
            frames -= 1;
        }
        // The first error is the one to tell of.
        let _ = self.put_header(frames).and_then(|()| self.sink.flush());
        self.state = State::Failed(error.clone());
        error
    }
}

impl<W: Write + Seek> Drop for WavWriter<W> {
    fn drop(&mut self) {
        if self.state == State::Open {
            // Nobody is left to tell.
            let _ = self.checkpoint();
            let _ = self.sink.flush();
        }
    }
}

fn misuse(message: String) -> FileError {
    FileError::new(crate::io::error::FileErrorKind::Misuse, message)
}
