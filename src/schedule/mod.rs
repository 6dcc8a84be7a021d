//! The sample clock: instants, the queue of what is due, deadlines that change, and tasks that come back at exact intervals. It is the same for
//! synthesis, motor drives and knob, and knows nothing of what it schedules.

#![deny(clippy::disallowed_methods)]

mod deadlines;
mod instant;
mod queue;
mod task;

pub(crate) use deadlines::Deadlines;
pub use instant::Instant;
pub(crate) use queue::Queue;
pub use task::Beat;
