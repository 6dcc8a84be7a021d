//! Blocks that several rooms share.

pub mod lanes;
pub mod phase;
pub mod random;
pub mod sine;
