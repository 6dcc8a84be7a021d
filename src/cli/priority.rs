//! What is said where threads that play do not go before all others.

use pacinian::io::device::priority::{Priority, latest};

/// In words, once something has played and the system has refused it.
pub fn told() -> Option<&'static str> {
    let why = "the system gives no real-time priority, so gaps are likelier; `pacinian devices` says how to allow it";
    (latest() == Priority::Refused).then_some(why)
}
