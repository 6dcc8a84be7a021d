//! Force feedback: a knob of one degree of freedom, an angle in and a torque out.
//!
//! | room | holds |
//! |---|---|
//! | [`plant`] | the simulated knob: inertia, friction, stops, shaft, winding and current loop, a hand, encoder, delay, heat |
//!
//! It is here for programs: nothing of a patch or a rig reaches it yet.

pub mod plant;
