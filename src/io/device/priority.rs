//! Real-time priority for the thread that plays.

use std::sync::atomic::{AtomicU8, Ordering};

/// How it stands with the priority of the threads that play.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Priority {
    /// None has begun yet.
    Unknown,
    /// The last that began plays before all others.
    RealTime,
    /// The system refused; the last that began plays like any other thread.
    Refused,
}

static LATEST: AtomicU8 = AtomicU8::new(0);

/// What [`raise`] came to, the last time it was called.
pub fn latest() -> Priority {
    match LATEST.load(Ordering::Relaxed) {
        1 => Priority::RealTime,
        2 => Priority::Refused,
        _ => Priority::Unknown,
    }
}

/// SCHED_FIFO's priority: above what else people run in real time, below the kernel's own threads.
#[cfg(unix)]
const FIFO: u8 = if cfg!(target_vendor = "apple") { 47 } else { 60 };

/// That of threads which bring those what they play: a busy machine must not make events late, nor they a callback.
#[cfg(unix)]
const FEEDING: u8 = 40;

/// Asks the system to let this thread run before all others. It is called once by each thread that plays, before it first does.
pub fn raise() {
    LATEST.store(if rises() { 1 } else { 2 }, Ordering::Relaxed);
}

/// What a thread that a host's stream calls back in is to ask for. JACK gives its own what they are to have, below its server's, and so does macOS, which
/// has more than a number for them.
pub(super) fn of_host(host: &str) -> fn() {
    if cfg!(target_vendor = "apple") {
        return || LATEST.store(1, Ordering::Relaxed);
    }
    if host == "jack" { raise_unless_raised } else { raise }
}

/// As [`raise`], but of one that runs before others already, which is left as it is.
fn raise_unless_raised() {
    #[cfg(unix)]
    if is_real_time() {
        return LATEST.store(1, Ordering::Relaxed);
    }
    raise();
}

/// The same for a thread that only wants to know whether it may.
pub(super) fn rises() -> bool {
    #[cfg(unix)]
    return fifo(FIFO) || under(limit()).0.is_some_and(fifo);
    #[cfg(not(unix))]
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max).is_ok()
}

/// Asks the same for a thread that waits for events and sends them to those that play, which go before it. Where the system refuses it
/// has refused those, too, and that is told. One that runs before others already, as JACK's do, is left as it is.
pub fn raise_feeding() {
    #[cfg(unix)]
    if !is_real_time() {
        let _ = under(limit()).1.is_some_and(fifo);
    }
    #[cfg(windows)]
    let _ = thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Os(
        thread_priority::WinAPIThreadPriority::AboveNormal.into(),
    ));
}

/// What there is for a thread that plays and one that feeds it, where a system allows no more than so much: the latter waits for the former, and must never
/// keep it from running.
#[cfg(unix)]
fn under(limit: Option<u64>) -> (Option<u8>, Option<u8>) {
    match limit.and_then(|limit| u8::try_from(limit).ok()) {
        Some(limit @ 1..FIFO) => (Some(limit), Some(FEEDING.min(limit - 1)).filter(|left| *left > 0)),
        // A program that may have any has a limit of 0 as well, as a rule.
        _ => (Some(FIFO), Some(FEEDING)),
    }
}

/// The highest priority that the system allows this program, if it says.
#[cfg(unix)]
fn limit() -> Option<u64> {
    #[cfg(target_os = "linux")]
    return rustix::process::getrlimit(rustix::process::Resource::Rtprio).current;
    #[cfg(not(target_os = "linux"))]
    None
}

#[cfg(unix)]
fn is_real_time() -> bool {
    use thread_priority::{ThreadSchedulePolicy, thread_schedule_policy};
    #[cfg(target_os = "linux")]
    if let Some(policy) = policy() {
        return policy == FIRST_IN_FIRST_OUT || policy == ROUND_ROBIN;
    }
    matches!(thread_schedule_policy(), Ok(ThreadSchedulePolicy::Realtime(_)))
}

/// SCHED_FIFO and SCHED_RR.
#[cfg(target_os = "linux")]
const FIRST_IN_FIRST_OUT: u32 = 1;
#[cfg(target_os = "linux")]
const ROUND_ROBIN: u32 = 2;

/// By which policy this thread runs: field 41 of `/proc/thread-self/stat` (proc_pid_stat(5)). What the system's call gives has flags in it that a
/// library which compares does not know: PipeWire sets that children are not to inherit it.
#[cfg(target_os = "linux")]
fn policy() -> Option<u32> {
    use std::io::Read;
    let mut bytes = [0; 1024];
    let length = std::fs::File::open("/proc/thread-self/stat").ok()?.read(&mut bytes).ok()?;
    let text = std::str::from_utf8(bytes.get(..length)?).ok()?;
    // A name may have anything in it; behind its end stands field 3.
    text.rsplit_once(')')?.1.split_ascii_whitespace().nth(41 - 3)?.parse().ok()
}

/// Whether the system lets this thread run before others, those aside that have more.
#[cfg(unix)]
fn fifo(priority: u8) -> bool {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    ThreadPriorityValue::try_from(priority)
        .map(ThreadPriority::Crossplatform)
        .is_ok_and(|priority| set_thread_priority_and_policy(thread_native_id(), priority, fifo).is_ok())
}

#[cfg(all(test, unix))]
mod tests {
    use thread_priority::{ThreadPriority, get_current_thread_priority, thread_schedule_policy};

    use super::{FEEDING, FIFO, Priority, latest, limit, raise, raise_feeding, raise_unless_raised, under};

    #[test]
    fn where_there_is_less_what_plays_still_goes_before_what_feeds_it() {
        for most in 1..FIFO {
            let (plays, feeds) = under(Some(u64::from(most)));
            assert!(plays == Some(most) && feeds < plays && feeds != Some(0), "{most}: {plays:?} {feeds:?}");
        }
        for enough in [None, Some(0), Some(60), Some(99), Some(u64::MAX)] {
            assert_eq!(under(enough), (Some(FIFO), Some(FEEDING)));
        }
    }

    /// What a thread has after it asked; `None` where the system refused.
    fn after(ask: fn()) -> Option<ThreadPriority> {
        let asked = move || {
            let before = thread_schedule_policy().ok();
            ask();
            let raised = thread_schedule_policy().ok() != before;
            raised.then(|| get_current_thread_priority().ok()).flatten()
        };
        std::thread::spawn(asked).join().unwrap()
    }

    #[test]
    fn what_plays_goes_before_what_feeds_it_and_both_before_the_rest_or_it_is_told() {
        const { assert!(FEEDING < FIFO && FEEDING > 1) };
        let (plays, feeds) = (after(raise), after(raise_feeding));
        let refused = latest() == Priority::Refused;
        assert_eq!((plays.is_none(), feeds.is_none()), (refused, refused || limit() == Some(1)));
        if let (Some(plays), Some(feeds)) = (plays, feeds) {
            assert!(plays > feeds, "{plays:?} {feeds:?}");
            let both = || {
                raise();
                raise_feeding();
            };
            assert_eq!(after(both), Some(plays), "one that plays is not put back");
            let served = || {
                raise_feeding();
                raise_unless_raised();
            };
            assert_eq!(after(served), Some(feeds), "a server's is left where it is");
            assert_eq!(after(raise_unless_raised), Some(plays), "and one that it has not raised is raised");
        }
    }
}
