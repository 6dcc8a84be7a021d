//! Blocks that several rooms share.

pub mod corner;
pub mod lanes;
pub mod phase;
pub mod sine;
