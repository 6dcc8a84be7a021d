//! Blocks that several rooms share.

pub mod biquad;
pub mod elliptic;
pub mod interpolator;
pub mod isa;
pub mod lanes;
pub mod phase;
pub mod sine;
