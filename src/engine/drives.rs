//! Outputs that turn motors: levels out of the mix, and orders, become samples of what reaches the terminals.
//!
//! A motor is worked out at the engine's rate. What is sent may change at any instant between two of its samples, as a click does; each
//! sample of the device then gets the mean over its time, so that the motor gets the same volt-seconds. Behind a bridge, pulses are as wide as that mean.

use super::vibration::{Counts, Row, Vibration, single};
use super::workspace::BLOCK;
use crate::actuator::driver::order::Order;
use crate::actuator::driver::turner::{self, Turner};
use crate::actuator::fault::Fault;
use crate::actuator::link::pwm::Modulator;
use crate::dsp::lanes::LANES;
use crate::graph::plan::Plan;
use crate::rig::Bridge;

/// The motors of a plan.
#[derive(Debug)]
pub struct Drives {
    lines: Vec<Line>,
    channels: usize,
    ratio: usize,
    counts: Counts,
}

#[derive(Debug)]
struct Line {
    channel: usize,
    turner: Turner,
    /// Samples of the device for each volt, or ampere, at the motor.
    samples: f64,
    /// The most that leaves it, on either line.
    most: f32,
    levels: [f32; BLOCK],
    /// What is sent in each device frame of an engine sample.
    parts: Vec<f64>,
    pulses: Option<Pulses>,
}

/// What makes pulses for a bridge.
#[derive(Debug)]
struct Pulses {
    modulator: Modulator,
    /// The channel of the line that says which way.
    direction: usize,
}

impl Drives {
    /// Those of a plan.
    ///
    /// # Errors
    /// A figure of a motor that cannot be, with its channel (from 0).
    pub fn new(plan: &Plan, vibration: &Vibration) -> Result<Self, (u32, Fault)> {
        // As late as what vibrates, so that all that is felt begins at once.
        let late = (vibration.delay().frames(plan.device_rate) / plan.ratio as f64).round() as usize;
        let pulses = |bridge: Bridge| {
            let direction = bridge.direction as usize;
            Ok(Pulses { modulator: Modulator::new(&bridge.switching)?, direction })
        };
        let line = |drive: &crate::graph::plan::Drive| {
            Ok(Line {
                channel: drive.channel as usize,
                turner: Turner::new(&drive.setup, late).map_err(|fault| (drive.channel, fault))?,
                samples: 1.0 / drive.per_sample,
                most: plan.max_levels().get(drive.channel as usize).map_or(1.0, |level| single(*level)),
                levels: [0.0; BLOCK],
                parts: vec![0.0; plan.ratio],
                pulses: drive.bridge.map(pulses).transpose().map_err(|fault| (drive.channel, fault))?,
            })
        };
        let is_there = |channel: u32| (channel as usize) < plan.channels;
        let there = plan.drives.iter().filter(|drive| {
            is_there(drive.channel) && drive.bridge.is_none_or(|bridge| is_there(bridge.direction))
        });
        let lines = there.map(line).collect::<Result<_, _>>()?;
        Ok(Self { lines, channels: plan.channels, ratio: plan.ratio, counts: Counts::default() })
    }

    /// By how many engine samples what a channel (from 0) sends is later than what is played there.
    pub fn late(&self, channel: usize) -> Option<usize> {
        self.lines.iter().find(|line| line.channel == channel).map(|line| line.turner.late())
    }

    /// What happened to the motor of a channel (from 0).
    pub fn counts_of(&self, channel: usize) -> Option<turner::Counts> {
        self.lines.iter().find(|line| line.channel == channel).map(|line| line.turner.counts())
    }

    /// Whether nothing is sent and nothing waits.
    pub fn is_idle(&self) -> bool {
        let gives = |pulses: &Pulses| !pulses.modulator.is_idle();
        self.lines.iter().all(|line| line.turner.is_idle() && !line.pulses.as_ref().is_some_and(gives))
    }

    /// Lets no more leave the channels than these levels.
    pub fn limit_to(&mut self, levels: &[f32]) {
        for line in &mut self.lines {
            line.most = levels.get(line.channel).copied().unwrap_or(1.0);
        }
    }

    /// Samples that were no numbers, and those that were beyond what may leave.
    pub fn counts(&self) -> Counts {
        let mut counts = self.counts;
        counts.masked += self.lines.iter().map(|line| line.turner.counts().masked).sum::<u64>();
        counts
    }

    /// An order at an instant, in engine samples.
    pub fn order(&mut self, channel: u32, at: f64, voice: u64, order: Order) {
        if let Some(line) = self.lines.iter_mut().find(|line| line.channel == channel as usize) {
            line.turner.order(at, voice, order);
        }
    }

    /// All of them are brought to rest, as fast as may be.
    pub fn brake(&mut self) {
        self.lines.iter_mut().for_each(|line| line.turner.brake());
    }

    /// Takes its channels out of the mix: a block of `samples` rows for each group of eight channels, and whether it was fed.
    pub fn take(&mut self, rows: &mut [Row], fed: &[bool], samples: usize) {
        for line in &mut self.lines {
            let (group, lane) = (line.channel / LANES, line.channel % LANES);
            let levels = &mut line.levels[..samples];
            match rows.get_mut(group * samples..(group + 1) * samples) {
                Some(rows) if fed.get(group) != Some(&false) => {
                    for (level, row) in levels.iter_mut().zip(rows) {
                        *level = std::mem::take(&mut row[lane]);
                    }
                }
                _ => levels.fill(0.0),
            }
        }
    }

    /// Writes the frames of the samples that were taken last; those of the last one lie in `rest` where `frames` has no room.
    pub fn write(&mut self, samples: usize, frames: &mut [f32], rest: &mut [f32]) {
        let whole = frames.len() / (self.ratio * self.channels).max(1) * self.ratio;
        for line in &mut self.lines {
            let before = frames.chunks_exact_mut(self.channels).take(whole);
            let mut frames = before.chain(rest.chunks_exact_mut(self.channels));
            for level in &line.levels[..samples] {
                line.turner.step(f64::from(*level), &mut line.parts);
                for (sent, frame) in line.parts.iter().zip(&mut frames) {
                    if let Some(pulses) = &mut line.pulses {
                        let now = pulses.modulator.step(*sent);
                        frame[line.channel] = if now.on { line.most } else { 0.0 };
                        frame[pulses.direction] = if now.reverse { line.most } else { 0.0 };
                        continue;
                    }
                    let value = (sent * line.samples) as f32;
                    let within = value.abs() <= line.most;
                    self.counts.clamped += u64::from(!within);
                    frame[line.channel] = if within { value } else { line.most.copysign(value) };
                }
            }
        }
    }
}
