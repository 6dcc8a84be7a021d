//! Where on the body: from points to weights and times.
//!
//! | file | holds |
//! |---|---|
//! | [`law`] | how a weight becomes a gain |
//! | [`array`](mod@array) | tactors at their positions, and how much of a point each of them has |
//! | [`row`] | the weights of one point, tactor by tactor |
//! | [`path`] | a point that moves, with its time law |
//! | [`moving`] | what tactors have of a point that moves, at every engine sample, so that nothing folds back |
//! | [`brush`] | Tactile Brush: a stroke as overlapping bursts |
//! | [`apparent`], [`saltation`] | apparent motion over a list of places; the cutaneous rabbit |
//! | [`layout`] | tactors of common arrays, named and in metres |
//! | [`spot`] | where a voice sounds, and the channels of tactors that share a point |
//! | [`point`], [`fault`] | three coordinates; what cannot be |
//!
//! Lengths are metres, times are seconds. Of the body, x points to the wearer's right, y up and z ahead.
//!
//! [`Array::weights`](array::Array::weights), [`Law::gain`](law::Law::gain), [`Path::at`](path::Path::at) and what [`Mover`](moving::Mover) does are for the audio thread:
//! they neither allocate nor panic, every loop in them ends, and they give the same bits on every machine.

#![deny(clippy::disallowed_methods)]

pub mod apparent;
pub mod array;
pub mod brush;
pub mod fault;
pub mod law;
pub mod layout;
pub mod moving;
pub mod path;
pub mod point;
pub mod row;
pub mod saltation;
pub mod spot;
