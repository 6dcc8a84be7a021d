//! Sound cards, those that are there and one that is not.

pub mod access;
mod ahead;
mod callers;
pub mod capture;
pub mod card;
pub mod choose;
pub mod failure;
pub mod hosts;
pub mod hush;
#[cfg(all(feature = "jack", target_os = "linux"))]
mod jack_ports;
pub(crate) mod jack_turn;
pub mod keeper;
mod kept;
pub mod list;
pub mod listening;
mod minder;
pub mod missing;
mod pcm;
#[cfg(all(feature = "pipewire", target_os = "linux"))]
mod pipewire_default;
pub mod priority;
#[cfg(all(feature = "pulseaudio", target_os = "linux"))]
mod pulse;
pub mod rates;
mod returning;
pub mod servers;
pub mod virtual_card;
mod watch;
