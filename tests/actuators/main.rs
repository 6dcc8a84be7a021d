//! Models of actuators against reference data, closed forms and laws; drive shaping on them.

mod coil_contact;
mod coil_quiet;
mod coil_reference;
mod coil_stop;
mod common;
mod motor_energy;
mod motor_events;
mod motor_extremes;
mod motor_grid;
mod motor_laws;
mod motor_nonsense;
mod motor_plan;
mod motor_quiet;
mod motor_reference;
mod motor_time;
#[cfg(feature = "report")]
mod race;
mod shape;
mod shape_inverse;
mod shape_rest;
mod silent;
mod turner;
mod turner_home;
mod turner_levels;
mod turner_orders;
mod turner_reach;
mod turner_staged;
mod turner_swell;
