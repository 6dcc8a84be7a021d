//! Telling of what signals set off in the engine, which no performer has played.

use std::sync::Arc;

use super::{Happening, Heard, Origin, Performer};
use crate::engine::watch::Crossing;
use crate::graph::plan::Plan;
use crate::schedule::Instant;

/// A voice by its name, and its fields with their defaults.
type Voice = (Arc<str>, Vec<(String, f64)>);

/// What a plan calls what its watches and its knob set off.
#[derive(Debug, Clone)]
pub struct Callings {
    /// By instrument.
    voices: Vec<Voice>,
    places: Vec<Arc<str>>,
    watches: Vec<Arc<str>>,
    rate: f64,
}

impl Callings {
    /// Those of a plan.
    pub fn of(plan: &Plan) -> Self {
        let starts = plan.knob.iter().flat_map(|knob| &knob.starts);
        if plan.watches.is_empty() && starts.clone().next().is_none() {
            return Self { voices: vec![], places: vec![], watches: vec![], rate: plan.engine_rate() };
        }
        let voices = plan.instruments.iter().map(|instrument| {
            let fields = instrument
                .fields
                .iter()
                .map(|name| name.to_string())
                .zip(instrument.defaults.iter().copied());
            (Arc::clone(&instrument.name), fields.collect())
        });
        Self {
            voices: voices.collect(),
            places: plan.outputs.iter().map(|output| &output.name).chain(&plan.together).cloned().collect(),
            // As their ids count: the knob's stand behind.
            watches: plan
                .watches
                .iter()
                .map(|watch| &watch.name)
                .chain(starts.map(|start| &start.name))
                .cloned()
                .collect(),
            rate: plan.engine_rate(),
        }
    }
}

impl Performer {
    /// Tells the listener of a voice that a signal has set off in an engine whose plan calls things so. Its origin is what set it off,
    /// `node.breath rises 0.3`.
    pub fn tell_crossing(&mut self, callings: &Callings, crossing: &Crossing) {
        let Some(listener) = &mut self.listener else { return };
        let &Crossing { at, watch, number, play } = crossing;
        let (Some((name, fields)), Some(pattern)) =
            (callings.voices.get(play.instrument as usize), callings.watches.get(watch as usize))
        else {
            return;
        };
        let what = Happening::Voice {
            name,
            place: &play.place.name(|row| callings.places.get(row).map(|name| &**name)),
            level: play.level,
            felt: play.felt,
            duration: play.duration,
            fields,
            own: &play.own,
        };
        let seconds = at.since(Instant::default()) / callings.rate;
        let origin = Some(Origin { pattern, event: number, drawn: None });
        listener(&Heard { at: seconds, instant: at, origin, id: Some(play.id), what });
    }
}
