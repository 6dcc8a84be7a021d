//! The plant of a force-feedback knob: what turns, and what measures that it turns.
//!
//! | file | holds |
//! |---|---|
//! | [`parameters`], [`stops`], [`parts`], [`wave`] | what a knob is made of |
//! | [`rotor`] | one inertia with friction and stops: exact for a held torque, by closed forms |
//! | [`chain`] | all the rest: shaft, winding and current loop, a hand's grasp, torque over the angle |
//! | [`encoder`], [`heat`] | counts, a delay line; how warm the winding is |
//! | [`rival`] | other integrators and friction models, to compare with |
//!
//! [`Plant`] takes the least of them that a knob needs: one inertia pays nothing for what it has not. Angles are radians,
//! torques newton metres, times seconds. What steps neither allocates nor panics, every loop in it ends, and it gives the same bits on
//! every machine; steps hold their inputs, and what switches within one does so at its instant, at most [`rotor::MOST_EVENTS`] times.
//!
//! | model | error | ns a step | ns with events (on 2 shared cores, Zen 4) |
//! |---|---|---|---|
//! | one inertia, friction | rounding: 1e-15 of the largest angle of a free run | 7, 1 at rest | 160 for a stop and a start |
//! | and stops | rounding: a rebound within 1e-13 of the impact's speed | 7, 19 behind a stop | 2,100 for contact, reversal and release, 2,800 for eight events |
//! | shaft, winding, grasp | rounding: 5e-14 of the largest speed after 4,800 steps | 80 to 220 | 1,200 to 2,000 for one |
//! | torque over the angle | 1e-17 rad of its phase left out of a piece: 7e-15 after 1,200 steps | 1,250 with one harmonic, 2,600 with eight | the same |

pub mod chain;
mod crossing;
pub mod encoder;
pub mod heat;
mod law;
mod least;
mod network;
pub mod parameters;
pub mod parts;

pub mod rival;
pub mod rotor;
mod series;
pub mod stops;
pub mod wave;

pub use least::Plant;
