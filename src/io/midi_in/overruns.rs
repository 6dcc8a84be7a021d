//! What ALSA's sequencer has lost since more came than was fetched: the library that reads it says so in its log, and nowhere else.

use std::sync::atomic::{AtomicU64, Ordering};

use log::{LevelFilter, Log, Metadata, Record};

/// A log that counts them and keeps nothing.
struct Overruns;

static COUNT: AtomicU64 = AtomicU64::new(0);

impl Log for Overruns {
    fn enabled(&self, about: &Metadata<'_>) -> bool {
        about.target().starts_with("midir")
    }

    fn log(&self, record: &Record<'_>) {
        let is_one = self.enabled(record.metadata()) && record.args().to_string().contains("overrun");
        COUNT.fetch_add(u64::from(is_one), Ordering::Relaxed);
    }

    fn flush(&self) {}
}

/// From now on they are counted, as gaps of MIDI, by whatever session listens. It takes the place of the process's log, so it is for programs that have
/// none. Says whether there was none.
pub fn count_overruns() -> bool {
    let first = log::set_logger(&Overruns).is_ok();
    if first {
        log::set_max_level(LevelFilter::Error);
    }
    first
}

/// Those since this was asked last.
pub(super) fn taken() -> u64 {
    COUNT.swap(0, Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::{count_overruns, taken};

    #[test]
    fn what_the_library_says_of_lost_messages_is_counted() {
        assert!(count_overruns() && !count_overruns());
        let target = "midir::backend::alsa";
        log::error!(target: target, "Error in handle_input: ALSA MIDI input buffer overrun!");
        log::error!(target: target, "Error in handle_input: no input event from ALSA MIDI input buffer!");
        log::error!("somebody else's buffer overrun");
        assert_eq!((taken(), taken()), (1, 0));
    }
}
