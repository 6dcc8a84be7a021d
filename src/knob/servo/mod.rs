//! A tick of force feedback, from an angle to a torque.
//!
//! | file | holds |
//! |---|---|
//! | [`setup`] | what a servo is made of |
//! | [`tick`] | the servo: speed, governor, effects, what a slow thread sent, passivity, safety |
//! | [`simulated`] | a knob that is not there: plant, encoder, delay, a hand, with a servo around it |
//!
//! A servo knows no clock: whoever calls [`Servo::tick`](tick::Servo::tick) does so every [`Setup::period`](setup::Setup::period) seconds, with
//! the reading of that instant or with none.
//!
//! With six effects (end stops, detents, damper, friction, inertia, ripple) a whole tick at 10 kHz takes 43 ns with a Kalman filter, 51 ns with
//! a window of 10 ms, and 12 ns more where all that scales the effects is set before it (`cargo bench --bench servo`, one core, Zen 4).

pub mod setup;
pub mod simulated;
pub mod tick;

#[cfg(test)]
mod tests;
