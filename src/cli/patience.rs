//! A word where somebody does not answer.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// So long a sound system may take to open a device before something is said.
pub const LONG: Duration = Duration::from_secs(5);

/// What `ask` comes to; where that takes longer than `long`, `told` is called meanwhile.
pub fn answer<T>(long: Duration, told: impl FnOnce() + Send, ask: impl FnOnce() -> T) -> T {
    std::thread::scope(|scope| {
        let (answered, waits) = channel::<()>();
        let wait = move || {
            if waits.recv_timeout(long) == Err(RecvTimeoutError::Timeout) {
                told();
            }
        };
        // Without a thread for it, nothing is said.
        let waiting = std::thread::Builder::new().name("patience".into()).spawn_scoped(scope, wait);
        let answer = ask();
        drop(answered);
        drop(waiting);
        answer
    })
}

#[cfg(test)]
mod tests {
    use super::answer;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    #[test]
    fn only_who_takes_long_is_told_of() {
        let told = AtomicBool::new(false);
        let tell = || told.store(true, Ordering::SeqCst);
        assert_eq!(answer(Duration::from_secs(60), tell, || 1), 1);
        assert!(!told.load(Ordering::SeqCst));
        let waits = || {
            while !told.load(Ordering::SeqCst) {
                std::thread::yield_now();
            }
            2
        };
        assert_eq!(answer(Duration::from_millis(1), tell, waits), 2);
    }
}
