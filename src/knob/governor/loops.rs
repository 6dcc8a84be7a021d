//! The loops of a device, one for each length that an adaptive window may have: the least stable one counts.

use crate::knob::stability::edge::Edge;
use crate::knob::stability::sampled::Loop;

/// Loops of one device. Each is stable or not by itself; what a window does that changes from tick to tick is between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Loops(Vec<Loop>);

impl Loops {
    /// Of at least one loop.
    pub(super) fn new(loops: Vec<Loop>) -> Self {
        Self(loops)
    }

    /// The loop whose speed is the latest.
    pub fn latest(&self) -> Option<&Loop> {
        self.0.last()
    }

    fn least<F: Fn(&Loop) -> Edge>(&self, edge: F) -> Edge {
        self.0.iter().map(edge).reduce(|a, b| if b.gain < a.gain { b } else { a }).unwrap_or(Edge::NONE)
    }

    /// The stiffness (N m/rad) up to which the knob comes to rest with a computed damping (N m s/rad).
    pub fn edge(&self, damping: f64) -> Edge {
        // Without damping all of them are the same.
        if damping == 0.0 {
            self.latest().map_or(Edge::NONE, |one| one.edge(0.0))
        } else {
            self.least(|one| one.edge(damping))
        }
    }

    /// The same for a damping within [`Loops::damping_edge`].
    pub(crate) fn edge_within(&self, damping: f64) -> Edge {
        if damping == 0.0 {
            self.latest().map_or(Edge::NONE, |one| one.edge_within(0.0))
        } else {
            self.least(|one| one.edge_within(damping))
        }
    }

    /// The computed damping (N m s/rad) up to which a knob without a spring comes to rest.
    pub fn damping_edge(&self) -> Edge {
        self.least(Loop::damping_edge)
    }

    /// How fast the outermost eigenvalue of all grows, 1/s.
    pub fn growth(&self, stiffness: f64, damping: f64) -> f64 {
        let of = |one: &Loop| one.growth(stiffness, damping);
        if damping == 0.0 {
            return self.latest().map_or(f64::INFINITY, of);
        }
        self.0.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }
}
