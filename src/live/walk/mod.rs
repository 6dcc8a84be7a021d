//! A walk over the channels of a device, to find out which tactor hangs where: what is played on each, whose turn it is, and what follows.
//!
//! [`probe::patch`] on [`probe::bare`] is the scene of a session; [`probe::Probe::note`] is what its handle plays for a channel.
//! [`turns::Turns`] takes what somebody says was felt, and [`map::map`] says on which channels the outputs of the rig are then.
//!
//! ```
//! use pacinian::Rig;
//! use pacinian::live::walk::map::{Felt, map};
//! use pacinian::live::walk::probe::probes;
//! use pacinian::live::walk::turns::Turns;
//! use std::collections::BTreeMap;
//!
//! // A card whose first two jacks are permuted: each tactor is felt where the other should be.
//! let rig = Rig::default_for(4);
//! let probes = probes(&rig, 0.25, false);
//! let mut turns = Turns::over(probes.iter().map(|probe| probe.channel).collect());
//! let (mut felt, answers) = (BTreeMap::new(), [1, 0, 2, 3]);
//! while let Some(turn) = turns.now() {
//!     // Here the probe is played, and somebody is asked.
//!     turns.said(Some(Felt::Output(answers[turn])), &mut felt);
//! }
//! let moved = map(&rig, &probes, &felt)?.moved;
//! assert_eq!(moved, BTreeMap::from([(0, 2), (1, 1)]));
//! # Ok::<(), String>(())
//! ```

pub mod map;
pub mod probe;
pub mod turns;
