//! Patches and rigs, from disk or from standard input to bytes.

use super::error::{FileError, FileErrorKind};
use super::open::open;
use std::io::{IsTerminal, Read};
use std::path::{Component, Path};

/// The most that [`read`] takes, in bytes: no patch that a person writes comes near it.
pub const LIMIT: u64 = 16 << 20;

/// The bytes of a patch, rig or other short document.
///
/// # Errors
/// When the file is missing, a folder, not allowed, or over [`LIMIT`].
pub fn read(path: impl AsRef<Path>) -> Result<Vec<u8>, FileError> {
    read_up_to(path, LIMIT)
}

/// Whether a path is what others hand this program open: `-` for standard input, `/dev/stdin`, `/dev/fd/63`. Such a document lies
/// in no folder, and may be a pipe: somebody writes into it, or has ended it.
pub fn is_stream(path: &Path) -> bool {
    if path.as_os_str() == "-" {
        return true;
    }
    let mut parts = path.components();
    if !cfg!(unix) || parts.next() != Some(Component::RootDir) {
        return false;
    }
    let parts: Vec<_> = parts.filter_map(|part| part.as_os_str().to_str()).collect();
    match parts[..] {
        ["dev", "stdin"] => true,
        // The program's own output is nothing to read.
        ["dev", "fd", number] | ["proc", "self", "fd", number] => !matches!(number, "1" | "2"),
        _ => false,
    }
}

/// Whether two paths are the same stream, so that the second to be read would find nothing left.
pub fn is_same_stream(a: &Path, b: &Path) -> bool {
    if !is_stream(a) || !is_stream(b) {
        return false;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let at = |path: &Path| {
            let path = if path.as_os_str() == "-" { Path::new("/dev/stdin") } else { path };
            std::fs::metadata(path).ok().map(|about| (about.dev(), about.ino()))
        };
        if let (Some(a), Some(b)) = (at(a), at(b)) {
            return a == b;
        }
    }
    a == b
}

/// The bytes of a document of at most `limit` bytes. Never reads further than that, whatever the file turns out to be.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_up_to(path: impl AsRef<Path>, limit: u64) -> Result<Vec<u8>, FileError> {
    let path = path.as_ref();
    let failed = |error: std::io::Error| FileError::reading(path, &error);
    let source: Box<dyn Read> = if path.as_os_str() == "-" {
        let input = std::io::stdin();
        if input.is_terminal() {
            let what = "`-` is standard input, and that is the terminal: name a file, or send one, `... < patch.toml`";
            return Err(FileError::new(FileErrorKind::Malformed, what));
        }
        Box::new(input)
    } else if is_stream(path) && is_pipe(path) {
        Box::new(std::fs::File::open(path).map_err(failed)?)
    } else {
        Box::new(open(path)?)
    };
    let mut bytes = Vec::new();
    source.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
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

fn is_pipe(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|about| super::open::kind(&about) == Some(super::open::Kind::Pipe))
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

    #[cfg(unix)]
    #[test]
    fn what_is_handed_over_open_is_told_from_files() {
        let is = |path: &str| super::is_stream(std::path::Path::new(path));
        assert!(["-", "/dev/stdin", "/dev/fd/63", "/proc/self/fd/0"].into_iter().all(is));
        assert!(
            !["/dev/fd/1", "/proc/self/fd/2", "./-", "a.toml", "/dev/null", "/dev/fd", "dev/stdin", "/", ""]
                .into_iter()
                .any(is)
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_endless_file_ends() {
        assert_eq!(read_up_to("/dev/zero", 1000).unwrap_err().exit_code(), 65);
    }
}
