//! Recordings from the patch's folder.

use super::error::{FileError, FileErrorKind};
use super::resample::Converter;
use super::wav::WavReader;
use crate::node::asset::{Asset, Assets};
use crate::rig::usual_ratio;
use std::collections::{BTreeMap, HashMap};
use std::io::{Cursor, ErrorKind, Read, Seek};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Rates of recordings that make sense to a tactor, in hertz.
const RATES: std::ops::RangeInclusive<u32> = 1_000..=384_000;

/// A folder that recordings are loaded from, each channel once.
#[derive(Debug)]
pub struct Folder {
    root: PathBuf,
    allow_outside: bool,
    rate: Option<f64>,
    held: &'static [(&'static str, &'static [u8])],
    instead: BTreeMap<String, PathBuf>,
    /// What a file is known again by, if somebody wants to.
    digest: Option<fn(&[u8]) -> String>,
    loaded: Mutex<Loaded>,
}

#[derive(Debug, Default)]
struct Loaded {
    assets: HashMap<(PathBuf, usize), Arc<Asset>>,
    samples: u64,
    digests: HashMap<PathBuf, String>,
}

/// Samples of all recordings together that are held, at most.
const MOST: u64 = 1 << 28;

/// A file of no more bytes is read at once where it is to be known again, so that what is played is what was read; the channels of larger ones
/// cannot all be held either.
const AT_ONCE: u64 = 4 * MOST;

/// The rate to which recordings are brought for an engine of a device: twice its own, so that one may be played at half its speed and
/// keep its band.
pub fn recordings_rate(device_rate: f64) -> f64 {
    2.0 * device_rate / usual_ratio(device_rate) as f64
}

impl Folder {
    /// The folder of a patch. Paths count from it and may not leave it.
    pub fn new(root: impl AsRef<Path>) -> Self {
        let root = root.as_ref();
        // The folder of `patch.toml` is ``, by which the current one is meant.
        let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
        Self {
            root: root.to_owned(),
            allow_outside: false,
            rate: None,
            held: &[],
            instead: BTreeMap::new(),
            digest: None,
            loaded: Mutex::default(),
        }
    }

    /// Whether paths may leave the folder.
    pub fn allow_outside(mut self, allow: bool) -> Self {
        self.allow_outside = allow;
        self
    }

    /// Files that need no disk, by their path as a patch says it.
    pub fn holding(mut self, files: &'static [(&'static str, &'static [u8])]) -> Self {
        self.held = files;
        self
    }

    /// Notes a digest of each file that is read, of the very bytes from which its samples come, whoever writes it meanwhile.
    pub fn digesting(mut self, digest: fn(&[u8]) -> String) -> Self {
        self.digest = Some(digest);
        self
    }

    /// The digest of the file at `path`, as a patch says it, if it has been read and [noted](Self::digesting).
    pub fn digest(&self, path: &str) -> Option<String> {
        let real = self.resolve(path).ok()?;
        self.loaded.lock().unwrap_or_else(PoisonError::into_inner).digests.get(&real).cloned()
    }

    /// Recordings that lie elsewhere, by their path as a patch says it; what they are, somebody has looked at.
    #[cfg(feature = "live")]
    pub(crate) fn with_others(mut self, instead: BTreeMap<String, PathBuf>) -> Self {
        self.instead = instead;
        self
    }

    /// Brings all recordings to this rate, in hertz, band-limited to half of it. Without, they keep their own.
    pub fn at_rate(mut self, rate: f64) -> Self {
        self.rate = Some(rate);
        // What is loaded has another rate.
        self.loaded = Mutex::default();
        self
    }

    /// The same folder, which brings its recordings to another rate, unless that is its own.
    #[cfg(feature = "live")]
    pub fn at_other_rate(&self, rate: f64) -> Option<Self> {
        (self.rate != Some(rate)).then(|| Self {
            root: self.root.clone(),
            allow_outside: self.allow_outside,
            rate: Some(rate),
            held: self.held,
            instead: self.instead.clone(),
            digest: self.digest,
            loaded: Mutex::default(),
        })
    }

    /// The folder, as it was given.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Whether paths may leave it.
    pub fn allows_outside(&self) -> bool {
        self.allow_outside
    }

    /// Where the file at `path`, as a patch says it, is on the disk; links are followed.
    ///
    /// # Errors
    /// When it is not there, and when it is outside the folder and that is not allowed.
    pub fn resolve(&self, path: &str) -> Result<PathBuf, FileError> {
        let outside = || {
            let message = format!(
                "`{path}` leads out of the patch's folder `{}`: put the file into that folder, or allow files outside it on the command line",
                self.root.display()
            );
            FileError::new(FileErrorKind::Outside, message)
        };
        // Refused by its look first, so that a patch cannot find out what exists elsewhere.
        if !self.allow_outside && leaves(Path::new(path)) {
            return Err(outside());
        }
        let joined = self.root.join(path);
        let real = joined.canonicalize().map_err(|error| {
            let mut error = FileError::reading(&joined, &error);
            if matches!(error.io, Some(ErrorKind::NotFound | ErrorKind::NotADirectory)) {
                error.message = format!(
                    "`{}` is not there: check the path, which counts from the patch's folder `{}`",
                    path,
                    self.root.display()
                );
            }
            error
        })?;
        if !self.allow_outside {
            let root = self.root.canonicalize().map_err(|error| FileError::reading(&self.root, &error))?;
            if !real.starts_with(root) {
                return Err(outside());
            }
        }
        Ok(real)
    }

    /// The channel (from 1) of the recording at `path`.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve) and [`WavReader`], when its rate is not from 1 to 384 kHz, and when all recordings together would
    /// have more than 2²⁸ samples (1 GiB).
    pub fn recording(&self, path: &str, channel: usize) -> Result<Arc<Asset>, FileError> {
        let held = self.held.iter().find(|(name, _)| *name == path);
        let real = match self.instead.get(path) {
            _ if held.is_some() => PathBuf::from(path),
            Some(other) => other.clone(),
            None => self.resolve(path)?,
        };
        let key = (real, channel);
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(asset) = loaded.assets.get(&key) {
            return Ok(Arc::clone(asset));
        }
        let room = MOST.saturating_sub(loaded.samples);
        let asset = match held {
            Some((_, bytes)) => {
                self.load_from(WavReader::new(Cursor::new(*bytes), path)?, &key.0, channel, room)?
            }
            None => match self.digest.filter(|_| is_small(&key.0)) {
                None => self.load_from(WavReader::open(&key.0)?, &key.0, channel, room)?,
                Some(digest) => {
                    let bytes = super::open::bytes(&key.0)?;
                    let now = digest(&bytes);
                    if *loaded.digests.entry(key.0.clone()).or_insert_with(|| now.clone()) != now {
                        let what = format!("`{}` was written anew while it was read", key.0.display());
                        return Err(FileError::new(FileErrorKind::Io, what));
                    }
                    self.load_from(WavReader::new(Cursor::new(bytes), &key.0)?, &key.0, channel, room)?
                }
            },
        };
        let asset = Arc::new(asset);
        loaded.samples += asset.samples.len() as u64;
        loaded.assets.insert(key, Arc::clone(&asset));
        Ok(asset)
    }

    fn load_from<R: Read + Seek>(
        &self,
        mut reader: WavReader<R>,
        path: &Path,
        channel: usize,
        room: u64,
    ) -> Result<Asset, FileError> {
        let malformed = |what: String| {
            FileError::new(FileErrorKind::Malformed, format!("`{}` cannot be used: {what}", path.display()))
        };
        let (rate, frames) = (reader.info().rate, reader.info().frames);
        check_rate(path, rate)?;
        let wanted = self.rate.unwrap_or(f64::from(rate));
        let mut converter = Converter::new(f64::from(rate), wanted).map_err(malformed)?;
        if converter.length(frames) > room {
            let length = converter.length(frames);
            return Err(malformed(format!(
                "it has {length} samples at {wanted} Hz, and all recordings together may have {MOST} (1 GiB): \
                 cut it to what is played of it, or play fewer of them"
            )));
        }
        converter.reserve(frames).map_err(malformed)?;
        reader.read(channel, frames, |x| converter.push(x))?;
        Ok(Asset { samples: converter.finish().map_err(malformed)?, rate: wanted })
    }
}

fn is_small(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|about| about.len() <= AT_ONCE)
}

/// Refuses a rate (Hz) that no recording for the skin has.
pub(super) fn check_rate(path: &Path, rate: u32) -> Result<(), FileError> {
    if RATES.contains(&rate) {
        return Ok(());
    }
    let message = format!(
        "`{}` cannot be used: its rate of {rate} Hz is not from {} to {}: convert it, such as to 16000 Hz",
        path.display(),
        RATES.start(),
        RATES.end()
    );
    Err(FileError::new(FileErrorKind::Malformed, message))
}

impl Assets for Folder {
    fn load(&self, path: &str, channel: usize) -> Result<Arc<Asset>, String> {
        self.recording(path, channel).map_err(|error| error.message)
    }
}

/// Whether the path climbs above where it starts.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    for part in path.components() {
        match part {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return true,
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::{Folder, leaves};
    use crate::io::error::FileErrorKind;
    use crate::io::wav::{Encoding, WavSpec, WavWriter};
    use crate::node::asset::Assets;
    use std::path::{Path, PathBuf};
    use std::sync::Arc;

    struct Scratch(PathBuf);

    impl Scratch {
        /// `patch/tone.wav` with two channels at 48 kHz, `patch/sub/`, `secret.wav`.
        fn new(name: &str) -> Self {
            let root = std::env::temp_dir().join(format!("pacinian-assets-{name}-{}", std::process::id()));
            std::fs::create_dir_all(root.join("patch/sub")).unwrap();
            for file in ["patch/tone.wav", "secret.wav"] {
                let mut wav =
                    WavWriter::create(root.join(file), WavSpec::new(2, 48_000, Encoding::F32)).unwrap();
                wav.write(&[0.25, -0.5].repeat(4_800)).unwrap();
                wav.finish().unwrap();
            }
            Self(root)
        }
        fn patch(&self) -> PathBuf {
            self.0.join("patch")
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    /// A stand-in for a digest.
    fn length_and_end(bytes: &[u8]) -> String {
        format!("{} {:?}", bytes.len(), bytes.last())
    }

    #[test]
    fn what_is_noted_of_a_file_is_what_was_read() {
        let scratch = Scratch::new("noted");
        let path = scratch.patch().join("tone.wav");
        let before = std::fs::read(&path).unwrap();
        let folder = Folder::new(scratch.patch()).digesting(length_and_end);
        assert_eq!(folder.digest("tone.wav"), None, "it has not been read");
        let first = folder.load("tone.wav", 1).unwrap();
        // It is written anew.
        let mut wav = WavWriter::create(&path, WavSpec::new(2, 48_000, Encoding::F32)).unwrap();
        wav.write(&[0.125, -0.75].repeat(2_400)).unwrap();
        wav.finish().unwrap();
        assert_eq!(folder.digest("tone.wav"), Some(length_and_end(&before)));
        assert_eq!(folder.load("tone.wav", 1).unwrap().samples.len(), first.samples.len());
        let error = folder.load("tone.wav", 2).unwrap_err();
        assert!(error.contains("written anew while it was read"), "{error}");
        // The same samples as without.
        let plain = Folder::new(scratch.patch()).load("tone.wav", 2).unwrap();
        let noted = Folder::new(scratch.patch()).digesting(length_and_end).load("tone.wav", 2).unwrap();
        assert_eq!(plain.samples, noted.samples);
    }

    #[test]
    fn a_channel_is_loaded_once_whatever_its_path_looks_like() {
        let scratch = Scratch::new("once");
        let folder = Folder::new(scratch.patch());
        let first = folder.load("tone.wav", 2).unwrap();
        assert_eq!((first.samples.len(), first.samples[7], first.rate), (4_800, -0.5, 48_000.0));
        assert!(Arc::ptr_eq(&first, &folder.load("./sub/../tone.wav", 2).unwrap()));
        assert_eq!(folder.load("tone.wav", 1).unwrap().samples[7], 0.25);
    }

    #[test]
    fn recordings_come_at_the_rate_that_was_asked_for() {
        let scratch = Scratch::new("rate");
        let asset = Folder::new(scratch.patch()).at_rate(14_700.0).load("tone.wav", 1).unwrap();
        assert_eq!((asset.samples.len(), asset.rate), (1_470, 14_700.0));
        assert!((asset.samples[735] - 0.25).abs() < 1e-4);
        let error = Folder::new(scratch.patch()).at_rate(f64::NAN).load("tone.wav", 1).unwrap_err();
        assert!(error.contains("NaN Hz"), "{error}");
    }

    #[test]
    fn the_folder_is_not_left_unless_allowed() {
        let scratch = Scratch::new("leave");
        let absolute = scratch.0.join("secret.wav").to_string_lossy().into_owned();
        let open = Folder::new(scratch.patch()).allow_outside(true);
        for path in ["../secret.wav", "sub/../../secret.wav", &absolute, "../nothing.wav"] {
            let error = Folder::new(scratch.patch()).recording(path, 1).unwrap_err();
            assert_eq!((error.kind, error.exit_code()), (FileErrorKind::Outside, 65), "{path}");
            assert!(error.message.contains(path), "{error}");
            assert_eq!(open.load(path, 1).is_ok(), !path.contains("nothing"), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn nor_through_a_link() {
        let scratch = Scratch::new("link");
        std::os::unix::fs::symlink("../secret.wav", scratch.patch().join("link.wav")).unwrap();
        std::os::unix::fs::symlink("..", scratch.patch().join("up")).unwrap();
        for path in ["link.wav", "up/secret.wav"] {
            let error = Folder::new(scratch.patch()).recording(path, 1).unwrap_err();
            assert_eq!(error.kind, FileErrorKind::Outside, "{path}");
            assert!(Folder::new(scratch.patch()).allow_outside(true).load(path, 1).is_ok());
        }
        // A link that stays inside is as good as the file.
        std::os::unix::fs::symlink("tone.wav", scratch.patch().join("same.wav")).unwrap();
        assert!(Folder::new(scratch.patch()).load("same.wav", 1).is_ok());
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said() {
        let scratch = Scratch::new("wrong");
        let folder = Folder::new(scratch.patch());
        std::fs::write(scratch.patch().join("notes.wav"), "not a recording").unwrap();
        let mut slow =
            WavWriter::create(scratch.patch().join("slow.wav"), WavSpec::new(1, 10, Encoding::I16)).unwrap();
        slow.write(&[0.1]).unwrap();
        slow.finish().unwrap();
        for (path, channel, kind, words) in [
            (
                "none.wav",
                1,
                FileErrorKind::Missing,
                "`none.wav` is not there: check the path, which counts from the patch's folder",
            ),
            ("sub", 1, FileErrorKind::Missing, "is a folder"),
            ("", 1, FileErrorKind::Missing, "is a folder"),
            ("notes.wav", 1, FileErrorKind::Malformed, "no WAV file"),
            ("tone.wav", 3, FileErrorKind::Malformed, "2 channels, so there is no channel 3"),
            ("tone.wav", 0, FileErrorKind::Malformed, "no channel 0"),
            ("slow.wav", 1, FileErrorKind::Malformed, "rate of 10 Hz"),
        ] {
            let error = folder.recording(path, channel).unwrap_err();
            assert_eq!(error.kind, kind, "{error}");
            assert!(error.message.contains(words), "{error}");
        }
    }

    #[test]
    fn climbing_is_seen_without_looking_at_the_disk() {
        assert!(!leaves(Path::new("a/../b/./c.wav")));
        for path in ["..", "a/../../b", "/a"] {
            assert!(leaves(Path::new(path)), "{path}");
        }
    }
}
