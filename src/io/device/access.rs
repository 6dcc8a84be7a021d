//! Whether this user may use the sound cards at all.

/// What helps where [`forbidden`] says so.
pub const HELP: &str = "sudo usermod -aG audio $USER; log in again";

/// Whether there is hardware of sound that the system does not let this user open. ALSA then lists none of it.
#[cfg(target_os = "linux")]
pub fn forbidden() -> bool {
    is_kept_from(std::path::Path::new("/dev/snd"))
}

/// Whether a folder may not be looked into, or what controls a card in it not be opened. What plays and hears is left alone: a card that another program has
/// would be waited for, and one that none has would be taken from others.
#[cfg(target_os = "linux")]
fn is_kept_from(folder: &std::path::Path) -> bool {
    use std::os::unix::fs::OpenOptionsExt;
    let denied = |error: std::io::Error| error.kind() == std::io::ErrorKind::PermissionDenied;
    let at_once = rustix::fs::OFlags::NONBLOCK.bits() as i32;
    let refused = |path: &std::path::Path| {
        std::fs::OpenOptions::new().read(true).custom_flags(at_once).open(path).is_err_and(denied)
    };
    let controls = |entry: &std::fs::DirEntry| entry.file_name().to_string_lossy().starts_with("control");
    match std::fs::read_dir(folder) {
        Ok(entries) => entries.flatten().filter(controls).any(|entry| refused(&entry.path())),
        Err(error) => denied(error),
    }
}

/// Other systems list what they do not let one open.
#[cfg(not(target_os = "linux"))]
pub fn forbidden() -> bool {
    false
}

#[cfg(all(test, target_os = "linux", target_arch = "x86_64"))]
mod tests {
    use super::is_kept_from;
    use std::fs::{self, Permissions};
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn what_the_system_refuses_to_this_user_is_noticed() {
        let folder = std::env::temp_dir().join(format!("pacinian-access-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("controlC0"), "").unwrap();
        let mode =
            |path: &std::path::Path, mode| fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
        // What root may is nothing to go by: the thread that looks is nobody's.
        let looked = || {
            let folder = folder.clone();
            let look = move || {
                // SAFETY: it concerns this thread's access to files alone, and the thread ends with it.
                unsafe { libc::setfsuid(65_534) };
                is_kept_from(&folder)
            };
            std::thread::spawn(look).join().unwrap()
        };
        mode(&folder, 0o755);
        mode(&folder.join("controlC0"), 0o644);
        // What keeps whoever opens it waiting, as a card does that another program plays on.
        for name in ["pcmC0D0p", "controlC1"] {
            assert!(std::process::Command::new("mkfifo").arg(folder.join(name)).status().unwrap().success());
        }
        assert!(!looked());
        mode(&folder.join("controlC0"), 0o000);
        assert!(looked(), "a card that may not be opened");
        mode(&folder.join("controlC0"), 0o644);
        mode(&folder, 0o000);
        assert!(looked(), "cards that may not be listed");
        mode(&folder, 0o755);
        fs::remove_dir_all(&folder).unwrap();
        assert!(!looked(), "no cards");
    }
}
