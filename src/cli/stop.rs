//! Ctrl-C and its kin: the first asks to come to an end. Only who insists ends the program at once: a signal often comes twice (from the
//! system and a shell, or from whoever passes it on), and what plays must still fade, motors be braked and files be finished then.

use super::failure::Failure;
use super::guard;
use signal_hook::consts::signal::{SIGINT, SIGTERM};
use signal_hook::flag;
#[cfg(unix)]
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
#[cfg(unix)]
use std::time::{Duration, Instant};

#[cfg(unix)]
use signal_hook::consts::signal::{SIGHUP, SIGQUIT};

/// Those that ask. Whoever has begun the program with `nohup`, which leaves it no terminal to write to, wants it to outlive the terminal. What is shown on
/// one ends with it, whatever whoever began it ignores.
#[cfg(unix)]
fn signals() -> &'static [i32] {
    static OUTLIVES: std::sync::OnceLock<bool> = std::sync::OnceLock::new();
    const ALL: [i32; 4] = [SIGINT, SIGTERM, SIGQUIT, SIGHUP];
    let status = || std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let shown = || std::io::stdout().is_terminal() || std::io::stderr().is_terminal();
    match OUTLIVES.get_or_init(|| !shown() && ignores(&status(), SIGHUP)) {
        true => &ALL[..3],
        false => &ALL,
    }
}
#[cfg(not(unix))]
fn signals() -> &'static [i32] {
    &[SIGINT, SIGTERM]
}

/// Whether a process ignores a signal, as Linux tells of it (proc_pid_status(5)).
#[cfg(unix)]
fn ignores(status: &str, signal: i32) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}

fn unheard(error: &std::io::Error) -> Failure {
    Failure::said(71, format!("Ctrl-C cannot be listened to ({error})"))
}

/// From now on, a file that may not grow any further (`ulimit -f`) is an error of that file and no end of the program: what plays is to fade, and
/// other files are to be finished.
pub fn outlive_large_files() {
    // Where it cannot be, the system has the last word.
    #[cfg(unix)]
    let _ = flag::register(signal_hook::consts::signal::SIGXFSZ, Arc::default());
}

/// The exit code of Ctrl-C,
pub const INTERRUPTED: u8 = 130;

/// and where the terminal was closed, as that of SIGHUP.
pub const CLOSED: u8 = 129;

/// Whether somebody has asked to stop.
#[derive(Debug, Clone, Default)]
pub struct Stop {
    signal: Arc<AtomicUsize>,
    /// Whether it listens: then a thread that has panicked counts as well.
    listens: bool,
}

/// From so long after the first on, any signal means at once.
#[cfg(unix)]
const PATIENCE: Duration = Duration::from_secs(1);

/// So long the terminal has to be given back where the program ends at once.
#[cfg(unix)]
const LAST: Duration = Duration::from_millis(100);

impl Stop {
    /// Listens from now on.
    ///
    /// # Errors
    /// When the system does not let the program listen.
    pub fn listen() -> Result<Self, Failure> {
        let stop = Self { listens: true, ..Self::default() };
        stop.begin().map_err(|error| unheard(&error))?;
        Ok(stop)
    }

    /// Sets a flag at the moment at which somebody asks.
    ///
    /// # Errors
    /// As [`Stop::listen`].
    pub fn also(&self, set: &Arc<AtomicBool>) -> Result<(), Failure> {
        for signal in signals() {
            flag::register(*signal, Arc::clone(set)).map_err(|error| unheard(&error))?;
        }
        // Somebody may have been faster.
        if self.asked().is_some() {
            set.store(true, Ordering::Release);
        }
        Ok(())
    }

    #[cfg(unix)]
    fn begin(&self) -> std::io::Result<()> {
        let mut signals = signal_hook::iterator::Signals::new(signals())?;
        let first = Arc::clone(&self.signal);
        // It waits for as long as the program runs, and acts where all others are stuck.
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            let mut insistence = Insistence::default();
            for signal in signals.forever() {
                let _ = first.compare_exchange(0, signal as usize, Ordering::Relaxed, Ordering::Relaxed);
                if insistence.means_at_once(Instant::now()) {
                    at_once(128 + signal);
                }
            }
        })?;
        Ok(())
    }

    #[cfg(not(unix))]
    fn begin(&self) -> std::io::Result<()> {
        let again = Arc::new(AtomicBool::new(false));
        // In this order: the second Ctrl-C ends the program before it is noted as the first.
        flag::register_conditional_shutdown(SIGINT, 128 + SIGINT, Arc::clone(&again))?;
        flag::register(SIGINT, again)?;
        for signal in signals() {
            flag::register_usize(*signal, Arc::clone(&self.signal), *signal as usize)?;
        }
        Ok(())
    }

    /// The exit code to end with, if somebody has asked: 129 for SIGHUP, 130 for Ctrl-C, 131 for SIGQUIT, 143 for SIGTERM; [`guard::BUG`] where a
    /// thread has panicked, without which nothing is worth going on with.
    pub fn asked(&self) -> Option<u8> {
        if self.listens && guard::has_panicked() {
            return Some(guard::BUG);
        }
        match self.signal.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(u8::try_from(128 + signal).unwrap_or(INTERRUPTED)),
        }
    }
}

/// Who has asked before.
#[cfg(unix)]
#[derive(Debug, Default)]
struct Insistence {
    first: Option<Instant>,
}

#[cfg(unix)]
impl Insistence {
    /// Whether a signal that comes now says that the program is to end at once: any some time after the first.
    fn means_at_once(&mut self, now: Instant) -> bool {
        let first = *self.first.get_or_insert(now);
        now.saturating_duration_since(first) >= PATIENCE
    }
}

/// Ends the program without waiting for anything but the terminal, and for that not long: it may be what everybody waits for.
#[cfg(unix)]
fn at_once(code: i32) {
    let giving = std::thread::Builder::new().spawn(super::screen::tty::give_back);
    let until = Instant::now() + LAST;
    while giving.as_ref().is_ok_and(|thread| !thread.is_finished()) && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(1));
    }
    signal_hook::low_level::exit(code);
}

#[cfg(all(test, unix))]
mod tests {
    use super::{Insistence, SIGHUP, SIGINT, ignores};
    use std::time::{Duration, Instant};

    /// Which of the signals at so many milliseconds is the first that means at once.
    fn at_once(signals: &[u64]) -> Option<usize> {
        let (begin, mut insistence) = (Instant::now(), Insistence::default());
        signals.iter().position(|ms| insistence.means_at_once(begin + Duration::from_millis(*ms)))
    }

    #[test]
    fn what_nohup_has_done_is_seen() {
        let status =
            "Name:\tx\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\nSigCgt:\t00000001800004ec\n";
        assert!(ignores(status, SIGHUP) && !ignores(status, SIGINT));
        assert!(!ignores("", SIGHUP) && !ignores("SigIgn:\tnone", SIGHUP));
    }

    #[test]
    fn only_who_insists_ends_it_at_once() {
        assert_eq!(at_once(&[5000]), None);
        assert_eq!(at_once(&[0, 1000]), Some(1));
        // As when a terminal is closed, or a signal passed on, and whoever did so says it again.
        assert_eq!(at_once(&[0, 0, 1, 20, 999]), None);
        assert_eq!(at_once(&[0, 0, 1, 1001]), Some(3));
    }
}
