//! What a channel must be sent for so many decibels above the threshold.

use super::calibration::Table;
use super::threshold::{RANGE, Threshold, decibels};
use crate::actuator::elementary::{cosine, exp, sine};
use crate::actuator::link::coupling::Corners;
use crate::dsp::biquad::Biquad;
use crate::dsp::complex::Complex;
use crate::dsp::steady::steady;

/// Where nobody has measured a tactor, its full level at [`REFERENCE`] counts for so many decibels, whatever they really are.
pub const FULL: f64 = 40.0;

/// That frequency, Hz.
pub const REFERENCE: f64 = 250.0;

/// Between what is played at a tactor and what it is given.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// By what the output multiplies, without its sign.
    pub gain: f64,
    /// Volts, amperes or full scales at the tactor for a sample of 1.0.
    pub per_sample: f64,
    /// What keeps steady voltages off it.
    pub corners: Vec<f64>,
    /// What is done to it before it leaves, at `rate`: an equaliser, a band limit.
    pub filters: Vec<Biquad>,
    /// The engine's rate, Hz.
    pub rate: f64,
    /// The largest sample that may leave, above 0.
    pub most: f64,
    /// `max_level`, to which a limiter keeps it, if one does: of a steady tone it leaves less.
    pub limited: Option<f64>,
}

impl Path {
    /// Adds the corners of a coupling.
    pub fn behind(&mut self, corners: &Corners) {
        self.corners.extend_from_slice(corners.hertz());
    }

    /// What filters and coupling make of an amplitude at a frequency, and what the filters alone do.
    fn response(&self, hertz: f64) -> [f64; 2] {
        let filters: f64 = self.filters.iter().map(|section| magnitude(section, hertz / self.rate)).product();
        let coupling: f64 =
            self.corners.iter().map(|corner| hertz / (hertz * hertz + corner * corner).sqrt()).product();
        [filters * coupling, filters]
    }
}

/// What a section makes of an amplitude at so many turns a sample.
fn magnitude(Biquad { b, a }: &Biquad, turns: f64) -> f64 {
    let z = Complex::new(cosine(turns), -sine(turns));
    let above = z * (z * b[2] + b[1]) + b[0];
    let below = z * (z * a[1] + a[0]) + 1.0;
    let ratio = above / below;
    (ratio.re * ratio.re + ratio.im * ratio.im).sqrt()
}

/// A tactor as it is felt: the threshold at its site, what it gives by its calibration, and the way there.
#[derive(Debug, Clone, PartialEq)]
pub struct Gauge {
    threshold: Threshold,
    table: Table,
    path: Path,
    /// Added to what the table says, dB.
    offset: f64,
    is_calibrated: bool,
}

impl Gauge {
    /// Of a tactor that was measured.
    pub fn calibrated(threshold: Threshold, table: Table, path: Path) -> Self {
        let offset = decibels(path.per_sample.abs().max(f64::MIN_POSITIVE));
        Self { threshold, table, path, offset, is_calibrated: true }
    }

    /// Of one of which only the shape is known, in any unit: its full level at [`REFERENCE`] counts for [`FULL`] decibels. What the output's gain
    /// and the way to it make of it was trimmed by hand, and stays.
    pub fn relative(threshold: Threshold, shape: Table, path: Path) -> Self {
        let path = Path { gain: 1.0, per_sample: 1.0, corners: Vec::new(), ..path };
        let at = [REFERENCE, shape.range()[0], shape.range()[1]];
        let given = at.into_iter().find_map(|hertz| Some(shape.metres(hertz)? - threshold.metres(hertz)));
        let offset =
            FULL - given.unwrap_or(0.0) - decibels(path.response(REFERENCE)[0].max(f64::MIN_POSITIVE));
        Self { threshold, table: shape, path, offset, is_calibrated: false }
    }

    /// Of one of which nothing is known but where it sits: with the same acceleration for each volt at all frequencies, as far above a resonance.
    pub fn unknown(threshold: Threshold, path: Path) -> Self {
        Self::relative(threshold, Table::flat_acceleration(), path)
    }

    /// Whether somebody measured it.
    pub fn is_calibrated(&self) -> bool {
        self.is_calibrated
    }

    /// The threshold at its site.
    pub fn threshold(&self) -> &Threshold {
        &self.threshold
    }

    /// Between which frequencies it is known, Hz.
    pub fn range(&self) -> [f64; 2] {
        let [low, high] = self.table.range();
        [low.max(RANGE[0]), high.min(RANGE[1])]
    }

    /// Whether it is known at a frequency.
    pub fn knows(&self, hertz: f64) -> bool {
        let [low, high] = self.range();
        (low..=high).contains(&hertz)
    }

    /// Within its range: at a frequency beyond, what is at its end holds.
    fn within(&self, hertz: f64) -> f64 {
        let [low, high] = self.range();
        // A range may be empty, which is refused before anything is played.
        if hertz > low { hertz.min(high) } else { low }
    }

    /// Decibels above the threshold of a voice of amplitude 1 at a frequency (Hz), on a tactor that bears any.
    fn full(&self, hertz: f64) -> f64 {
        let sent = self.path.gain * self.path.response(hertz)[0];
        let metres = self.table.metres(hertz).unwrap_or(f64::NEG_INFINITY) + self.offset;
        metres + decibels(sent.max(f64::MIN_POSITIVE)) - self.threshold.metres(hertz)
    }

    /// The most decibels above the threshold that it gives at a frequency (Hz) within [`Gauge::range`].
    pub fn most(&self, hertz: f64) -> f64 {
        let hertz = self.within(hertz);
        self.full(hertz) + decibels(self.limit(hertz))
    }

    /// The largest amplitude of a voice that leaves as it is.
    fn limit(&self, hertz: f64) -> f64 {
        let raised = self.path.gain * self.path.response(hertz)[1];
        let most = self.path.limited.map_or(f64::INFINITY, |level| level * steady(hertz)).min(self.path.most);
        (most / raised.max(f64::MIN_POSITIVE)).max(f64::MIN_POSITIVE)
    }

    /// The amplitude that a voice of amplitude 1 needs for so many decibels above the threshold at a frequency (Hz): 1 is a level of 1. Of it the tactor
    /// takes the share `share`, and no more than its limit leaves. For the audio thread.
    ///
    /// What is no number needs nothing. Beyond [`Gauge::range`] what is at its end holds.
    fn level(&self, felt: f64, share: f64, hertz: f64) -> f64 {
        let hertz = self.within(hertz);
        let wanted = share * amplitude(felt - self.full(hertz));
        // A tactor that is turned down to nothing gives nothing.
        if wanted.is_nan() || self.path.gain <= 0.0 { 0.0 } else { wanted.min(self.limit(hertz)) }
    }

    /// The gain that a channel needs in place of `gain`, by which a voice of a level would reach it, for the voice to be felt there like so many
    /// decibels above the threshold, times the level, at a frequency (Hz). For the audio thread.
    pub fn gain(&self, gain: f64, level: f64, felt: f64, hertz: f64) -> f64 {
        if !self.path.gain.is_normal() || !level.is_normal() {
            return 0.0;
        }
        let share = self.share(gain) * level.abs();
        (self.path.gain * self.level(felt, share, hertz) / level.abs()).copysign(gain)
    }

    /// The share that a channel has of what is played with a gain there.
    pub fn share(&self, gain: f64) -> f64 {
        if self.path.gain > 0.0 { (gain / self.path.gain).abs() } else { 0.0 }
    }

    /// By how much so many decibels on it, of which it takes a share, are beyond its limit, dB; 0 where they are not.
    pub fn missing(&self, felt: f64, share: f64, hertz: f64) -> f64 {
        let wanted = felt + decibels(share.max(f64::MIN_POSITIVE));
        (wanted - self.most(hertz)).max(0.0)
    }
}

/// The ratio of amplitudes of so many decibels.
fn amplitude(decibels: f64) -> f64 {
    exp(decibels * (std::f64::consts::LN_10 / 20.0))
}

#[cfg(test)]
mod tests;
