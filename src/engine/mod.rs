//! The run-time: runs a plan. It knows no files, no devices and no formats.

pub mod bank;
pub mod core;
pub mod event;
pub mod mixer;
pub mod workspace;
