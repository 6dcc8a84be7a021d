//! What moves: how an actuator answers its drive, and which drive makes it do what is wanted.

pub mod coil;
pub mod drive;
pub mod elementary;
pub mod exponential;
pub mod fault;
pub mod link;
pub mod motor;
pub mod piezo;
pub mod shape;
pub mod thermal;
