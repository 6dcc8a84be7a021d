//! Where a sampled spring and damper begin to oscillate.
//!
//! A computer reads the knob's angle every T, and holds its torque over T after a delay. Both take energy from nowhere, so that
//! above some stiffness the knob swings by itself. [`sampled::Loop`] is that loop without an approximation: the plant's exact
//! zero-order hold, whole and fractional delay, damping computed from a finite difference, a reconstruction low-pass, the
//! resonance of a shaft. [`edge`] finds the stiffness at which its first eigenvalue reaches the unit circle; [`roots`] finds all
//! its eigenvalues. [`rules`] holds the closed forms of the literature, each of which is a corner of the exact answer.

pub mod edge;
pub mod roots;
pub mod rules;
pub mod sampled;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod work;
