//! The patch: what people write about sound and time. Voices are node graphs, patterns are events in time, triggers start
//! either.
//!
//! A [`Patch`] is a plain description with no state, and may as well be built in code; [`Patch::check`] finds what is wrong
//! with it. [`Patch::parse`] reads it from a file's bytes and reports every problem at once, each at its place.

pub mod control;
pub mod event;
pub mod expr;
pub mod node;
pub mod pattern;
pub mod place;
pub mod scope;
pub mod trigger;
pub mod voice;

pub use control::{Control, Curve};
pub use event::{Action, Alternative, Event, Play, Repeat};
pub use expr::{Expr, Function, Operator};
pub use node::{Argument, Node, Value};
pub use pattern::{Events, Jitter, Pattern, TimeBase};
pub use place::Place;
pub use scope::{Scope, Target};
pub use trigger::{Source, Trigger};
pub use voice::{Start, Voice};

use crate::text::{Checked, Problem, Problems};

/// A patch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patch {
    /// What it is called.
    pub title: String,
    /// What it is about; may be empty.
    pub description: String,
    /// What MIDI, OSC or a program may move while it plays.
    pub controls: Vec<Control>,
    /// Voices, in the order of the file.
    pub voices: Vec<Voice>,
    /// Nodes that run once for the whole engine.
    pub shared: Vec<Node>,
    /// Patterns, in the order of the file.
    pub patterns: Vec<Pattern>,
    /// What starts voices and patterns.
    pub triggers: Vec<Trigger>,
    /// How to render it where the person says nothing else.
    pub render: Render,
}

/// Defaults for rendering.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Render {
    /// Length in seconds; `None`: until everything has ended.
    pub duration: Option<f64>,
    /// From which all random numbers come; `None` is 0.
    pub seed: Option<u64>,
    /// Seconds to go on after the last voice has ended.
    pub tail: Option<f64>,
}

impl Patch {
    /// Reads a patch from the bytes of a file called `name`.
    ///
    /// # Errors
    /// Every problem of the file at once, each with its place.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Checked<Self>, Problems> {
        let _ = bytes;
        Err(Problems::of_file(name, "patches cannot be read yet"))
    }
    /// What is wrong with it as a whole: names that nothing has, cycles, numbers out of range. Spans are those of the parts.
    pub fn check(&self) -> Vec<Problem> {
        Vec::new()
    }
}
