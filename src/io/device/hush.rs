//! Silence for libraries that talk: what a device that is looked at cannot do is written to standard error, over a screen too.

/// From here on, this thread's calls to ALSA say what is wrong by their results alone. What they have said since this was called last
/// is forgotten.
pub(crate) fn hush() {
    // Where there is no memory for it, it talks.
    #[cfg(target_os = "linux")]
    let _ = alsa::Output::local_error_handler();
}

/// The same of JACK's library, on every thread; whether there is one.
///
/// # Errors
/// Why it cannot be loaded.
#[cfg(all(feature = "midi-jack", target_os = "linux"))]
pub(crate) fn hush_jack() -> Result<(), String> {
    use jack::{Client, ClientOptions, Error};
    static MISSING: std::sync::OnceLock<Option<String>> = std::sync::OnceLock::new();
    // A client, whether there is a server or not, has it talk to the log, which nobody reads.
    let missing = MISSING.get_or_init(|| {
        let _turn = super::jack_turn::turn();
        match Client::new("pacinian_hush", ClientOptions::NO_START_SERVER) {
            Err(Error::LibraryError(why)) => Some(why),
            _ => None,
        }
    });
    missing.clone().map_or(Ok(()), Err)
}

/// What standard error was, while nothing is written to it.
#[cfg(target_os = "linux")]
static QUIET: std::sync::Mutex<Option<rustix::fd::OwnedFd>> = std::sync::Mutex::new(None);

/// Lets standard error be what it is, whatever a device that does not answer is still being asked; its library may talk then.
pub fn aloud() {
    #[cfg(target_os = "linux")]
    if let Some(kept) = QUIET.lock().ok().and_then(|mut quiet| quiet.take()) {
        // What was there was open.
        let _ = rustix::stdio::dup2_stderr(&kept);
    }
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
            && let Ok(mut quiet) = QUIET.lock()
            && quiet.is_none()
            && dup2_stderr(&nothing).is_ok()
        {
            *quiet = Some(kept);
            drop(quiet);
            let done = work();
            aloud();
            return done;
        }
    }
    work()
}
