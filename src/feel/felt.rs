//! An output whose actuator is simulated.

use super::chain::{Lines, assumed_of, carrier, chain};
use super::figures::{Counts, Figures, Meter};
use super::left::Left;
use super::mover::Mover;
use super::now::Now;
use super::trace::{Trace, Unit};
use super::wish::Wish;
use crate::actuator::fault::Fault;
use crate::actuator::link::Link;
use crate::actuator::link::converter::{Converter, LATE};
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
    /// Before diodes: what leaves between samples, and how many samples of the first [`LATE`] have come.
    between: Option<(Box<Converter>, usize)>,
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
        let carrier = carrier(rig, output);
        let Some(mover) = Mover::new(actuator, output, &chain.amplifier, carrier.as_ref(), rate, wish.error)?
        else {
            return Ok(None);
        };
        let parts = if carrier.is_some() { mover.steps } else { 1 };
        let between = carrier.map(|_| Converter::new(parts)).transpose()?;
        Ok(Some(Self {
            output: output.name.clone(),
            channel: output.channel.saturating_sub(1) as usize,
            actuator: actuator.name.clone(),
            model: actuator.model,
            assumed,
            stroke: actuator.value("stroke"),
            rate,
            link: Link::new(&chain, rate * f64::from(parts))?,
            between: between.map(|converter| (Box::new(converter), 0)),
            lines: Lines::of(rig, output),
            mover,
            meter: Meter::new(rate),
            moved: false,
            masked: 0,
            drives: Vec::with_capacity(BLOCK * parts as usize),
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

    /// Whether samples are joined as a converter joins them, which matters before diodes, and not held.
    pub fn is_joined(&self) -> bool {
        self.between.is_some()
    }

    /// The error of what is felt that is left where the wish cannot be granted; `None` where it is. Before diodes a carrier is followed in no more than 256 parts of
    /// a frame.
    pub fn reaches(&self) -> Option<f64> {
        self.mover.reaches
    }

    /// What of the model was left out, and why.
    pub fn left_out(&self) -> &[Left] {
        &self.mover.left_out
    }

    /// What it does at the end of the last frame that was computed: that is [`Felt::is_joined`] later than the one that was given last.
    pub fn now(&self) -> Now {
        let last =
            self.drives.len().saturating_sub(if self.between.is_some() { self.steps() as usize } else { 1 });
        let given = self.drives.get(last..).unwrap_or_default();
        let drive = given.iter().sum::<f64>() / given.len().max(1) as f64;
        Now { drive, ..self.mover.now() }
    }

    /// What it did so far.
    pub fn figures(&self) -> Figures {
        let [peak, peak_at, rms] = self.meter.read(self.rate);
        let link = self.link.counts();
        let counts =
            Counts { clipped: link.clipped, limited: link.limited, masked: link.masked + self.masked };
        let last = self.meter.last();
        let mut figures = Figures { peak, peak_at, rms, last, counts, ..Figures::default() };
        self.mover.fill_in(&mut figures, self.stroke);
        figures
    }

    /// Whether what is felt is no more than that share of what was felt at most.
    pub(super) fn rests(&self, share: f64) -> bool {
        self.meter.last() <= share * self.meter.read(self.rate)[0]
    }

    /// How many traces it has.
    pub(super) fn width(&self) -> usize {
        self.mover.axes.len()
    }

    /// How many frames must follow one before it is known what is felt in it.
    pub(super) fn late(&self) -> usize {
        if self.between.is_some() { LATE } else { 0 }
    }

    /// Waits anew for what must follow a frame.
    pub(super) fn wait(&mut self) {
        if let Some((_, known)) = &mut self.between {
            *known = 0;
        }
    }

    /// Takes its samples out of frames of `channels`, [`BLOCK`] at most, and puts what is felt into frames of `traces` that are 0, from its
    /// `first` on. Of one that is [`Felt::late`] these are so many frames before those that come.
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
        let samples = frames.chunks_exact(channels).map(|frame| f64::from(sample(frame)));
        let each = match &mut self.between {
            None => {
                self.drives.extend(samples.map(|sample| link.step(sample)));
                1
            }
            Some((converter, known)) => {
                let each = converter.parts();
                for sample in samples {
                    let begin = self.drives.len();
                    self.drives.resize(begin + each, 0.0);
                    converter.step(link.cut(sample), &mut self.drives[begin..]);
                    if *known < LATE {
                        *known += 1;
                        self.drives.truncate(begin);
                    } else {
                        link.parts(&mut self.drives[begin..]);
                    }
                }
                each
            }
        };
        // At rest, what is driven by nothing stays so: no model runs before something is played.
        let is_still = |drives: &&[f64]| drives.iter().all(|drive| *drive == 0.0);
        let rests = if self.moved { 0 } else { self.drives.chunks_exact(each).take_while(is_still).count() };
        let count = self.drives.len() / each;
        self.moved |= rests < count;
        self.meter.rest(rests as u64);
        let done = &mut self.felt[..count - rests];
        self.mover.run(&self.drives[rests * each..], done);
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
