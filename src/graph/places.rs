//! Where voices sound, as channels with gains.

use std::sync::Arc;

use super::plan::Plan;
use crate::patch::Pitch;
use crate::perception::gauge::Gauge;
use crate::space::law::Law;
use crate::space::spot::{Spot, Spread};

/// The places of a plan.
#[derive(Debug, Clone)]
pub struct Places {
    rows: Vec<Vec<(u32, f64)>>,
    spread: Option<Spread>,
    /// By instrument: how tactors share its points, and how far those spread.
    sharing: Vec<(Law, f64)>,
    /// Room for what is found.
    found: Vec<(u32, f64)>,
    /// By channel: what it needs to be felt.
    gauges: Arc<[Option<Gauge>]>,
    /// By instrument: the frequency at which what is felt of it holds.
    pitches: Vec<Pitch>,
}

/// How strong a voice is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// Its level.
    pub level: f64,
    /// Decibels above the threshold that a level of 1 is to be felt like; `None`: as loud as it comes.
    pub felt: Option<f64>,
    /// The frequency of its event, Hz.
    pub frequency: f64,
}

/// What is said in decibels above the threshold is as much on every channel as that one needs.
#[derive(Debug, Clone, Copy)]
pub struct Needs<'a> {
    gauges: &'a [Option<Gauge>],
    strength: Strength,
    /// The frequency at which it holds, Hz.
    hertz: f64,
}

impl<'a> Needs<'a> {
    /// Of a voice, where channels are felt by these gauges.
    pub fn new(gauges: &'a [Option<Gauge>], strength: Strength, pitch: Pitch) -> Self {
        Self { gauges, strength, hertz: pitch.hertz(strength.frequency).unwrap_or(strength.frequency) }
    }

    /// The gain of a channel that would have this one. A channel of which nothing is known that could be felt, as a motor's, gets nothing. For the
    /// audio thread.
    #[inline(always)]
    pub fn of(&self, channel: u32, gain: f64) -> f64 {
        let Strength { level, felt: Some(felt), .. } = self.strength else { return gain };
        let gauge = self.gauges.get(channel as usize).and_then(Option::as_ref);
        gauge.map_or(0.0, |gauge| gauge.gain(gain, level, felt, self.hertz))
    }
}

impl Places {
    /// Those of a plan.
    pub fn new(plan: &Plan) -> Self {
        let most = plan.spread.as_ref().map_or(0, |spread| spread.channels().len());
        let longest = plan.places.iter().map(Vec::len).max().unwrap_or(0);
        Self {
            rows: plan.places.clone(),
            spread: plan.spread.clone(),
            sharing: plan.instruments.iter().map(|instrument| (instrument.law, instrument.width)).collect(),
            found: Vec::with_capacity(if plan.gauges.is_empty() { most } else { most.max(longest) }),
            gauges: Arc::clone(&plan.gauges),
            pitches: plan.instruments.iter().map(|instrument| instrument.pitch).collect(),
        }
    }

    /// The channels on which a voice of an instrument sounds, with their gains; none where there is no such place, nor along a path, where
    /// they change all the time.
    pub fn of(&mut self, instrument: usize, spot: Spot) -> &[(u32, f64)] {
        match spot {
            Spot::Row(row) => self.rows.get(row as usize).map_or(&[][..], |row| row),
            Spot::Point(point) => {
                self.found.clear();
                let (law, width) = self.sharing.get(instrument).copied().unwrap_or_default();
                if let Some(spread) = &mut self.spread {
                    spread.gains(point, width, law, &mut self.found);
                }
                &self.found
            }
            Spot::Path(_) => &[],
        }
    }

    /// The same for a voice of a strength: where that is said in decibels above the threshold, with the gains that its level needs for them on each of
    /// the channels, within what they bear. For the audio thread.
    pub fn felt(&mut self, instrument: usize, spot: Spot, strength: Strength) -> &[(u32, f64)] {
        if strength.felt.is_none() {
            return self.of(instrument, spot);
        }
        match spot {
            Spot::Row(row) => {
                self.found.clear();
                self.found
                    .extend(self.rows.get(row as usize).into_iter().flatten().take(self.found.capacity()));
            }
            // They are found where they are wanted.
            Spot::Point(_) => {
                let _ = self.of(instrument, spot);
            }
            Spot::Path(_) => self.found.clear(),
        }
        let pitch = self.pitches.get(instrument).copied().unwrap_or(Pitch::OfEvent);
        let needs = Needs::new(&self.gauges, strength, pitch);
        for (channel, gain) in &mut self.found {
            *gain = needs.of(*channel, *gain);
        }
        &self.found
    }
}
