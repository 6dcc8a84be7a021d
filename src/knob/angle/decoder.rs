//! Readings of a sensor, one for each tick of the servo.

use super::linear::{Linear, Slope};
use super::quadrature::{Lines, Quadrature};
use super::resolver::{Pair, Resolver};
use crate::actuator::fault::Fault;

/// Stands in a frame for what was not heard: no card gives it, and a file keeps it.
pub const NOT_HEARD: f32 = f32::MAX;

/// How inputs say an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sense {
    /// Sine and cosine.
    Pair(Pair),
    /// The lines A and B of an encoder.
    Lines(Lines),
    /// A voltage.
    Slope(Slope),
}

/// What reads an angle by a card's inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// How they say it.
    pub sense: Sense,
    /// The inputs, from 0: sine and cosine, A and B, or the voltage twice.
    pub channels: [usize; 2],
    /// Whether it falls where the knob's angle rises.
    pub inverted: bool,
}

impl Sensor {
    /// Frames by which the middle of what a reading is made of is older than the reading, at so many frames a tick.
    pub fn late(&self, frames: usize) -> f64 {
        match self.sense {
            Sense::Lines(_) => 0.0,
            Sense::Pair(_) | Sense::Slope(_) => 0.5 * (frames.max(1) - 1) as f64,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    Pair(Resolver),
    Lines(Quadrature),
    Slope(Linear),
}

/// Frames into readings. What sine, cosine or a voltage were is the mean over a tick's frames, which takes √frames of their noise away; an
/// encoder's edges are counted in each.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoder {
    by: By,
    channels: [usize; 2],
    sign: f64,
    /// Frames of a tick, and how many are still to come until it is full.
    frames: usize,
    left: usize,
    /// What came since the last reading, and in how many frames.
    sum: [f64; 2],
    heard: usize,
    whole: bool,
    /// What the encoder's lines said last.
    counted: Option<f64>,
    lost: u64,
}

impl Decoder {
    /// For so many frames a tick, 1 or more. The first frame makes a reading of its own.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(sensor: &Sensor, frames: usize) -> Result<Self, Fault> {
        let by = match &sensor.sense {
            Sense::Pair(pair) => By::Pair(Resolver::new(pair)?),
            Sense::Lines(lines) => By::Lines(Quadrature::new(lines)?),
            Sense::Slope(slope) => By::Slope(Linear::new(slope)?),
        };
        Ok(Self {
            by,
            channels: sensor.channels,
            sign: if sensor.inverted { -1.0 } else { 1.0 },
            frames: frames.max(1),
            left: 1,
            sum: [0.0; 2],
            heard: 0,
            whole: true,
            counted: None,
            lost: 0,
        })
    }

    /// Takes a frame of all inputs, or that there was none. Where it ends a tick, gives the angle in radians, or that it is lost: a frame of
    /// the tick was not heard, or the sensor says nothing that can be.
    #[inline]
    pub fn push(&mut self, frame: Option<&[f32]>) -> Option<Option<f64>> {
        let value = |channel: usize| match frame.and_then(|frame| frame.get(channel)) {
            Some(x) if x.abs() < NOT_HEARD => f64::from(*x),
            _ => f64::NAN,
        };
        let pair = self.channels.map(value);
        match &mut self.by {
            By::Lines(lines) => {
                self.counted = lines.push(pair[0], pair[1]);
                self.whole &= self.counted.is_some();
            }
            By::Pair(by) => self.whole &= by.is_whole(pair[0], pair[1]),
            By::Slope(by) => self.whole &= by.is_whole(pair[0]),
        }
        // In the mean a part of a tick would pass that is far off.
        self.sum[0] += pair[0];
        self.sum[1] += pair[1];
        self.heard += 1;
        self.left -= 1;
        (self.left == 0).then(|| self.reading())
    }

    fn reading(&mut self) -> Option<f64> {
        let mean = self.sum.map(|sum| sum / self.heard as f64);
        let whole = std::mem::replace(&mut self.whole, true);
        (self.left, self.heard, self.sum) = (self.frames, 0, [0.0; 2]);
        let angle = match &mut self.by {
            _ if !whole => None,
            By::Pair(pair) => pair.push(mean[0], mean[1]),
            By::Lines(_) => self.counted,
            By::Slope(slope) => slope.push(mean[0]),
        };
        self.lost += u64::from(angle.is_none());
        angle.map(|angle| self.sign * angle)
    }

    /// Ticks for which there was no angle.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}
