//! A file being written, which knows its path so that its errors can name it.

use super::error::FileError;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file being written, in its final place from the first byte on.
#[derive(Debug)]
pub struct OutputFile {
    file: File,
    path: PathBuf,
}

impl OutputFile {
    /// Makes the file, or empties the one that is there.
    ///
    /// # Errors
    /// When the path is a folder, when its folder is missing or when the system refuses.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        // Asked beforehand, as systems differ in how they refuse a folder.
        if path.is_dir() {
            return Err(FileError::creating(path, &io::Error::from(io::ErrorKind::IsADirectory)));
        }
        let file = File::create(path).map_err(|error| FileError::creating(path, &error))?;
        Ok(Self { file, path: path.to_owned() })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Writes a whole small file, such as a picture or a table.
///
/// # Errors
/// As [`OutputFile::create`], and when the disk is full.
pub fn write(path: impl AsRef<Path>, content: &[u8]) -> Result<(), FileError> {
    let mut file = OutputFile::create(path)?;
    file.write_all(content).map_err(|error| FileError::writing(&file.path, &error))
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::{OutputFile, write};
    use crate::io::error::FileErrorKind;

    #[test]
    fn a_folder_is_refused_and_left_alone() {
        let folder = std::env::temp_dir();
        let error = OutputFile::create(&folder).unwrap_err();
        assert_eq!((error.kind, error.exit_code()), (FileErrorKind::CannotCreate, 73));
        assert!(error.message.contains("is a folder"), "{error}");
    }

    #[test]
    fn a_missing_folder_is_named_as_the_reason() {
        let path = std::env::temp_dir().join(format!("pacinian-none-{}", std::process::id())).join("a.svg");
        let error = write(&path, b"x").unwrap_err();
        assert_eq!(error.exit_code(), 73);
        assert!(error.message.contains("folder is not there"), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_called_one() {
        let error = write("/dev/full", b"x").unwrap_err();
        assert_eq!(error.exit_code(), 74);
        assert!(error.message.contains("no room left for `/dev/full`"), "{error}");
    }
}
