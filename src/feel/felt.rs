//! An output whose actuator is simulated.

use super::chain::{Lines, assumed_of, chain, rectifier};
use super::figures::{Counts, Figures, Meter};
use super::left::Left;
use super::mover::Mover;
use super::trace::{Trace, Unit};
use super::wish::Wish;
use crate::actuator::fault::Fault;
use crate::actuator::link::Link;
use crate::actuator::motor::Level;
use crate::rig::{Model, Output, Rig};

/// An output whose actuator is simulated.
#[derive(Debug, Clone)]
pub struct Felt {
    /// Its name.
    pub output: String,
    /// Its channel, from 0.
    pub channel: usize,
    /// Name of the actuator in the rig.
    pub actuator: String,
    /// What that is.
    pub model: Model,
    /// What was assumed as the rig does not say it, a clause each.
    pub assumed: Vec<String>,
    stroke: Option<f64>,
    rate: f64,
    link: Link,
    lines: Option<Lines>,
    mover: Mover,
    meter: Meter,
    /// Whether something has been played.
    moved: bool,
    /// What led to no number.
    masked: u64,
    drives: Vec<f64>,
    felt: Vec<[f64; 2]>,
}

/// Frames that are computed at once, at most.
pub(super) const BLOCK: usize = 256;

impl Felt {
    /// Of an output of which [`lacking`](super::unfelt::lacking) misses nothing; `None` if something is missing all the same.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub(super) fn new(rig: &Rig, output: &Output, rate: f64, wish: &Wish) -> Result<Option<Self>, Fault> {
        let Some(actuator) = output.actuator.as_ref().and_then(|name| rig.actuator(name)) else {
            return Ok(None);
        };
        let mut assumed = Vec::new();
        let Some(chain) = chain(rig, output, &mut assumed) else { return Ok(None) };
        assumed_of(actuator, &chain.amplifier, &mut assumed);
        let link = Link::new(&chain, rate)?;
        let mover = Mover::new(actuator, output, &chain.amplifier, rectifier(rig, output), rate, wish.error)?;
        Ok(mover.map(|mover| Self {
            output: output.name.clone(),
            channel: output.channel.saturating_sub(1) as usize,
            actuator: actuator.name.clone(),
            model: actuator.model,
            assumed,
            stroke: actuator.value("stroke"),
            rate,
            link,
            lines: Lines::of(rig, output),
            mover,
            meter: Meter::default(),
            moved: false,
            masked: 0,
            drives: Vec::with_capacity(BLOCK),
            felt: vec![[0.0; 2]; BLOCK],
        }))
    }

    /// What is told of it, in the order of its traces.
    pub fn traces(&self) -> impl Iterator<Item = Trace> + '_ {
        let trace = |axis: &_| Trace { output: self.output.clone(), axis: *axis, unit: self.unit() };
        self.mover.axes.iter().map(trace)
    }

    /// Of its traces.
    pub fn unit(&self) -> Unit {
        self.mover.unit
    }

    /// Of a rumble motor: how well it is computed. Models of actuators with a coil are exact, but for rounding.
    pub fn level(&self) -> Option<Level> {
        self.mover.level
    }

    /// Steps of the model for each sample.
    pub fn steps(&self) -> u32 {
        self.mover.steps
    }

    /// What of the model was left out, and why.
    pub fn left_out(&self) -> &[Left] {
        &self.mover.left_out
    }

    /// What it did so far.
    pub fn figures(&self) -> Figures {
        let [peak, peak_at, rms] = self.meter.read(self.rate);
        let link = self.link.counts();
        let counts =
            Counts { clipped: link.clipped, limited: link.limited, masked: link.masked + self.masked };
        let mut figures = Figures { peak, peak_at, rms, counts, ..Figures::default() };
        self.mover.fill_in(&mut figures, self.stroke);
        figures
    }

    /// How many traces it has.
    pub(super) fn width(&self) -> usize {
        self.mover.axes.len()
    }

    /// Takes its samples out of frames of `channels`, [`BLOCK`] at most, and puts what is felt into frames of `traces` that are 0, from its
    /// `first` on.
    pub(super) fn process(
        &mut self,
        frames: &[f32],
        channels: usize,
        felt: &mut [f32],
        [first, traces]: [usize; 2],
    ) {
        self.drives.clear();
        let (link, lines, channel) = (&mut self.link, &self.lines, self.channel);
        let sample = |frame: &[f32]| match lines {
            Some(lines) => lines.read(frame, channel),
            None => frame.get(channel).copied().unwrap_or(0.0),
        };
        let drives = frames.chunks_exact(channels).map(|frame| link.step(f64::from(sample(frame))));
        self.drives.extend(drives);
        // At rest, what is driven by nothing stays so: no model runs before something is played.
        let rests =
            if self.moved { 0 } else { self.drives.iter().take_while(|drive| **drive == 0.0).count() };
        self.moved |= rests < self.drives.len();
        self.meter.rest(rests as u64);
        let done = &mut self.felt[..self.drives.len() - rests];
        self.mover.run(&self.drives[rests..], done);
        let axes = self.mover.axes.len();
        for (done, frame) in done.iter().zip(felt.chunks_exact_mut(traces).skip(rests)) {
            // Far below what a float holds, so that no figure of the meter overflows either.
            let sound = done.iter().all(|value| value.abs() < 1e30);
            self.masked += u64::from(!sound);
            let [x, y] = if sound { *done } else { [0.0; 2] };
            self.meter.take(x * x + y * y);
            for (slot, value) in frame[first..].iter_mut().zip([x, y]).take(axes) {
                *slot = value as f32;
            }
        }
    }
}
