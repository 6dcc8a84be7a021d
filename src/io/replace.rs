//! Another content for a file that is there: all of it or nothing.

use super::error::{FileError, FileErrorKind};
use super::text;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

/// Puts `after` in place of `before` into the file at `path`, by renaming a new file over it, so that nobody ever finds half of it and
/// a full disk leaves it as it was. Rights and owner stay; a symbolic link is followed; what has a second hard link keeps the old
/// content under that name. `before` is what was read of it.
///
/// # Errors
/// When something else stands in it by now, when it may not be written, and when the new file cannot be made, given to whoever has the old
/// one, written or renamed.
pub fn replace(path: impl AsRef<Path>, before: &[u8], after: &[u8]) -> Result<(), FileError> {
    let path = path.as_ref();
    let real = path.canonicalize().map_err(|error| FileError::reading(path, &error))?;
    let about = fs::metadata(&real).map_err(|error| FileError::reading(path, &error))?;
    // Renaming asks the folder alone.
    File::options().write(true).open(&real).map_err(|error| FileError::creating(path, &error))?;
    let name = real.file_name().unwrap_or_default().to_string_lossy();
    let near = real.with_file_name(format!(".{name}.{}", std::process::id()));
    let written = (|| {
        let mut file = File::options().write(true).create_new(true).open(&near)?;
        own(&file, &about)?;
        file.set_permissions(about.permissions())?;
        file.write_all(after)?;
        file.sync_all()
    })();
    let swapped = written.map_err(|error| FileError::creating(path, &error)).and_then(|()| {
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
        // Where nothing was made there is nothing to take away.
        let _ = fs::remove_file(&near);
    }
    swapped
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
    use super::replace;
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
