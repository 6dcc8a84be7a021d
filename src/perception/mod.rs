//! What the skin feels of a vibration: thresholds by frequency, site and contactor, what short tones lose, how strong a vibration seems, and what a calibrated tactor
//! must be given for so many decibels above the threshold.
//!
//! Amplitudes are peaks. Every curve says where it is from and how far it may be off; of what nobody has measured nothing is made up.

#![deny(clippy::disallowed_methods)]

pub mod calibration;
pub mod fault;
pub mod gauge;
pub mod loudness;
pub mod site;
pub mod summation;
pub mod threshold;
