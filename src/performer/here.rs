//! Where the places of a patch are, for the score that plays it.

use crate::patch::Place;
use crate::rig::{Finder, Rig};
use crate::score::Places;
use crate::space::array::Array;
use crate::space::spot::{Spot, Spread};
use crate::text::Problem;
use std::sync::Arc;

/// The places of a patch on a rig.
pub(super) struct Here {
    pub rig: Arc<Rig>,
    pub finder: Arc<Finder>,
    /// The tactors that share points.
    pub spread: Option<Spread>,
}

impl Places for Here {
    fn spot(&mut self, place: Option<&Place>) -> Result<Spot, Problem> {
        self.rig.resolve_by(&self.finder, place, &(0..0))
    }

    fn array(&self) -> Option<&Array> {
        self.spread.as_ref().map(Spread::array)
    }
}
