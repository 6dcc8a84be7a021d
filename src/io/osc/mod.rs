//! OSC (Open Sound Control 1.0) in and out, over UDP: what other programs play, move and ask, and what they are told.
//!
//! A datagram is stamped as it arrives, and pulls the brake then if it asks for that (`receiver`); in its turn (`listener`) it is unpacked ([`packet`]), its address patterns are matched against what the patch has
//! ([`names`]), and what it asks for ([`message`]) goes to the session, or into the [`agenda`] until its time has come. What cannot be
//! done is counted by kind in [`counts::Counts`], said once for each address ([`server::Server::complaints`]), and given to the session for its journal as long as
//! not too much of it comes ([`Signal::Vain`](crate::live::signal::Signal::Vain)). The addresses are listed in `docs/osc.md`.

pub mod address;
pub mod agenda;
mod allowance;
pub mod announce;
mod arrivals;
mod brake;
mod complaints;
pub mod counts;
mod drops;
pub mod endpoint;
mod ids;
mod listener;
pub mod message;
pub mod names;
pub mod packet;
pub mod peers;
mod receiver;
mod rest;
mod said;
pub mod server;
pub mod time;

#[cfg(test)]
mod tests;
