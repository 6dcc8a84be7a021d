//! What numbers of events are called.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::engine::event::{Event, Move, Play};
use crate::graph::plan::Plan;
use crate::node::motion::Motion;

use super::kind::Kind;
use super::line::Line;

/// The names of a plan, for its events.
#[derive(Debug, Clone)]
pub struct Names {
    instruments: Vec<(Arc<str>, Vec<Arc<str>>)>,
    /// With the gains in words.
    places: Vec<(Arc<str>, String)>,
    controls: Vec<Arc<str>>,
    markers: Vec<Arc<str>>,
    /// Device frames for each engine sample.
    pub ratio: f64,
}

impl Names {
    /// Those of a plan.
    pub fn of(plan: &Plan) -> Self {
        let gains = |row: &[(u32, f64)]| {
            let mut words = String::new();
            for (channel, gain) in row {
                let between = if words.is_empty() { "" } else { ";" };
                // A string takes whatever it is given.
                let _ = write!(words, "{between}{}={gain}", channel + 1);
            }
            words
        };
        let outputs = plan.outputs.iter().map(|output| Arc::clone(&output.name));
        Self {
            instruments: plan.instruments.iter().map(|i| (Arc::clone(&i.name), i.fields.clone())).collect(),
            places: outputs.zip(&plan.places).map(|(name, row)| (name, gains(row))).collect(),
            controls: plan.controls.iter().map(|control| Arc::clone(&control.name)).collect(),
            markers: plan.markers.clone(),
            ratio: plan.ratio as f64,
        }
    }

    /// The line of an event, without its times.
    pub fn line(&self, event: &Event) -> Line {
        let named = |names: &[Arc<str>], number: u32| names.get(number as usize).map(|name| name.to_string());
        match event {
            Event::Play(play) => self.voice(play),
            Event::Release(id) => Line { id: Some(*id), ..Line::new(Kind::Release) },
            Event::ReleaseAll => Line::new(Kind::ReleaseAll),
            Event::Silence(id, bits) => {
                Line { id: Some(*id), value: Some(f64::from(*bits)), ..Line::new(Kind::Silence) }
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
            Event::Marker(marker) => Line { name: named(&self.markers, *marker), ..Line::new(Kind::Marker) },
        }
    }

    fn voice(&self, play: &Play) -> Line {
        let instrument = self.instruments.get(play.instrument as usize);
        let place = self.places.get(play.place as usize);
        let own = instrument.into_iter().flat_map(|(_, fields)| fields).zip(play.own);
        let fields: BTreeMap<String, f64> = own.map(|(name, value)| (name.to_string(), value)).collect();
        Line {
            id: Some(play.id),
            name: instrument.map(|(name, _)| name.to_string()),
            place: place.map(|(name, _)| name.to_string()),
            gains: place.map(|(_, gains)| gains.clone()),
            level: Some(play.level),
            duration: Some(play.duration).filter(|duration| duration.is_finite()),
            fields,
            ..Line::new(Kind::Voice)
        }
    }
}
