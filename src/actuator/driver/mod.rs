//! Turning a rumble motor while it is played: from levels and orders to what reaches its terminals, sample by sample, in bounded time.
//!
//! | file | holds |
//! |---|---|
//! | [`setup`] | the motor, its limits, how levels are shaped |
//! | [`ahead`] | speeds that the motor can follow, planned on what is known ahead |
//! | [`law`] | the drive that brings a speed about: the inverse, and the way to another speed |
//! | [`coast`] | how it comes to rest by itself, where nothing brakes it |
//! | [`track`] | envelopes that are known as a whole, made into speeds that it can follow |
//! | [`order`], [`book`] | clicks, spins and brakes; clicks worked out for every level |
//! | [`homing`] | the way to where gravity catches the mass |
//! | [`hanging`] | where the mass hangs since, and for how long that is known |
//! | [`stopping`] | where a motor comes to stand that is driven backward from now on |
//! | [`warmth`] | how warm it becomes, and what of it all is held back for that |
//! | [`turner`] | all of it, one engine sample at a time |
//!
//! What is sent is worked out on the motor's own model, which runs beside it where that is needed: nothing is measured on the motor.

pub mod ahead;
pub mod book;
pub mod coast;
pub mod hanging;
pub mod homing;
pub mod law;
pub mod order;
pub mod reach;
pub mod setup;
pub mod stopping;
pub mod track;
pub mod turner;
pub mod warmth;
