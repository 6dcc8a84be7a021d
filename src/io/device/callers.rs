//! Threads of a client library by which a stream calls back. JACK's library ends its own where they stand once their client is closed: one that is
//! still in a callback then, and were it on its way back out of it, takes the whole program with it. While the server lives, it waits for them; of one
//! that has died it does not, so that this does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

/// How many are remembered: the one that plays, and the one that brings news.
const MOST: usize = 4;

/// The threads that have called back, as long as somebody needs to know.
#[derive(Clone, Default)]
pub(super) struct Callers {
    /// As the system numbers them; 0 is none.
    threads: Arc<[AtomicI32; MOST]>,
    /// Whether one has said that its server is gone.
    lost: Arc<AtomicBool>,
}

impl Callers {
    /// This thread is one of them. It is to be said once by the one that plays, as it asks the system.
    pub fn calls(&self) {
        let own = own();
        let free = |slot: &&AtomicI32| {
            let before = slot.compare_exchange(0, own, Ordering::AcqRel, Ordering::Acquire);
            before.is_ok() || before == Err(own)
        };
        self.threads.iter().find(free);
    }

    /// This thread is one of them, and says that the server is gone.
    pub fn lose(&self) {
        self.calls();
        self.lost.store(true, Ordering::Release);
    }

    /// Waits until none is in a callback any more, if the server is gone: each has ended, or sleeps as only the library lets it. Says whether
    /// that is so; nobody waits for longer than half a second for each.
    pub fn rest(&self) -> bool {
        !self.lost.load(Ordering::Acquire)
            || self.threads.iter().map(|slot| slot.load(Ordering::Acquire)).all(rests)
    }
}

#[cfg(target_os = "linux")]
fn own() -> i32 {
    rustix::thread::gettid().as_raw_nonzero().get()
}

#[cfg(target_os = "linux")]
fn rests(thread: i32) -> bool {
    use std::time::Duration;
    const LOOK: Duration = Duration::from_millis(1);
    /// A callback may wait for a lock, though not for so many looks.
    const ASLEEP: u32 = 20;
    const LOOKS: u32 = 500;
    let mut asleep = 0;
    for _ in 0..LOOKS {
        match state(thread) {
            _ if thread == 0 || thread == own() => return true,
            None => return true,
            Some('S') => asleep += 1,
            Some(_) => asleep = 0,
        }
        if asleep == ASLEEP {
            return true;
        }
        std::thread::sleep(LOOK);
    }
    false
}

/// What a thread of this program does, as proc(5) has it; `None` of one that has ended.
#[cfg(target_os = "linux")]
fn state(thread: i32) -> Option<char> {
    let stat = std::fs::read_to_string(format!("/proc/self/task/{thread}/stat")).ok()?;
    // A name in brackets stands in front of it, in which anything may be.
    stat.rsplit_once(')')?.1.trim_start().chars().next().filter(|state| !matches!(state, 'Z' | 'X'))
}

#[cfg(not(target_os = "linux"))]
fn own() -> i32 {
    1
}

/// Nobody says what a thread does: it is given time.
#[cfg(not(target_os = "linux"))]
fn rests(thread: i32) -> bool {
    if thread != 0 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    true
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::Callers;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    /// A thread that calls, says so, does something, and ends.
    fn caller(callers: &Callers, does: impl FnOnce() + Send + 'static) -> std::thread::JoinHandle<()> {
        let (tell, told) = channel();
        let own = callers.clone();
        let thread = std::thread::spawn(move || {
            own.lose();
            tell.send(()).unwrap();
            does();
        });
        told.recv().unwrap();
        thread
    }

    fn work(until: impl Fn(Duration) -> bool) {
        let begin = Instant::now();
        while !until(begin.elapsed()) {
            std::hint::spin_loop();
        }
    }

    #[test]
    fn one_that_is_still_in_its_callback_is_waited_for() {
        let callers = Callers::default();
        let done = Arc::new(AtomicBool::new(false));
        let does = Arc::clone(&done);
        let thread = caller(&callers, move || {
            work(|time| time > Duration::from_millis(60));
            does.store(true, Ordering::Release);
        });
        let rests = callers.rest();
        assert!(rests && done.load(Ordering::Acquire));
        thread.join().unwrap();
    }

    #[test]
    fn one_that_sleeps_is_not_in_a_callback() {
        let callers = Callers::default();
        let (wake, sleeps) = channel::<()>();
        let thread = caller(&callers, move || {
            let _ = sleeps.recv();
        });
        assert!(callers.rest());
        drop(wake);
        thread.join().unwrap();
    }

    #[test]
    fn one_that_never_comes_back_holds_up_nobody() {
        let callers = Callers::default();
        let over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&over);
        let thread = caller(&callers, move || work(|_| until.load(Ordering::Acquire)));
        assert!(!callers.rest());
        over.store(true, Ordering::Release);
        thread.join().unwrap();
        assert!(callers.rest(), "it has ended");
    }

    #[test]
    fn while_the_server_lives_nobody_waits() {
        let callers = Callers::default();
        callers.calls();
        let over = Arc::new(AtomicBool::new(false));
        let (until, own, (tell, told)) = (Arc::clone(&over), callers.clone(), channel());
        let thread = std::thread::spawn(move || {
            own.calls();
            tell.send(()).unwrap();
            work(|_| until.load(Ordering::Acquire));
        });
        told.recv().unwrap();
        assert!(callers.rest(), "one that works on is not waited for");
        over.store(true, Ordering::Release);
        thread.join().unwrap();
    }
}
