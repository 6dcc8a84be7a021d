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
const FIFO: u8 = 60;

/// Asks the system to let this thread run before all others. It is called once by each thread that plays, before it first does.
pub fn raise() {
    use thread_priority::ThreadPriority;
    #[cfg(unix)]
    let raised = {
        use thread_priority::{
            RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
            thread_native_id,
        };
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let priority =
            thread_priority::ThreadPriorityValue::try_from(FIFO).map(ThreadPriority::Crossplatform);
        priority
            .is_ok_and(|priority| set_thread_priority_and_policy(thread_native_id(), priority, fifo).is_ok())
    };
    #[cfg(not(unix))]
    let raised = thread_priority::set_current_thread_priority(ThreadPriority::Max).is_ok();
    LATEST.store(if raised { 1 } else { 2 }, Ordering::Relaxed);
}
