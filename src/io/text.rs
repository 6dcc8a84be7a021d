//! Patches and rigs, from disk to bytes.

use super::error::{FileError, FileErrorKind};
use super::open::open;
use std::io::Read;
use std::path::Path;

/// The most that [`read`] takes, in bytes: no patch that a person writes comes near it.
pub const LIMIT: u64 = 16 << 20;

/// The bytes of a patch, rig or other short document.
///
/// # Errors
/// When the file is missing, a folder, not allowed, or over [`LIMIT`].
pub fn read(path: impl AsRef<Path>) -> Result<Vec<u8>, FileError> {
    read_up_to(path, LIMIT)
}

/// The bytes of a document of at most `limit` bytes. Never reads further than that, whatever the file turns out to be.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_up_to(path: impl AsRef<Path>, limit: u64) -> Result<Vec<u8>, FileError> {
    let path = path.as_ref();
    let failed = |error: std::io::Error| FileError::reading(path, &error);
    let file = open(path)?;
    let mut bytes = Vec::new();
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit {
        let message = format!(
            "`{}` is longer than {limit} bytes, which is the most that is read of such a file: \
             see whether it is the file you mean, or split it",
            path.display()
        );
        return Err(FileError::new(FileErrorKind::Malformed, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::{read, read_up_to};
    use std::io::ErrorKind;

    #[test]
    fn missing_files_and_folders_are_told_apart() {
        let missing = read("no/such.toml").unwrap_err();
        assert_eq!((missing.exit_code(), missing.io), (66, Some(ErrorKind::NotFound)));
        assert!(missing.message.contains("`no/such.toml`"), "{missing}");
        let folder = read(std::env::temp_dir()).unwrap_err();
        assert_eq!((folder.exit_code(), folder.io), (66, Some(ErrorKind::IsADirectory)));
    }

    #[test]
    fn the_limit_itself_passes_and_one_more_does_not() {
        let path = std::env::temp_dir().join(format!("pacinian-text-{}", std::process::id()));
        std::fs::write(&path, [7; 100]).unwrap();
        assert_eq!(read_up_to(&path, 100).unwrap(), [7; 100]);
        let error = read_up_to(&path, 99).unwrap_err();
        assert_eq!(error.exit_code(), 65);
        assert!(error.message.contains("longer than 99 bytes"), "{error}");
        std::fs::remove_file(&path).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_endless_file_ends() {
        assert_eq!(read_up_to("/dev/zero", 1000).unwrap_err().exit_code(), 65);
    }
}
