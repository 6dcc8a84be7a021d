//! What a knob set off.

use pacinian::performer::{Happening, Heard};
use serde::Serialize;
use std::collections::BTreeMap;

/// Something that it set off.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Set {
    /// Seconds.
    pub at: f64,
    /// What set it off, and what that played.
    pub by: String,
    /// The voice or pattern.
    pub voice: String,
}

/// All of it: how often, and if wished each of them.
#[derive(Debug, Clone, Default)]
pub struct SetOff {
    /// How often each trigger set off its voice or pattern.
    pub times: BTreeMap<String, usize>,
    /// Each of them; `None` where nobody wants them, however long it goes on.
    pub each: Option<Vec<Set>>,
}

impl SetOff {
    /// An event of a session.
    pub fn hear(&mut self, event: &Heard<'_>) {
        let Some(origin) = &event.origin else { return };
        let (Happening::Voice { name, .. } | Happening::Start(name)) = &event.what else { return };
        if !origin.pattern.starts_with("knob.") {
            return;
        }
        *self.times.entry(format!("{} plays {name}", origin.pattern)).or_insert(0) += 1;
        if let Some(each) = &mut self.each {
            each.push(Set { at: event.at, by: origin.pattern.to_string(), voice: (*name).to_string() });
        }
    }
}
