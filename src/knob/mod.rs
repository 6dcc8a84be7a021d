//! Force feedback: a knob of one degree of freedom, an angle in and a torque out.
//!
//! | room | holds |
//! |---|---|
//! | [`plant`] | the simulated knob: inertia, friction, stops, shaft, winding and current loop, a hand, encoder, delay, heat |
//! | [`angle`] | an angle out of a sound card's inputs: sine and cosine, an encoder's lines, a voltage |
//! | [`velocity`] | estimators of speed from an encoder, with the error each has at its rate |
//! | [`effect`] | what the knob feels like: effects that add up |
//! | [`local_model`] | what a slow thread sends: a world near one angle, followed without a jump of force |
//! | [`stability`] | where a sampled spring and damper begin to oscillate: exactly, and by the closed forms |
//! | [`governor`] | what a device bears of what effects ask, what binds, and what would lift it |
//! | [`passivity`] | energy booked, and damping for what came out in excess |
//! | [`safety`] | between the sum of the effects and the amplifier |
//! | [`servo`] | all of them in one tick; a simulated knob around it |
//! | [`low_pass`] | the filter that velocity estimates and torque reconstruction share |
//!
//! A servo's tick: an [`Estimator`](velocity::Estimator) gives the speed; [`Program::demand`](effect::program::Program::demand) says how stiff and
//! viscous the effects are together, [`Governor::allow`](governor::Governor::allow) what is left of that;
//! [`Program::tick`](effect::program::Program::tick) gives their sum and what happened; [`Chain::tick`](safety::chain::Chain::tick) what the amplifier gets.
//! None of these allocates, panics, locks or calls the platform's `sin` or `exp`; all else is for the control thread.
//!
//! ```
//! use pacinian::knob::effect::events::{Events, What};
//! use pacinian::knob::effect::program::Program;
//! use pacinian::knob::effect::{Reading, detent::Detent, wall::Stops};
//! use pacinian::knob::plant::{Plant, parts::{Build, Hand}};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // 24 detents a turn of 0.1 N m/rad, and a stop after a sixth of a turn; a hand turns with 5 mN m.
//! let stop = Stops { low: -1.0, high: std::f64::consts::TAU / 6.0, stiffness: 0.5, damping: 1e-3 };
//! let mut effects = Program::new(vec![Detent::with_stiffness(24.0, 0.1).into(), stop.into()]).map_err(|(_, fault)| fault)?;
//! let (rate, mut events) = (10_000.0, Events::default());
//! let mut knob = Plant::new(&Build::default(), rate)?;
//! let hand = Hand { torque: 5e-3, ..Hand::default() };
//! let (mut detents, mut walls) = (0, 0);
//! for _ in 0..2_000 {
//!     // Its own speed in place of an estimate from an encoder.
//!     let reading = Reading { angle: knob.angle(), velocity: knob.speed(), dt: 1.0 / rate };
//!     let torque = effects.tick(&reading, 1.0, 1.0, &mut events);
//!     for event in events.list() {
//!         match event.what {
//!             What::Detent { passed, .. } if walls == 0 => detents += passed,
//!             What::Detent { .. } => {}
//!             What::Wall { .. } => walls += 1,
//!         }
//!     }
//!     knob.step(torque, &hand);
//! }
//! assert!(walls > 0 && detents >= 3, "{walls} {detents}");
//! # Ok(())
//! # }
//! ```
//!
//! Angles are radians, torques newton metres on the knob (positive turns it to larger angles), times seconds.

#![deny(clippy::disallowed_methods)]

pub mod angle;
pub mod effect;
pub mod governor;
pub mod local_model;
pub mod low_pass;
mod order;
pub mod passivity;
pub mod plant;
pub mod safety;
pub mod servo;
pub mod stability;
#[cfg(test)]
#[allow(dead_code)] // Each test asks another part of it.
pub(crate) mod test_plant;
pub mod velocity;
