//! Silence for a library that talks: ALSA writes to standard error whatever a device that is looked at cannot do, over a screen too.

/// From here on, this thread's calls to ALSA say what is wrong by their results alone. What they have said since this was called last
/// is forgotten.
pub(crate) fn hush() {
    // Where there is no memory for it, it talks.
    #[cfg(target_os = "linux")]
    let _ = alsa::Output::local_error_handler();
}
