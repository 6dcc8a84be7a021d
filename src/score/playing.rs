//! One playing of a pattern, and where it stands among all that is played.

use std::cmp::Ordering;
use std::sync::Arc;

/// Which event of a playing, and which of its repetitions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Leaf {
    pub event: u64,
    pub k: u64,
}

/// One round of a pattern, from one of its onsets.
#[derive(Debug)]
pub(super) struct Playing {
    /// Which of the score's roots it belongs to.
    pub root: usize,
    /// What plays it; `None` for a root.
    pub parent: Option<Arc<Playing>>,
    /// Which event of the parent it is; for a root, its number.
    pub leaf: Leaf,
    /// How often it has been played before from the same onset.
    pub round: u64,
    /// The pattern.
    pub sheet: usize,
    /// How many play around it.
    pub depth: u32,
    /// Seconds: when round 0 begins.
    pub begin: f64,
    /// Seconds: when this round begins.
    pub start: f64,
    /// Product of the rates of this pattern and all around it.
    pub rate: f64,
    /// Seconds in one unit of the pattern's time.
    pub scale: f64,
    /// Product of the gains of this pattern and all around it.
    pub gain: f64,
    /// Key of the draws of all its rounds.
    pub base: u64,
    /// Key of its draws.
    pub key: u64,
}

impl Playing {
    /// Seconds at a time of the pattern. Never falls as `time` rises.
    pub fn seconds(&self, time: f64) -> f64 {
        self.start + time * self.scale
    }
}

/// The order of two places in the tree of all that is played, depth first. A place is a playing itself (`None`), or one of
/// its events.
pub(super) fn order(a: (&Arc<Playing>, Option<Leaf>), b: (&Arc<Playing>, Option<Leaf>)) -> Ordering {
    if a.0.depth > b.0.depth {
        return order(b, a).reverse();
    }
    // Up from b to the depth of a; `below` is where that path leaves.
    let (mut left, mut right, mut below) = (a.0, b.0, b.1);
    while right.depth > left.depth {
        let Some(parent) = &right.parent else { break };
        below = Some(right.leaf);
        right = parent;
    }
    let deeper = b.0.depth > a.0.depth;
    // Up together; the difference nearest to the root decides.
    let mut decided = a.1.cmp(&below);
    if decided == Ordering::Equal && deeper {
        decided = Ordering::Less;
    }
    while !Arc::ptr_eq(left, right) {
        let here = (left.leaf, left.round).cmp(&(right.leaf, right.round));
        decided = here.then(decided);
        let (Some(l), Some(r)) = (&left.parent, &right.parent) else { break };
        (left, right) = (l, r);
    }
    decided
}
