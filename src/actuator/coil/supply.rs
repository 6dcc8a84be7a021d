//! A source with two limits: one that imposes a voltage runs out of current, one that imposes a current runs out of volts.

use super::model::Model;
use super::readout::Outputs;
use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, positive};

/// A real amplifier on a coil: at each sample it holds the voltage that brings the current, or keeps it within its limit, by the end of
/// the sample, as far as its volts suffice.
///
/// It drives a model under [`Drive::Voltage`], whatever it imposes itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// What it imposes.
    imposes: Drive,
    volts: f64,
    amperes: f64,
    limited: u64,
}

impl Supply {
    /// One that imposes a drive; `None`: no limit.
    ///
    /// # Errors
    /// A limit that is not above 0.
    pub fn new(imposes: Drive, volts: Option<f64>, amperes: Option<f64>) -> Result<Self, Fault> {
        volts.map_or(Ok(()), |volts| positive("max_volts", volts))?;
        amperes.map_or(Ok(()), |amperes| positive("max_amperes", amperes))?;
        let [volts, amperes] = [volts, amperes].map(|most| most.unwrap_or(f64::INFINITY));
        Ok(Self { imposes, volts, amperes, limited: 0 })
    }

    /// A step of the model at a command: volts or amperes.
    #[inline]
    pub fn step(&mut self, model: &mut Model, command: f64) -> Outputs {
        let [current, by_volt] = model.current_ahead();
        let bring = |amperes: f64| (amperes - current) / by_volt;
        let within = |x: f64, most: f64| x.max(-most).min(most);
        let asked = match self.imposes {
            Drive::Voltage => command,
            Drive::Current => bring(command),
        };
        let volts = within(asked, self.volts);
        let ahead = current + by_volt * volts;
        let volts = if ahead.abs() > self.amperes {
            within(bring(within(ahead, self.amperes)), self.volts)
        } else {
            volts
        };
        // A command that is not a number is masked, and counted, by the model.
        self.limited += u64::from((volts - asked).abs() > 1e-9 * asked.abs());
        model.step(if command.is_finite() { volts } else { command })
    }

    /// Steps at which a limit was met.
    pub fn limited(&self) -> u64 {
        self.limited
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Model;
    use super::super::parameters::tests::tactor;
    use super::super::parameters::{Coil, VoiceCoil};
    use super::super::plant::Plant;
    use super::{Drive, Supply};

    fn plant(inductance: f64) -> Plant {
        Plant::voice_coil(&VoiceCoil { coil: Coil { inductance, ..tactor().coil }, ..tactor() }).unwrap()
    }

    /// Without limits a current source does what the ideal one does, but for the way within a sample.
    #[test]
    fn a_current_source_follows_its_command() {
        for inductance in [0.0, 2.5e-4] {
            let rate = 192_000.0;
            let mut real = Model::new(&plant(inductance), rate, Drive::Voltage).unwrap();
            let mut ideal = Model::new(&plant(inductance), rate, Drive::Current).unwrap();
            let mut supply = Supply::new(Drive::Current, None, None).unwrap();
            let (mut apart, mut most) = (0.0f64, 0.0f64);
            for n in 0..20_000 {
                let amperes = 0.3 * (f64::from(n) * 0.008).sin();
                let (a, b) = (supply.step(&mut real, amperes), ideal.step(amperes));
                assert!((a.current - amperes).abs() < 1e-12, "{n}: {a:?}");
                apart = apart.max((a.displacement - b.displacement).abs());
                most = most.max(b.displacement.abs());
            }
            assert!(apart < 0.01 * most, "{apart:e} {most:e}");
            assert_eq!(supply.limited(), 0);
        }
    }

    #[test]
    fn limits_are_kept_and_counted() {
        for (imposes, command) in [(Drive::Voltage, 20.0), (Drive::Current, 3.0)] {
            for inductance in [0.0, 2.5e-4, 0.1] {
                let mut model = Model::new(&plant(inductance), 48_000.0, Drive::Voltage).unwrap();
                let mut supply = Supply::new(imposes, Some(6.0), Some(0.5)).unwrap();
                for n in 0..4800 {
                    let o = supply.step(&mut model, if n / 100 % 2 == 0 { command } else { -command });
                    assert!(
                        o.voltage.abs() <= 6.0 && o.current.abs() <= 0.5 + 1e-12,
                        "{imposes:?} {inductance} {n}: {o:?}"
                    );
                }
                assert!(supply.limited() > 1000);
            }
        }
    }

    /// Volts set how fast a current source brings its current into an inductance: L I / V.
    #[test]
    fn a_current_rises_as_fast_as_the_volts_let_it() {
        let mut model = Model::new(&plant(0.1), 48_000.0, Drive::Voltage).unwrap();
        let mut supply = Supply::new(Drive::Current, Some(10.0), None).unwrap();
        let steps = (1..4800).find(|_| supply.step(&mut model, 0.1).current > 0.0999999).unwrap();
        let time = f64::from(steps) / 48_000.0;
        // I = V / R (1 − e^(−tR/L)), the contactor hardly moving meanwhile.
        let expected = -(0.1 / 7.0) * f64::ln(1.0 - 0.1 * 7.0 / 10.0);
        assert!((time - expected).abs() < 3e-5, "{time} {expected}");
    }

    #[test]
    fn nonsense_is_masked_and_refused() {
        let mut model = Model::new(&plant(0.0), 48_000.0, Drive::Voltage).unwrap();
        let mut supply = Supply::new(Drive::Current, None, Some(1.0)).unwrap();
        let o = supply.step(&mut model, f64::NAN);
        assert!(o.current == 0.0 && model.masked() == 1);
        assert_eq!(Supply::new(Drive::Current, Some(0.0), None).unwrap_err().field, "max_volts");
        assert_eq!(Supply::new(Drive::Current, None, Some(f64::NAN)).unwrap_err().field, "max_amperes");
    }
}
