//! What is sent to motors that do nothing of it, levels where clicks alone are played and ways home where there is none: warnings.

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
use std::sync::Arc;

/// What is looked for.
pub struct Search<'a> {
    patch: &'a Patch,
    rig: &'a Rig,
    finder: Finder,
    /// Levels, of outputs whose stage plays clicks alone.
    levels: Sought<'a>,
    /// Orders home, of outputs whose motor cannot be brought there.
    homes: Sought<'a>,
    /// Of those outputs, why.
    why: BTreeMap<usize, Arc<str>>,
    /// The outputs whose motor can be brought home.
    homing: Vec<&'a str>,
}

/// Voices of one sort on outputs of one sort.
struct Sought<'a> {
    /// By their place in the rig.
    outputs: BTreeSet<usize>,
    voices: HashMap<&'a str, &'a Voice>,
    /// On which of those outputs each of them is played.
    found: BTreeMap<&'a str, BTreeSet<usize>>,
}

/// Looks through the events of a scene that was made of these; those of events files are given to [`Search::row`]. `None` where every motor
/// plays levels and goes home.
pub fn search<'a>(patch: &'a Patch, rig: &'a Rig, scene: &Scene) -> Option<Search<'a>> {
    let is_alone =
        |kind: &OutputKind| matches!(kind, OutputKind::Drive(turning) if turning.shaping == Shaping::Clicks);
    let alone: BTreeSet<usize> =
        rig.outputs.iter().enumerate().filter(|(_, output)| is_alone(&output.kind)).map(|(n, _)| n).collect();
    let output = |number: usize| {
        let drive = scene.plan.drives.get(number)?;
        rig.outputs.iter().position(|output| output.channel == drive.channel + 1)
    };
    let homeless = scene.plan.homeless.iter();
    let why: BTreeMap<usize, Arc<str>> =
        homeless.filter_map(|(number, why)| Some((output(*number)?, Arc::clone(why)))).collect();
    if alone.is_empty() && why.is_empty() {
        return None;
    }
    let homing = scene.plan.homes.iter().filter_map(|(number, _)| rig.outputs.get(output(*number)?));
    let homing = homing.map(|output| output.name.as_str()).collect();
    let instrument = |number: &Option<u32>| scene.plan.instruments.get((*number)? as usize);
    let sought = |outputs, is_meant: fn(&Instrument) -> bool| {
        let voices = patch.voices.iter().zip(&scene.instruments);
        let meant = voices.filter(|(_, number)| instrument(number).is_some_and(is_meant));
        let voices = meant.map(|(voice, _)| (voice.name.as_str(), voice)).collect();
        Sought { outputs, voices, found: BTreeMap::new() }
    };
    let levels = sought(alone, sends_a_level);
    let homes = sought(why.keys().copied().collect(), sends_home);
    let finder = Finder::with(rig, patch);
    let mut search = Search { patch, rig, finder, levels, homes, why, homing };
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

/// Whether a voice orders the way home.
fn sends_home(instrument: &Instrument) -> bool {
    instrument.commands().contains(&Command::Home)
}

impl Search<'_> {
    /// An event.
    pub fn row(&mut self, play: &Play) {
        if play.motion.is_none() {
            self.see(&play.voice, play.place.as_ref());
        }
    }

    fn see(&mut self, voice: &str, place: Option<&Place>) {
        for sought in [&mut self.levels, &mut self.homes] {
            let Some((name, voice)) = sought.voices.get_key_value(voice) else { continue };
            let place = place.or(voice.place.as_ref());
            let Ok(spot) = self.rig.resolve_by(&self.finder, place, &(0..0)) else { continue };
            let outputs = self.finder.outputs(spot).into_iter();
            let mut outputs = outputs.filter(|output| sought.outputs.contains(output)).peekable();
            if outputs.peek().is_some() {
                sought.found.entry(name).or_default().extend(outputs);
            }
        }
    }

    /// Of each voice one for its levels, and one for each motor that it cannot send home; `None` where there are none.
    pub fn advice(self) -> Option<Problems> {
        let span =
            |sought: &Sought, name: &str| sought.voices.get(name).map_or(0..0, |voice| voice.span.clone());
        let told = |(name, outputs): (&&str, &BTreeSet<usize>)| {
            let names = outputs.iter().filter_map(|number| self.rig.outputs.get(*number));
            let names: Vec<String> = names.map(|output| format!("`{}`", output.name)).collect();
            let what = format!(
                "voice `{name}` sends a level to {}, where clicks alone are played (shaping = \"clicks\"): its level is ignored there",
                names.join(", ")
            );
            let help = "order clicks with the node `drive-click`, place the voice elsewhere, or give the output another shaping, as \"inverse\", \
                        on a card and an amplifier that let steady voltages through";
            Problem::warning(&span(&self.levels, name), what).help(help.to_string())
        };
        let mut list: Vec<Problem> = self.levels.found.iter().map(told).collect();
        let homing: Vec<String> = self.homing.iter().map(|name| format!("`{name}`")).collect();
        for (name, number) in
            self.homes.found.iter().flat_map(|(name, all)| all.iter().map(move |n| (name, n)))
        {
            let (Some(output), Some(why)) = (self.rig.outputs.get(*number), self.why.get(number)) else {
                continue;
            };
            let what = format!(
                "voice `{name}` sends the motor of `{}` home (drive-home), where its mass cannot be brought: {why}; the order is ignored there",
                output.name
            );
            let help = format!(
                "an upright plane (tilt = 0.0) and a steady voltage are what it takes; or play the voice on what can be brought home: {}",
                homing.join(", ")
            );
            list.push(Problem::warning(&span(&self.homes, name), what).help(help));
        }
        (!list.is_empty()).then(|| self.patch.origin.problems(list))
    }
}
