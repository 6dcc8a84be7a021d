//! The rumble motor: an eccentric mass on the shaft of a DC motor.
//!
//! ```
//! use pacinian::actuator::motor::{Casing, Drive, GRAVITY, Motor, Parameters, Plan, Wish};
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
//!     gravity: GRAVITY,
//!     casing: Casing::Free { mass: 0.1 },
//!     rated_volts: 3.0,
//! };
//! let rate = 48_000.0;
//! let plan = Plan::choose(&coin, rate, &Wish { error: 1e-5, posture: true, casing: true });
//! let mut motor = Motor::<false>::new(&coin, &plan, rate)?;
//! motor.drive(Drive::Voltage(3.0));
//! for _ in 0..4800 {
//!     motor.step();
//! }
//! // The supply is taken away a third of a step later.
//! motor.step_with(&[(1.0 / 3.0, Drive::Open)]);
//! let now = motor.reading();
//! assert!(now.speed > 1400.0 && now.current == 0.0 && now.acceleration[0].abs() < 18.0);
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

mod drive;
mod energy;
mod events;
#[cfg(test)]
mod exact;
mod flow;
mod group;
mod kernels;
mod model;
mod mount;
mod output;
mod parameters;
mod piece;
mod plan;
mod rush;
mod steps;
mod swift;
mod table;

pub use drive::{Drive, MOST_DRIVE};
pub use energy::Energy;
pub use events::MOST_EVENTS;
pub use group::{Group, LANES};
pub use model::{Counts, Motor};
pub use output::Reading;
pub use parameters::{Casing, GRAVITY, Parameters, Suspension};
pub use plan::{LeftOut, Level, Part, Plan, Why, Wish};
pub use steps::Steps;
