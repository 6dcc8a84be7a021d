//! Blocks that several rooms share.

#![deny(clippy::disallowed_methods)]

pub mod biquad;
pub(crate) mod blocker;
pub mod complex;
pub(crate) mod corner;
pub(crate) mod elementary;
pub(crate) mod elliptic;
pub(crate) mod fade;
pub(crate) mod fractional;
pub(crate) mod interleaved;
pub(crate) mod interpolator;
pub mod isa;
pub mod lanes;
pub(crate) mod phase;
pub(crate) mod quadrature;
pub(crate) mod random;
pub(crate) mod recording;
pub(crate) mod sinc;
pub(crate) mod sine;
pub(crate) mod steady;
pub(crate) mod student;
pub(crate) mod svf;
#[cfg(feature = "live")]
pub(crate) mod varispeed;
pub(crate) mod wavetable;
