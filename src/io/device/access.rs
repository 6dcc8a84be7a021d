//! Whether this user may use the sound cards at all.

/// What helps where [`forbidden`] says so.
pub const HELP: &str = "sudo usermod -aG audio $USER; log in again";

/// Whether there is hardware of sound that the system does not let this user open. ALSA then lists none of it.
#[cfg(target_os = "linux")]
pub fn forbidden() -> bool {
    let refused = |path: &std::path::Path| {
        let opened = std::fs::OpenOptions::new().read(true).open(path);
        opened.is_err_and(|error| error.kind() == std::io::ErrorKind::PermissionDenied)
    };
    let cards = std::fs::read_dir("/dev/snd").into_iter().flatten();
    cards.flatten().any(|entry| refused(&entry.path()))
}

/// Other systems list what they do not let one open.
#[cfg(not(target_os = "linux"))]
pub fn forbidden() -> bool {
    false
}
