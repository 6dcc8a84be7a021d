//! A patch and a rig, ready to play: a session begins with them, or they take over from others.

use std::fmt;
use std::sync::Arc;

use super::provenance::Provenance;
use crate::graph::scene::{Options, Scene, scene};
use crate::node::asset::Assets;
use crate::patch::Patch;
use crate::performer::OpenEvents;
use crate::rig::Rig;
use crate::text::{Problem, Problems};

/// A compiled scene that is to play, at once or in place of the one that plays.
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

impl Reload {
    /// Compiled as `options` say, but always for playing live. For a sound card that is [`Options::for_card`],
    /// with which no steady voltage leaves where none is declared. A patch that names events files is given them afterwards, as `files`: here they are not
    /// opened.
    ///
    /// # Errors
    /// As [`scene`].
    pub fn of(
        patch: impl Into<Arc<Patch>>,
        rig: impl Into<Arc<Rig>>,
        options: &Options,
        assets: &dyn Assets,
    ) -> Result<Self, Problems> {
        let (patch, rig) = (patch.into(), rig.into());
        let scene = scene(&patch, &rig, &Options { live: true, ..options.clone() }, assets)?;
        let files = |path: &str| {
            let what = format!("nobody has said how `{path}` is opened");
            Err(Problem::of_file(what).help("set `files` of what is to play".to_string()))
        };
        Ok(Self { scene, patch, rig, files: Box::new(files), provenance: None })
    }
}

impl fmt::Debug for Reload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Reload").field("patch", &self.patch.title).finish_non_exhaustive()
    }
}
