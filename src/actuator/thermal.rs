//! Heat: a winding in a housing in the air.
//!
//! C_w dT_w/dt = I² R (1 + α (T_w − T_0)) − (T_w − T_h) / R_wh and C_h dT_h/dt = (T_w − T_h) / R_wh − (T_h − T_a) / R_ha. While the mean
//! square of the current stands still this is linear, so a step is exact however long it is. The two rates are real, and with
//! α I² R (R_wh + R_ha) at or above 1 one of them grows: the winding heats faster than the air cools, without an end.

use crate::actuator::elementary::exp_m1;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};

/// How resistance rises with temperature in copper, a kelvin: the 0.393 % of annealed copper at 20 °C (IEC 60028), as makers of motors round it.
pub const COPPER: f64 = 0.0039;
/// Temperatures beyond this are no temperatures any more, kelvins above the air.
const MOST_RISE: f64 = 1e4;

/// How a winding sheds its heat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cooling {
    /// Ohms at the temperature of the air.
    pub resistance: f64,
    /// By how much it rises, a kelvin: [`COPPER`].
    pub rise: f64,
    /// Kelvins a watt from winding to housing, and from housing to air.
    pub to_housing: f64,
    /// Kelvins a watt from housing to air.
    pub to_air: f64,
    /// Seconds in which the winding follows the housing: its heat capacity times `to_housing`.
    pub winding_time: f64,
    /// Seconds in which the housing follows the air: its heat capacity times `to_air`.
    pub housing_time: f64,
    /// Kelvins above the air that the winding bears.
    pub most: f64,
}

/// What becomes of a steady current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Steady {
    /// The winding ends so many kelvins above the air.
    Rise(f64),
    /// Its temperature grows without end.
    Runaway,
}

impl Cooling {
    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first figure that is not above 0 (`rise`: that is below it).
    pub fn check(&self) -> Result<(), Fault> {
        positive("resistance", self.resistance)?;
        not_negative("rise", self.rise)?;
        positive("to_housing", self.to_housing)?;
        positive("to_air", self.to_air)?;
        positive("winding_time", self.winding_time)?;
        check("housing_time", self.housing_time, Limit::Above(0.0))?;
        positive("most", self.most)
    }

    /// α I² R (R_wh + R_ha) for a mean square of the current (A²): at 1 or above, temperature runs away.
    pub fn feedback(&self, mean_square: f64) -> f64 {
        self.rise * mean_square * self.resistance * (self.to_housing + self.to_air)
    }

    /// What becomes of a steady current of this mean square (A²): P R_th / (1 − α P R_th).
    pub fn steady(&self, mean_square: f64) -> Steady {
        let feedback = self.feedback(mean_square);
        if feedback < 1.0 {
            let cold = mean_square * self.resistance * (self.to_housing + self.to_air);
            Steady::Rise(cold / (1.0 - feedback))
        } else {
            Steady::Runaway
        }
    }

    /// The steady current (root mean square, amperes) at which the winding ends at what it bears.
    pub fn continuous_amperes(&self) -> f64 {
        let hot = self.resistance * (1.0 + self.rise * self.most);
        (self.most / ((self.to_housing + self.to_air) * hot)).sqrt()
    }
}

/// Temperatures of a winding and its housing, kelvins above the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermal {
    cooling: Cooling,
    /// One over the heat capacities, kelvins a joule.
    warming: [f64; 2],
    winding: f64,
    housing: f64,
}

impl Thermal {
    /// As cold as the air.
    ///
    /// # Errors
    /// A figure of the cooling that cannot be.
    pub fn new(cooling: &Cooling) -> Result<Self, Fault> {
        cooling.check()?;
        let warming = [cooling.to_housing / cooling.winding_time, cooling.to_air / cooling.housing_time];
        Ok(Self { cooling: *cooling, warming, winding: 0.0, housing: 0.0 })
    }

    /// Passes `time` seconds with a current of this mean square (A²). What is not a number, or negative, counts as no current.
    pub fn step(&mut self, mean_square: f64, time: f64) {
        let mean_square = if mean_square > 0.0 && mean_square < 1e12 { mean_square } else { 0.0 };
        let time = if time > 0.0 && time < 1e12 { time } else { 0.0 };
        let c = &self.cooling;
        let cold = mean_square * c.resistance;
        let (wh, ha) = (1.0 / c.to_housing, 1.0 / c.to_air);
        let a = [
            [self.warming[0] * (cold * c.rise - wh), self.warming[0] * wh],
            [self.warming[1] * wh, -self.warming[1] * (wh + ha)],
        ];
        let (w, h) = (self.winding, self.housing);
        let slope = [a[0][0] * w + a[0][1] * h + self.warming[0] * cold, a[1][0] * w + a[1][1] * h];
        // x + t φ(A t) ẋ with φ(z) = (e^z − 1) / z: of both eigenvalues, which are real and apart since both couplings are positive.
        let (mean, half) = (0.5 * (a[0][0] + a[1][1]), 0.5 * (a[0][0] - a[1][1]));
        let apart = (half * half + a[0][1] * a[1][0]).sqrt();
        let [fast, slow] = [mean - apart, mean + apart].map(|rate| weight(rate * time) * time);
        // f(A) = f(λ₊) (A − λ₋) / 2q − f(λ₋) (A − λ₊) / 2q.
        let (both, each) = (0.5 * (slow + fast), 0.5 * (slow - fast) / apart);
        self.winding += both * slope[0] + each * (half * slope[0] + a[0][1] * slope[1]);
        self.housing += both * slope[1] + each * (a[1][0] * slope[0] - half * slope[1]);
        let within = |t: f64| {
            if t > 0.0 && t < MOST_RISE {
                t
            } else if t > 0.0 {
                MOST_RISE
            } else {
                0.0
            }
        };
        (self.winding, self.housing) = (within(self.winding), within(self.housing));
    }

    /// The winding, kelvins above the air; no more than 10 000.
    pub fn winding(&self) -> f64 {
        self.winding
    }

    /// As warm as another.
    pub fn warm_as(&mut self, other: &Self) {
        (self.winding, self.housing) = (other.winding, other.housing);
    }

    /// The housing, kelvins above the air.
    pub fn housing(&self) -> f64 {
        self.housing
    }

    /// Ohms of the winding as warm as it is.
    pub fn resistance(&self) -> f64 {
        self.cooling.resistance * (1.0 + self.cooling.rise * self.winding)
    }

    /// What share of what the winding bears is left: 1 cold, 0 or less at its limit.
    pub fn headroom(&self) -> f64 {
        1.0 - self.winding / self.cooling.most
    }
}

/// (e^z − 1) / z.
fn weight(z: f64) -> f64 {
    if z == 0.0 { 1.0 } else { exp_m1(z) / z }
}

/// A small motor, RE25; its thermal resistances are from memory of a data sheet, the time constants are published.
#[cfg(test)]
pub(crate) const RE25: Cooling = Cooling {
    resistance: 1.26,
    rise: COPPER,
    to_housing: 3.1,
    to_air: 14.0,
    winding_time: 12.0,
    housing_time: 910.0,
    most: 100.0,
};

#[cfg(test)]
mod tests {
    use super::{COPPER, Cooling, RE25, Steady, Thermal};

    /// A² of a torque, with 16.3 mN m an ampere.
    fn mean_square(torque: f64) -> f64 {
        (torque / 16.3e-3f64).powi(2)
    }

    #[test]
    fn steady_currents_end_where_the_closed_form_says() {
        let Steady::Rise(rise) = RE25.steady(mean_square(0.023)) else { panic!("no runaway") };
        assert!((rise - 52.0).abs() < 1.0, "{rise}");
        let Steady::Rise(rise) = RE25.steady(mean_square(0.050)) else { panic!("no runaway") };
        assert!((rise - 969.0).abs() < 20.0, "{rise}");
        assert_eq!(RE25.steady(mean_square(0.175)), Steady::Runaway);
        for torque in [0.01, 0.023, 0.04] {
            let mut t = Thermal::new(&RE25).unwrap();
            // The feedback makes it slower: 1 / (1 − feedback) times the time constant.
            t.step(mean_square(torque), 1e6);
            let Steady::Rise(rise) = RE25.steady(mean_square(torque)) else { panic!("no runaway") };
            assert!((t.winding() / rise - 1.0).abs() < 1e-9, "{} {rise}", t.winding());
            let flow = mean_square(torque) * t.resistance();
            assert!((t.housing() / (flow * 14.0) - 1.0).abs() < 1e-9);
        }
        let most = RE25.continuous_amperes();
        let Steady::Rise(rise) = RE25.steady(most * most) else { panic!("no runaway") };
        assert!((rise - 100.0).abs() < 1e-9);
    }

    /// At 175 mN m, before the winding sheds any of its heat: 37 K/s at first, 100 K after 2.25 s, or 2.67 s if resistance did not rise.
    #[test]
    fn an_overload_heats_as_fast_as_it_should() {
        for (rise, expected) in [(COPPER, 2.25f64), (0.0, 2.67)] {
            // The same heat capacity, hardly coupled.
            let alone = Cooling { rise, to_housing: 3.1e6, winding_time: 12e6, ..RE25 };
            let mut t = Thermal::new(&alone).unwrap();
            t.step(mean_square(0.175), 1e-3);
            assert!((t.winding() / 1e-3 - 37.5).abs() < 0.1, "{}", t.winding());
            let mut time = 1e-3;
            while t.winding() < 100.0 {
                t.step(mean_square(0.175), 1e-3);
                time += 1e-3;
            }
            assert!((time - expected).abs() < 0.01, "{time} {expected}");
            assert!(t.headroom() <= 0.0);
        }
    }

    /// However a time is cut, the temperatures are the same; and they are those of small steps of the equations.
    #[test]
    fn a_step_is_exact_however_long() {
        for torque in [0.0, 0.023, 0.050, 0.0517, 0.175] {
            let mut start = Thermal::new(&RE25).unwrap();
            start.step(mean_square(0.1), 5.0);
            let (mut long, mut short) = (start, start);
            long.step(mean_square(torque), 20.0);
            (0..2000).for_each(|_| short.step(mean_square(torque), 0.01));
            assert!((long.winding() / short.winding() - 1.0).abs() < 1e-11, "{torque}");
            assert!((long.housing() / short.housing() - 1.0).abs() < 1e-11);
            // Runge and Kutta on the equations as they stand above.
            let c = RE25;
            let (cw, ch) = (c.winding_time / c.to_housing, c.housing_time / c.to_air);
            let slope = |x: [f64; 2]| {
                let heat = mean_square(torque) * c.resistance * (1.0 + c.rise * x[0]);
                let flow = (x[0] - x[1]) / c.to_housing;
                [(heat - flow) / cw, (flow - x[1] / c.to_air) / ch]
            };
            let (mut x, h) = ([start.winding(), start.housing()], 0.01);
            for _ in 0..2000 {
                let plus = |k: [f64; 2], f: f64| [x[0] + f * k[0], x[1] + f * k[1]];
                let k1 = slope(x);
                let k2 = slope(plus(k1, 0.5 * h));
                let k3 = slope(plus(k2, 0.5 * h));
                let k4 = slope(plus(k3, h));
                x = [0, 1].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            }
            assert!((long.winding() / x[0] - 1.0).abs() < 1e-9, "{torque}: {} {x:?}", long.winding());
        }
    }

    #[test]
    fn runaway_is_told_and_bounded() {
        let edge = 1.0 / (COPPER * 1.26 * 17.1);
        assert!(RE25.feedback(edge * 0.999) < 1.0 && RE25.feedback(edge * 1.001) > 1.0);
        for current in [edge, edge * 1.0001, 1e6, 1e11] {
            let mut t = Thermal::new(&RE25).unwrap();
            t.step(current, 1e9);
            assert!(t.winding() <= 1e4 && t.winding() > 1000.0, "{current}: {}", t.winding());
            t.step(0.0, 1e9);
            assert!(t.winding() < 1e-9 && t.housing() < 1e-9, "{t:?}");
        }
    }

    #[test]
    fn nonsense_is_no_current_and_no_time() {
        let mut t = Thermal::new(&RE25).unwrap();
        t.step(1.0, 1.0);
        let before = t;
        t.step(1.0, f64::NAN);
        t.step(5.0, -1.0);
        assert_eq!(t, before);
        t.step(f64::NAN, 1.0);
        t.step(-3.0, 1.0);
        assert!(t.winding() < before.winding());
        // What has no end is none either: a winding that would be no number stays one.
        let mut cools = before;
        cools.step(0.0, 1.0);
        let mut t = before;
        t.step(f64::INFINITY, 1.0);
        assert_eq!(t, cools);
        t.step(5.0, f64::INFINITY);
        assert_eq!(t, cools);
        for (cooling, field) in [
            (Cooling { resistance: 0.0, ..RE25 }, "resistance"),
            (Cooling { rise: -0.1, ..RE25 }, "rise"),
            (Cooling { to_housing: -1.0, ..RE25 }, "to_housing"),
            (Cooling { to_air: f64::INFINITY, ..RE25 }, "to_air"),
            (Cooling { winding_time: 0.0, ..RE25 }, "winding_time"),
            (Cooling { housing_time: f64::NAN, ..RE25 }, "housing_time"),
            (Cooling { most: 0.0, ..RE25 }, "most"),
        ] {
            assert_eq!(Thermal::new(&cooling).unwrap_err().field, field);
        }
    }
}
