//! Setting up a kernel: what can be worked out before the first sample.

use super::{CORNER, Filtered, Protection, Steady};
use crate::actuator::coil::sampled::Sampled;
use crate::actuator::elementary::exp;
use crate::actuator::fault::{Fault, within};
use crate::actuator::protect::bounds::{Actuator, Bounds, Unit};
use crate::actuator::protect::counts::Counts;
use crate::actuator::protect::governor::{Flow, Governor};
use crate::actuator::protect::motion::Motion;
use crate::actuator::protect::store::Store;

/// Rates that a device may have, Hz.
pub const RATES: (f64, f64) = (6e3, 1e6);
/// The longest tick, seconds; its share of the shortest time of a budget; its least samples.
const TICK: f64 = 0.01;
const TICKS: f64 = 400.0;
const LEAST_TICK: u32 = 8;

/// Samples of a tick for the shortest of these times of budgets, s; 0 where that is less than half a sample.
pub(in crate::actuator::protect) fn tick_of(times: impl Iterator<Item = f64>, rate: f64) -> u32 {
    let tick = times.fold(TICK, |tick, time| tick.min(time / TICKS));
    (tick * rate).round() as u32
}

impl Protection {
    /// At rest and cold, at a device's rate, 6 kHz to 1 MHz.
    ///
    /// # Errors
    /// What [`Bounds::check`] refuses, a rate beyond its ends, or a stroke where no springs bring back what moves.
    pub fn new(bounds: &Bounds, rate: f64) -> Result<Self, Fault> {
        within("rate", rate, RATES, "Hz")?;
        bounds.check()?;
        let times = [
            bounds.heat.map(|cooling| cooling.winding_time),
            bounds.rms.map(|rms| rms.seconds),
            bounds.alternating.map(|a| a.seconds),
        ];
        let mut it = Self {
            bounds: *bounds,
            rate,
            counts: Counts::default(),
            volts: bounds.full_scale.unwrap_or(1.0),
            peak: bounds.peak.unwrap_or(f64::INFINITY),
            range: [f64::NEG_INFINITY, f64::INFINITY],
            slew: bounds.slew.map_or(f64::INFINITY, |slew| slew / rate),
            alternating: None,
            heat: None,
            rms: None,
            steady: bounds.steady.map(|most| Steady { most, mean: 0.0, pull: pull(CORNER, rate) }),
            motion: None,
            last: 0.0,
            tick: tick_of(times.into_iter().flatten(), rate).max(LEAST_TICK),
            left: 0,
            plain: false,
            pass: 0.0,
            still: false,
        };
        if bounds.stroke.is_some() && bounds.slew.is_some() {
            // The converter lets no more pass anyway.
            it.peak = it.peak.min(it.volts);
        }
        let [low, high] = bounds.range.unwrap_or(it.range);
        it.range = [low.max(-it.peak), high.min(it.peak)];
        it.govern()?;
        if bounds.stroke.is_some() || [&it.heat, &it.rms].into_iter().flatten().any(Governor::wants_current) {
            let sampled = match &bounds.actuator {
                Actuator::Coil(plant) => Some(plant.sampled(rate)),
                Actuator::Resonant { resonance, per_volt } => {
                    Some(Sampled::resonant(resonance, *per_volt, rate))
                }
                Actuator::Unknown | Actuator::Resistance(_) => None,
            };
            // Let go no faster than the slew allows from the peak.
            let keep = if bounds.slew.is_some() { (1.0 - it.slew / it.peak).max(0.0) } else { 0.0 };
            it.motion = sampled.map(|sampled| Motion::new(&sampled, bounds.stroke, keep)).transpose()?;
        }
        it.begin();
        Ok(it)
    }

    /// Sets up what governs budgets: empty, and cold.
    fn govern(&mut self) -> Result<(), Fault> {
        let (tick, rate) = (self.tick, self.rate);
        let seconds = f64::from(tick) / rate;
        let of_model = match &self.bounds.actuator {
            Actuator::Coil(plant) => Some(Flow::Model(plant.coil().resistance)),
            _ => None,
        };
        self.heat = match &self.bounds.heat {
            None => None,
            Some(cooling) => {
                let flow = of_model.unwrap_or(Flow::Winding);
                Some(Governor::new(Store::heat(cooling)?, flow, tick, rate))
            }
        };
        self.rms = self.bounds.rms.map(|rms| {
            let flow = match (rms.unit, &self.bounds.actuator) {
                (Unit::Volts, _) => Flow::Volts,
                (Unit::Amperes, Actuator::Resistance(ohms)) => Flow::Ohms(*ohms),
                (Unit::Amperes, _) => of_model.unwrap_or(Flow::Volts),
            };
            Governor::new(Store::mean(rms.most, rms.seconds, seconds), flow, tick, rate)
        });
        self.alternating = self.bounds.alternating.map(|a| {
            let store = Store::mean(a.most, a.seconds, seconds);
            Filtered {
                mean: 0.0,
                pull: pull(a.hertz, rate),
                governor: Governor::new(store, Flow::Volts, tick, rate),
            }
        });
        Ok(())
    }

    /// Back to rest, cold, with nothing counted. A winding that is warm does not become cold by this.
    pub fn reset(&mut self) {
        // What was checked is not refused.
        let _ = self.govern();
        if let Some(steady) = &mut self.steady {
            steady.mean = 0.0;
        }
        if let Some(motion) = &mut self.motion {
            motion.reset();
        }
        self.counts = Counts::default();
        self.last = 0.0;
        self.begin();
    }
}

/// A first-order mean's pull each sample.
fn pull(hertz: f64, rate: f64) -> f64 {
    1.0 - exp(-std::f64::consts::TAU * hertz / rate)
}
