//! How long it takes from an output through a cable, or an actuator and an accelerometer, back to an input.
//!
//! A short sweep goes out again and again, and is looked for in what comes in. Both streams are numbered in frames; what binds the
//! two are the moments at which, by what the system says of its buffers, a frame is played and another was heard. So the latency is
//! what lies between these two moments: converters, cable, actuator, and whatever of its buffers the system conceals.

pub mod echo;
pub mod figures;
pub mod line;
pub mod measure;
pub mod probe;
