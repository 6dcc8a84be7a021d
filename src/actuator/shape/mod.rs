//! Drive shaping: what to do to the terminals of a motor so that it does what is wanted. All of it is open loop, and computed ahead
//! from the motor's parameters.

mod click;
mod course;
mod home;
mod inverse;
mod root;
mod spin;
mod switching;
pub(crate) mod trial;
mod unreachable;

pub use click::{Click, Clicked, Ending, starts};
pub use course::Course;
pub use home::{Home, Homed};
pub use inverse::{Inverse, Shaped};
pub use spin::Spin;
pub use switching::Switching;
pub use unreachable::Unreachable;
