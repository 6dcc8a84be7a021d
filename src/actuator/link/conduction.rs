//! Diodes into a motor: which carrier makes which current flow against what a motor's turning sets against it.
//!
//! Behind a rectifier, current flows only while a half-wave is above the motor's own voltage E and what the diodes take, d. Without inductance
//! it flows while A sin x > u = E + d, and its mean over the half-waves is R i = (2/π) (√(A² − u²) − u acos(u/A)) of a bridge, half of that of one
//! diode: [`Rectifier::mean`] with u in the place of the drop. An inductance holds the current back at first and keeps it flowing
//! after, against u: less flows on average, down to (2/π) A − u where it never ceases.
//!
//! All of it grows as volts do, so one row of ratios is enough for every amplitude and every speed.

use super::carrier::{Carrier, Rectifier};
use crate::actuator::fault::{Fault, not_negative, positive};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Ratios that are worked out ahead.
const ROWS: usize = 256;

/// Halvings in which the end of a current is found.
const HALVINGS: usize = 60;

/// What a carrier drives through a rectifier and a motor's winding.
#[derive(Debug, Clone, PartialEq)]
pub struct Conduction {
    rectifier: Rectifier,
    /// ωL/R: by how many radians of the carrier the current is late.
    lag: f64,
    /// Of each angle: (R i)/(R i + u), and A/(R i + u).
    rows: Vec<[f64; 2]>,
}

impl Conduction {
    /// That of a carrier into a winding of a time constant L/R, s (0: without inductance).
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(carrier: &Carrier, electrical_time: f64) -> Result<Self, Fault> {
        positive("carrier", carrier.hertz)?;
        not_negative("diode_drop", carrier.rectifier.drop)?;
        not_negative("inductance", electrical_time)?;
        let (rectifier, lag) = (carrier.rectifier, TAU * carrier.hertz * electrical_time);
        let row = |n: usize| {
            let opposed = if n == ROWS { 0.0 } else { (FRAC_PI_2 * n as f64 / ROWS as f64).cos() };
            let flows = flows(opposed, lag, rectifier.full_wave);
            [flows / (flows + opposed), 1.0 / (flows + opposed)]
        };
        Ok(Self { rectifier, lag, rows: (0..=ROWS).map(row).collect() })
    }

    /// What stands against a carrier's amplitude while a motor's turning makes so many volts.
    fn against(&self, emf: f64) -> f64 {
        (emf + self.rectifier.drop).max(0.0)
    }

    /// What the mean current is worth on the resistance, V, for an amplitude (V) against a motor's own voltage (V).
    pub fn mean(&self, amplitude: f64, emf: f64) -> f64 {
        let against = self.against(emf);
        if !(amplitude > against && amplitude.is_finite()) {
            return 0.0;
        }
        amplitude * flows(against / amplitude, self.lag, self.rectifier.full_wave)
    }

    /// The amplitude, V, whose mean current is worth so many volts on the resistance, against a motor's own voltage (V); 0 for what is
    /// not above 0.
    ///
    /// It looks the ratio up, and is within 1e-4 of it where the coil keeps no current or there is one diode, else within 5e-3.
    #[inline]
    pub fn amplitude(&self, mean: f64, emf: f64) -> f64 {
        if !(mean > 0.0 && mean.is_finite() && emf.is_finite()) {
            return 0.0;
        }
        let whole = mean + self.against(emf);
        let share = mean / whole;
        let above = self.rows.partition_point(|row| row[0] < share).clamp(1, ROWS);
        let ([low, from], [high, to]) = (self.rows[above - 1], self.rows[above]);
        let at = ((share - low) / (high - low)).clamp(0.0, 1.0);
        whole * (from + at * (to - from))
    }
}

/// The mean of R i for an amplitude of 1 against `opposed`, 0 to 1, where the current is `lag` radians late.
fn flows(opposed: f64, lag: f64, full_wave: bool) -> f64 {
    let turn = if full_wave { PI } else { TAU };
    let begin = opposed.clamp(0.0, 1.0).asin();
    // ∫ (sin x − u) dx over what flows; the inductance keeps nothing from one half-wave to the next.
    let flowed = |end: f64| ((begin.cos() - end.cos()) - opposed * (end - begin)) / turn;
    if lag == 0.0 {
        return flowed(PI - begin).max(0.0);
    }
    // The current at x, after it was `before` at `from`, under sin x − u.
    let steady = |x: f64| (x.sin() - lag * x.cos()) / (1.0 + lag * lag) - opposed;
    let current =
        |x: f64, from: f64, before: f64| steady(x) + (before - steady(from)) * (-(x - from) / lag).exp();
    // From where the source is below what stands against it, the current only falls.
    let ends = |low: f64, high: f64, from: f64, before: f64| {
        let (mut low, mut high) = (low, high);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if current(middle, from, before) > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    if !full_wave {
        return flowed(ends(PI - begin, TAU + begin, begin, 0.0)).max(0.0);
    }
    let crossing = current(PI, begin, 0.0);
    if crossing <= 0.0 {
        return flowed(ends(PI - begin, PI, begin, 0.0)).max(0.0);
    }
    // The other pair of diodes takes over: the same half-wave again, from its beginning to where this one began, if it flows for so long; it
    // never ceases then, and the mean is that of a whole half-wave.
    let end = ends(0.0, begin, 0.0, crossing);
    (flowed(PI) + ((1.0 - end.cos()) - opposed * end) / turn).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::{Carrier, Conduction, PI, Rectifier, TAU};

    fn carrier(full_wave: bool, drop: f64) -> Carrier {
        Carrier { hertz: 4000.0, rectifier: Rectifier { full_wave, drop } }
    }

    /// Without inductance: the closed form of the half-waves above what stands against them, which is also their mean by the definition.
    #[test]
    fn without_inductance_it_is_the_closed_form() {
        for full_wave in [true, false] {
            for (amplitude, emf, drop) in
                [(3.0, 0.0, 0.0), (3.0, 1.5, 0.0), (5.5, 2.4, 1.4), (1.0, 0.98, 0.0), (7.0, 0.1, 0.6)]
            {
                let conduction = Conduction::new(&carrier(full_wave, drop), 0.0).unwrap();
                let is = conduction.mean(amplitude, emf);
                let u: f64 = emf + drop;
                let angle = (u / amplitude).acos();
                let share = if full_wave { 2.0 / PI } else { 1.0 / PI };
                let closed = share * ((amplitude * amplitude - u * u).sqrt() - u * angle);
                assert!((is - closed).abs() < 1e-12, "{is} {closed}");
                let count = 100_000;
                let passes = |n: i32| {
                    let x = TAU * (f64::from(n) + 0.5) / f64::from(count);
                    let volts = amplitude * x.sin();
                    ((if full_wave { volts.abs() } else { volts }) - u).max(0.0)
                };
                let sum = (0..count).map(passes).sum::<f64>() / f64::from(count);
                assert!((is - sum).abs() < 1e-8, "{is} {sum}");
                assert_eq!(conduction.mean(u, emf), 0.0);
            }
        }
    }

    /// With inductance: the steady state of L i' = |A sin x| − u − R i, i ≥ 0, in small steps.
    #[test]
    fn with_inductance_it_is_what_the_circuit_settles_to() {
        for full_wave in [true, false] {
            for lag in [0.05, 0.6, 2.0, 10.0] {
                for opposed in [0.0, 0.2, 0.5, 0.62, 0.9] {
                    let count = 20_000;
                    let step = TAU / f64::from(count);
                    let (mut current, mut sum) = (0.0_f64, 0.0);
                    let turns = 12 + (6.0 * lag) as i32;
                    for n in 0..count * turns {
                        let x: f64 = step * (f64::from(n % count) + 0.5);
                        let source = if full_wave { x.sin().abs() } else { x.sin() } - opposed;
                        let middle = current + 0.5 * step / lag * (source - current);
                        let next = current + step / lag * (source - middle);
                        // Diodes let nothing back.
                        let next = if next > 0.0 { next } else { 0.0 };
                        if n >= count * (turns - 1) {
                            sum += 0.5 * (current + next) / f64::from(count);
                        }
                        current = next;
                    }
                    let conduction = Conduction::new(&carrier(full_wave, 0.0), lag / TAU / 4000.0).unwrap();
                    let is = conduction.mean(2.0, 2.0 * opposed);
                    assert!(
                        (is - 2.0 * sum).abs() < 2e-3 * sum + 1e-4,
                        "{full_wave} {lag} {opposed}: {is} {}",
                        2.0 * sum
                    );
                }
            }
        }
    }

    /// What is looked up makes what was asked for, for every speed from rest to where it hardly flows any more.
    #[test]
    fn the_amplitude_makes_the_mean() {
        for full_wave in [true, false] {
            for time in [0.0, 1e-5, 1e-4, 4e-4] {
                for drop in [0.0, 1.4] {
                    let conduction = Conduction::new(&carrier(full_wave, drop), time).unwrap();
                    for emf in [0.0, 1e-6, 0.3, 2.5, 40.0] {
                        for mean in [1e-6, 1e-3, 0.2, 3.0, 100.0] {
                            let amplitude = conduction.amplitude(mean, emf);
                            let back = conduction.mean(amplitude, emf);
                            let off = (back - mean).abs();
                            assert!(
                                off < 1e-4 * (mean + emf + drop) && off < 0.02 * mean + 2e-6 * (emf + drop),
                                "{time} {drop} {emf} {mean}: {back}"
                            );
                        }
                    }
                }
            }
        }
        let conduction = Conduction::new(&carrier(true, 1.4), 0.0).unwrap();
        for nothing in [(0.0, 1.0), (-1.0, 0.0), (f64::NAN, 0.0), (1.0, f64::NAN), (f64::INFINITY, 0.0)] {
            assert_eq!(conduction.amplitude(nothing.0, nothing.1), 0.0);
        }
        // A motor that is swung backward helps.
        assert!(conduction.amplitude(1.0, -9.0) > 0.0);
    }

    /// As a motor turns faster, the same amplitude holds it to a higher mean: what can be had at rest can be had at any speed.
    #[test]
    fn what_can_be_had_at_rest_can_be_had_at_speed() {
        for full_wave in [true, false] {
            for time in [0.0, 1e-4, 4e-4] {
                let conduction = Conduction::new(&carrier(full_wave, 0.7), time).unwrap();
                let most = conduction.mean(5.0, 0.0);
                for n in 0..100 {
                    let emf = most * f64::from(n) / 100.0;
                    assert!(
                        emf + conduction.mean(5.0, emf) > most * (1.0 - 1e-12),
                        "{full_wave} {time} {emf}"
                    );
                    assert!(conduction.amplitude(most - emf, emf) < 5.0 * (1.0 + 1e-4));
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let field = |carrier: Carrier, time: f64| Conduction::new(&carrier, time).unwrap_err().field;
        assert_eq!(field(Carrier { hertz: 0.0, ..carrier(true, 0.0) }, 0.0), "carrier");
        assert_eq!(field(carrier(true, -0.1), 0.0), "diode_drop");
        assert_eq!(field(carrier(true, 0.0), f64::NAN), "inductance");
    }
}
