//! Taking leave of a thread.

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Waits for a thread that was told to end, `most` at most: one that waits for a system that does not answer ends by itself when that does. Says
/// whether it has ended.
pub fn part_with(thread: JoinHandle<()>, most: Duration) -> bool {
    let begin = Instant::now();
    while !thread.is_finished() {
        if begin.elapsed() >= most {
            return false;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    // One that has panicked has nothing more to say.
    let _ = thread.join();
    true
}

#[cfg(test)]
mod tests {
    use super::part_with;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    #[test]
    fn one_that_does_not_end_is_left() {
        let (answer, waits) = channel::<()>();
        let thread = std::thread::spawn(move || _ = waits.recv());
        assert!(!part_with(thread, Duration::from_millis(20)));
        let thread = std::thread::spawn(move || drop(answer));
        assert!(part_with(thread, Duration::from_secs(100)));
    }
}
