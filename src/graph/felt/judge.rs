//! What becomes of what is played in decibels above the threshold.

use std::collections::{BTreeMap, HashMap};

use super::uses::Use;
use crate::graph::places::Places;
use crate::graph::plan::Plan;
use crate::graph::scene::Scene;
use crate::patch::Patch;
use crate::rig::{Finder, Rig};
use crate::space::spot::Spot;
use crate::text::Problem;

/// What becomes of what is played in decibels above the threshold in a scene.
pub struct Judge<'a> {
    rig: &'a Rig,
    finder: Finder,
    plan: &'a Plan,
    places: Places,
    /// By voice, its instrument.
    instruments: HashMap<&'a str, u32>,
    /// By instrument and path: the channels that are passed, each with its largest gain.
    passed: HashMap<(u32, u32), Vec<(u32, f64)>>,
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
            passed: HashMap::new(),
        }
    }

    /// Why something cannot be felt so strongly.
    pub fn check(&self, used: &Use) -> Option<Problem> {
        used.check(self.rig, &self.finder, &self.plan.gauges)
    }

    /// What becomes of it on each output on which it sounds, where that has most of it; nothing of a voice that was left out. Where a node moves it is not known.
    pub fn of(&mut self, used: &Use) -> Vec<Verdict> {
        let Some(number) = self.instruments.get(used.voice.name.as_str()).copied() else { return Vec::new() };
        let mut gains = BTreeMap::<u32, f64>::new();
        for spot in used.spots(self.rig, &self.finder) {
            for &(channel, gain) in self.reached(number, spot) {
                let most = gains.entry(channel).or_default();
                *most = most.max(gain.abs());
            }
        }
        let verdict = |(channel, gain): (u32, f64)| {
            let gauge = self.plan.gauges.get(channel as usize)?.as_ref()?;
            Some(Verdict {
                channel,
                missing: gauge.missing(used.felt, gauge.share(gain), used.hertz),
                most: gauge.most(used.hertz),
                is_calibrated: gauge.is_calibrated(),
            })
        };
        gains.into_iter().filter_map(verdict).collect()
    }

    /// The channels on which an instrument sounds at a place, or along a path.
    fn reached(&mut self, number: u32, spot: Spot) -> &[(u32, f64)] {
        let Self { plan, places, passed, .. } = self;
        match spot {
            Spot::Path(path) => {
                passed.entry((number, path)).or_insert_with(|| along(plan, places, number, path))
            }
            _ => places.of(number as usize, spot),
        }
    }
}

/// A path is looked at so many times from one tactor to the next, and at its points: a tactor that it passes has then its whole share within 0.14 dB.
const FINE: f64 = 32.0;

/// A path is looked at no more often: of one of more than 128 tactors less finely.
const LOOKS: f64 = 4096.0;

/// The channels that an instrument passes on a path, each with its largest gain.
fn along(plan: &Plan, places: &mut Places, number: u32, path: u32) -> Vec<(u32, f64)> {
    let (Some(route), Some(spread)) = (plan.paths.get(path as usize), &plan.spread) else {
        return Vec::new();
    };
    let path = &route.path;
    let looks = (FINE * path.length() / spread.array().spacing()).clamp(1.0, LOOKS).ceil() as u32;
    let between = (0..=looks).map(|n| path.point(path.length() * f64::from(n) / f64::from(looks)));
    let mut gains = BTreeMap::<u32, f64>::new();
    for point in between.chain(path.points().iter().copied()) {
        for &(channel, gain) in places.of(number as usize, Spot::Point(point)) {
            let most = gains.entry(channel).or_default();
            *most = most.max(gain.abs());
        }
    }
    gains.into_iter().collect()
}
