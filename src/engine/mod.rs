//! The run-time.

pub mod vibration;
