//! From a place in a patch to an output of the rig.

use super::{Finder, Output, OutputKind, Rig};
use crate::patch::{Patch, Place};
use crate::space::spot::Spot;
use crate::text::nearest::suggest;
use crate::text::sink::Sink;
use crate::text::{Problem, Span};
use std::collections::HashSet;

fn sounds(output: &Output) -> bool {
    !matches!(output.kind, OutputKind::Trigger { .. })
}

impl Rig {
    /// Where a place sounds. `None` is the first tactor; a position is shared by the tactors that have one. A name or a channel may be any
    /// output but a trigger, a name also a group. Lists of names are found by [`Rig::resolve_by`].
    ///
    /// # Errors
    /// Says what the rig lacks and suggests the nearest name; points at `span`.
    pub fn resolve(&self, place: Option<&Place>, span: &Span) -> Result<Spot, Problem> {
        self.resolve_by(&Finder::new(self), place, span)
    }

    /// As [`Rig::resolve`], for many places: `finder` is this rig's, and of the patch in which lists of names stand.
    ///
    /// # Errors
    /// As [`Rig::resolve`].
    pub fn resolve_by(&self, finder: &Finder, place: Option<&Place>, span: &Span) -> Result<Spot, Problem> {
        if let Some(Place::Position(position)) = place
            && !position.iter().all(|x| x.is_finite())
        {
            let what = format!("{position:?} is no position");
            return Err(Problem::error(span, what).help("give metres, finite numbers".to_string()));
        }
        let trigger = |spot| {
            let outputs = finder.outputs(spot);
            let output = outputs.iter().filter_map(|output| self.outputs.get(*output));
            output.into_iter().find(|output| !sounds(output))
        };
        match (finder.find(place), place) {
            (Some(spot), _) => match trigger(spot) {
                None => Ok(spot),
                Some(output) => Err(Problem::error(
                    span,
                    format!(
                        "output `{}` is a trigger: it gives pulses at markers and plays nothing",
                        output.name
                    ),
                )),
            },
            (None, Some(Place::Names(names))) => {
                let lacks =
                    names.iter().find(|name| finder.find(Some(&Place::Name(name.to_string()))).is_none());
                Err(match lacks {
                    Some(name) => self.lacks(name, span),
                    None => {
                        let what = format!("the list of names {names:?} stands nowhere in the patch");
                        let help = "make it a [group.NAME] of the rig, and play that".to_string();
                        Problem::error(span, what).help(help)
                    }
                })
            }
            (None, Some(Place::Name(name))) => Err(self.lacks(name, span)),
            (None, Some(Place::Channel(channel))) if *channel == 0 || *channel > self.device.channels => {
                let has = self.device.channels;
                let what = format!(
                    "this rig has {has} channel{}; there is no channel {channel}",
                    if has == 1 { "" } else { "s" }
                );
                let help = if *channel == 0 {
                    "channels count from 1"
                } else {
                    "give --rig one that has it; without --rig there are as many as the patch needs"
                };
                Err(Problem::error(span, what).help(help.to_string()))
            }
            (None, Some(Place::Channel(channel))) => {
                let help = format!("describe what hangs there: [[tactor]] with channel = {channel}");
                Err(Problem::error(span, format!("the rig has no tactor on channel {channel}")).help(help))
            }
            (None, Some(Place::Path(_))) if finder.nearest(&[0.0; 3]).is_some() => {
                let what = "the path stands nowhere in the patch";
                Err(Problem::error(span, what)
                    .help("write it as the place of an event or a voice".to_string()))
            }
            (None, Some(Place::Position(_) | Place::Path(_))) => {
                let help = "give the tactors a `position`".to_string();
                Err(Problem::error(span, "no tactor of the rig has a position").help(help))
            }
            (None, None) => {
                let help = "describe one, [[tactor]], or say at which output it is played: place = \"NAME\"";
                Err(Problem::error(span, "the rig has no tactor").help(help.to_string()))
            }
        }
    }

    /// That nothing has a name, and which might have been meant.
    fn lacks(&self, name: &str, span: &Span) -> Problem {
        let outputs = self.outputs.iter().filter(|o| sounds(o)).map(|o| o.name.as_str());
        let names = outputs.chain(self.groups.iter().map(|group| group.name.as_str()));
        Problem::error(span, format!("the rig has no tactor `{name}`")).help(suggest(name, names))
    }

    /// Every place of a patch that the rig lacks, up to [`Sink::MOST`]; those of events files are left to their reader.
    pub fn check_places(&self, patch: &Patch) -> Vec<Problem> {
        let (mut problems, mut further, mut last) = (Vec::new(), 0_usize, 0..0);
        let finder = Finder::with(self, patch);
        patch.each_place(|place, span| {
            if problems.len() < Sink::MOST {
                problems.extend(self.resolve_by(&finder, Some(place), span).err());
            } else {
                // Without advice, which takes a look at every name there is.
                let found = finder.find(Some(place)).map(|spot| finder.outputs(spot));
                let sound =
                    |all: &Vec<usize>| all.iter().all(|output| self.outputs.get(*output).is_some_and(sounds));
                if !found.as_ref().is_some_and(sound) {
                    (further, last) = (further + 1, span.clone());
                }
            }
        });
        if further > 0 {
            let what = format!("and {further} more places that the rig lacks, up to here");
            problems.push(Problem::error(&last, what));
        }
        problems
    }

    /// What a patch says of places that plays, but hardly where it was meant: warnings. Those of events files are left out.
    pub fn advise(&self, patch: &Patch) -> Vec<Problem> {
        let (mut problems, finder) = (Vec::new(), Finder::new(self));
        let astray = finder.extent().clamp(ASTRAY[0], ASTRAY[1]);
        // How far a stroke leaves the tactors is told with what else there is to know of it.
        let mut strokes = HashSet::new();
        patch.each_play(|play, _| {
            strokes.extend(play.motion.iter().filter(|m| m.key() == "stroke").map(|m| m.span.clone()));
        });
        patch.each_place(|place, span| {
            let points = match place {
                _ if strokes.contains(span) => return,
                Place::Position(position) => std::slice::from_ref(position),
                Place::Path(way) => way.route().path.points(),
                _ => return,
            };
            let far = |point| finder.nearest(point).map(|(far, i)| (far, point, i));
            let farthest = points.iter().filter_map(far).max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((far, position, output)) =
                farthest.and_then(|(far, point, i)| Some((far, point, self.outputs.get(i)?)))
            else {
                return;
            };
            if far > astray && problems.len() < Sink::MOST {
                let shown = position.map(|x| x.to_string()).join(", ");
                let what = format!(
                    "the {} [{shown}] is {far:.2} m from the nearest tactor, `{}`: it sounds at the rim",
                    if points.len() > 1 { "path leaves the tactors:" } else { "place" },
                    output.name
                );
                let help = "positions are metres, of the patch as of the rig".to_string();
                problems.push(Problem::warning(span, what).help(help));
            }
        });
        problems
    }
}

/// A place farther from every tactor than they lie apart was hardly meant; metres, at least and at most.
const ASTRAY: [f64; 2] = [0.1, 0.5];

#[cfg(test)]
mod tests {
    use crate::patch::{Patch, Place};
    use crate::rig::{OutputKind, Rig};
    use crate::space::spot::Spot;

    #[test]
    fn finds_tactors_by_name_channel_and_position() {
        let rig = Rig::default_for(4);
        let find = |place| rig.resolve(Some(&place), &(0..0));
        assert_eq!(find(Place::Name("t3".into())), Ok(Spot::Row(2)));
        assert_eq!(find(Place::Channel(4)), Ok(Spot::Row(3)));
        assert_eq!(find(Place::Position([0.05, 0.2, 0.0])), Ok(Spot::Point([0.05, 0.2, 0.0])));
        assert_eq!(rig.resolve(None, &(0..0)), Ok(Spot::Row(0)));
    }

    #[test]
    fn a_place_far_from_every_tactor_is_a_warning() {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.v]\noutput = \"n\"\n\
                    nodes.n = { type = \"white\" }\n[pattern.p]\nevents = [\n\
                    { at = 0, voice = \"v\", place = [0, 0.09] },\n{ at = 1, voice = \"v\", place = [0, 0.2] },\n\
                    { at = 2, voice = \"v\", place = [0, 0.4] },\n{ at = 3, voice = \"v\", place = [0, 20] },\n]\n";
        let patch = Patch::parse("p.toml", text.as_bytes()).unwrap().value;
        // Farther off than the array is wide, from 0.1 m on; 0.5 m is too far from any.
        for (wide, wanted) in [
            (0.0, &["[0, 0.2]", "[0, 0.4]", "[0, 20]"][..]),
            (0.19, &["[0, 0.2]", "[0, 0.4]", "[0, 20]"]),
            (0.21, &["[0, 0.4]", "[0, 20]"]),
            (0.41, &["[0, 20]"]),
            (25.0, &["[0, 20]"]),
        ] {
            let mut rig = Rig::default_for(8);
            for (n, output) in rig.outputs.iter_mut().enumerate() {
                output.position = Some([wide * n as f64 / 7.0, 0.0, 0.0]);
            }
            let list = rig.advise(&patch);
            assert_eq!(list.len(), wanted.len(), "{wide}: {list:?}");
            for (warning, wanted) in list.iter().zip(wanted) {
                assert!(
                    !warning.is_error() && text[warning.span.clone().unwrap()].contains(wanted),
                    "{wide}: {list:?}"
                );
            }
            assert!(list[list.len() - 1].what.contains("20.00 m from the nearest tactor, `t1`"), "{list:?}");
        }
    }

    #[test]
    fn says_what_the_rig_lacks() {
        let mut rig = Rig::default_for(4);
        rig.outputs.pop();
        let wrong = |rig: &Rig, place| rig.resolve(Some(&place), &(5..9)).unwrap_err();
        let name = wrong(&rig, Place::Name("t33".into()));
        assert_eq!(name.what, "the rig has no tactor `t33`");
        assert_eq!(name.help.as_deref(), Some("did you mean `t3`?"));
        assert_eq!(name.span, Some(5..9));
        assert_eq!(wrong(&rig, Place::Channel(5)).what, "this rig has 4 channels; there is no channel 5");
        assert_eq!(wrong(&rig, Place::Channel(4)).what, "the rig has no tactor on channel 4");
        rig.outputs[0].kind = OutputKind::Trigger { marker: None, pulse: 0.005 };
        assert!(wrong(&rig, Place::Channel(1)).what.contains("is a trigger"));
        assert_eq!(rig.resolve(None, &(0..0)), Ok(Spot::Row(1)));
        rig.outputs.clear();
        assert_eq!(rig.resolve(None, &(0..0)).unwrap_err().what, "the rig has no tactor");
        assert_eq!(wrong(&rig, Place::Position([0.0; 3])).what, "no tactor of the rig has a position");
    }
}
