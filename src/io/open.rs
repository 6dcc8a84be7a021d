//! Opening files to read, and nothing that is none: a pipe would make whoever opens it wait, a device may have no end.

use super::error::{FileError, FileErrorKind};
use std::fmt;
use std::fs::{File, Metadata};
use std::io::Read;
use std::path::Path;

/// What stands where a file is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(not(unix), allow(dead_code))] // Where the system has no words for them, they are other.
pub(super) enum Kind {
    Pipe,
    Socket,
    /// Of characters, such as `/dev/null`.
    Device,
    /// Of blocks.
    Disk,
    Other,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pipe => "a pipe",
            Self::Socket => "a socket",
            Self::Device => "a device",
            Self::Disk => "a whole disk",
            Self::Other => "no file",
        })
    }
}

/// What it is, unless it is a file or a folder.
pub(super) fn kind(about: &Metadata) -> Option<Kind> {
    if about.is_file() || about.is_dir() {
        return None;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = about.file_type();
        let found = [
            (kind.is_fifo(), Kind::Pipe),
            (kind.is_socket(), Kind::Socket),
            (kind.is_char_device(), Kind::Device),
            (kind.is_block_device(), Kind::Disk),
        ];
        if let Some((_, kind)) = found.into_iter().find(|(is, _)| *is) {
            return Some(kind);
        }
    }
    Some(Kind::Other)
}

/// Opens a file to read.
///
/// # Errors
/// When it is missing, not allowed, a folder, or no file at all.
pub(super) fn open(path: &Path) -> Result<File, FileError> {
    let failed = |error: std::io::Error| FileError::reading(path, &error);
    let about = std::fs::metadata(path).map_err(failed)?;
    if about.is_dir() {
        return Err(FileError::folder(path));
    }
    if let Some(kind) = kind(&about) {
        let what = format!(
            "`{}` is {kind}, and what is read here is a file: write it into one first and name that",
            path.display()
        );
        return Err(FileError::new(FileErrorKind::Malformed, what));
    }
    File::open(path).map_err(failed)
}

/// All of a file.
///
/// # Errors
/// As [`open`], and when it cannot be read.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    let mut all = Vec::new();
    open(path)?.read_to_end(&mut all).map_err(|error| FileError::reading(path, &error))?;
    Ok(all)
}

#[cfg(all(test, unix))]
mod tests {
    use super::open;
    use std::path::Path;

    #[test]
    fn what_is_no_file_is_named_and_not_opened() {
        let error = open(Path::new("/dev/zero")).unwrap_err();
        assert_eq!(error.exit_code(), 65);
        assert!(error.message.contains("`/dev/zero` is a device"), "{error}");
        let socket = std::env::temp_dir().join(format!("pacinian-socket-{}", std::process::id()));
        let listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        let error = open(&socket).unwrap_err();
        drop(listener);
        std::fs::remove_file(&socket).unwrap();
        assert!(error.message.contains("is a socket"), "{error}");
    }
}
