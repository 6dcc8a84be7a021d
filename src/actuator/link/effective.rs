//! What a drive that is not steady amounts to as heat: its root mean square on the winding.
//!
//! A bridge gives a mean by pulses, a carrier by half-waves. What a motor turns by is the mean; what warms it is the mean square, and of
//! what ripples as much as the coil's inductance lets through. Here that is of a motor that stands: one that turns makes a voltage of its own,
//! which takes from the mean and leaves the ripple as it is.

use super::carrier::Carrier;
use super::conduction::Conduction;
use super::pwm::Switching;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};

/// What drives amount to, one way or the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Effective(Way);

#[derive(Debug, Clone, PartialEq)]
enum Way {
    /// As they are.
    Steady,
    /// Volts from one width of pulses to the next, and the mean square of each, from 0 on.
    Pulses(f64, Vec<f64>),
    Carrier(Box<Conduction>),
}

impl Effective {
    /// Drives that are as steady as they are sent, volts or amperes.
    pub fn steady() -> Self {
        Self(Way::Steady)
    }

    /// The pulses of a bridge for a coil of a time constant L/R (s), at `rate` samples a second. A mean between two widths is made by taking turns.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn pulses(switching: &Switching, rate: f64, electrical_time: f64) -> Result<Self, Fault> {
        positive("rate", rate)?;
        positive("supply", switching.supply)?;
        check("period", f64::from(switching.period), Limit::Least(2.0))?;
        not_negative("inductance", electrical_time)?;
        let square = |width| switching.square(width, rate, electrical_time);
        Ok(Self(Way::Pulses(switching.resolution(), (0..=switching.period).map(square).collect())))
    }

    /// A carrier behind diodes, into a coil of a time constant L/R (s).
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn carrier(carrier: &Carrier, electrical_time: f64) -> Result<Self, Fault> {
        Ok(Self(Way::Carrier(Box::new(Conduction::new(carrier, electrical_time)?))))
    }

    /// The root mean square of a mean of this size, not below it.
    #[inline]
    pub fn of(&self, mean: f64) -> f64 {
        match &self.0 {
            Way::Steady => mean,
            Way::Pulses(step, squares) => {
                let place = (mean / step).min((squares.len() - 1) as f64);
                let width = (place as usize).min(squares.len() - 2);
                let share = place - width as f64;
                (squares[width] + share * (squares[width + 1] - squares[width])).sqrt().max(mean)
            }
            Way::Carrier(conduction) => conduction.root(mean, 0.0),
        }
    }

    /// The mean whose root mean square that is: the inverse of [`Effective::of`].
    #[inline]
    pub fn mean(&self, root: f64) -> f64 {
        match &self.0 {
            Way::Steady => root,
            Way::Pulses(step, squares) => {
                let square = root * root;
                let above = squares.partition_point(|at| *at < square).clamp(1, squares.len() - 1);
                let (low, high) = (squares[above - 1], squares[above]);
                let share = ((square - low) / (high - low)).clamp(0.0, 1.0);
                (step * ((above - 1) as f64 + share)).min(root)
            }
            Way::Carrier(conduction) => conduction.mean_of_root(root),
        }
    }

    /// The mean square of what flows, on the winding, V²: where a mean is driven, a motor makes `emf` by turning, and what flows on average is
    /// worth `flows` (V) there.
    #[inline]
    pub fn square(&self, mean: f64, emf: f64, flows: f64) -> f64 {
        match &self.0 {
            Way::Steady => flows * flows,
            Way::Pulses(..) => {
                let root = self.of(mean.abs());
                flows * flows + (root * root - mean * mean).max(0.0)
            }
            Way::Carrier(conduction) => {
                let root = conduction.root(flows, emf);
                root * root
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Carrier, Effective, Switching};
    use crate::actuator::link::carrier::Rectifier;
    use crate::actuator::link::pwm::Modulator;

    const SWITCHING: Switching = Switching { period: 16, supply: 6.0 };
    const RATE: f64 = 48_000.0;

    /// Against the current itself of a coil behind the modulator, stepped exactly from sample to sample, while the motor stands and while it turns.
    #[test]
    fn pulses_warm_as_their_current_does() {
        for time in [0.0, 2e-5, 1e-4, 4e-4, 5e-3] {
            let effective = Effective::pulses(&SWITCHING, RATE, time).unwrap();
            for (wanted, emf) in
                [(0.0, 0.0), (0.1, 0.0), (0.375, 0.0), (1.7, 1.1), (3.0, 2.0), (-4.4, 2.0), (6.0, 5.0)]
            {
                let mut modulator = Modulator::new(&SWITCHING).unwrap();
                let (keeps, mut flows) = ((-1.0 / (RATE * time)).exp(), 0.0);
                let (mut sum, mut squares, count) = (0.0, 0.0, 480_000);
                for n in 0..count + 4800 {
                    let bridge = modulator.step(wanted);
                    let volts = modulator.volts(bridge) - emf;
                    // Of y' = (v − y)/τ over a sample: y itself, its mean and its mean square.
                    let z = 1.0 / (RATE * time);
                    let (off, once, twice) =
                        (flows - volts, -(-z).exp_m1() / z, -(-2.0 * z).exp_m1() / (2.0 * z));
                    let (once, twice) = if time == 0.0 { (0.0, 0.0) } else { (once, twice) };
                    if n >= 4800 {
                        sum += volts + off * once;
                        squares += volts * volts + 2.0 * volts * off * once + off * off * twice;
                    }
                    flows = volts + off * if time == 0.0 { 0.0 } else { keeps };
                }
                let (mean, square) = (sum / f64::from(count), squares / f64::from(count));
                assert!((mean - (wanted - emf)).abs() < 1e-3, "{time} {wanted}: {mean}");
                let is = effective.square(wanted, emf, mean);
                // Taking turns is slower than pulses, and a coil keeps some of it off.
                let turns = 0.25 * SWITCHING.resolution().powi(2);
                assert!(is > square * (1.0 - 1e-3) - 1e-9, "{time} {wanted} {emf}: {is} {square}");
                assert!(is < square * (1.0 + 1e-3) + turns, "{time} {wanted} {emf}: {is} {square}");
                if emf == 0.0 {
                    assert!((is.sqrt() - effective.of(wanted.abs())).abs() < 2e-3);
                }
            }
        }
    }

    /// There and back, of every kind; never less than the mean, and more of the one is more of the other.
    #[test]
    fn it_can_be_turned_round() {
        let carrier = |full_wave, drop| Carrier { hertz: 4000.0, rectifier: Rectifier { full_wave, drop } };
        let mut all = vec![Effective::steady()];
        for time in [0.0, 1e-5, 1e-4, 1e-3, 1.0] {
            all.push(Effective::pulses(&SWITCHING, RATE, time).unwrap());
            for (full_wave, drop) in [(true, 0.0), (true, 1.4), (false, 0.0), (false, 0.7)] {
                all.push(Effective::carrier(&carrier(full_wave, drop), time).unwrap());
            }
        }
        for effective in all {
            let mut last = 0.0;
            for n in 1..=600 {
                let mean = 0.01 * f64::from(n);
                let root = effective.of(mean);
                assert!(root >= mean * (1.0 - 1e-9) && root > last, "{mean}: {root} {last}");
                let back = effective.mean(root);
                assert!((back / mean - 1.0).abs() < 1e-9, "{mean}: {root} {back}");
                last = root;
            }
            assert_eq!((effective.of(0.0), effective.mean(0.0)), (0.0, 0.0));
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let field =
            |switching: Switching, time: f64| Effective::pulses(&switching, RATE, time).unwrap_err().field;
        assert_eq!(field(Switching { supply: f64::NAN, ..SWITCHING }, 0.0), "supply");
        assert_eq!(field(Switching { period: 0, ..SWITCHING }, 0.0), "period");
        assert_eq!(field(SWITCHING, -1.0), "inductance");
    }
}
