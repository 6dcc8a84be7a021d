//! From a place in a patch to an output of the rig.

use super::{Finder, Output, OutputKind, Rig};
use crate::patch::{Patch, Place};
use crate::text::nearest::suggest;
use crate::text::sink::Sink;
use crate::text::{Problem, Span};

fn sounds(output: &Output) -> bool {
    !matches!(output.kind, OutputKind::Trigger { .. })
}

impl Rig {
    /// The output, by its place in [`Rig::outputs`], on which a place sounds. `None` is the first tactor; a position goes to the
    /// nearest tactor, the first in the list among equals. A name or a channel may be any output but a trigger.
    ///
    /// # Errors
    /// Says what the rig lacks and suggests the nearest name; points at `span`.
    pub fn resolve(&self, place: Option<&Place>, span: &Span) -> Result<usize, Problem> {
        self.answer(|place| self.find(place), place, span)
    }

    /// As [`Rig::resolve`], for many places: `finder` is this rig's.
    ///
    /// # Errors
    /// As [`Rig::resolve`].
    pub fn resolve_by(&self, finder: &Finder, place: Option<&Place>, span: &Span) -> Result<usize, Problem> {
        self.answer(|place| finder.find(place), place, span)
    }

    fn answer(
        &self,
        find: impl Fn(Option<&Place>) -> Option<usize>,
        place: Option<&Place>,
        span: &Span,
    ) -> Result<usize, Problem> {
        if let Some(Place::Position(position)) = place
            && !position.iter().all(|x| x.is_finite())
        {
            let what = format!("{position:?} is no position");
            return Err(Problem::error(span, what).help("give metres, finite numbers".to_string()));
        }
        match (find(place).and_then(|i| self.outputs.get(i).map(|o| (i, o))), place) {
            (Some((i, output)), _) if sounds(output) => Ok(i),
            (Some((_, output)), _) => Err(Problem::error(
                span,
                format!(
                    "output `{}` is a trigger: it gives pulses at markers and plays nothing",
                    output.name
                ),
            )),
            (None, Some(Place::Name(name))) => {
                let names = self.outputs.iter().filter(|o| sounds(o)).map(|o| o.name.as_str());
                Err(Problem::error(span, format!("the rig has no tactor `{name}`"))
                    .help(suggest(name, names)))
            }
            (None, Some(Place::Channel(channel))) if *channel == 0 || *channel > self.device.channels => {
                let has = self.device.channels;
                let what = format!(
                    "this rig has {has} channel{}; the patch needs channel {channel}",
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
            (None, Some(Place::Position(_))) => {
                let help = "give the tactors a `position`".to_string();
                Err(Problem::error(span, "no tactor of the rig has a position").help(help))
            }
            (None, None) => {
                let help = "describe one, [[tactor]], or say at which output it is played: place = \"NAME\"";
                Err(Problem::error(span, "the rig has no tactor").help(help.to_string()))
            }
        }
    }

    fn find(&self, place: Option<&Place>) -> Option<usize> {
        match place {
            None => super::finder::first(&self.outputs),
            Some(Place::Name(name)) => self.outputs.iter().position(|o| o.name == *name),
            Some(Place::Channel(channel)) => self.outputs.iter().position(|o| o.channel == *channel),
            Some(Place::Position(position)) => self.nearest(position),
        }
    }

    /// Every place of a patch that the rig lacks, up to [`Sink::MOST`]; those of events files are left to their reader.
    pub fn check_places(&self, patch: &Patch) -> Vec<Problem> {
        let (mut problems, mut further, mut last) = (Vec::new(), 0_usize, 0..0);
        let finder = Finder::new(self);
        patch.each_place(|place, span| {
            if problems.len() < Sink::MOST {
                problems.extend(self.resolve_by(&finder, Some(place), span).err());
            } else {
                // Without advice, which takes a look at every name there is.
                let found = finder.find(Some(place)).and_then(|i| self.outputs.get(i));
                if !found.is_some_and(sounds) {
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
        patch.each_place(|place, span| {
            let Place::Position(position) = place else { return };
            let Some((far, output)) =
                finder.nearest(position).and_then(|(far, i)| Some((far, self.outputs.get(i)?)))
            else {
                return;
            };
            if far > ASTRAY && problems.len() < Sink::MOST {
                let shown = position.map(|x| x.to_string()).join(", ");
                let what = format!(
                    "the place [{shown}] is {far:.2} m from the nearest tactor, `{}`, which plays it",
                    output.name
                );
                let help = "positions are metres, of the patch as of the rig".to_string();
                problems.push(Problem::warning(span, what).help(help));
            }
        });
        problems
    }

    fn nearest(&self, position: &[f64; 3]) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for (i, output) in self.outputs.iter().enumerate() {
            let (OutputKind::Vibration, Some(at)) = (&output.kind, &output.position) else { continue };
            let far: f64 = at.iter().zip(position).map(|(a, b)| (a - b) * (a - b)).sum();
            if best.is_none_or(|(least, _)| far < least) {
                best = Some((far, i));
            }
        }
        best.map(|(_, i)| i)
    }
}

/// A place so many metres from every tactor was hardly meant.
const ASTRAY: f64 = 0.5;

#[cfg(test)]
mod tests {
    use crate::patch::{Patch, Place};
    use crate::rig::{OutputKind, Rig};

    #[test]
    fn finds_tactors_by_name_channel_and_position() {
        let rig = Rig::default_for(4);
        let find = |place| rig.resolve(Some(&place), &(0..0));
        assert_eq!(find(Place::Name("t3".into())), Ok(2));
        assert_eq!(find(Place::Channel(4)), Ok(3));
        assert_eq!(find(Place::Position([0.05, 0.2, 0.0])), Ok(1), "40 mm is nearer than 80 mm");
        assert_eq!(find(Place::Position([0.06, 0.0, 0.0])), Ok(1), "the first among equals");
        assert_eq!(rig.resolve(None, &(0..0)), Ok(0));
    }

    #[test]
    fn a_place_far_from_every_tactor_is_a_warning() {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.v]\noutput = \"n\"\n\
                    nodes.n = { type = \"white\" }\n[pattern.p]\nevents = [\n\
                    { at = 0, voice = \"v\", place = [0.1, 0.4] },\n{ at = 1, voice = \"v\", place = [0, 20] },\n]\n";
        let patch = Patch::parse("p.toml", text.as_bytes()).unwrap().value;
        let list = Rig::default_for(8).advise(&patch);
        assert_eq!(list.len(), 1, "{list:?}");
        assert!(
            !list[0].is_error() && list[0].what.contains("20.00 m from the nearest tactor, `t1`"),
            "{list:?}"
        );
        assert!(text[list[0].span.clone().unwrap()].contains("[0, 20]"));
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
        assert_eq!(wrong(&rig, Place::Channel(5)).what, "this rig has 4 channels; the patch needs channel 5");
        assert_eq!(wrong(&rig, Place::Channel(4)).what, "the rig has no tactor on channel 4");
        rig.outputs[0].kind = OutputKind::Trigger { marker: None, pulse: 0.005 };
        assert!(wrong(&rig, Place::Channel(1)).what.contains("is a trigger"));
        assert_eq!(rig.resolve(None, &(0..0)), Ok(1));
        rig.outputs.clear();
        assert_eq!(rig.resolve(None, &(0..0)).unwrap_err().what, "the rig has no tactor");
        assert_eq!(wrong(&rig, Place::Position([0.0; 3])).what, "no tactor of the rig has a position");
    }
}
