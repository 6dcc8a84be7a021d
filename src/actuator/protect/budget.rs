//! What a winding bears for long, where the samples that leave are not the volts at its terminals: the same budgets, for what turns a motor.
//!
//! Its drives are volts, or amperes, as a root mean square over the time for which they hold, with all that ripples about their mean and gets into
//! the coil. The current is what a model says.

use super::counts::{Counts, Touched};
use super::governor::{Flow, Governor};
use super::kernel::tick_of;
use super::store::Store;
use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, positive, within};
use crate::actuator::thermal::Cooling;

/// What a motor bears for long.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bears {
    /// How its winding sheds its heat, and how warm it may become.
    pub heat: Option<Cooling>,
    /// The root mean square of its volts, and the seconds over which it is taken, 10 ms to 1e6 s. Of a current they are those on the winding alone.
    pub rms: Option<[f64; 2]>,
}

impl Bears {
    /// Refuses what cannot be.
    ///
    /// # Errors
    /// A figure of the cooling or of the mean square that cannot be.
    pub fn check(&self) -> Result<(), Fault> {
        self.heat.map_or(Ok(()), |cooling| cooling.check())?;
        let Some([most, seconds]) = self.rms else { return Ok(()) };
        positive("rms.most", most)?;
        within("rms.seconds", seconds, (0.01, 1e6), "s")
    }
}

/// Keeps drives to what a motor bears. It neither allocates nor locks.
#[derive(Debug, Clone)]
pub struct Budget {
    heat: Option<Governor>,
    rms: Option<Governor>,
    /// Samples of a tick, and of this one the number of that which is under way, from 1.
    tick: u32,
    at: u32,
    /// Whether this tick has part in what was allowed ahead.
    reserved: bool,
    /// Of the sample that is under way: mean squares wanted, let out, and of the current, A².
    squares: [f64; 3],
    /// The most by which heat and mean square changed it.
    changed: [f64; 2],
    counts: Counts,
}

impl Budget {
    /// Cold, of drives of a kind through so many ohms (those of the model that gives the mean square of volts), `rate` samples a second.
    ///
    /// # Errors
    /// What [`Bears::check`] refuses, ohms that are not above 0, a rate beyond 100 to 1e6.
    pub fn new(bears: &Bears, drive: Drive, ohms: f64, rate: f64) -> Result<Self, Fault> {
        within("rate", rate, (100.0, 1e6), "samples a second")?;
        positive("resistance", ohms)?;
        bears.check()?;
        let times = [bears.heat.map(|cooling| cooling.winding_time), bears.rms.map(|[_, seconds]| seconds)];
        let tick = tick_of(times.into_iter().flatten(), rate).max(1);
        let seconds = f64::from(tick) / rate;
        let heat = bears.heat.map(|cooling| -> Result<Governor, Fault> {
            let ohms = if drive == Drive::Voltage { cooling.resistance } else { 1.0 };
            Ok(Governor::new(Store::heat(&cooling)?, Flow::Model(ohms), tick, rate))
        });
        let rms = bears.rms.map(|[most, time]| {
            let flow = if drive == Drive::Voltage { Flow::Volts } else { Flow::Ohms(1.0 / ohms) };
            Governor::new(Store::mean(most, time, seconds), flow, tick, rate)
        });
        Ok(Self {
            heat: heat.transpose()?,
            rms,
            tick,
            at: 1,
            reserved: false,
            squares: [0.0; 3],
            changed: [0.0; 2],
            counts: Counts::default(),
        })
    }

    /// Goes on where another was: as warm, and counts on.
    pub fn warm_as(&mut self, other: &Self) {
        self.counts = other.counts;
        for (own, other) in [(&mut self.heat, &other.heat), (&mut self.rms, &other.rms)] {
            if let (Some(own), Some(other)) = (own, other) {
                own.fill_as(other);
            }
        }
    }

    /// What it did so far; of samples, those of the device.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The winding, kelvins above the air, as of the last tick; `None` without a heat bound.
    pub fn temperature(&self) -> Option<f64> {
        self.heat.as_ref().map(Governor::level)
    }

    /// What of a drive may be let out now, and whether it is the heat that holds it back.
    #[inline]
    pub fn hold(&self, drive: f64) -> (f64, bool) {
        let by = |budget: &Option<Governor>| {
            let Some(budget) = budget else { return drive };
            let cap = if self.reserved { budget.rest(self.at - 1) } else { budget.cap() };
            (drive * budget.gain(self.at)).min(cap)
        };
        let (heat, rms) = (by(&self.heat), by(&self.rms));
        (heat.min(rms), heat <= rms)
    }

    /// What of drives of this mean square over so many seconds to come may be let out, as a share of all of them, 1 for all; and whether it is
    /// the heat that holds them back. Until they are over, nothing else may be.
    pub fn share(&self, square: f64, seconds: f64) -> (f64, bool) {
        let by = |budget: &Option<Governor>| {
            let Some(budget) = budget else { return 1.0 };
            let share = (budget.spare(seconds, self.at - 1) / square).sqrt();
            // Of nothing everything is borne.
            budget.gain(self.at).min(if share.is_nan() { 1.0 } else { share })
        };
        let (heat, rms) = (by(&self.heat), by(&self.rms));
        (heat.min(rms), heat <= rms)
    }

    /// That what is driven now was allowed by [`Budget::share`].
    pub fn reserve(&mut self) {
        self.reserved = true;
    }

    /// Takes note of what was driven for a share of a sample: mean squares wanted, let out, and of the current, A².
    #[inline]
    pub fn note(&mut self, share: f64, squares: [f64; 3]) {
        for (sum, square) in self.squares.iter_mut().zip(squares) {
            *sum += share * square;
        }
    }

    /// That the current of the sample that is under way had this mean square, A², whatever was noted.
    pub fn flowed(&mut self, square: f64) {
        self.squares[2] = square;
    }

    /// Takes note of a drive that it held back, by which: of the mean, in the unit that is told.
    #[inline]
    pub fn changed(&mut self, before: f64, after: f64, by_heat: bool) {
        let most = &mut self.changed[usize::from(!by_heat)];
        *most = most.max((before - after).abs());
    }

    /// Ends a sample of so many frames of the device.
    #[inline]
    pub fn pass(&mut self, frames: u64) {
        let [wanted, left, current] = std::mem::take(&mut self.squares);
        self.counts.samples += frames;
        if self.changed != [0.0; 2] {
            let [heat, rms] = std::mem::take(&mut self.changed);
            self.counts.changed += frames;
            let enter = |touched: &mut Touched, most: f64| {
                touched.samples += if most > 0.0 { frames } else { 0 };
                touched.most = touched.most.max(most);
            };
            enter(&mut self.counts.heat, heat);
            enter(&mut self.counts.rms, rms);
        }
        for budget in [&mut self.heat, &mut self.rms].into_iter().flatten() {
            budget.note_squares(wanted, left, current);
        }
        self.at += 1;
        if self.at > self.tick {
            (self.at, self.reserved) = (1, false);
            for budget in [&mut self.heat, &mut self.rms].into_iter().flatten() {
                budget.tick();
            }
            if let Some(heat) = &self.heat {
                self.counts.warmest = self.counts.warmest.max(heat.level());
            }
        }
    }
}

#[cfg(test)]
mod tests;
