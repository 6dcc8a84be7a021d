//! What becomes of what is played in decibels above the threshold.

use std::collections::HashMap;

use super::uses::Use;
use crate::graph::places::Places;
use crate::graph::plan::Plan;
use crate::graph::scene::Scene;
use crate::patch::Patch;
use crate::rig::{Finder, Rig};
use crate::text::Problem;

/// What becomes of what is played in decibels above the threshold in a scene.
pub struct Judge<'a> {
    rig: &'a Rig,
    finder: Finder,
    plan: &'a Plan,
    places: Places,
    /// By voice, its instrument.
    instruments: HashMap<&'a str, u32>,
}

/// What becomes of it on one output.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The channel, from 0.
    pub channel: u32,
    /// By how much it is capped, dB; 0 where it is not.
    pub missing: f64,
    /// The most decibels above the threshold that the tactor gives there.
    pub most: f64,
    /// Whether it was measured, so that all of these are what they say.
    pub is_calibrated: bool,
}

impl<'a> Judge<'a> {
    /// Of a scene that was made of these.
    pub fn new(patch: &'a Patch, rig: &'a Rig, scene: &'a Scene) -> Self {
        let instruments = patch.voices.iter().zip(&scene.instruments);
        Self {
            rig,
            finder: Finder::with(rig, patch),
            plan: &scene.plan,
            places: Places::new(&scene.plan),
            instruments: instruments
                .filter_map(|(voice, number)| Some((voice.name.as_str(), (*number)?)))
                .collect(),
        }
    }

    /// Why something cannot be felt so strongly.
    pub fn check(&self, used: &Use) -> Option<Problem> {
        used.check(self.rig, &self.finder, &self.plan.gauges)
    }

    /// What becomes of it on each output on which it sounds; nothing of a voice that was left out.
    pub fn of(&mut self, used: &Use) -> Vec<Verdict> {
        let Some(number) = self.instruments.get(used.voice.name.as_str()) else { return Vec::new() };
        let Ok(spot) = self.rig.resolve_by(&self.finder, used.place, used.span) else { return Vec::new() };
        let gauges = &self.plan.gauges;
        let verdict = |&(channel, gain): &(u32, f64)| {
            let gauge = gauges.get(channel as usize)?.as_ref()?;
            Some(Verdict {
                channel,
                missing: gauge.missing(used.felt, gauge.share(gain), used.hertz),
                most: gauge.most(used.hertz),
                is_calibrated: gauge.is_calibrated(),
            })
        };
        self.places.of(*number as usize, spot).iter().filter_map(verdict).collect()
    }
}
