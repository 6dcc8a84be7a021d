//! A piezo as what an amplifier sees of it: a capacitor.
//!
//! What it moves is not modelled; its stroke is taken to follow the voltage across it. C dv/dt = i − v / R_p, i = (V − v) / R_s within
//! the amplifier's ± I; what it cannot supply, the voltage runs after. Steps are exact, also those in which the limit sets in or is left.

use std::f64::consts::{PI, TAU};

use crate::actuator::elementary::exp_m1;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// A piezo and the amplifier that drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piezo {
    /// Farads.
    pub capacitance: f64,
    /// Ohms in series: leads, amplifier, losses; above 0.
    pub series: f64,
    /// Ohms in parallel: leakage; `None`: there is none.
    pub parallel: Option<f64>,
    /// Tangent of the loss angle: heat over reactive power. It heats, and is else neglected.
    pub loss: f64,
    /// Volts it bears, lowest and highest; lowest at most 0.
    pub volts: [f64; 2],
    /// Amperes the amplifier gives.
    pub amperes: f64,
    /// Volts a second the amplifier gives; `None`: no limit but the current.
    pub slew: Option<f64>,
}

impl Piezo {
    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first figure that is not above 0 (`loss`: not below it), or a range of voltage without 0 inside.
    pub fn check(&self) -> Result<(), Fault> {
        positive("capacitance", self.capacitance)?;
        positive("series", self.series)?;
        self.parallel.map_or(Ok(()), |parallel| positive("parallel", parallel))?;
        check("loss", self.loss, Limit::Least(0.0))?;
        check("volts.low", self.volts[0], Limit::Most(0.0))?;
        positive("volts.high", self.volts[1])?;
        positive("amperes", self.amperes)?;
        self.slew.map_or(Ok(()), |slew| positive("slew", slew))
    }

    /// Volts a second at most: of the current or the amplifier, whichever is less.
    pub fn most_slew(&self) -> f64 {
        let current = self.amperes / self.capacitance;
        self.slew.map_or(current, |slew| slew.min(current))
    }

    /// The highest frequency (Hz) at which a sine of this amplitude (V, peak) is followed: I / (2π C V), or slew / (2π V).
    pub fn most_hertz(&self, amplitude: f64) -> f64 {
        self.most_slew() / (TAU * amplitude)
    }

    /// The largest amplitude (V, peak) of a sine about the middle of its range that amplifier and piezo follow at a frequency (Hz).
    pub fn most_volts(&self, hertz: f64) -> f64 {
        let range = 0.5 * (self.volts[1] - self.volts[0]);
        range.min(self.most_slew() / (TAU * hertz))
    }

    /// Heat (W) of a sine of this amplitude (V, peak) at a frequency: π f C V² tan δ in the piezo, V² / 2 R_p in the leakage, and what the series
    /// resistance takes of the current.
    pub fn heat(&self, amplitude: f64, hertz: f64) -> f64 {
        let current = TAU * hertz * self.capacitance * amplitude;
        let leak = self.parallel.map_or(0.0, |parallel| 0.5 * amplitude * amplitude / parallel);
        PI * hertz * self.capacitance * amplitude * amplitude * self.loss
            + leak
            + 0.5 * current * current * self.series
    }
}

/// The voltage across a piezo in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Charge {
    piezo: Piezo,
    volts: f64,
    /// What the amplifier gives out, behind its slew.
    source: f64,
    limited: u64,
    masked: u64,
}

/// Phases of a step: limited before, free, limited after.
const PHASES: u32 = 8;

impl Charge {
    /// Without a charge.
    ///
    /// # Errors
    /// A figure of the piezo that cannot be.
    pub fn new(piezo: &Piezo) -> Result<Self, Fault> {
        piezo.check()?;
        Ok(Self { piezo: *piezo, volts: 0.0, source: 0.0, limited: 0, masked: 0 })
    }

    /// Holds a drive (V) for `time` seconds; returns the voltage across the piezo at the end. A drive beyond the piezo's range is
    /// cut, one that is not a number counts as 0; both are counted, as is a step in which current or slew do not suffice.
    ///
    /// A slew limit moves the held voltage by no more than slew × time a step.
    pub fn step(&mut self, drive: f64, time: f64) -> f64 {
        let p = self.piezo;
        let [low, high] = p.volts;
        self.masked += u64::from(!drive.is_finite());
        let drive = if drive.is_finite() { drive } else { 0.0 };
        let mut limited = drive < low || drive > high;
        let wanted = drive.max(low).min(high);
        let time = if time > 0.0 && time < 1e9 { time } else { 0.0 };
        let reach = p.slew.map_or(f64::INFINITY, |slew| slew * time);
        self.source += (wanted - self.source).max(-reach).min(reach);
        limited |= self.source != wanted;
        let leak = p.parallel.map_or(0.0, |parallel| 1.0 / parallel);
        // Free, it runs to V / (1 + R_s / R_p); at the limit, to ± I R_p or for ever.
        let free = (self.source / (1.0 + p.series * leak), (1.0 / p.series + leak) / p.capacitance);
        let mut left = time;
        for _ in 0..PHASES {
            let apart = self.source - self.volts;
            let most = p.amperes * p.series;
            if apart.abs() <= most * (1.0 + 1e-12) {
                self.volts += (free.0 - self.volts) * -exp_m1(-free.1 * left);
                break;
            }
            limited = true;
            let current = p.amperes.copysign(apart);
            let edge = self.source - current * p.series;
            let after = |left: f64| {
                let rate = leak / p.capacitance;
                let slope = current / p.capacitance - rate * self.volts;
                let z = -rate * left;
                self.volts + slope * left * if z == 0.0 { 1.0 } else { exp_m1(z) / z }
            };
            let end = after(left);
            if (edge - end) * apart > 0.0 {
                self.volts = end;
                break;
            }
            // When the limit is left: by halving, which no leakage can lead astray.
            let (mut from, mut to) = (0.0, left);
            for _ in 0..60 {
                let middle = 0.5 * (from + to);
                if (edge - after(middle)) * apart > 0.0 { from = middle } else { to = middle }
            }
            self.volts = edge;
            left -= to;
        }
        self.limited += u64::from(limited);
        self.volts
    }

    /// Volts across the piezo.
    pub fn volts(&self) -> f64 {
        self.volts
    }

    /// Steps in which range, current or slew did not suffice.
    pub fn limited(&self) -> u64 {
        self.limited
    }

    /// Drives that were masked.
    pub fn masked(&self) -> u64 {
        self.masked
    }
}

#[cfg(test)]
mod tests;
