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
mod tests {
    use super::{Charge, Piezo};
    use std::f64::consts::TAU;

    fn bender() -> Piezo {
        Piezo {
            capacitance: 1e-6,
            series: 100.0,
            parallel: None,
            loss: 0.02,
            volts: [-30.0, 150.0],
            amperes: 20e-3,
            slew: None,
        }
    }

    /// I / (2π C V): 20 mA into 1 µF at 60 V is 53 Hz; beyond, a driven sine comes out as a triangle of that slew.
    #[test]
    fn current_limits_the_frequency() {
        let piezo = bender();
        let edge = piezo.most_hertz(60.0);
        assert!((edge - 20e-3 / (TAU * 1e-6 * 60.0)).abs() < 1e-9 && (edge - 53.05).abs() < 0.01);
        assert!((piezo.most_volts(edge) - 60.0).abs() < 1e-9);
        assert_eq!(piezo.most_volts(1.0), 90.0);
        for (hertz, follows) in [(0.9 * edge, true), (3.0 * edge, false)] {
            let mut charge = Charge::new(&piezo).unwrap();
            let (rate, mut range, mut before) = (192_000.0, [f64::MAX, f64::MIN], 0.0);
            let mut steepest = 0.0f64;
            let count = (3.0 * rate / hertz) as u32;
            for n in 0..count {
                let v = charge.step(60.0 + 60.0 * -(TAU * hertz * f64::from(n) / rate).cos(), 1.0 / rate);
                steepest = steepest.max((v - before).abs() * rate);
                before = v;
                if n > count / 3 {
                    range = [v.min(range[0]), v.max(range[1])];
                }
            }
            assert!(steepest <= piezo.most_slew() * (1.0 + 1e-9), "{steepest}");
            assert_eq!(charge.limited() == 0, follows);
            let most = 0.5 * (range[1] - range[0]);
            if follows {
                assert!((most - 60.0).abs() < 0.5, "{most}");
            } else {
                // A triangle of that slew: a quarter of a period up from the middle.
                let triangle = piezo.most_slew() / (4.0 * hertz);
                assert!((most / triangle - 1.0).abs() < 0.05, "{most} {triangle}");
            }
        }
    }

    /// A step up: a ramp of I / C until the rest is I R_s, then an exponential; the same however it is cut.
    #[test]
    fn a_leap_is_a_ramp_and_an_exponential() {
        for parallel in [None, Some(1e5)] {
            let piezo = Piezo { parallel, ..bender() };
            for time in [1e-3, 3e-3, 5.1e-3, 20e-3] {
                let (mut one, mut many) = (Charge::new(&piezo).unwrap(), Charge::new(&piezo).unwrap());
                one.step(100.0, time);
                (0..1000).for_each(|_| {
                    many.step(100.0, time / 1000.0);
                });
                assert!(
                    (one.volts() - many.volts()).abs() < 1e-9,
                    "{time}: {} {}",
                    one.volts(),
                    many.volts()
                );
                if parallel.is_none() {
                    let ramp = (100.0 - 2.0) / 20e3;
                    let expected =
                        if time < ramp { 20e3 * time } else { 100.0 - 2.0 * (-(time - ramp) / 1e-4).exp() };
                    assert!((one.volts() - expected).abs() < 1e-9, "{time}: {} {expected}", one.volts());
                }
            }
        }
        let mut leaking = Charge::new(&Piezo { parallel: Some(900.0), amperes: 1.0, ..bender() }).unwrap();
        leaking.step(100.0, 1.0);
        assert!((leaking.volts() - 90.0).abs() < 1e-9, "what leaks divides the voltage");
        // More leakage than the amplifier gives: the voltage stays at I R_p.
        let mut short = Charge::new(&Piezo { parallel: Some(1000.0), ..bender() }).unwrap();
        short.step(100.0, 1.0);
        assert!((short.volts() - 20.0).abs() < 1e-9, "{}", short.volts());
    }

    #[test]
    fn range_and_slew_are_kept() {
        let mut charge =
            Charge::new(&Piezo { slew: Some(1e3), amperes: 10.0, series: 1e-3, ..bender() }).unwrap();
        (0..10).for_each(|_| {
            charge.step(1e6, 1e-3);
        });
        assert!((charge.volts() - 10.0).abs() < 1e-6 && charge.limited() == 10, "{}", charge.volts());
        (0..1000).for_each(|_| {
            charge.step(f64::NAN, 1e-3);
        });
        assert!(charge.volts().abs() < 1e-9 && charge.masked() == 1000);
        (0..1000).for_each(|_| {
            charge.step(-1e9, 1e-3);
        });
        assert!((charge.volts() + 30.0).abs() < 1e-9);
    }

    /// A voltage within the range that the slew does not reach in a step is counted, one that it reaches is not.
    #[test]
    fn what_the_slew_holds_back_is_counted() {
        let mut charge = Charge::new(&Piezo { slew: Some(1e4), amperes: 1.0, ..bender() }).unwrap();
        charge.step(15.0, 1e-3);
        assert_eq!(charge.limited(), 1);
        charge.step(15.0, 1e-3);
        assert_eq!(charge.limited(), 1);
    }

    /// Real power by integrating v i of a sine over a period, with the three losses told apart.
    #[test]
    fn losses_add_up() {
        let piezo = Piezo { parallel: Some(1e5), ..bender() };
        let (amplitude, hertz) = (50.0, 40.0);
        let reactive = 0.5 * amplitude * amplitude * TAU * hertz * piezo.capacitance;
        let leak = amplitude * amplitude / 2.0 / 1e5;
        let current = TAU * hertz * piezo.capacitance * amplitude;
        let expected = reactive * 0.02 + leak + current * current / 2.0 * 100.0;
        assert!((piezo.heat(amplitude, hertz) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn figures_that_cannot_be_are_refused() {
        for (piezo, field) in [
            (Piezo { capacitance: 0.0, ..bender() }, "capacitance"),
            (Piezo { series: 0.0, ..bender() }, "series"),
            (Piezo { parallel: Some(-1.0), ..bender() }, "parallel"),
            (Piezo { loss: -0.1, ..bender() }, "loss"),
            (Piezo { volts: [1.0, 150.0], ..bender() }, "volts.low"),
            (Piezo { volts: [-30.0, -1.0], ..bender() }, "volts.high"),
            (Piezo { amperes: f64::NAN, ..bender() }, "amperes"),
            (Piezo { slew: Some(0.0), ..bender() }, "slew"),
        ] {
            assert_eq!(Charge::new(&piezo).unwrap_err().field, field);
        }
    }
}
