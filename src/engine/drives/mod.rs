//! Outputs that turn motors: levels out of the mix, and orders, become samples of what reaches the terminals.
//!
//! A motor is worked out at the engine's rate. What is sent may change at any instant between two of its samples, as a click does; each
//! sample of the device then gets the mean over its time, so that the motor gets the same volt-seconds. Behind a bridge, pulses are as wide as that mean;
//! before a rectifier, a carrier is as large as it takes; and what coupling takes of a click is given beforehand.

pub mod halt;
mod line;

use super::vibration::{Counts, Row, Vibration};
use super::workspace::BLOCK;
use crate::actuator::driver::order::{Order, TOGETHER};
use crate::actuator::driver::turner;
use crate::actuator::fault::Fault;
use crate::actuator::protect::counts;
use crate::dsp::lanes::LANES;
use crate::graph::plan::Plan;
use halt::{Halt, Halts};
use line::Line;

// Orders of a block come before its first sample is computed.
const _: () = assert!(BLOCK <= TOGETHER);

/// The motors of a plan.
#[derive(Debug)]
pub struct Drives {
    lines: Vec<Line>,
    channels: usize,
    ratio: usize,
    counts: Counts,
    halts: Halts,
}

impl Drives {
    /// Those of a plan.
    ///
    /// # Errors
    /// A figure of a motor that cannot be, with its channel (from 0).
    pub fn new(plan: &Plan, vibration: &Vibration) -> Result<Self, (u32, Fault)> {
        // As late as what vibrates, so that all that is felt begins at once.
        let late = (vibration.delay().frames(plan.device_rate) / plan.ratio as f64).round() as usize;
        let there = plan.drives.iter().filter(|drive| Line::is_there(drive, plan.channels));
        let line = |drive| Line::new(plan, drive, late);
        let lines = there.map(line).collect::<Result<_, _>>()?;
        let halts = Halts::new(plan.engine_rate());
        Ok(Self { lines, channels: plan.channels, ratio: plan.ratio, counts: Counts::default(), halts })
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// By how many engine samples what a channel (from 0) sends is later than what is played there.
    pub fn late(&self, channel: usize) -> Option<usize> {
        self.lines.iter().find(|line| line.channel == channel).map(|line| line.turner.late())
    }

    /// Where the mass of the motor of a channel (from 0) hangs, rad from straight down; `None` where that is not known, or no motor is there.
    pub fn hangs(&self, channel: usize) -> Option<f64> {
        self.lines.iter().find(|line| line.channel == channel)?.turner.hangs()
    }

    /// The speed that is wished of the motor of a channel (from 0) in the engine sample that was sent last, rad/s: see [`turner::Turner::wished`].
    pub fn wished(&self, channel: usize) -> Option<f64> {
        self.lines.iter().find(|line| line.channel == channel).map(|line| line.turner.wished())
    }

    /// What happened to the motor of a channel (from 0).
    pub fn counts_of(&self, channel: usize) -> Option<turner::Counts> {
        self.lines.iter().find(|line| line.channel == channel).map(|line| line.turner.counts())
    }

    /// What was held back of what turns the motor of a channel (from 0) so that it bears it; `None` where nothing is known that would be, or where
    /// it is held back behind it ([`Protections`](super::protection::Protections)). Of volts or amperes at the motor.
    pub fn held_back(&self, channel: usize) -> Option<counts::Counts> {
        self.lines.iter().find(|line| line.channel == channel)?.turner.held_back()
    }

    /// Orders for which there was no room, of all motors.
    pub fn dropped(&self) -> u64 {
        self.lines.iter().map(|line| line.turner.counts().dropped).sum()
    }

    /// Samples of the device in which that was so, of all channels.
    pub fn changed(&self) -> u64 {
        self.lines.iter().filter_map(|line| line.turner.held_back()).map(|counts| counts.changed).sum()
    }

    /// The winding of the motor of a channel (from 0), kelvins above the air, where its heat is watched here.
    pub fn temperature(&self, channel: usize) -> Option<f64> {
        self.lines.iter().find(|line| line.channel == channel)?.turner.temperature()
    }

    /// Whether nothing is sent and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.lines.iter().all(Line::is_idle)
    }

    /// Lets no more leave the channels than these levels.
    pub fn limit_to(&mut self, levels: &[f32]) {
        for line in &mut self.lines {
            line.most = levels.get(line.channel).copied().unwrap_or(1.0);
        }
    }

    /// Takes over from old ones at the engine sample `clock`: motors on channels that are not among the `crossed` go on as they were, and of the
    /// others those that were there are as warm as they were, and are brought to rest there.
    pub fn take_over(&mut self, old: &mut Self, crossed: &[usize], clock: u64) {
        for line in &mut self.lines {
            line.turner.begin_at(clock);
            let Some(old) = old.lines.iter_mut().find(|old| old.channel == line.channel) else { continue };
            if crossed.contains(&line.channel) {
                line.turner.warm_as(&mut old.turner);
            } else {
                std::mem::swap(line, old);
                line.turner.trade_tracks(&mut old.turner);
            }
        }
        // Those where there is no motor any more included.
        for line in old.lines.iter_mut().filter(|line| crossed.contains(&line.channel)) {
            line.turner.brake(clock);
        }
        std::mem::swap(&mut self.halts, &mut old.halts);
    }

    /// Halts when others do.
    pub fn halt_with(&mut self, other: &Self) {
        self.halts = other.halts.clone();
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

    /// The channels on which motors are turned, those that say which way among them (from 0).
    pub fn channels(&self) -> impl Iterator<Item = usize> + '_ {
        self.lines.iter().flat_map(|line| [Some(line.channel), line.direction()]).flatten()
    }

    /// All that was ordered ends at an engine sample of the next block: braked for [`BRAKING`](halt::BRAKING), and then exact zeros until something begins.
    pub fn shut(&mut self, clock: u64) {
        self.lines.iter_mut().for_each(|line| line.turner.brake(clock));
        self.halts.shut(clock);
    }

    /// Something begins at an engine sample of the next block.
    pub fn open(&mut self, clock: u64) {
        self.halts.open(clock);
    }

    /// Whether nothing may leave, from the next sample on: motors are braked as long as [`BRAKING`](halt::BRAKING), and then exact zeros are sent until it
    /// may again. What was ordered and is still held goes on then.
    pub fn hold(&mut self, held: bool) {
        self.halts.hold(held);
    }

    /// Takes over what others, of the same motors, know of envelopes.
    pub fn trade_swells(&mut self, other: &mut Self) {
        for (line, other) in self.lines.iter_mut().zip(&mut other.lines) {
            line.turner.trade_tracks(&mut other.turner);
        }
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
        let mut halts = [Halt::None; BLOCK];
        self.halts.next(samples, &mut halts);
        let whole = frames.len() / (self.ratio * self.channels).max(1) * self.ratio;
        for line in &mut self.lines {
            let before = frames.chunks_exact_mut(self.channels).take(whole);
            let mut frames = before.chain(rest.chunks_exact_mut(self.channels));
            for (level, halt) in line.levels[..samples].iter().zip(halts) {
                line.turner.halt(halt != Halt::None, halt == Halt::Rests);
                // What dies away is not played when all is over.
                let level = if halt == Halt::Brakes { 0.0 } else { f64::from(*level) };
                line.turner.step(level, &mut line.parts);
                let emf = line.turner.emf();
                let rests = line.turner.rests();
                let (mut short, mut may_differ) = (false, false);
                for n in 0..line.parts.len() {
                    let (sent, Some(frame)) = (line.parts[n], frames.next()) else { break };
                    let sent = (sent != 0.0 || !rests).then_some(sent);
                    if halt == Halt::Rests {
                        line.output.rest(frame, line.channel);
                    } else {
                        let within = line.output.write(sent, emf, frame, line.channel, line.most);
                        self.counts.clamped += u64::from(!within);
                    }
                    if let Some((arriving, is_short)) = line.arrives() {
                        line.arriving[n] = arriving;
                        (short, may_differ) = (short || is_short, true);
                    }
                }
                if short {
                    line.turner.arrived(&line.arriving);
                }
                if may_differ {
                    line.turner.flowed(&line.arriving);
                }
            }
        }
    }
}
