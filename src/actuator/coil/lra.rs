//! A linear resonant actuator as its data sheet describes it.

use super::parameters::{Coil, Inertial, Spring, Tissue};
use super::plant::Plant;
use crate::actuator::fault::{Fault, Limit, not_negative, positive};

/// What a data sheet says of a linear resonant actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Resonance of the slug in the casing mounted as it was measured, hertz.
    pub resonance: f64,
    /// Quality of that resonance with the terminals shorted, the inductance neglected: at a steady voltage amplitude.
    pub q: f64,
    /// Volts, peak, at which it is rated.
    pub rated_volts: f64,
    /// Acceleration that these make at the resonance, metres a second squared, peak.
    pub rated_acceleration: f64,
    /// What it was mounted on, kilograms; 0: nothing.
    pub on_mass: f64,
    /// The device with its slug, kilograms.
    pub device_mass: f64,
    /// The slug alone, kilograms; few sheets say it.
    pub slug_mass: f64,
    /// Ohms.
    pub resistance: f64,
    /// Henries; 0: neglected.
    pub inductance: f64,
}

/// Corrections of the force factor for the inductance: each leaves about (ωL / R)² of the last error.
const CORRECTIONS: usize = 60;

impl Sheet {
    /// The actuator, mounted as it was measured.
    ///
    /// With M for all but the slug and μ for the reduced mass, a = Bl V Q / (R M) at the resonance, less what the inductance takes;
    /// Q = μ ω / (c + Bl² / R) leaves the damping c.
    ///
    /// # Errors
    /// A figure that cannot be, or those that contradict each other: a device no heavier than its slug, an acceleration that takes
    /// more damping by the coil than the quality allows.
    pub fn actuator(&self) -> Result<Inertial, Fault> {
        positive("resonance", self.resonance)?;
        positive("q", self.q)?;
        positive("rated_volts", self.rated_volts)?;
        positive("rated_acceleration", self.rated_acceleration)?;
        not_negative("on_mass", self.on_mass)?;
        positive("resistance", self.resistance)?;
        not_negative("inductance", self.inductance)?;
        let casing_mass = Inertial::casing_of(self.device_mass, self.slug_mass)? + self.on_mass;
        let reduced = 1.0 / (1.0 / self.slug_mass + 1.0 / casing_mass);
        let omega = std::f64::consts::TAU * self.resonance;
        let with = |force_factor: f64| Inertial {
            coil: Coil { resistance: self.resistance, inductance: self.inductance, force_factor },
            slug_mass: self.slug_mass,
            casing_mass,
            suspension: Spring {
                stiffness: reduced * omega * omega,
                damping: reduced * omega / self.q - force_factor * force_factor / self.resistance,
            },
            hand: Tissue::default(),
        };
        let most = (reduced * omega * self.resistance / self.q).sqrt();
        let unit = self.rated_acceleration * self.resistance * casing_mass / (self.rated_volts * self.q);
        let mut force_factor = unit;
        for _ in 0..CORRECTIONS {
            if !(force_factor.is_finite() && force_factor <= most) {
                let limit = Limit::Most(self.rated_acceleration * most / unit);
                let why = "with this quality, slug and resistance the coil alone would brake more";
                return Err(Fault::because("rated_acceleration", self.rated_acceleration, limit, why));
            }
            let plant = Plant::inertial(&with(force_factor))?;
            let is = plant.per_volt(self.resonance).casing.abs() * self.rated_volts;
            force_factor *= self.rated_acceleration / is;
        }
        Ok(with(force_factor))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::Sheet;
    use crate::actuator::coil::plant::Plant;

    /// A made-up but plausible device.
    pub fn sheet() -> Sheet {
        Sheet {
            resonance: 175.0,
            q: 15.0,
            rated_volts: 2.0 * std::f64::consts::SQRT_2,
            rated_acceleration: 17.0,
            on_mass: 0.1,
            device_mass: 2.5e-3,
            slug_mass: 1.5e-3,
            resistance: 25.0,
            inductance: 0.0,
        }
    }

    #[test]
    fn it_does_what_the_sheet_says() {
        for inductance in [0.0, 1e-4, 5e-3] {
            let sheet = Sheet { inductance, ..sheet() };
            let plant = Plant::inertial(&sheet.actuator().unwrap()).unwrap();
            let peak = plant.per_volt(sheet.resonance).casing.abs() * sheet.rated_volts;
            assert!((peak / sheet.rated_acceleration - 1.0).abs() < 1e-12, "{inductance}: {peak}");
        }
        // Without inductance, half power lies at ω (sqrt(1 + 1/4Q²) ± 1/2Q) of the velocity, and there are no other losses.
        let plant = Plant::inertial(&sheet().actuator().unwrap()).unwrap();
        let half = 0.5 / sheet().q;
        let peak = plant.per_volt(175.0).velocity.abs();
        for sign in [-1.0, 1.0] {
            let hertz = 175.0 * ((1.0 + half * half).sqrt() + sign * half);
            let share = plant.per_volt(hertz).velocity.abs() / peak;
            assert!((share * std::f64::consts::SQRT_2 - 1.0).abs() < 1e-12, "{share}");
        }
    }

    #[test]
    fn figures_that_contradict_each_other_are_refused() {
        let fault = |sheet: Sheet| sheet.actuator().unwrap_err().to_string();
        assert!(fault(Sheet { device_mass: 1.5e-3, ..sheet() }).contains("the slug is part of it"));
        let text = fault(Sheet { rated_acceleration: 1e3, ..sheet() });
        assert!(
            text.contains("`rated_acceleration` is 1000, but must be at most") && text.contains("brake"),
            "{text}"
        );
        // The limit it names, to four digits, is where it is.
        let most: f64 =
            text.split("at most ").nth(1).unwrap().split(':').next().unwrap().parse().expect("a number");
        assert!(Sheet { rated_acceleration: most * (1.0 - 1e-3), ..sheet() }.actuator().is_ok());
        assert!(Sheet { rated_acceleration: most * (1.0 + 1e-3), ..sheet() }.actuator().is_err());
        for (sheet, field) in [
            (Sheet { q: 0.0, ..sheet() }, "q"),
            (Sheet { resonance: f64::NAN, ..sheet() }, "resonance"),
            (Sheet { on_mass: -1.0, ..sheet() }, "on_mass"),
            (Sheet { resistance: 0.0, ..sheet() }, "resistance"),
            (Sheet { inductance: -1.0, ..sheet() }, "inductance"),
            (Sheet { slug_mass: 0.0, ..sheet() }, "slug_mass"),
            (Sheet { rated_volts: 0.0, ..sheet() }, "rated_volts"),
        ] {
            assert_eq!(sheet.actuator().unwrap_err().field, field);
        }
    }
}
