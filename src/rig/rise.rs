//! How long an actuator takes to rise, by its model.

use std::f64::consts::LN_10;

use super::{Drive, Output, OutputKind, Rig};
use crate::actuator::drive::Drive as Imposed;
use crate::actuator::driver::setup::{Setup, Shaping};

/// The share of what it is to shake with at which an actuator has risen.
pub const RISEN: f64 = 0.9;

/// A resonance of less quality does not hold back what is played.
const RESONANT: f64 = 2.0;

/// How an actuator rises.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rise {
    /// Seconds from rest to [`RISEN`] of what it is to shake with.
    ///
    /// Of a resonance of quality Q that is driven at its frequency f₀ the amplitude is 1 − e^(−t/τ) of that, τ = Q / (π f₀): 2.3 τ. Of a motor the
    /// acceleration goes with the square of the speed, so that is √0.9 of the speed: 2.97 time constants at what holds the speed, and sooner with all that its
    /// amplifier gives.
    pub seconds: f64,
    /// What would make it faster.
    pub way: Way,
}

/// What would make an actuator faster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// `even_out`, by which a resonance is overdriven.
    EvenOut,
    /// A `shaping` that overdrives a motor.
    Overdrive,
    /// More volts to overdrive it with.
    Volts,
    /// Nothing that a rig could say.
    None,
}

impl Rig {
    /// How the actuator of an output rises to a level; `None` where its model is not known or does not hold back what is played.
    pub fn rise(&self, output: &Output, level: f64) -> Option<Rise> {
        if let OutputKind::Drive(turning) = output.kind {
            // The rate has no part in it.
            let setup = self.wiring(output)?.ok()?.setup(8000.0);
            let seconds = spin_up(&setup, level)?;
            let way = match turning.shaping {
                Shaping::Plain => Way::Overdrive,
                _ => Way::Volts,
            };
            return Some(Rise { seconds, way });
        }
        let actuator = self.actuator(output.actuator.as_ref()?)?;
        let amplifier = output.amplifier.as_ref().and_then(|name| self.amplifier(name));
        let imposes = match amplifier.map(|amplifier| amplifier.drive) {
            Some(Drive::Current) => Imposed::Current,
            _ => Imposed::Voltage,
        };
        let (resonance, way) = match self.evened(output) {
            Some(even) => (even.ok()?.poles, Way::None),
            None => (actuator.coil().ok()?.resonance(imposes)?, Way::EvenOut),
        };
        (resonance.q >= RESONANT).then(|| Rise { seconds: LN_10 * resonance.decay(), way })
    }
}

/// Seconds in which a motor comes to [`RISEN`] of the acceleration of a level. `None`: it plays no levels, or does not come to that.
fn spin_up(setup: &Setup, level: f64) -> Option<f64> {
    let is_off = setup.shaping == Shaping::OnOff && level.abs() < setup.stage.on_at;
    if setup.shaping == Shaping::Clicks || level == 0.0 || is_off {
        return None;
    }
    let (wanted, p) = (setup.speed_of(level).abs(), &setup.parameters);
    let (inertia, damping) = (p.effective_inertia(), setup.damping());
    let risen = RISEN.sqrt() * wanted;
    // What turns it, friction aside.
    let torque = match setup.shaping {
        Shaping::Plain => damping * wanted,
        _ => setup.full_torque() - p.coulomb,
    };
    let seconds = match damping * risen / torque {
        // Without damping it speeds up evenly.
        share if share < 1e-9 => risen * inertia / torque,
        share => -inertia / damping * (1.0 - share).ln(),
    };
    (seconds > 0.0 && seconds.is_finite()).then_some(seconds)
}

#[cfg(test)]
mod tests {
    use super::Way;
    use crate::rig::Rig;

    fn rig(more: &str) -> Rig {
        let text = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 1.0\ncoupling = \"dc\"\n[amplifier.board]\ngain = 6.0\n\
             max_volts = 5.0\ncoupling = \"dc\"\n[actuator.coin]\npart = \"coin-10mm\"\n[actuator.lra]\nmodel = \"lra\"\nresonance = 175.0\nq = 15.0\n\
             rated_volts = 2.0\nrated_acceleration = 12.0\ntest_mass = 0.1\ndevice_mass = 2.5e-3\nslug_mass = 1.5e-3\nresistance = 25.0\n{more}"
        );
        Rig::parse("r.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    }

    /// τ = Q / (π f₀) = 27.3 ms; 90 % comes after ln 10 of them.
    #[test]
    fn a_resonance_rises_by_its_quality() {
        let lra = "[[tactor]]\nname = \"t\"\nchannel = 1\nactuator = \"lra\"\n";
        let bare = rig(lra);
        let rise = bare.rise(&bare.outputs[0], 1.0).unwrap();
        let due = 10f64.ln() * 15.0 / (std::f64::consts::PI * 175.0);
        assert!((rise.seconds / due - 1.0).abs() < 1e-6 && rise.way == Way::EvenOut, "{rise:?} {due}");
        let evened = rig(&format!("even_out = {{ q = 4.0, most_db = 40.0 }}\n{lra}"));
        let rise = evened.rise(&evened.outputs[0], 1.0).unwrap();
        assert!(rise.seconds < 0.5 * due && rise.way == Way::None, "{rise:?}");
        let flat = rig(&format!("even_out = {{ most_db = 40.0 }}\n{lra}"));
        assert_eq!(flat.rise(&flat.outputs[0], 1.0), None, "nothing is left that rings");
        let generic = rig("[[tactor]]\nname = \"t\"\nchannel = 1\n");
        assert_eq!(generic.rise(&generic.outputs[0], 1.0), None);
    }

    /// By the definition: the speed of a motor without coil and gravity, integrated in small steps until its square is 90 % of that wanted.
    #[test]
    fn a_motor_rises_as_its_equation_says() {
        for (shaping, way) in [("plain", Way::Overdrive), ("overdrive", Way::Volts), ("inverse", Way::Volts)]
        {
            let text = format!(
                "[[output]]\nkind = \"drive\"\nname = \"m\"\nchannel = 1\nactuator = \"coin\"\namplifier = \"board\"\nshaping = \"{shaping}\"\n"
            );
            let rig = rig(&text);
            let output = &rig.outputs[0];
            let setup = rig.wiring(output).unwrap().unwrap().setup(8000.0);
            let p = &setup.parameters;
            for level in [0.1, 0.5, 1.0] {
                let wanted = setup.speed_of(level);
                let volts = if shaping == "plain" { setup.held_by(wanted) } else { setup.limit };
                let (mut speed, mut seconds, step) = (0.0, 0.0, 1e-6);
                while speed * speed < 0.9 * wanted * wanted {
                    let torque =
                        p.gain * (volts - p.gain * speed) / p.resistance - p.viscous * speed - p.coulomb;
                    speed += step * torque / p.effective_inertia();
                    seconds += step;
                }
                let rise = rig.rise(output, level).unwrap();
                assert!(
                    (rise.seconds / seconds - 1.0).abs() < 1e-3 && rise.way == way,
                    "{shaping} {level}: {rise:?} {seconds}"
                );
            }
            assert_eq!(rig.rise(output, 0.0), None);
        }
    }
}
