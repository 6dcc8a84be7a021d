//! An angle out of a sound card's inputs.
//!
//! | sense | what comes in | what it takes |
//! |---|---|---|
//! | [`resolver`] | sine and cosine of the angle | inputs that let steady voltages through |
//! | [`quadrature`] | the two lines of an encoder | the same, and less than an edge a frame |
//! | [`linear`] | a voltage that grows with the angle | the same |
//!
//! A [`decoder`] makes a reading for each tick of the servo out of the frames since the last: `None` where the angle is lost, and whoever asks
//! lets torque fall then. None allocates, panics or calls the platform's `sin` once it is made. [`turn`] is the angle of a pair.

pub mod decoder;
pub mod linear;
pub mod quadrature;
pub mod resolver;
#[cfg(test)]
mod tests;
pub mod turn;
