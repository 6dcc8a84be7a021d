//! A file being written, which knows its path so that its errors can name it.

use super::error::{FileError, FileErrorKind};
use super::open::{Kind, kind};
use std::fs::{File, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file being written, in its final place from the first byte on.
///
/// What somebody else cuts short meanwhile takes no more: it would have a hole. A file that was removed, moved or replaced is written on, and
/// [`Write::flush`], which ends it, says so.
#[derive(Debug)]
pub struct OutputFile {
    file: File,
    path: PathBuf,
    /// Where the next bytes go, and where the furthest that were written end; both stay 0 where there is no file on a disk.
    at: u64,
    length: u64,
    plain: bool,
}

impl OutputFile {
    /// Makes the file, or empties the one that is there. Until it is dropped, nobody else can make it so.
    ///
    /// # Errors
    /// When the path is a folder, a pipe, a socket or a disk, when its folder is missing, when somebody writes it in this way already, or when
    /// the system refuses.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        refuse_what_is_no_file(path)?;
        let failed = |error| FileError::creating(path, &error);
        // What somebody else writes is not emptied.
        let file = File::options().write(true).create(true).truncate(false).open(path).map_err(failed)?;
        let plain = file.metadata().map_err(failed)?.is_file();
        if plain {
            refuse_what_is_written(&file, path)?;
            file.set_len(0).map_err(failed)?;
        }
        Ok(Self { file, path: path.to_owned(), at: 0, length: 0, plain })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// That its path still leads to it.
    fn is_in_place(&self) -> io::Result<()> {
        let now = std::fs::metadata(&self.path)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let own = self.file.metadata()?;
            if (own.dev(), own.ino()) != (now.dev(), now.ino()) {
                return Err(io::Error::from(io::ErrorKind::NotFound));
            }
        }
        #[cfg(not(unix))]
        drop(now);
        Ok(())
    }

    /// That what was written is still there.
    fn is_whole(&self) -> io::Result<()> {
        if self.plain && self.file.metadata()?.len() < self.length {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
        }
        Ok(())
    }
}

/// Whether [`OutputFile::create`] would succeed. What is there stays as it is, and what is not there is not there afterwards.
///
/// # Errors
/// As [`OutputFile::create`].
pub fn check(path: impl AsRef<Path>) -> Result<(), FileError> {
    let path = path.as_ref();
    refuse_what_is_no_file(path)?;
    let failed = |error: io::Error| FileError::creating(path, &error);
    match File::options().write(true).create_new(true).open(path) {
        Ok(_) => std::fs::remove_file(path).map_err(failed),
        // A link to nowhere is there, too: only opening it tells whether what it leads to can be made.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            let dangling = !path.exists();
            let file = File::options().write(true).create(true).truncate(false).open(path).map_err(failed)?;
            refuse_what_is_written(&file, path)?;
            let made = if dangling { path.canonicalize().ok() } else { None };
            made.map_or(Ok(()), std::fs::remove_file).map_err(failed)
        }
        Err(error) => Err(failed(error)),
    }
}

/// Asked before a file is opened: systems differ in how they refuse a folder, and a pipe makes whoever opens it wait for a reader.
fn refuse_what_is_no_file(path: &Path) -> Result<(), FileError> {
    match std::fs::metadata(path) {
        Ok(about) if about.is_dir() => {
            Err(FileError::creating(path, &io::Error::from(io::ErrorKind::IsADirectory)))
        }
        Ok(about) => kind(&about).filter(|kind| *kind != Kind::Device).map_or(Ok(()), |kind| {
            let shown = path.display();
            let what = format!(
                "`{shown}` is {kind}, and a file whose length is written last cannot go into one: name a file on a disk"
            );
            Err(FileError::new(FileErrorKind::CannotCreate, what))
        }),
        // Whatever is wrong, opening it says so.
        Err(_) => Ok(()),
    }
}

/// Locks a file. Of a disk or a share without locks nobody knows who else writes there; on Windows a lock would keep readers out as well.
fn refuse_what_is_written(file: &File, path: &Path) -> Result<(), FileError> {
    if !cfg!(unix) || !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        return Ok(());
    }
    let what = format!(
        "`{}` is written by another program at this moment: wait until that is done, or name another file",
        path.display()
    );
    Err(FileError::new(FileErrorKind::CannotCreate, what))
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
        self.is_whole()?;
        let written = self.file.write(bytes)?;
        if self.plain {
            self.at += written as u64;
            self.length = self.length.max(self.at);
        }
        Ok(written)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()?;
        self.is_whole()?;
        if self.plain { self.is_in_place() } else { Ok(()) }
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = self.file.seek(to)?;
        self.at = if self.plain { at } else { 0 };
        Ok(at)
    }
}

#[cfg(test)]
mod tests {
    use super::{OutputFile, check, write};
    use crate::io::error::{FileError, FileErrorKind};

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

    #[cfg(unix)]
    #[test]
    fn what_somebody_writes_is_left_to_them_until_they_are_done() {
        let path = std::env::temp_dir().join(format!("pacinian-lock-{}", std::process::id()));
        let mut first = OutputFile::create(&path).unwrap();
        std::io::Write::write_all(&mut first, b"first").unwrap();
        for refused in [OutputFile::create(&path).map(drop), check(&path), write(&path, b"second")] {
            let error = refused.unwrap_err();
            assert!(error.exit_code() == 73 && error.message.contains("another program"), "{error}");
        }
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        drop(first);
        check(&path).unwrap();
        write(&path, b"2nd").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"2nd");
        // Of what is no file on a disk there may be any number.
        let _two = [(); 2].map(|()| OutputFile::create("/dev/null").unwrap());
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn what_is_cut_short_meanwhile_takes_no_more() {
        use std::io::{Seek, SeekFrom, Write};
        let path = std::env::temp_dir().join(format!("pacinian-cut-{}", std::process::id()));
        let mut file = OutputFile::create(&path).unwrap();
        file.write_all(&[1; 100]).unwrap();
        file.seek(SeekFrom::Start(0)).unwrap();
        file.write_all(&[2; 10]).unwrap();
        file.seek(SeekFrom::Start(100)).unwrap();
        file.flush().unwrap();
        // More than was written is nobody's loss.
        let other = std::fs::File::options().write(true).open(&path).unwrap();
        other.set_len(101).unwrap();
        file.write_all(&[3; 2]).unwrap();
        other.set_len(101).unwrap();
        for result in [file.flush(), file.write_all(b"x")] {
            let error = FileError::writing(&path, &result.unwrap_err());
            assert!(error.exit_code() == 74 && error.message.contains("has been cut short"), "{error}");
        }
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 101);
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn what_is_elsewhere_in_the_end_is_told_of() {
        use std::io::Write;
        let path = std::env::temp_dir().join(format!("pacinian-moved-{}", std::process::id()));
        let other = path.with_extension("other");
        let mut file = OutputFile::create(&path).unwrap();
        file.write_all(b"first").unwrap();
        file.flush().unwrap();
        std::fs::rename(&path, &other).unwrap();
        // What it holds is not lost to whoever has moved it.
        file.write_all(b" and more").unwrap();
        let mut gone = || FileError::writing(&path, &file.flush().unwrap_err());
        assert!(gone().exit_code() == 74 && gone().message.contains("is gone"), "{}", gone());
        #[cfg(unix)]
        {
            std::fs::write(&path, b"another").unwrap();
            assert!(gone().message.contains("is gone"), "{}", gone());
            std::fs::remove_file(&path).unwrap();
        }
        assert_eq!(std::fs::read(&other).unwrap(), b"first and more");
        std::fs::remove_file(&other).unwrap();
    }

    #[test]
    fn looking_beforehand_changes_nothing() {
        let folder = std::env::temp_dir().join(format!("pacinian-out-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (there, new) = (folder.join("there"), folder.join("new"));
        std::fs::write(&there, b"abc").unwrap();
        check(&there).unwrap();
        check(&new).unwrap();
        assert_eq!(std::fs::read(&there).unwrap(), b"abc");
        assert!(!new.exists());
        assert_eq!(check(&folder).unwrap_err().exit_code(), 73);
        assert_eq!(check(folder.join("no/where")).unwrap_err().exit_code(), 73);
        #[cfg(unix)]
        {
            let link = folder.join("link");
            std::os::unix::fs::symlink("new", &link).unwrap();
            check(&link).unwrap();
            assert!(!new.exists() && link.is_symlink());
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
