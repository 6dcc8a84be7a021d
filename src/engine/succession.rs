//! From one output stage to another, while both sound.
//!
//! Where a new plan has another actuator on a channel, another equaliser or another amplifier, its stage is another as well. Channels of which
//! all is as it was go on in the new stage as they were in the old one, to the bit. The others are played by both: each hears the same mix,
//! and the old one's part falls from 1 to 0 while that of the new one rises from 0 to 1, [`RAMP`] seconds long. What is between two things that both
//! keep to their limits keeps to the wider of them.
//!
//! A motor of the old stage is brought to rest first, and hears nothing any more; only then the new stage is heard there. Lines that are on or off
//! (pulses at markers, bridges) are not faded in, as half of full scale would mean neither: they begin when the old ones are gone.

use std::sync::Arc;

use super::vibration::Row;
use super::workspace::BLOCK;
use crate::actuator::protect::bounds::Bounds;
use crate::dsp::biquad::Biquad;
use crate::dsp::lanes::LANES;
use crate::graph::plan::{Drive, OutputKind, Plan};
use crate::rig::Terminals;

/// Seconds from the old stage to the new one.
pub(super) const RAMP: f64 = 0.02;

/// Seconds for which a motor is braked before, at least and at most: twice the time in which it comes to speed.
const BRAKE: (f64, f64) = (0.02, 1.0);

/// The channels that differ, and how far each is.
#[derive(Debug)]
pub(crate) struct Succession {
    channels: Vec<usize>,
    fades: Vec<Fade>,
    width: usize,
    ratio: usize,
    ramp: u32,
    /// Frames since it began, and when all is over.
    at: u32,
    end: u32,
    /// Of the old stage, its groups that are fed, and its frames.
    fed: Vec<bool>,
    frames: Vec<f32>,
}

#[derive(Debug)]
struct Fade {
    channel: usize,
    /// Frames for which the new stage waits.
    wait: u32,
    /// Whether the old stage hears nothing there.
    deaf: bool,
    /// Whether the new stage comes at once when the old one is gone.
    abrupt: bool,
}

/// All that makes the stage of one channel what it is.
#[derive(Debug, PartialEq)]
struct Hanging<'a> {
    outputs: Vec<(Kind<'a>, &'a [Biquad], bool)>,
    drive: Option<&'a Drive>,
    bounds: Option<&'a Bounds>,
}

/// What an output is, markers by their names.
#[derive(Debug, PartialEq)]
enum Kind<'a> {
    Trigger(Option<&'a Arc<str>>, f64),
    Other(OutputKind),
}

impl<'a> Hanging<'a> {
    fn on(plan: &'a Plan, channel: usize) -> Self {
        let kind = |kind: OutputKind| match kind {
            OutputKind::Trigger { marker, pulse } => {
                Kind::Trigger(marker.and_then(|marker| plan.markers.get(marker as usize)), pulse)
            }
            other => Kind::Other(other),
        };
        let here = plan.outputs.iter().filter(|output| output.channel as usize == channel);
        Self {
            outputs: here.map(|o| (kind(o.kind), o.equaliser.as_slice(), o.keeps_dc_off)).collect(),
            drive: plan.drives.iter().find(|drive| lines(drive).contains(&Some(channel))),
            bounds: plan.protections.iter().find(|(c, _)| *c as usize == channel).map(|(_, bounds)| bounds),
        }
    }

    fn is_trigger(&self) -> bool {
        matches!(self.outputs.first(), Some((Kind::Trigger(..), ..)))
    }

    fn is_on_or_off(&self) -> bool {
        self.is_trigger() || self.drive.is_some_and(|d| matches!(d.terminals, Terminals::Bridge(_)))
    }
}

/// The channels that a motor is driven by.
fn lines(drive: &Drive) -> [Option<usize>; 2] {
    let way = match &drive.terminals {
        Terminals::Bridge(bridge) => Some(bridge.direction as usize),
        Terminals::Straight | Terminals::Carrier(_) | Terminals::Coupled(_) => None,
    };
    [Some(drive.channel as usize), way]
}

impl Succession {
    /// Between the stages of two plans of as many channels at the same rates; `None` where nothing differs but levels.
    pub fn between(old: &Plan, new: &Plan) -> Option<Self> {
        // A trigger knows its marker by a number, which may be another one now.
        let renumbered = old.markers != new.markers;
        let ramp = (RAMP * new.device_rate).round().max(1.0) as u32;
        let (mut channels, mut fades) = (Vec::new(), Vec::new());
        for channel in 0..new.channels {
            let (was, is) = (Hanging::on(old, channel), Hanging::on(new, channel));
            if was == is && !(renumbered && is.is_trigger()) {
                continue;
            }
            channels.push(channel);
            // Pulses go on, whatever those to come will be like.
            if was.is_trigger() && is.is_trigger() {
                continue;
            }
            let brakes = |drive: &Drive| {
                let seconds = 2.0 * drive.setup.parameters.mechanical_time();
                let seconds = if seconds.is_finite() { seconds.clamp(BRAKE.0, BRAKE.1) } else { BRAKE.1 };
                (seconds * new.device_rate).round() as u32
            };
            let wait = was.drive.map_or(0, brakes);
            fades.push(Fade { channel, wait, deaf: was.drive.is_some(), abrupt: is.is_on_or_off() });
        }
        let end = fades.iter().map(|fade| fade.wait + ramp).max().unwrap_or(0);
        (!channels.is_empty()).then(|| Self {
            channels,
            fades,
            width: new.channels,
            ratio: new.ratio.max(1),
            ramp,
            at: 0,
            // One that has begun is over at once where there is nothing to fade.
            end: end.max(1),
            fed: vec![false; new.channels.div_ceil(LANES)],
            frames: vec![0.0; (BLOCK + 1) * new.ratio * new.channels],
        })
    }

    /// The channels that differ, from 0.
    pub fn channels(&self) -> &[usize] {
        &self.channels
    }

    /// Whether nothing of the old stage is heard any more.
    pub fn is_over(&self) -> bool {
        self.at >= self.end
    }

    /// Gives the old stage what it hears of a mix of `samples` rows for each group of eight channels.
    pub fn feed(&mut self, old: &mut [Row], mix: &[Row], fed: &[bool], samples: usize) {
        self.fed.fill(false);
        for fade in self.fades.iter().filter(|fade| !fade.deaf) {
            let (group, lane) = (fade.channel / LANES, fade.channel % LANES);
            let range = group * samples..(group + 1) * samples;
            let (Some(old), Some(mix)) = (old.get_mut(range.clone()), mix.get(range)) else { continue };
            if fed.get(group) == Some(&false) {
                continue;
            }
            if !std::mem::replace(&mut self.fed[group], true) {
                old.fill([0.0; LANES]);
            }
            old.iter_mut().zip(mix).for_each(|(old, mix)| old[lane] = mix[lane]);
        }
    }

    /// The old stage's groups that are fed, and where its frames go, which are as many.
    pub fn room(&mut self, output: usize, rest: usize) -> (&[bool], &mut [f32], &mut [f32]) {
        let (output, over) = self.frames.split_at_mut(output);
        (&self.fed, output, &mut over[..rest])
    }

    /// Mixes the old stage's frames of so many engine samples into those of the new one.
    pub fn mix(&mut self, samples: usize, output: &mut [f32], rest: &mut [f32]) {
        let width = self.width.max(1);
        // Both stages write whole engine samples, and one that has no room there to the rest.
        let (room, whole) = (output.len(), output.len() / (self.ratio * width) * self.ratio);
        let frames = output.chunks_exact_mut(width).take(whole).chain(rest.chunks_exact_mut(width));
        let old = self.frames[..room].chunks_exact(width).take(whole);
        let both = frames.zip(old.chain(self.frames[room..].chunks_exact(width)));
        for (new, old) in both.take(samples * self.ratio) {
            self.at = self.at.saturating_add(1);
            for fade in &self.fades {
                let x = self.at.saturating_sub(fade.wait).min(self.ramp) as f32 / self.ramp as f32;
                let share = x * x * (3.0 - 2.0 * x);
                let (old, new) = (old[fade.channel], &mut new[fade.channel]);
                *new = match (x >= 1.0, fade.abrupt) {
                    (true, _) => *new,
                    (false, true) => old * (1.0 - share),
                    // Rounding leads nowhere that neither of both goes.
                    (false, false) => (old + share * (*new - old)).max(old.min(*new)).min(old.max(*new)),
                };
            }
        }
    }
}
