//! What a name means to a node.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Patch, Voice};

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Target {
    /// A node of the same voice, by its place in [`Voice::nodes`].
    Node(usize),
    /// A shared node, by its place in [`Patch::shared`].
    Shared(usize),
    /// A control, by its place in [`Patch::controls`].
    Control(usize),
}

/// The names that the nodes of one voice, or the shared nodes, may read: the voice's nodes first, then shared ones, then
/// controls.
#[derive(Debug, Clone)]
pub struct Scope<'a> {
    /// Shared by all voices.
    outer: Arc<HashMap<&'a str, Target>>,
    own: HashMap<&'a str, Target>,
}

impl<'a> Scope<'a> {
    /// Of a voice; `None` for the shared nodes. For many voices, see [`Scope::within`].
    pub fn new(patch: &'a Patch, voice: Option<&'a Voice>) -> Self {
        let mut names = HashMap::new();
        names.extend(patch.controls.iter().enumerate().map(|(i, c)| (c.name.as_str(), Target::Control(i))));
        names.extend(patch.shared.iter().enumerate().map(|(i, n)| (n.name.as_str(), Target::Shared(i))));
        let shared = Self { outer: Arc::new(names), own: HashMap::new() };
        voice.map_or(shared.clone(), |voice| shared.within(voice))
    }
    /// That of the shared nodes, as it is within a voice. It takes as long as the voice has nodes.
    #[must_use]
    pub fn within(&self, voice: &'a Voice) -> Self {
        let own = voice.nodes.iter().enumerate().map(|(i, n)| (n.name.as_str(), Target::Node(i))).collect();
        Self { outer: Arc::clone(&self.outer), own }
    }
    /// What a name stands for.
    pub fn find(&self, name: &str) -> Option<Target> {
        self.own.get(name).or_else(|| self.outer.get(name)).copied()
    }
    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &'a str> {
        self.own.keys().chain(self.outer.keys().filter(|name| !self.own.contains_key(*name))).copied()
    }
}
