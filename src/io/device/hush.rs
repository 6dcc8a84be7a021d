//! Silence for libraries that talk: what a device that is looked at cannot do is written to standard error, over a screen too.

/// From here on, this thread's calls to ALSA say what is wrong by their results alone. What they have said since this was called last
/// is forgotten.
pub(crate) fn hush() {
    // Where there is no memory for it, it talks.
    #[cfg(target_os = "linux")]
    let _ = alsa::Output::local_error_handler();
}

/// Does something while nothing is written to standard error: JACK's library, which ALSA's plug-in for it loads, cannot be told to say
/// nothing. Only for a moment, and before there is anything else to say.
pub(super) fn quietly<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{Mode, OFlags, open};
        use rustix::stdio::{dup2_stderr, stderr};
        let nothing = open("/dev/null", OFlags::WRONLY | OFlags::CLOEXEC, Mode::empty());
        if let (Ok(nothing), Ok(kept)) = (nothing, rustix::io::fcntl_dupfd_cloexec(stderr(), 3))
            && dup2_stderr(&nothing).is_ok()
        {
            let done = work();
            // What was there was open.
            let _ = dup2_stderr(&kept);
            return done;
        }
    }
    work()
}
