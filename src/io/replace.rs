//! Another content for a file that is there: all of it or nothing.

use super::error::{FileError, FileErrorKind};
use super::text;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Puts `after` in place of `before` into the file at `path`, by renaming a new file over it, so that nobody ever finds half of it and
/// a full disk leaves it as it was. Rights and owner stay; a symbolic link is followed; what has a second hard link keeps the old
/// content under that name. `before` is what was read of it.
///
/// # Errors
/// When something else stands in it by now, when it may not be written, and when the new file cannot be made, given to whoever has the old
/// one, written or renamed.
pub fn replace(path: impl AsRef<Path>, before: &[u8], after: &[u8]) -> Result<(), FileError> {
    let path = path.as_ref();
    let (real, near, mut file) = beside(path)?;
    let written = file.write_all(after).and_then(|()| file.sync_all());
    let swapped = written.map_err(|error| FileError::writing(path, &error)).and_then(|()| {
        if text::read(&real)? != before {
            let what = format!(
                "`{}` was written by somebody else meanwhile, so it was left alone: do it again",
                path.display()
            );
            return Err(FileError::new(FileErrorKind::Io, what));
        }
        fs::rename(&near, &real).map_err(|error| FileError::creating(path, &error))
    });
    if swapped.is_err() {
        // It is of no use any more; what is wrong has been found.
        let _ = fs::remove_file(&near);
    }
    swapped
}

/// Whether [`replace`] could put something into a file, as far as can be known beforehand.
///
/// # Errors
/// As [`replace`].
pub fn check(path: impl AsRef<Path>) -> Result<(), FileError> {
    let path = path.as_ref();
    let (_, near, _) = beside(path)?;
    fs::remove_file(near).map_err(|error| FileError::creating(path, &error))
}

/// The file itself, and a new one beside it with its rights and its owner.
fn beside(path: &Path) -> Result<(PathBuf, PathBuf, File), FileError> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let real = path.canonicalize().map_err(|error| FileError::reading(path, &error))?;
    let about = fs::metadata(&real).map_err(|error| FileError::reading(path, &error))?;
    if !about.is_file() {
        // One that opens a pipe waits for whoever reads it.
        let what = format!("`{}` is no file, so nothing can be written into it: name a file", path.display());
        return Err(FileError::new(FileErrorKind::CannotCreate, what));
    }
    // Renaming asks the folder alone.
    File::options().write(true).open(&real).map_err(|error| FileError::creating(path, &error))?;
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let near = real.with_file_name(format!(".pacinian-{}-{number}", std::process::id()));
    let refused = |why: String, error: &std::io::Error| {
        let message =
            format!("`{}` is changed by a new file in its place, and {why} ({error})", path.display());
        FileError { message, ..FileError::creating(path, error) }
    };
    let file = File::options().write(true).create_new(true).open(&near).map_err(|error| {
        let folder = real.parent().unwrap_or(Path::new("")).display();
        refused(format!("none can be made in `{folder}`: allow it, or change it by hand"), &error)
    })?;
    let made = own(&file, &about)
        .map_err(|error| {
            refused("that cannot be its owner's: take it over, or change it by hand".into(), &error)
        })
        .and_then(|()| {
            let rights = file.set_permissions(about.permissions());
            rights.map_err(|error| refused("that cannot have its rights".into(), &error))
        });
    match made {
        Ok(()) => Ok((real, near, file)),
        Err(error) => {
            // What cannot take its place is of no use.
            let _ = fs::remove_file(&near);
            Err(error)
        }
    }
}

/// Gives a new file to whoever has the old one.
#[cfg(unix)]
fn own(file: &File, like: &fs::Metadata) -> std::io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let now = file.metadata()?;
    let other = |now: u32, then: u32| (now != then).then_some(then);
    match (other(now.uid(), like.uid()), other(now.gid(), like.gid())) {
        (None, None) => Ok(()),
        (user, group) => fchown(file, user, group),
    }
}

#[cfg(not(unix))]
fn own(_: &File, _: &fs::Metadata) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{check, replace};
    use std::fs;

    #[test]
    fn all_or_nothing() {
        let folder = std::env::temp_dir().join(format!("pacinian-replace-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("a");
        fs::write(&file, "one").unwrap();
        replace(&file, b"one", b"two").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"two");
        let error = replace(&file, b"one", b"three").unwrap_err();
        assert!(error.exit_code() == 74 && error.message.contains("somebody else"), "{error}");
        assert_eq!(fs::read(&file).unwrap(), b"two");
        assert_eq!(replace(folder.join("none"), b"", b"x").unwrap_err().exit_code(), 66);
        check(&file).unwrap();
        assert_eq!(check(&folder).unwrap_err().exit_code(), 73, "a folder");
        // As long as a name may be.
        let long = folder.join("x".repeat(255));
        fs::write(&long, "one").unwrap();
        replace(&long, b"one", b"two").unwrap();
        assert_eq!(fs::read(&long).unwrap(), b"two");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
            let link = folder.join("link");
            std::os::unix::fs::symlink("a", &link).unwrap();
            replace(&link, b"two", b"four").unwrap();
            assert!(link.is_symlink() && fs::read(&file).unwrap() == b"four");
            assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
            let owned = |file: &std::path::Path| {
                use std::os::unix::fs::MetadataExt;
                let about = fs::metadata(file).unwrap();
                (about.uid(), about.gid())
            };
            // Only root can give files away, and only root writes what nobody may.
            if std::os::unix::fs::chown(&file, Some(1234), Some(4321)).is_ok() {
                replace(&file, b"four", b"five").unwrap();
                assert_eq!(owned(&file), (1234, 4321));
            } else {
                fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).unwrap();
                let error = replace(&file, b"four", b"five").unwrap_err();
                assert_eq!((error.exit_code(), fs::read(&file).unwrap()), (77, b"four".to_vec()), "{error}");
            }
        }
        assert_eq!(
            fs::read_dir(&folder)
                .unwrap()
                .filter(|f| f.as_ref().unwrap().file_name().to_string_lossy().starts_with('.'))
                .count(),
            0
        );
        fs::remove_dir_all(&folder).unwrap();
    }
}
