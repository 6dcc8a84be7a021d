//! What numbers of events are called.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::engine::event::{Event, Move, Play};
use crate::graph::places::Places;
use crate::graph::plan::Plan;
use crate::node::motion::Motion;

use super::kind::Kind;
use super::line::Line;

/// The names of a plan, for its events.
#[derive(Debug, Clone)]
pub struct Names {
    instruments: Vec<(Arc<str>, Vec<Arc<str>>)>,
    /// Whether the node of an instrument moves its voices.
    steered: Vec<bool>,
    rows: Vec<Arc<str>>,
    /// What tells the gains.
    places: Places,
    controls: Vec<Arc<str>>,
    markers: Vec<Arc<str>>,
    /// What sets something off, as their ids count, and the patterns that are set off.
    pub watches: Vec<Arc<str>>,
    pub patterns: Vec<Arc<str>>,
    /// Device frames for each engine sample.
    pub ratio: f64,
}

impl Names {
    /// Those of a plan.
    pub fn of(plan: &Plan) -> Self {
        Self {
            instruments: plan.instruments.iter().map(|i| (Arc::clone(&i.name), i.fields.clone())).collect(),
            steered: plan.instruments.iter().map(|i| i.steered).collect(),
            rows: plan.outputs.iter().map(|output| &output.name).chain(&plan.together).cloned().collect(),
            places: Places::new(plan),
            controls: plan.controls.iter().map(|control| Arc::clone(&control.name)).collect(),
            markers: plan.markers.clone(),
            watches: plan.watching().cloned().collect(),
            patterns: plan.answering.clone(),
            ratio: plan.ratio as f64,
        }
    }

    /// The line of an event, without its times.
    pub fn line(&mut self, event: &Event) -> Line {
        if let Event::Play(play) = event {
            return self.voice(play);
        }
        let named = |names: &[Arc<str>], number: u32| names.get(number as usize).map(|name| name.to_string());
        match event {
            Event::Play(_) => Line::new(Kind::Voice),
            Event::Release(id) => Line { id: Some(*id), ..Line::new(Kind::Release) },
            Event::ReleaseAll => Line::new(Kind::ReleaseAll),
            Event::Silence(id, bits) => {
                Line { id: Some(*id), value: Some(f64::from(*bits)), ..Line::new(Kind::Silence) }
            }
            Event::Cancel(id, bits) => {
                Line { id: Some(*id), value: Some(f64::from(*bits)), ..Line::new(Kind::Cancel) }
            }
            Event::Touch(Move { id, motion, value }) => Line {
                id: Some(*id),
                name: Motion::WORDS.get(motion.number()).map(|word| (*word).to_string()),
                value: Some(*value),
                ..Line::new(Kind::Touch)
            },
            Event::Glide(control, value, seconds) => {
                let (name, duration) = (named(&self.controls, *control), Some(*seconds));
                Line { name, value: Some(*value), duration, ..Line::new(Kind::Control) }
            }
            Event::Control(control, value) => {
                let name = named(&self.controls, *control);
                Line { name, value: Some(*value), ..Line::new(Kind::Control) }
            }
            Event::Shed(above) => Line { value: Some(f64::from(*above)), ..Line::new(Kind::Shed) },
            Event::Push(torque) => Line { value: Some(*torque), ..Line::new(Kind::Push) },
            Event::Arm(arms) => Line { value: Some(f64::from(u8::from(*arms))), ..Line::new(Kind::Arm) },
            Event::Deadline(kept) => {
                Line { value: Some(f64::from(u8::from(*kept))), ..Line::new(Kind::Deadline) }
            }
            Event::Marker(marker, id) => {
                Line { id: Some(*id), name: named(&self.markers, *marker), ..Line::new(Kind::Marker) }
            }
        }
    }

    fn voice(&mut self, play: &Play) -> Line {
        let mut gains = String::new();
        let number = play.instrument as usize;
        // Those of what moves are others at every sample.
        let still = !self.steered.get(number).is_some_and(|steered| *steered);
        let felt = still.then(|| self.places.felt(number, play.place, play.strength()));
        for (channel, gain) in felt.into_iter().flatten() {
            let between = if gains.is_empty() { "" } else { ";" };
            // A string takes whatever it is given.
            let _ = write!(gains, "{between}{}={gain}", channel + 1);
        }
        let instrument = self.instruments.get(play.instrument as usize);
        let place = play.place.name(|row| self.rows.get(row).map(|name| &**name));
        let own = instrument.into_iter().flat_map(|(_, fields)| fields).zip(play.own);
        let fields: BTreeMap<String, f64> = own.map(|(name, value)| (name.to_string(), value)).collect();
        Line {
            id: Some(play.id),
            name: instrument.map(|(name, _)| name.to_string()),
            place: Some(place.into_owned()).filter(|name| !name.is_empty()),
            gains: Some(gains),
            level: Some(play.level),
            felt: play.felt,
            duration: Some(play.duration).filter(|duration| duration.is_finite()),
            fields,
            ..Line::new(Kind::Voice)
        }
    }
}
