//! The sample clock: instants, the queue of what is due, deadlines that change, and tasks that come back at exact intervals. It is the same for
//! synthesis, motor drives and knob, and knows nothing of what it schedules.

pub mod deadlines;
pub mod instant;
pub mod queue;
pub mod task;

pub use deadlines::Deadlines;
pub use instant::Instant;
pub use queue::{Entry, Queue};
pub use task::Beat;
