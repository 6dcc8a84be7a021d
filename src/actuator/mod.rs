//! What moves: how an actuator answers its drive, and which drive makes it do what is wanted.
//!
//! | file | holds |
//! |---|---|
//! | [`motor`] | the rumble motor: an eccentric mass on the shaft of a DC motor, step by step |
//! | [`shape`] | what to do to its terminals: clicks, spins, envelopes, parking |
//! | [`driver`] | the same while it is played, sample by sample |
//! | [`coil`] | voice-coil tactors on skin, inertial motors, linear resonant actuators: responses, steps, equalisers, bursts |
//! | [`identify`] | what a recording of its response tells of an actuator, with intervals |
//! | [`link`] | the way from a sample to a coil: coupling, amplifiers, carriers, pulse widths |
//! | [`protect`] | what stands last before the converter, so that nothing breaks |
//! | [`thermal`], [`piezo`] | heat in two nodes; elements that are a capacitance |
//! | [`fault`], [`drive`] | a parameter that cannot be; what is imposed on a coil |
//!
//! Models are exact between events, whatever the step, and stable for every parameter that their checks let pass; steps neither
//! allocate nor panic.
//!
//! ```
//! use pacinian::actuator::motor::{Casing, Drive, Parameters};
//! use pacinian::actuator::shape::{Click, Ending};
//!
//! let motor = Parameters {
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
//! let click = Click { turns: 0.25, drive: Drive::Voltage(3.0), angle: 0.0, ending: Ending::Settled }.solve(&motor)?;
//! let volts = click.course.means(48_000.0).expect("voltages all the way");
//! // Forward, then backward for about half as long, and it stands.
//! assert!(volts.len() as f64 / 48_000.0 < 0.0125 && click.left.abs() < 1e-6 * click.peak_speed);
//! # Ok::<(), pacinian::actuator::shape::Unreachable>(())
//! ```

#![deny(clippy::disallowed_methods)]

pub mod coil;
pub mod drive;
pub mod driver;
pub(crate) mod elementary;
pub(crate) mod exponential;
pub mod fault;
pub mod identify;
pub mod link;
pub mod motor;
pub mod piezo;
pub mod protect;
pub mod shape;
pub mod thermal;
