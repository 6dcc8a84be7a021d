//! The rig that is there where nobody named one.

use pacinian::patch::{Action, Events, Patch, Place};
use pacinian::rig::{MAX_CHANNELS, Rig};
use pacinian::text::Problem;

/// How long the line is where nobody says.
pub const USUAL: u32 = 8;

/// A device that offers all numbers of channels from one to this takes any.
const ANY: usize = 16;

/// A line of tactors: as many as the patch names, or more, for a device that offers these numbers of channels; any, where there are none.
pub fn rig(patch: &Patch, offered: &[u16]) -> Rig {
    Rig::default_for(fit(needed(patch), offered))
}

/// How long a line is that must have `needed` tactors: the usual number or more; on a device that offers only these numbers of channels, one
/// of those, if one is enough.
pub fn fit(needed: u32, offered: &[u16]) -> u32 {
    if offered.is_empty() {
        return needed.max(USUAL);
    }
    // Who takes any number converts it, and does not say what there is behind: most likely headphones.
    if offered.len() >= ANY && offered.iter().enumerate().all(|(n, count)| usize::from(*count) == n + 1) {
        return needed.max(2);
    }
    let enough = || offered.iter().map(|count| u32::from(*count)).filter(|count| *count >= needed);
    enough().filter(|count| *count <= USUAL).max().or(enough().min()).unwrap_or(needed)
}

/// As many as the patch names, by number or as `t12`.
fn needed(patch: &Patch) -> u32 {
    let number = |name: &str| name.strip_prefix('t').and_then(|n| n.parse().ok()).unwrap_or(0);
    let of_place = |place: &Place| match place {
        Place::Channel(channel) => *channel,
        Place::Name(name) => number(name),
        Place::Names(names) => names.iter().map(|name| number(name)).max().unwrap_or(0),
        Place::Position(_) | Place::Path(_) => 0,
    };
    let of_action = |action: &Action| match action {
        Action::Voice(play) => play.places().map(|(place, _)| of_place(place)).max().unwrap_or(0),
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
    voices.chain(triggers).chain(events).filter(|n| *n <= MAX_CHANNELS).max().unwrap_or(0)
}

/// Places that the rig lacks are no wonder where nobody named a rig. That is said once; `source` is the patch, which may name its rig
/// in a line `# rig: PATH`.
pub fn advise_a_rig(problems: &mut [Problem], source: &str) {
    let named = source.lines().find_map(|line| line.strip_prefix("# rig:")).map(str::trim);
    let help = match named.filter(|path| !path.is_empty()) {
        Some(path) => {
            format!("the patch names its rig: --rig {path}; without, there are `t1`, `t2`, ... in a line")
        }
        None => "name the rig that has it with --rig; without, there are `t1`, `t2`, ... in a line".into(),
    };
    let mut lacking: Vec<&mut Problem> =
        problems.iter_mut().filter(|p| p.what.contains("the rig has no tactor `")).collect();
    lacking.sort_by_key(|p| p.span.as_ref().map_or(0, |s| s.start));
    lacking.iter_mut().for_each(|p| p.help = None);
    lacking.into_iter().take(1).for_each(|p| p.help = Some(help.clone()));
}

#[cfg(test)]
mod tests {
    use super::{fit, needed};
    use pacinian::patch::{Patch, Place, Voice};

    #[test]
    fn the_default_rig_is_as_large_as_the_patch_needs() {
        let with = |place| Patch {
            voices: vec![Voice { place: Some(place), ..Voice::new("v", "o") }],
            ..Patch::default()
        };
        assert_eq!(needed(&with(Place::Channel(3))), 3);
        assert_eq!(needed(&with(Place::Channel(17))), 17);
        assert_eq!(needed(&with(Place::Name("t12".into()))), 12);
        assert_eq!(needed(&with(Place::Name("t99999".into()))), 0);
        assert_eq!(needed(&with(Place::Name("top".into()))), 0);
    }

    #[test]
    fn the_line_is_as_long_as_the_device_offers() {
        for (needed, offered, length) in [
            (0, &[][..], 8),
            (12, &[], 12),
            (0, &[2], 2),
            (2, &[2], 2),
            (3, &[2], 3),
            (1, &[1, 2, 4, 6, 8, 16], 8),
            (9, &[1, 2, 4, 6, 8, 16], 16),
            (0, &[16, 32], 16),
            (0, &Vec::from_iter(1..=64), 2),
            (5, &Vec::from_iter(1..=64), 5),
            (0, &Vec::from_iter(1..=10), 8),
        ] {
            assert_eq!(fit(needed, offered), length, "{needed} of {offered:?}");
        }
    }
}
