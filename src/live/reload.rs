//! Another patch or rig, ready to take over.

use std::fmt;
use std::sync::Arc;

use super::provenance::Provenance;
use crate::graph::scene::Scene;
use crate::patch::Patch;
use crate::performer::OpenEvents;
use crate::rig::Rig;

/// A compiled scene that is to take over from the one that plays.
pub struct Reload {
    /// For the engine.
    pub scene: Scene,
    /// What it was compiled from.
    pub patch: Arc<Patch>,
    /// And for.
    pub rig: Arc<Rig>,
    /// Opens its events files.
    pub files: OpenEvents,
    /// What a journal writes of it, so that it can be made again; `None` for what a program has put together.
    pub provenance: Option<Arc<Provenance>>,
}

impl fmt::Debug for Reload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Reload").field("patch", &self.patch.title).finish_non_exhaustive()
    }
}
