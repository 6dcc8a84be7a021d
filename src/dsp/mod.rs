//! Blocks that several rooms share.

pub mod biquad;
pub mod corner;
pub mod elementary;
pub mod elliptic;
pub mod fade;
pub mod fractional;
pub mod interleaved;
pub mod interpolator;
pub mod isa;
pub mod lanes;
pub mod phase;
pub mod quadrature;
pub mod random;
pub mod recording;
pub mod sine;
pub mod svf;
pub mod wavetable;
