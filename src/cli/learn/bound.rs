//! What a control is bound to, in words.

use pacinian::Patch;
use pacinian::patch::Bind;
use pacinian::text::problem::escaped;

/// What a binding is moved by, for people.
pub fn moved_by(bind: &Bind) -> String {
    let from = bind.from.to_string();
    let from = escaped(&from);
    bind.channel.map_or(from.to_string(), |channel| format!("{from} on channel {channel}"))
}

/// What becomes of the bindings that a control has in a patch once `new` moves it, for people.
pub fn replaced(patch: &Patch, new: &Bind) -> Option<String> {
    let old: Vec<&Bind> = patch.binds.iter().filter(|bind| bind.control == new.control).collect();
    match old.as_slice() {
        [] => None,
        [one] if one.from == new.from && one.channel == new.channel => Some("as before".into()),
        [one] => Some(format!("instead of {}", moved_by(one))),
        several => {
            let all: Vec<String> = several.iter().map(|bind| moved_by(bind)).collect();
            Some(format!("beside {}", all.join(", ")))
        }
    }
}
