//! Levels that are sent to motors for which clicks alone are played: warnings.

use pacinian::actuator::driver::setup::Shaping;
use pacinian::graph::command::Command;
use pacinian::graph::motions;
use pacinian::graph::plan::Instrument;
use pacinian::graph::program::Feed;
use pacinian::graph::scene::Scene;
use pacinian::patch::{Patch, Place, Play, Start, Voice};
use pacinian::rig::{Finder, OutputKind, Rig};
use pacinian::space::spot::Spread;
use pacinian::text::{Problem, Problems};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// What is looked for.
pub struct Search<'a> {
    patch: &'a Patch,
    rig: &'a Rig,
    finder: Finder,
    /// Outputs whose stage plays clicks alone, by their place in the rig.
    alone: BTreeSet<usize>,
    /// Voices that send a level.
    sounding: HashMap<&'a str, &'a Voice>,
    /// On which of those outputs each of them is played.
    found: BTreeMap<&'a str, BTreeSet<usize>>,
}

/// Looks through the events of a scene that was made of these; those of events files are given to [`Search::row`]. `None` where every motor
/// plays levels.
pub fn search<'a>(patch: &'a Patch, rig: &'a Rig, scene: &Scene) -> Option<Search<'a>> {
    let is_alone =
        |kind: &OutputKind| matches!(kind, OutputKind::Drive(turning) if turning.shaping == Shaping::Clicks);
    let alone: BTreeSet<usize> =
        rig.outputs.iter().enumerate().filter(|(_, output)| is_alone(&output.kind)).map(|(n, _)| n).collect();
    if alone.is_empty() {
        return None;
    }
    let instrument = |number: &Option<u32>| scene.plan.instruments.get((*number)? as usize);
    let voices = patch.voices.iter().zip(&scene.instruments);
    let sounding = voices
        .filter(|(_, number)| instrument(number).is_some_and(sends_a_level))
        .map(|(voice, _)| (voice.name.as_str(), voice))
        .collect();
    let finder = Finder::with(rig, patch);
    let mut search = Search { patch, rig, finder, alone, sounding, found: BTreeMap::new() };
    let always = patch.voices.iter().filter(|voice| voice.start == Start::Always);
    always.for_each(|voice| search.see(&voice.name, None));
    let array = scene.plan.spread.as_ref().map(Spread::array);
    motions::each(patch, array, |voice, _, _, bursts| {
        for burst in bursts.map(|bursts| bursts.list).unwrap_or_default() {
            search.see(&voice.name, Some(&burst.place));
        }
    });
    patch.each_play(|play, _| search.row(play));
    patch.triggers.iter().for_each(|trigger| search.see(&trigger.play, trigger.place.as_ref()));
    Some(search)
}

/// Whether what comes out of a voice is more than the silence of an order.
fn sends_a_level(instrument: &Instrument) -> bool {
    let Some(Feed::Buffer(buffer)) = instrument.program.outputs.first() else { return true };
    let last = instrument.program.ops.iter().rev().find(|op| op.output == *buffer);
    last.is_none_or(|op| Command::of(op.node.kind, &op.node.settings).is_none())
}

impl Search<'_> {
    /// An event.
    pub fn row(&mut self, play: &Play) {
        if play.motion.is_none() {
            self.see(&play.voice, play.place.as_ref());
        }
    }

    fn see(&mut self, voice: &str, place: Option<&Place>) {
        let Some((name, voice)) = self.sounding.get_key_value(voice) else { return };
        let place = place.or(voice.place.as_ref());
        let Ok(spot) = self.rig.resolve_by(&self.finder, place, &(0..0)) else { return };
        let outputs = self.finder.outputs(spot).into_iter().filter(|output| self.alone.contains(output));
        let mut outputs = outputs.peekable();
        if outputs.peek().is_some() {
            self.found.entry(name).or_default().extend(outputs);
        }
    }

    /// Of each voice one; `None` where there are none.
    pub fn advice(self) -> Option<Problems> {
        let told = |(name, outputs): (&&str, &BTreeSet<usize>)| {
            let names = outputs.iter().filter_map(|number| self.rig.outputs.get(*number));
            let names: Vec<String> = names.map(|output| format!("`{}`", output.name)).collect();
            let what = format!(
                "voice `{name}` sends a level to {}, where clicks alone are played (shaping = \"clicks\"): its level is ignored there",
                names.join(", ")
            );
            let help = "order clicks with the node `drive-click`, place the voice elsewhere, or give the output another shaping, as \"inverse\", \
                        on a card and an amplifier that let steady voltages through";
            let span = self.sounding.get(*name).map_or(0..0, |voice| voice.span.clone());
            Problem::warning(&span, what).help(help.to_string())
        };
        let list: Vec<Problem> = self.found.iter().map(told).collect();
        (!list.is_empty()).then(|| self.patch.origin.problems(list))
    }
}
