//! All outputs of a rig.

use super::felt::{BLOCK, Felt};
use super::trace::Trace;
use super::unfelt::{Unfelt, lacking};
use super::wish::Wish;
use crate::actuator::fault::{Fault, within};
use crate::rig::Rig;
use crate::text::Problem;

/// What the actuators of a rig do with what leaves the device.
///
/// Takes interleaved frames as they go to the converter, and gives frames of what is felt: a trace for each voice coil, inertial motor and
/// linear resonant actuator, two for each rumble motor. Each sample is the mean over the time of its frame, so that sums give velocities and
/// no impulse is lost.
///
/// A drive is held for each frame, as models have it; the filter that a real converter has behind that is simulated before diodes alone, which make of
/// a held carrier another mean than of a smooth one: there samples are joined, each in the middle of its frame, as far as half the rate, and what is felt
/// in a frame is known as soon as [`Feel::late`] more have come.
///
/// Of a linear model the mean is what it does where its drive goes in straight lines from sample to sample, a frame late. Both together take at most (ω/rate)²/12
/// of what is felt at a frequency, 0.14 % of 1 kHz at 48 kHz, and below a resonance change it by as much as at that: [`Feel::loses`]. Above a
/// resonance the images of what is held give most of it back to an acceleration: there it is that of the resonance.
///
/// It does not matter how a run is cut, be it in the middle of a frame; [`Feel::finish`] ends it. It allocates only where `felt` has no room, and at
/// the end.
#[derive(Debug, Clone)]
pub struct Feel {
    channels: usize,
    rate: f64,
    felt: Vec<Felt>,
    traces: Vec<Trace>,
    unfelt: Vec<Unfelt>,
    /// A frame that is not yet whole.
    begun: Vec<f32>,
    /// Whole frames, of which is not told yet what is felt in them.
    waiting: Vec<f32>,
    late: usize,
}

/// Frames a second that make sense, at least and at most.
const RATES: (f64, f64) = (100.0, 1e7);

impl Feel {
    /// Everything at rest; frames of so many channels, `rate` a second (100 to 1e7). Outputs whose actuator cannot be simulated have no
    /// trace: see [`Feel::unfelt`].
    ///
    /// # Errors
    /// A wish, a rate or a number of channels that cannot be.
    pub fn new(rig: &Rig, channels: usize, rate: f64, wish: &Wish) -> Result<Self, Fault> {
        wish.check()?;
        within("rate", rate, RATES, "frames a second")?;
        within("channels", channels as f64, (1.0, 1e6), "a frame")?;
        let mut new = Self {
            channels,
            rate,
            felt: Vec::new(),
            traces: Vec::new(),
            unfelt: Vec::new(),
            begun: Vec::new(),
            waiting: Vec::new(),
            late: 0,
        };
        new.begun.reserve(channels);
        for output in &rig.outputs {
            let mut why = lacking(rig, output, channels);
            if why.is_empty() {
                match Felt::new(rig, output, rate, wish) {
                    Ok(Some(felt)) => {
                        new.traces.extend(felt.traces());
                        new.felt.push(felt);
                        continue;
                    }
                    Ok(None) => {
                        let what = format!("too little is known of the actuator of output `{}`", output.name);
                        why.push(Problem::error(&output.span, what));
                    }
                    Err(fault) => {
                        let what =
                            format!("the actuator of output `{}` cannot be simulated: {fault}", output.name);
                        why.push(Problem::error(&output.span, what));
                    }
                }
            }
            new.unfelt.push(Unfelt { output: output.name.clone(), why });
        }
        new.late = new.felt.iter().map(Felt::late).max().unwrap_or(0);
        if new.late > 0 {
            new.waiting.reserve((new.late + BLOCK) * channels);
        }
        Ok(new)
    }

    /// What a frame of what is felt holds, in order; none where of no output it is known what it moves.
    pub fn traces(&self) -> &[Trace] {
        &self.traces
    }

    /// Outputs that are simulated, in the order of their traces.
    pub fn felt(&self) -> &[Felt] {
        &self.felt
    }

    /// Outputs that are not, and why.
    pub fn unfelt(&self) -> &[Unfelt] {
        &self.unfelt
    }

    /// By what share, at most, a tone (Hz, at least 0) is weaker than what its actuator would do, as drives are held for a frame and means over it are told:
    /// 1 − (sin x / x)², x = π f/rate.
    pub fn loses(&self, hertz: f64) -> f64 {
        let x = std::f64::consts::PI * hertz / self.rate;
        if x > 0.0 { 1.0 - (x.sin() / x).powi(2) } else { 0.0 }
    }

    /// How many frames must follow one before it is known what is felt in it: none, or, with a motor behind diodes, 48.
    pub fn late(&self) -> usize {
        self.late
    }

    /// Whether on each output what is felt is no more than that share of what was felt there at most.
    pub fn rests(&self, share: f64) -> bool {
        self.felt.iter().all(|felt| felt.rests(share))
    }

    /// Takes interleaved frames, and leaves in `felt` what they make felt, in place of what was there: a frame for each that is whole, in order, none of them
    /// shifted. The last [`Feel::late`] wait for what follows them, and what is left of a frame waits for the next call.
    pub fn process(&mut self, frames: &[f32], felt: &mut Vec<f32>) {
        felt.clear();
        let mut frames = frames;
        if !self.begun.is_empty() {
            let (more, rest) = frames.split_at(frames.len().min(self.channels - self.begun.len()));
            self.begun.extend_from_slice(more);
            frames = rest;
            if self.begun.len() == self.channels {
                let mut begun = std::mem::take(&mut self.begun);
                self.whole(&begun, felt);
                begun.clear();
                self.begun = begun;
            }
        }
        let (whole, rest) = frames.split_at(frames.len() - frames.len() % self.channels);
        for block in whole.chunks(BLOCK * self.channels) {
            self.whole(block, felt);
        }
        self.begun.extend_from_slice(rest);
    }

    /// Leaves in `felt` what is felt in the frames that wait, as if silence followed, and forgets a frame that is not whole. Frames that are processed
    /// after that follow at once.
    pub fn finish(&mut self, felt: &mut Vec<f32>) {
        felt.clear();
        self.begun.clear();
        if self.waiting.is_empty() {
            return;
        }
        for frames in vec![0.0; self.late * self.channels].chunks(BLOCK * self.channels) {
            self.whole(frames, felt);
        }
        self.waiting.clear();
        self.felt.iter_mut().for_each(Felt::wait);
    }

    /// Whole frames, [`BLOCK`] at most.
    fn whole(&mut self, frames: &[f32], felt: &mut Vec<f32>) {
        if self.late > 0 {
            self.waiting.extend_from_slice(frames);
        }
        let (traces, begin) = (self.traces.len(), felt.len());
        let known = if self.late > 0 {
            let known = (self.waiting.len() / self.channels).saturating_sub(self.late);
            &self.waiting[..known * self.channels]
        } else {
            frames
        };
        felt.resize(begin + known.len() / self.channels * traces, 0.0);
        let mut first = 0;
        for output in &mut self.felt {
            // One behind diodes remembers itself what it waits with.
            let frames = if output.late() > 0 { frames } else { known };
            output.process(frames, self.channels, &mut felt[begin..], [first, traces]);
            first += output.width();
        }
        let known = known.len();
        self.waiting.drain(..if self.late > 0 { known } else { 0 });
    }
}
