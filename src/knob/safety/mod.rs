//! Between what effects ask and what the amplifier gets.
//!
//! In this order: what is not a number becomes 0 · the sum of the effects, within the governor's limits (both before this chain, and
//! reported to it) · slew · reconstruction low-pass · torque-squared budget · peak · arming and soft start · stale input · over-speed ·
//! latch. Torque is 0 until the chain is armed; a lost sensor or a missed deadline lets it fall to 0 over a set time; a fault that
//! demands it makes it exactly 0 in the tick that brings it, and keeps it there until the fault is acknowledged.
//!
//! | file | holds |
//! |---|---|
//! | [`budget`] | heat from torque squared |
//! | [`chain`] | the stages, their order and their counts |

pub mod budget;
pub mod chain;
#[cfg(test)]
mod tests;
