//! Standard MIDI Files from disk.

use std::path::Path;

use super::error::FileError;
use super::text::read_up_to;
use crate::midi::file::{MOST_BYTES, Song};
use crate::text::{Checked, Problems};

/// Why there is no song.
#[derive(Debug, Clone, PartialEq)]
pub enum SongError {
    /// The file cannot be read.
    File(FileError),
    /// It is no song.
    Song(Problems),
}

/// The song in a file.
///
/// # Errors
/// A file that cannot be read, or is none.
pub fn read(path: impl AsRef<Path>) -> Result<Checked<Song>, SongError> {
    read_with(path, |_| ())
}

/// The same. Shows its bytes to `see`, before anybody knows whether they are a song.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: impl AsRef<Path>, see: impl FnOnce(&[u8])) -> Result<Checked<Song>, SongError> {
    let path = path.as_ref();
    let bytes = read_up_to(path, MOST_BYTES as u64).map_err(SongError::File)?;
    see(&bytes);
    Song::read(&path.display().to_string(), &bytes).map_err(SongError::Song)
}
