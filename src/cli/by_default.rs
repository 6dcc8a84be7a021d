//! The rig that is there where nobody named one.

use pacinian::patch::{Action, Events, Patch, Place};
use pacinian::rig::{MAX_CHANNELS, Rig};
use pacinian::text::Problem;

/// A line of tactors, as many as the patch names.
pub fn rig(patch: &Patch) -> Rig {
    Rig::default_for(channels(patch))
}

/// As many as the patch names, by number or as `t12`, and 8 at least.
fn channels(patch: &Patch) -> u32 {
    let of_place = |place: &Place| match place {
        Place::Channel(channel) => *channel,
        Place::Name(name) => name.strip_prefix('t').and_then(|n| n.parse().ok()).unwrap_or(0),
        Place::Position(_) => 0,
    };
    let of_action = |action: &Action| match action {
        Action::Voice(play) => play.place.as_ref().map_or(0, of_place),
        Action::Pattern { .. } | Action::Marker(_) | Action::Choose(_) => 0,
    };
    let voices = patch.voices.iter().filter_map(|v| v.place.as_ref()).map(of_place);
    let triggers = patch.triggers.iter().filter_map(|t| t.place.as_ref()).map(of_place);
    let events = patch.patterns.iter().flat_map(|p| match &p.events {
        Events::Inline(events) => events.as_slice(),
        Events::File(..) => &[],
    });
    let events = events.map(|event| match &event.action {
        Action::Choose(list) => list.iter().map(|a| of_action(&a.action)).max().unwrap_or(0),
        action => of_action(action),
    });
    let most = voices.chain(triggers).chain(events).filter(|n| *n <= MAX_CHANNELS).max().unwrap_or(0);
    most.max(8)
}

/// A place that the rig lacks is no wonder where nobody named a rig.
pub fn advise_a_rig(problem: &mut Problem) {
    if problem.what.contains("the rig has no tactor `") {
        problem.help =
            Some("name the rig that has it with --rig; without, there are `t1`, `t2`, ... in a line".into());
    }
}

#[cfg(test)]
mod tests {
    use super::channels;
    use pacinian::patch::{Patch, Place, Voice};

    #[test]
    fn the_default_rig_is_as_large_as_the_patch_needs() {
        let with = |place| Patch {
            voices: vec![Voice { place: Some(place), ..Voice::new("v", "o") }],
            ..Patch::default()
        };
        assert_eq!(channels(&with(Place::Channel(3))), 8);
        assert_eq!(channels(&with(Place::Channel(17))), 17);
        assert_eq!(channels(&with(Place::Name("t12".into()))), 12);
        assert_eq!(channels(&with(Place::Name("t99999".into()))), 8);
        assert_eq!(channels(&with(Place::Name("top".into()))), 8);
    }
}
