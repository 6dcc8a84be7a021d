//! Sound cards, those that are there and one that is not.

pub mod capture;
pub mod card;
pub mod choose;
pub mod failure;
pub(crate) mod hush;
pub mod keeper;
pub mod list;
pub mod listening;
mod minder;
pub mod priority;
pub mod virtual_card;
