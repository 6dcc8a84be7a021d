//! One motor on its channel, and what becomes of what is sent to it.

use std::sync::Arc;

use super::super::vibration::single;
use super::super::workspace::BLOCK;
use crate::actuator::driver::turner::Turner;
use crate::actuator::fault::Fault;
use crate::actuator::link::compensator::Compensator;
use crate::actuator::link::effective::Effective;
use crate::actuator::link::pwm::Modulator;
use crate::actuator::link::wave::Wave;
use crate::graph::plan::{Drive, Plan};
use crate::rig::{Bridge, Terminals};

/// A motor on a channel.
#[derive(Debug)]
pub(super) struct Line {
    pub channel: usize,
    pub turner: Turner,
    pub output: Output,
    /// The most that leaves it, on any of its lines.
    pub most: f32,
    pub levels: [f32; BLOCK],
    /// What is sent in each device frame of an engine sample.
    pub parts: Vec<f64>,
    /// What of it arrives.
    pub arriving: Vec<f64>,
}

/// What makes samples of what is sent.
#[derive(Debug)]
pub(super) enum Output {
    /// So many samples for each volt, or ampere.
    Straight(f64),
    /// Pulses for a bridge, and the channel of the line that says which way.
    Bridge(Modulator, usize),
    /// A carrier before a rectifier.
    Carrier(Box<Wave>),
    /// So many samples for each volt, or ampere, and what coupling takes of them made up for.
    Coupled(f64, Box<Compensator>),
}

impl Line {
    /// Whether the channels of a motor are there.
    pub fn is_there(drive: &Drive, channels: usize) -> bool {
        let is_there = |channel: u32| (channel as usize) < channels;
        let has_way = match drive.terminals {
            Terminals::Bridge(Bridge { direction, .. }) => is_there(direction),
            Terminals::Straight | Terminals::Carrier(_) | Terminals::Coupled(_) => true,
        };
        is_there(drive.channel) && has_way
    }

    /// That of a motor, at least so many engine samples late.
    ///
    /// # Errors
    /// A figure that cannot be, with its channel (from 0).
    pub fn new(plan: &Plan, drive: &Drive, late: usize) -> Result<Self, (u32, Fault)> {
        let output = |drive: &Drive| -> Result<Output, Fault> {
            Ok(match drive.terminals {
                Terminals::Straight => Output::Straight(1.0 / drive.per_sample),
                Terminals::Bridge(Bridge { switching, direction }) => {
                    Output::Bridge(Modulator::new(&switching)?, direction as usize)
                }
                Terminals::Carrier(carrier) => {
                    let time = drive.setup.parameters.electrical_time();
                    Output::Carrier(Box::new(Wave::new(&carrier, time, plan.device_rate, drive.per_sample)?))
                }
                Terminals::Coupled(corners) => Output::Coupled(
                    1.0 / drive.per_sample,
                    Box::new(drive.setup.through(&corners, plan.device_rate, drive.per_sample)?),
                ),
            })
        };
        let of = |fault: Fault| (drive.channel, fault);
        let turner = || -> Result<Turner, Fault> {
            let number = plan.drives.iter().position(|other| other.channel == drive.channel);
            let swells = number.into_iter().flat_map(|number| plan.swells_of(number));
            let tracks = swells.map(|swell| Arc::clone(&swell.track)).collect();
            let turner = Turner::new(&drive.setup, late)?.knowing(tracks);
            let Some(bears) = &drive.bears else { return Ok(turner) };
            let time = drive.setup.parameters.electrical_time();
            let effective = match &drive.terminals {
                Terminals::Straight | Terminals::Coupled(_) => Effective::steady(),
                Terminals::Bridge(Bridge { switching, .. }) => {
                    Effective::pulses(switching, plan.device_rate, time)?
                }
                Terminals::Carrier(carrier) => Effective::carrier(carrier, time)?,
            };
            turner.bearing(bears, effective)
        };
        Ok(Self {
            channel: drive.channel as usize,
            turner: turner().map_err(of)?,
            output: output(drive).map_err(of)?,
            most: plan.max_levels().get(drive.channel as usize).map_or(1.0, |level| single(*level)),
            levels: [0.0; BLOCK],
            parts: vec![0.0; plan.ratio],
            arriving: vec![0.0; plan.ratio],
        })
    }

    /// What of the last frame reaches the motor, where that may be something else than what was sent, and whether it is.
    #[inline]
    pub fn arrives(&self) -> Option<(f64, bool)> {
        match &self.output {
            Output::Coupled(samples, compensator) => {
                Some((compensator.arrived() / *samples, compensator.is_short()))
            }
            _ => None,
        }
    }

    /// The channel of the line that says which way, where there is one.
    pub fn direction(&self) -> Option<usize> {
        match self.output {
            Output::Bridge(_, direction) => Some(direction),
            _ => None,
        }
    }

    /// Whether nothing is sent and nothing waits.
    pub fn is_idle(&self) -> bool {
        let is_idle = match &self.output {
            Output::Straight(_) | Output::Carrier(_) => true,
            Output::Bridge(modulator, _) => modulator.is_idle(),
            Output::Coupled(_, compensator) => compensator.is_idle(),
        };
        self.turner.is_idle() && is_idle
    }
}

impl Output {
    /// Writes a frame in which nothing is sent, whatever is still under way.
    #[inline]
    pub fn rest(&mut self, frame: &mut [f32], channel: usize) {
        frame[channel] = 0.0;
        match self {
            Self::Straight(_) => {}
            Self::Bridge(modulator, direction) => {
                modulator.reset();
                frame[*direction] = 0.0;
            }
            Self::Carrier(wave) => drop(wave.step(0.0, 0.0, 0.0)),
            Self::Coupled(_, compensator) => compensator.rest(),
        }
    }

    /// Writes a frame of what is sent on average, if anything is, of a motor that makes so many volts itself; whether that is within what may
    /// leave.
    #[inline]
    pub fn write(
        &mut self,
        sent: Option<f64>,
        emf: f64,
        frame: &mut [f32],
        channel: usize,
        most: f32,
    ) -> bool {
        let wanted = sent;
        let sent = sent.unwrap_or(0.0);
        match self {
            Self::Straight(samples) => {
                let value = (sent * *samples) as f32;
                let within = value.abs() <= most;
                frame[channel] = if within { value } else { most.copysign(value) };
                within
            }
            Self::Bridge(modulator, direction) => {
                let now = modulator.step(sent);
                frame[channel] = if now.on { most } else { 0.0 };
                frame[*direction] = if now.reverse { most } else { 0.0 };
                true
            }
            Self::Carrier(wave) => {
                let (value, held) = wave.step(sent, emf, f64::from(most));
                frame[channel] = value as f32;
                !held
            }
            Self::Coupled(samples, compensator) => {
                let before = compensator.limited();
                let value = compensator.step(wanted.map(|sent| sent * *samples), f64::from(most));
                frame[channel] = value as f32;
                compensator.limited() == before
            }
        }
    }
}
