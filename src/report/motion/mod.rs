//! What an actuator does under a drive: traces, the figures that are read off them, and ways to drive it side by side.
//!
//! | file | holds |
//! |---|---|
//! | [`Wish`] | the vibration that is wanted over time |
//! | [`Bench`], [`Run`] | a motor on which drives are tried, and what it did |
//! | [`Figures`] | rise, peak, stop, error |
//! | [`bursts`], [`clicks`] | one wish, driven in several ways |
//! | [`behind`] | what of a click arrives behind coupling that keeps steady voltages off |
//! | [`Played`], [`Stretch`], [`Modelled`] | what an actuator does under a patch, and how that was computed |
//! | [`coil`] | resonance, response and bursts of actuators with a coil |
//!
//! ```
//! use pacinian::actuator::motor::{Casing, Level, Parameters, Plan};
//! use pacinian::report::motion::{Bench, Envelope, Wish, bursts};
//!
//! let coin = Parameters {
//!     resistance: 30.0,
//!     inductance: 3e-4,
//!     gain: 0.955e-3,
//!     inertia: 1.8e-9,
//!     viscous: 2.15e-8,
//!     coulomb: 1.5e-5,
//!     stiction: 2e-5,
//!     eccentric: 7.3e-7,
//!     gravity: 0.0,
//!     casing: Casing::Free { mass: 0.1 },
//!     rated_volts: 3.0,
//! };
//! let bench = Bench::new(&coin, Plan::whole(Level::Default), 48_000.0, 0.0)?;
//! let wish = Wish { level: 0.5, seconds: 0.1, envelope: Envelope::Rectangle };
//! let rows = bursts(&bench, &wish, coin.rated_volts)?;
//! let stop = |n: usize| rows[n].done.as_ref().unwrap().figures.stop.unwrap();
//! // Left to itself it goes on for 50 ms; braked for less than a third of that.
//! assert!(stop(0) > 0.05 && stop(1) < 0.3 * stop(0));
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

mod bench;
pub mod coil;
mod coupled;
mod figures;
mod modelled;
mod played;
mod ways;
mod wish;

pub use bench::{Bench, Felt, Given, Run, Traces};
pub use coupled::{Arrival, Behind, behind};
pub use figures::Figures;
pub use modelled::Modelled;
pub use played::{Played, Stretch};
pub use ways::{Done, Row, Way, bursts, clicks, own};
pub use wish::{Envelope, Wish};
