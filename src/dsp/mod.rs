//! Blocks that several rooms share.

pub mod corner;
pub mod isa;
pub mod lanes;
pub mod phase;
pub mod quadrature;
pub mod random;
pub mod sine;
pub mod wavetable;
