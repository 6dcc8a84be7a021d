//! From a place in a patch to an output of the rig.

use super::{Output, OutputKind, Rig};
use crate::patch::{Action, Events, Patch, Place, Source};
use crate::text::nearest::suggest;
use crate::text::reader::Sink;
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
        if let Some(Place::Position(position)) = place
            && !position.iter().all(|x| x.is_finite())
        {
            let what = format!("{position:?} is no position");
            return Err(Problem::error(span, what).help("give metres, finite numbers".to_string()));
        }
        match (self.find(place).and_then(|i| self.outputs.get(i).map(|o| (i, o))), place) {
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
                let what = format!("there is no channel {channel}; the device has {}", self.device.channels);
                Err(Problem::error(span, what).help("channels count from 1".to_string()))
            }
            (None, Some(Place::Channel(channel))) => {
                let help = format!("describe what hangs there: [[tactor]] with channel = {channel}");
                Err(Problem::error(span, format!("the rig has no tactor on channel {channel}")).help(help))
            }
            (None, Some(Place::Position(_))) => {
                let help = "give the tactors a `position`".to_string();
                Err(Problem::error(span, "no tactor of the rig has a position").help(help))
            }
            (None, None) => Err(Problem::error(span, "the rig has no tactor")),
        }
    }

    fn find(&self, place: Option<&Place>) -> Option<usize> {
        match place {
            None => self.outputs.iter().position(|o| o.kind == OutputKind::Vibration),
            Some(Place::Name(name)) => self.outputs.iter().position(|o| o.name == *name),
            Some(Place::Channel(channel)) => self.outputs.iter().position(|o| o.channel == *channel),
            Some(Place::Position(position)) => self.nearest(position),
        }
    }

    /// Every place of a patch that the rig lacks, up to [`Sink::MOST`]; those of events files are left to their reader.
    pub fn check_places(&self, patch: &Patch) -> Vec<Problem> {
        let (mut problems, mut further, mut last) = (Vec::new(), 0_usize, 0..0);
        let mut check = |place: Option<&Place>, span: &Span| {
            let Some(place) = place else { return };
            if problems.len() < Sink::MOST {
                problems.extend(self.resolve(Some(place), span).err());
            } else {
                // Without advice, which takes a look at every name there is.
                let found = self.find(Some(place)).and_then(|i| self.outputs.get(i));
                if !found.is_some_and(sounds) {
                    (further, last) = (further + 1, span.clone());
                }
            }
        };
        for voice in &patch.voices {
            check(voice.place.as_ref(), &voice.place_span);
        }
        for pattern in &patch.patterns {
            let Events::Inline(events) = &pattern.events else { continue };
            for event in events {
                match &event.action {
                    Action::Voice(play) => check(play.place.as_ref(), &play.place_span),
                    Action::Choose(alternatives) => {
                        for alternative in alternatives {
                            if let Action::Voice(play) = &alternative.action {
                                check(play.place.as_ref(), &play.place_span);
                            }
                        }
                    }
                    Action::Pattern { .. } | Action::Marker(_) => {}
                }
            }
        }
        for trigger in patch.triggers.iter().filter(|t| t.on == Source::Start) {
            check(trigger.place.as_ref(), &trigger.span);
        }
        if further > 0 {
            problems.push(Problem::error(
                &last,
                format!("and {further} more places that the rig lacks, up to here"),
            ));
        }
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

#[cfg(test)]
mod tests {
    use crate::patch::Place;
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
    fn says_what_the_rig_lacks() {
        let mut rig = Rig::default_for(4);
        rig.outputs.pop();
        let wrong = |rig: &Rig, place| rig.resolve(Some(&place), &(5..9)).unwrap_err();
        let name = wrong(&rig, Place::Name("t33".into()));
        assert_eq!(name.what, "the rig has no tactor `t33`");
        assert_eq!(name.help.as_deref(), Some("did you mean `t3`?"));
        assert_eq!(name.span, Some(5..9));
        assert_eq!(wrong(&rig, Place::Channel(5)).what, "there is no channel 5; the device has 4");
        assert_eq!(wrong(&rig, Place::Channel(4)).what, "the rig has no tactor on channel 4");
        rig.outputs[0].kind = OutputKind::Trigger { marker: None, pulse: 0.005 };
        assert!(wrong(&rig, Place::Channel(1)).what.contains("is a trigger"));
        assert_eq!(rig.resolve(None, &(0..0)), Ok(1));
        rig.outputs.clear();
        assert_eq!(rig.resolve(None, &(0..0)).unwrap_err().what, "the rig has no tactor");
        assert_eq!(wrong(&rig, Place::Position([0.0; 3])).what, "no tactor of the rig has a position");
    }
}
