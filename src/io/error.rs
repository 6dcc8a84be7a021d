//! What can go wrong with a file, in one sentence and in one exit code.

use std::fmt;
use std::io;
use std::path::Path;

/// The kinds of trouble a program may want to tell apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FileErrorKind {
    /// The file to read is not there, or is a folder.
    Missing,
    /// The system does not allow it.
    Permission,
    /// The file to write cannot be made: its path is a folder, its folder is missing, the medium is read-only.
    CannotCreate,
    /// Reading or writing failed half-way: disk full, medium gone.
    Io,
    /// The content is not what it must be.
    Malformed,
    /// The path leads where it may not lead.
    Outside,
    /// The caller asked for what no file can hold.
    Misuse,
    /// The system has no thread left that would write it.
    System,
}

/// Trouble with a file: one sentence that says what, where and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileError {
    /// For programs.
    pub kind: FileErrorKind,
    /// What the system said, where it was the system that said it.
    pub io: Option<io::ErrorKind>,
    /// For people.
    pub message: String,
}

impl FileError {
    /// An error that did not come from the system.
    pub(crate) fn new(kind: FileErrorKind, message: impl Into<String>) -> Self {
        Self { kind, io: None, message: message.into() }
    }

    /// What the system said when `path` was opened or read.
    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        let shown = path.display();
        let (kind, message) = match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => (
                FileErrorKind::Missing,
                format!(
                    "`{shown}` is not there: check the path, which counts from the folder you are in unless it begins with /"
                ),
            ),
            io::ErrorKind::InvalidFilename => (
                FileErrorKind::Missing,
                format!("no file can have the name `{shown}`: give it a shorter one without odd characters"),
            ),
            _ if is_loop(error) => (
                FileErrorKind::Missing,
                format!(
                    "`{shown}` leads to itself, as links in it go round in a circle: name the file they were to lead to"
                ),
            ),
            io::ErrorKind::PermissionDenied => (
                FileErrorKind::Permission,
                format!(
                    "`{shown}` may not be read: ask its owner for the right to, or copy it where you have it"
                ),
            ),
            io::ErrorKind::IsADirectory => return Self::folder(path),
            _ => (
                FileErrorKind::Io,
                format!(
                    "`{shown}` cannot be read ({error}): see whether the disk or the connection to it is sound"
                ),
            ),
        };
        Self { kind, io: Some(error.kind()), message }
    }

    /// A folder where a file to read should be.
    pub(crate) fn folder(path: &Path) -> Self {
        Self {
            kind: FileErrorKind::Missing,
            io: Some(io::ErrorKind::IsADirectory),
            message: format!("`{}` is a folder: name a file in it", path.display()),
        }
    }

    /// What the system said when `path` was made.
    pub fn creating(path: &Path, error: &io::Error) -> Self {
        let shown = path.display();
        let (kind, message) = match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => (
                FileErrorKind::CannotCreate,
                format!(
                    "`{shown}` cannot be written, as its folder is not there: make the folder first or choose another path"
                ),
            ),
            io::ErrorKind::PermissionDenied => (
                FileErrorKind::Permission,
                format!("`{shown}` may not be written: choose a path where you have the right to write"),
            ),
            io::ErrorKind::IsADirectory => (
                FileErrorKind::CannotCreate,
                format!(
                    "`{shown}` is a folder: name a file in it, such as `{}`",
                    path.join("out.wav").display()
                ),
            ),
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => return Self::writing(path, error),
            _ => (
                FileErrorKind::CannotCreate,
                format!("`{shown}` cannot be written ({error}): choose another path"),
            ),
        };
        Self { kind, io: Some(error.kind()), message }
    }

    /// What the system said when a thread was asked for that was to write to `path`.
    #[cfg(feature = "live")]
    pub(crate) fn no_thread(path: &Path, error: &io::Error) -> Self {
        let message = format!("no thread to write `{}` in ({error}): end other programs", path.display());
        Self { kind: FileErrorKind::System, io: Some(error.kind()), message }
    }

    /// What the system said when more was written to `path`.
    pub(crate) fn writing(path: &Path, error: &io::Error) -> Self {
        let shown = path.display();
        let message = match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::WriteZero => {
                format!(
                    "there is no room left for `{shown}`: free some and write it again, or choose another disk"
                )
            }
            io::ErrorKind::FileTooLarge => {
                format!(
                    "`{shown}` has grown as large as its file system, or the limit of the shell (`ulimit -f`), allows: write less at a time, raise the limit, or choose another disk"
                )
            }
            io::ErrorKind::NotFound => {
                format!(
                    "`{shown}` is gone: it was removed, moved or replaced, or its folder was, while it was written; write it again where nobody does that"
                )
            }
            io::ErrorKind::UnexpectedEof => {
                format!(
                    "`{shown}` has been cut short by somebody else while it was written: write it again where nobody else writes"
                )
            }
            io::ErrorKind::NotSeekable => {
                format!(
                    "`{shown}` is a pipe, and a file whose length is written last cannot go into one: name a file on a disk"
                )
            }
            _ => format!(
                "writing `{shown}` failed ({error}): see whether the disk or the connection to it is sound"
            ),
        };
        Self { kind: FileErrorKind::Io, io: Some(error.kind()), message }
    }

    /// The exit code of a program that ends for this reason, after `sysexits.h`.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            FileErrorKind::Malformed | FileErrorKind::Outside => 65,
            FileErrorKind::Missing => 66,
            FileErrorKind::Misuse => 70,
            FileErrorKind::System => 71,
            FileErrorKind::CannotCreate => 73,
            FileErrorKind::Io => 74,
            FileErrorKind::Permission => 77,
        }
    }
}

/// Whether links lead in a circle, for which the library has no stable word.
fn is_loop(error: &io::Error) -> bool {
    const LOOP: i32 = if cfg!(any(target_os = "linux", target_os = "android")) { 40 } else { 62 };
    cfg!(unix) && error.raw_os_error() == Some(LOOP)
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for FileError {}

#[cfg(test)]
mod tests {
    use super::FileError;
    use std::io::{Error, ErrorKind};
    use std::path::Path;

    #[test]
    fn each_names_the_file_and_has_its_exit_code() {
        let path = Path::new("a/b.wav");
        let cases = vec![
            (FileError::reading(path, &Error::from(ErrorKind::NotFound)), 66),
            (FileError::reading(path, &Error::from(ErrorKind::IsADirectory)), 66),
            (FileError::reading(path, &Error::from(ErrorKind::PermissionDenied)), 77),
            (FileError::reading(path, &Error::other("cable")), 74),
            (FileError::creating(path, &Error::from(ErrorKind::NotFound)), 73),
            (FileError::creating(path, &Error::from(ErrorKind::IsADirectory)), 73),
            (FileError::creating(path, &Error::from(ErrorKind::ReadOnlyFilesystem)), 73),
            (FileError::creating(path, &Error::from(ErrorKind::PermissionDenied)), 77),
            (FileError::creating(path, &Error::from(ErrorKind::StorageFull)), 74),
            (FileError::writing(path, &Error::from(ErrorKind::StorageFull)), 74),
            (FileError::writing(path, &Error::other("cable")), 74),
            #[cfg(feature = "live")]
            (FileError::no_thread(path, &Error::from(ErrorKind::WouldBlock)), 71),
        ];
        for (error, code) in cases {
            assert!(error.message.contains("`a/b.wav`"), "{error}");
            assert!(error.message.contains(": "), "says what to do: {error}");
            assert_eq!(error.exit_code(), code, "{error}");
            assert!(error.io.is_some(), "{error}");
        }
    }
}
