//! What a coil actuator bears.

use super::plant::Plant;
use super::response::Response;
use crate::actuator::fault::{Fault, Limit, positive};

/// What a coil actuator, or what drives it, bears at most; `None`: unknown, or of no concern.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Volts at the terminals, peak.
    pub volts: Option<f64>,
    /// Amperes, peak.
    pub amperes: Option<f64>,
    /// Amperes for as long as one likes (root mean square): what heat allows.
    pub amperes_rms: Option<f64>,
    /// Metres from rest.
    pub stroke: Option<f64>,
}

/// Frequencies of a band at which it is looked what a coil does, evenly on a logarithmic axis; and steps by which what is most is closed in
/// between two of them, each to 0.62 of the last.
const POINTS: usize = 300;
const STEPS: usize = 40;
const GOLDEN: f64 = 0.618_033_988_749_895;

impl Limits {
    /// The most volts (peak) of a slow sweep over a band, Hz, with which a coil keeps to all of them; infinite where none is known. At a
    /// frequency it is the least of `volts`, of `stroke` over what it travels for a volt, of `amperes` and of √2 `amperes_rms` over what
    /// flows for a volt.
    ///
    /// # Errors
    /// A band that does not rise from above 0 Hz to something finite.
    pub fn most_volts(&self, plant: &Plant, [low, high]: [f64; 2]) -> Result<f64, Fault> {
        positive("low", low)?;
        positive("high", high)?;
        if low > high {
            return Err(Fault::because("low", low, Limit::Most(high), "the band ends there"));
        }
        // Each by itself: where the least of all is, another may hide how narrow a resonance is.
        let none = Self::default();
        let each = [
            Self { volts: self.volts, ..none },
            Self { stroke: self.stroke, ..none },
            Self { amperes: self.amperes, ..none },
            Self { amperes_rms: self.amperes_rms, ..none },
        ];
        Ok(each.iter().map(|one| one.least_volts(plant, low.ln(), high.ln())).fold(f64::INFINITY, f64::min))
    }

    /// The least volts of a single limit between two logarithms of a frequency.
    fn least_volts(&self, plant: &Plant, from: f64, to: f64) -> f64 {
        let at = |n: usize| from + (to - from) * n as f64 / (POINTS - 1) as f64;
        let bears = |log: f64| self.bears(&plant.per_volt(log.exp()));
        // A resonance may be narrower than what lies between two points: the least of all, and then between its neighbours.
        let Some(least) = (0..POINTS).min_by(|a, b| bears(at(*a)).total_cmp(&bears(at(*b)))) else {
            return f64::INFINITY;
        };
        let (mut near, mut far) = (at(least.saturating_sub(1)), at((least + 1).min(POINTS - 1)));
        for _ in 0..STEPS {
            let (a, b) = (far - GOLDEN * (far - near), near + GOLDEN * (far - near));
            if bears(a) < bears(b) {
                far = b;
            } else {
                near = a;
            }
        }
        bears(0.5 * (near + far)).min(bears(at(least)))
    }

    /// Volts at a frequency, by what a volt does there.
    fn bears(&self, response: &Response) -> f64 {
        let [travels, flows] = [response.displacement.abs(), response.current.abs()];
        let rms = self.amperes_rms.map(|rms| rms * std::f64::consts::SQRT_2 / flows);
        let each =
            [self.volts, self.stroke.map(|stroke| stroke / travels), self.amperes.map(|i| i / flows), rms];
        each.into_iter().flatten().fold(f64::INFINITY, f64::min)
    }

    /// The same behind what gives no more than these volts and amperes, peak.
    pub fn within(self, volts: Option<f64>, amperes: Option<f64>) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        Self { volts: least(self.volts, volts), amperes: least(self.amperes, amperes), ..self }
    }

    /// Refuses limits that cannot be.
    ///
    /// # Errors
    /// A limit that is not above 0, or a steady current beyond the peak.
    pub fn check(&self) -> Result<(), Fault> {
        let fields = ["volts", "amperes", "amperes_rms", "stroke"];
        for (field, limit) in
            fields.into_iter().zip([self.volts, self.amperes, self.amperes_rms, self.stroke])
        {
            limit.map_or(Ok(()), |limit| positive(field, limit))?;
        }
        match (self.amperes_rms, self.amperes) {
            (Some(rms), Some(peak)) if rms > peak => Err(Fault::because(
                "amperes_rms",
                rms,
                Limit::Most(peak),
                "no current is on average above its peak",
            )),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Limits;
    use crate::actuator::coil::parameters::{Coil, Skin, Spring, VoiceCoil};
    use crate::actuator::coil::plant::Plant;

    /// A mass on a spring, and a coil without inductance: x/V = (Bl/R) / (k − m ω² + j ω (c + Bl²/R)), whose most is Q / √(1 − 1/4Q²) times
    /// that of no frequency, and i/V = (1 − j ω Bl x/V) / R, which is 1/R without a frequency and at all high ones.
    #[test]
    fn most_volts_are_those_of_the_closed_form() {
        let plant = |damping: f64| {
            Plant::voice_coil(&VoiceCoil {
                coil: Coil { resistance: 8.0, inductance: 0.0, force_factor: 2.0 },
                mass: 0.004,
                suspension: Spring { stiffness: 4000.0, damping },
                skin: Skin::None,
            })
            .unwrap()
        };
        let none = Limits::default();
        // c + Bl²/R = 0.6 N s/m, and ω = 1000 rad/s: Q = 6.67.
        let coil = plant(0.1);
        let q: f64 = 4.0 / 0.6;
        let peak = 2.0 / 8.0 / 4000.0 * q / (1.0 - 0.25 / (q * q)).sqrt();
        let close = |limits: Limits, plant: &Plant, band: [f64; 2], due: f64| {
            let is = limits.most_volts(plant, band).unwrap();
            assert!((is / due - 1.0).abs() < 1e-9, "{limits:?} {band:?}: {is}, but it is {due}");
        };
        let stroke = Limits { stroke: Some(1e-3), ..none };
        close(stroke, &coil, [20.0, 1500.0], 1e-3 / peak);
        // Below the resonance it moves most where the band ends.
        let omega = std::f64::consts::TAU * 50.0;
        let there = 0.25 / (4000.0 - 0.004 * omega * omega).hypot(0.6 * omega);
        close(stroke, &coil, [20.0, 50.0], 1e-3 / there);
        // A resonance far narrower than what lies between two points that are looked at: Q = 100.
        let sharp = Coil { resistance: 800.0, inductance: 0.0, force_factor: 2.0 };
        let sharp = Plant::voice_coil(&VoiceCoil {
            coil: sharp,
            mass: 0.004,
            suspension: Spring { stiffness: 4000.0, damping: 0.035 },
            skin: Skin::None,
        });
        let (sharp, due) = (sharp.unwrap(), 1e-3 / (2.0 / 800.0 / 4000.0 * 100.0 / 0.999_975_f64.sqrt()));
        close(stroke, &sharp, [20.0, 1500.0], due);
        // Nor does another limit hide it that is the same everywhere.
        close(Limits { volts: Some(1.2 * due), ..stroke }, &sharp, [20.0, 1500.0], due);
        // What flows at the resonance, where the coil moves as fast as it can, is the least: R + Bl²/c.
        let hertz = 1000.0 / std::f64::consts::TAU;
        close(Limits { amperes: Some(0.5), ..none }, &coil, [hertz, hertz], 0.5 * (8.0 + 4.0 / 0.1));
        let rms = Limits { amperes_rms: Some(0.5), ..none };
        close(rms, &coil, [hertz, hertz], 0.5 * std::f64::consts::SQRT_2 * 48.0);
        // The least of all counts; and without any there is no end.
        let all = Limits { volts: Some(1.5), amperes: Some(0.5), amperes_rms: Some(0.4), stroke: Some(1.0) };
        close(all, &coil, [20.0, 1500.0], 1.5);
        assert_eq!(none.most_volts(&coil, [20.0, 1500.0]), Ok(f64::INFINITY));
        for (band, field) in [
            ([0.0, 9.0], "low"),
            ([1.0, f64::INFINITY], "high"),
            ([9.0, 1.0], "low"),
            ([f64::NAN, 1.0], "low"),
        ] {
            assert_eq!(stroke.most_volts(&coil, band).unwrap_err().field, field, "{band:?}");
        }
    }

    #[test]
    fn behind_something_the_lesser_of_both_counts() {
        let own = Limits { volts: Some(3.0), amperes: None, amperes_rms: Some(0.1), stroke: Some(1e-3) };
        for (volts, amperes, due) in [
            (None, None, [Some(3.0), None]),
            (Some(2.0), Some(0.5), [Some(2.0), Some(0.5)]),
            (Some(4.0), None, [Some(3.0), None]),
        ] {
            let both = own.within(volts, amperes);
            assert_eq!([both.volts, both.amperes], due);
            assert_eq!((both.amperes_rms, both.stroke), (own.amperes_rms, own.stroke));
        }
        assert_eq!(Limits::default().within(Some(2.0), None).volts, Some(2.0));
    }

    #[test]
    fn limits_that_contradict_each_other_are_refused() {
        let sound =
            Limits { volts: Some(3.0), amperes: Some(0.5), amperes_rms: Some(0.5), stroke: Some(1e-3) };
        assert!(sound.check().is_ok() && Limits::default().check().is_ok());
        let fault = Limits { amperes_rms: Some(0.6), ..sound }.check().unwrap_err().to_string();
        assert!(fault.starts_with("`amperes_rms` is 0.6, but must be at most 0.5"), "{fault}");
        for (limits, field) in [
            (Limits { volts: Some(0.0), ..sound }, "volts"),
            (Limits { amperes: Some(f64::NAN), ..sound }, "amperes"),
            (Limits { stroke: Some(-1.0), ..sound }, "stroke"),
        ] {
            assert_eq!(limits.check().unwrap_err().field, field);
        }
    }
}
