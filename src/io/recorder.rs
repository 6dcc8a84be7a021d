//! Keeps what a session sends to its device, or hears, in a WAV file.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use ringbuf::HeapCons;
use ringbuf::traits::{Consumer, Observer};

use super::error::{FileError, FileErrorKind};
use super::journal::Digest;
use super::out::OutputFile;
use super::wav::{WavSpec, WavWriter, Written};

/// How often it fetches what has come.
const EVERY: Duration = Duration::from_millis(50);

/// What became of a recording, and the digest of its samples, if there is one.
type Recording = Result<(Written, Option<String>), FileError>;

/// A recording under way, in a thread of its own.
#[derive(Debug)]
pub struct Recorder {
    thread: Option<JoinHandle<Recording>>,
    over: Arc<AtomicBool>,
}

impl Recorder {
    /// Makes the file, or empties the one that is there, and writes whatever comes through `ring`, interleaved frames.
    ///
    /// # Errors
    /// A file that cannot be made, and frames that no WAV file can have.
    pub fn start(ring: HeapCons<f32>, path: &Path, spec: WavSpec) -> Result<Self, FileError> {
        Self::begin(ring, path, spec, None)
    }

    /// The same, with a digest of the samples, by which the recording is known again.
    ///
    /// # Errors
    /// As [`Recorder::start`].
    pub fn start_with_digest(ring: HeapCons<f32>, path: &Path, spec: WavSpec) -> Result<Self, FileError> {
        Self::begin(ring, path, spec, Some(Digest::new()))
    }

    fn begin(
        ring: HeapCons<f32>,
        path: &Path,
        spec: WavSpec,
        digest: Option<Digest>,
    ) -> Result<Self, FileError> {
        let channels = spec.channels.max(1);
        // A session that is killed is played again from its journal, which is brought up to date as often.
        let rate = spec.rate;
        let writer = WavWriter::create(path, spec)?.refresh_every(u64::from(rate) / 2);
        let over = Arc::<AtomicBool>::default();
        let told = Arc::clone(&over);
        let thread = std::thread::Builder::new()
            .name("recorder".into())
            .spawn(move || record(ring, writer, channels, digest, &told))
            .map_err(|error| FileError::no_thread(path, &error))?;
        Ok(Self { thread: Some(thread), over })
    }

    /// Whether the file takes no more; [`Recorder::finish`] says why.
    pub fn has_failed(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Completes the file, after the session has stopped.
    ///
    /// # Errors
    /// What went wrong with the file.
    pub fn finish(self) -> Result<Written, FileError> {
        self.finish_with_digest().map(|(written, _)| written)
    }

    /// The same, with the digest of its samples if it was to make one ([`Recorder::start_with_digest`]).
    ///
    /// # Errors
    /// As [`Recorder::finish`].
    pub fn finish_with_digest(mut self) -> Recording {
        self.over.store(true, Ordering::Release);
        let ended = self.thread.take().map(JoinHandle::join);
        ended.and_then(Result::ok).unwrap_or_else(|| {
            let what = "the thread that wrote the recording has failed; the file plays as far as it goes";
            Err(FileError::new(FileErrorKind::Io, what))
        })
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
    }
}

fn record(
    mut ring: HeapCons<f32>,
    mut writer: WavWriter<OutputFile>,
    channels: usize,
    mut digest: Option<Digest>,
    over: &AtomicBool,
) -> Recording {
    let mut frames = vec![0.0; channels * 4096];
    loop {
        // Asked first, so that nothing is missed that came before.
        let last = over.load(Ordering::Acquire);
        while ring.occupied_len() >= channels {
            let whole = ring.occupied_len() / channels * channels;
            let part = whole.min(frames.len());
            let taken = ring.pop_slice(&mut frames[..part]);
            writer.write(&frames[..taken])?;
            digest.iter_mut().for_each(|digest| digest.samples(&frames[..taken]));
        }
        if last {
            return Ok((writer.finish()?, digest.map(Digest::finish)));
        }
        std::thread::sleep(EVERY);
    }
}
