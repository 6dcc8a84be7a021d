//! Actuators with a coil: what they do at single frequencies, and how soon a burst is there and gone.

use crate::actuator::coil::burst::Burst;
use crate::actuator::coil::energy::Ledger;
use crate::actuator::coil::equaliser::{Equaliser, Motion, Wish};
use crate::actuator::coil::limits::Limits;
use crate::actuator::coil::model::Model;
use crate::actuator::coil::plant::Plant;
use crate::actuator::coil::resonance::Resonance;
use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, within};

/// What an actuator does with a tone, for each volt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Hz.
    pub hertz: f64,
    /// Acceleration of what is felt ([`acceleration`]), m/s².
    pub acceleration: f64,
    /// Displacement of what the coil moves, m.
    pub displacement: f64,
    /// A.
    pub current: f64,
}

/// Acceleration of what is felt for each volt, m/s²: that of the casing, or of a tactor's contactor.
pub fn acceleration(plant: &Plant, hertz: f64) -> f64 {
    let response = plant.per_volt(hertz);
    let casing = response.casing.abs();
    if casing > 0.0 { casing } else { response.acceleration.abs() }
}

/// What an actuator does at frequencies, each within 0.1 and 1e5 Hz.
///
/// # Errors
/// A frequency beyond that.
pub fn tones(plant: &Plant, hertz: &[f64]) -> Result<Vec<Tone>, Fault> {
    let tone = |hertz: &f64| {
        within("hertz", *hertz, (0.1, 1e5), "Hz")?;
        let response = plant.per_volt(*hertz);
        let (displacement, current) = (response.displacement.abs(), response.current.abs());
        Ok(Tone { hertz: *hertz, acceleration: acceleration(plant, *hertz), displacement, current })
    };
    hertz.iter().map(tone).collect()
}

/// The most that an equaliser may boost or cut, dB; the band that it is for, Hz; the quality that it leaves.
const CHANGE: f64 = 12.0;
const BAND: [f64; 2] = [50.0, 500.0];
const EVEN: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// An equaliser that makes 50 to 500 Hz even, without a resonance and with no change beyond 12 dB, as far as the limits let it go.
///
/// # Errors
/// A level (volts, peak) or a limit that cannot be; an actuator without a spring.
pub fn evened(plant: &Plant, level: f64, limits: &Limits) -> Result<Equaliser, Fault> {
    let shakes = plant.per_volt(BAND[0]).casing.abs() > 0.0;
    let motion = if shakes { Motion::Acceleration } else { Motion::Displacement };
    let hertz = plant.resonance(Drive::Voltage).map_or(1.0, |own| own.hertz);
    let target = Resonance { hertz, q: EVEN };
    let wish = Wish { motion, target, band: BAND, level, most_change: CHANGE, limits: *limits };
    Equaliser::design(plant, Drive::Voltage, &wish)
}

/// A burst at the resonance, in one of the ways in which it can be driven.
#[derive(Debug, Clone, PartialEq)]
pub struct Shake {
    /// What it is called.
    pub name: &'static str,
    /// Until the amplitude is 90 % of the rated one, s; `None`: it never is.
    pub rise: Option<f64>,
    /// From the end of its length until the amplitude stays below 10 % of the rated one, s.
    pub stop: f64,
    /// The largest acceleration of what is felt, m/s².
    pub peak: f64,
    /// Amplitude when the drive ends, as a share of the rated one.
    pub left: f64,
    /// What the drive supplied, J.
    pub energy: f64,
    /// Volts and acceleration (m/s²) of each step.
    pub traces: [Vec<f64>; 2],
}

/// Shares of the rated amplitude at which it is there, and gone.
const THERE: f64 = 0.9;
const GONE: f64 = 0.1;
/// Decays for which one is watched.
const DECAYS: f64 = 8.0;

/// A burst of `length` seconds at `rated` volts (peak), plain; overdriven and braked with `most` volts; and that with its brake worked out
/// for the exact motion.
///
/// # Errors
/// A figure that cannot be; an actuator that does not swing, or hardly does (Q up to 0.5).
pub fn shakes(plant: &Plant, [rated, most]: [f64; 2], length: f64, rate: f64) -> Result<Vec<Shake>, Fault> {
    within("length", length, (1e-3, 10.0), "s")?;
    within("rate", rate, (1e3, 1e6), "steps a second")?;
    let resonance = plant.resonance(Drive::Voltage).unwrap_or(Resonance { hertz: 0.0, q: 0.0 });
    let driven = Burst::new(resonance, rated, most, length)?;
    let mut settled = driven;
    settled.settle(plant, Drive::Voltage);
    let plain = Burst { rise: 0.0, brake: 0.0, ..driven };
    [("plain", plain), ("overdrive", driven), ("settled", settled)]
        .into_iter()
        .map(|(name, burst)| Shake::new(name, plant, &burst, rate))
        .collect()
}

impl Shake {
    fn new(name: &'static str, plant: &Plant, burst: &Burst, rate: f64) -> Result<Self, Fault> {
        let omega = burst.resonance.omega();
        let rated = plant.per_volt(burst.resonance.hertz).displacement.abs() * burst.rated;
        let mut volts = burst.samples(rate);
        let over = volts.len();
        let watched = (DECAYS * burst.resonance.decay() * rate).min(1e7) as usize;
        volts.resize(over + watched + 1, 0.0);
        let mut model = Model::new(plant, rate, Drive::Voltage)?;
        let mut ledger = Ledger::new(&model);
        let (mut felt, mut amplitudes) = (Vec::new(), Vec::new());
        for volts in &volts {
            let now = ledger.step(&mut model, *volts);
            felt.push(if now.casing == 0.0 { now.acceleration } else { now.casing });
            amplitudes.push(now.displacement.hypot(now.velocity / omega) / rated);
        }
        let time = |n: usize| (n + 1) as f64 / rate;
        let there = amplitudes.iter().position(|a| *a >= THERE);
        let gone = amplitudes.iter().rposition(|a| *a >= GONE);
        Ok(Self {
            name,
            rise: there.map(time),
            stop: gone.map_or(0.0, |n| (time(n) - burst.length).max(0.0)),
            peak: felt.iter().fold(0.0_f64, |most, a| most.max(a.abs())),
            left: amplitudes.get(over.saturating_sub(1)).copied().unwrap_or(0.0),
            energy: ledger.supplied,
            traces: [volts, felt],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{acceleration, evened, shakes, tones};
    use crate::actuator::coil::limits::Limits;
    use crate::actuator::coil::lra::Sheet;
    use crate::actuator::coil::parameters::{Coil, Skin, Spring, VoiceCoil};
    use crate::actuator::coil::plant::Plant;

    /// Made up, but plausible: Q 15 at 175 Hz.
    fn lra() -> Plant {
        let sheet = Sheet {
            resonance: 175.0,
            q: 15.0,
            rated_volts: 2.0,
            rated_acceleration: 12.0,
            on_mass: 0.1,
            device_mass: 2.5e-3,
            slug_mass: 1.5e-3,
            resistance: 25.0,
            inductance: 0.0,
        };
        Plant::inertial(&sheet.actuator().unwrap()).unwrap()
    }

    fn tactor() -> Plant {
        let coil = Coil { resistance: 7.0, inductance: 0.0, force_factor: 1.2 };
        let suspension = Spring { stiffness: 3132.7, damping: 0.6 };
        Plant::voice_coil(&VoiceCoil { coil, mass: 1.5e-3, suspension, skin: Skin::None }).unwrap()
    }

    /// τ = Q/(π f): 90 % after τ ln 10, or with g times the voltage after τ ln(g/(g − 0.9)); gone after τ ln 10, or braked soon after
    /// τ ln(1 + 1/g). The envelope's formulas, to a period or so.
    #[test]
    fn a_burst_comes_and_goes_as_its_envelope() {
        let (tau, period) = (15.0 / (std::f64::consts::PI * 175.0), 1.0 / 175.0);
        let rows = shakes(&lra(), [2.0, 6.0], 0.3, 48_000.0).unwrap();
        let near = |is: f64, due: f64, name: &str| assert!((is - due).abs() < period, "{name}: {is} {due}");
        for (row, gain) in rows.iter().zip([1.0_f64, 3.0, 3.0]) {
            let rise = tau * (gain / (gain - 0.9)).ln();
            near(row.rise.unwrap(), rise, row.name);
            // From 1 towards −g: a tenth is left after τ ln((1 + g)/(0.1 + g)).
            let stop =
                if gain > 1.0 { tau * ((1.0 + gain) / (0.1 + gain)).ln() } else { tau * 10.0_f64.ln() };
            near(row.stop, stop, row.name);
            assert!((row.peak / 12.0 - 1.0).abs() < 0.2, "{}: {}", row.name, row.peak);
        }
        // What the formulas of the envelope leave, the exact brake takes away; but for samples that hold their means.
        assert!(rows[0].left > 0.9 && rows[1].left < 0.15 && rows[2].left < 0.2 * rows[1].left, "{rows:?}");
        assert_eq!(shakes(&lra(), [2.0, 1.0], 0.3, 48e3).unwrap_err().field, "most");
        assert_eq!(shakes(&lra(), [2.0, 2.0], 0.0, 48e3).unwrap_err().field, "length");
    }

    /// Half the squared voltage times the conductance, as long as it lasts; building up takes a decay or so of it.
    #[test]
    fn a_long_burst_takes_the_power_of_its_tone() {
        for plant in [lra(), tactor()] {
            let resonance = plant.resonance(crate::actuator::drive::Drive::Voltage).unwrap();
            let power = 0.5 * 4.0 * plant.per_volt(resonance.hertz).current.re;
            let rows = shakes(&plant, [2.0, 6.0], 6.0, 48_000.0).unwrap();
            let share = rows[0].energy / (6.0 * power);
            assert!((share - 1.0).abs() < 0.03, "{share}");
            assert!(
                rows[1].energy > rows[0].energy,
                "{rows:?}",
                rows = rows.iter().map(|row| row.energy).collect::<Vec<_>>()
            );
        }
    }

    #[test]
    fn tones_are_those_of_the_response() {
        let (lra, tactor) = (lra(), tactor());
        let at = tones(&lra, &[175.0]).unwrap()[0];
        assert!((at.acceleration * 2.0 / 12.0 - 1.0).abs() < 1e-9, "{at:?}");
        assert_eq!(at.displacement, lra.per_volt(175.0).displacement.abs());
        // A contactor's, whose housing is held: ω² x.
        let omega = std::f64::consts::TAU * 100.0;
        let at = tones(&tactor, &[100.0]).unwrap()[0];
        assert!((acceleration(&tactor, 100.0) / (omega * omega * at.displacement) - 1.0).abs() < 1e-12);
        assert_eq!(tones(&tactor, &[100.0, f64::NAN]).unwrap_err().field, "hertz");
    }

    /// An evened tactor moves as far at its resonance as a second order of Q 0.71 does: 0.71 of what it does at rest.
    #[test]
    fn an_equaliser_takes_the_resonance_away() {
        let plant = tactor();
        let own = plant.resonance(crate::actuator::drive::Drive::Voltage).unwrap();
        assert!(own.q > 1.5);
        let even = evened(&plant, 1.0, &Limits::default()).unwrap();
        let far = |hertz: f64| plant.per_volt(hertz).displacement.abs() * even.response(hertz).abs();
        assert!((far(own.hertz) / far(1.0) / std::f64::consts::FRAC_1_SQRT_2 - 1.0).abs() < 1e-3, "{even:?}");
        let weak = Limits { stroke: Some(1e-5), ..Limits::default() };
        assert!(evened(&plant, 1.0, &weak).unwrap().limited.is_some());
    }
}
