//! A rumble motor as a rig describes it: what it is made of, and what of a card's samples reaches it.

mod lack;
mod wiring;

pub use lack::Lack;
pub use wiring::Wiring;

use super::device::Coupling;
use super::output::Turning;
use super::terminals::Terminals;
use super::{Actuator, Amplifier, Drive, Model, Output, OutputKind, Rig};
use crate::actuator::driver::setup::Shaping;
use crate::actuator::fault::{Fault, Limit};
use crate::actuator::motor::{Casing, GRAVITY, Parameters, Suspension};
use crate::text::Problem;

/// Seconds in which no motor comes to its speed: the smallest take milliseconds.
const QUICKEST: f64 = 1e-4;
/// And seconds that none takes.
const SLOWEST: f64 = 10.0;

impl Actuator {
    /// A rumble motor, from what is known of it: gravity aside.
    ///
    /// Either all that it is made of is known, or what can be told from outside (`time_constant`, `speed_per_volt`, `running_volts`,
    /// `start_volts`, `eccentric_per_mass`). Then a resistance or a mass that is not known is 1 and stands for no real one; see
    /// [`Actuator::has_torques`].
    ///
    /// # Errors
    /// The first figure that is missing or cannot be.
    pub fn rumble_motor(&self) -> Result<Parameters, Lack> {
        let get = |key: &'static str| self.value(key).ok_or(Lack::Figure(key));
        let or = |key: &str, otherwise: f64| self.value(key).unwrap_or(otherwise);
        let rated_volts = get("rated_volts")?;
        let from_outside = self.is_from_outside();
        let parameters = if from_outside {
            let gain = 1.0 / get("speed_per_volt")?;
            let running = or("running_volts", 0.0);
            let starts = or("start_volts", running);
            if starts < running {
                let because = "in V: what starts it is no less than what friction takes of it while it turns, `running_volts`";
                let fault = Fault::because("start_volts", starts, Limit::Least(running), because);
                return Err(Lack::Fault(fault));
            }
            let (mass, known) = (or("mass", 1.0), self.value("resistance"));
            let resistance = known.unwrap_or(1.0);
            Parameters {
                resistance,
                inductance: if known.is_some() { or("inductance", 0.0) } else { 0.0 },
                gain,
                inertia: get("time_constant")? * gain * gain / resistance,
                viscous: 0.0,
                coulomb: running * gain / resistance,
                stiction: starts * gain / resistance,
                eccentric: get("eccentric_per_mass")? * mass,
                gravity: 0.0,
                casing: Casing::Suspended { mass, across: FREE, upright: FREE },
                rated_volts,
            }
        } else {
            let coulomb = or("coulomb_friction", 0.0);
            Parameters {
                resistance: get("resistance")?,
                inductance: or("inductance", 0.0),
                gain: get("torque_constant")?,
                inertia: get("inertia")?,
                viscous: or("viscous_friction", 0.0),
                coulomb,
                stiction: or("static_friction", coulomb),
                eccentric: get("eccentric_moment")?,
                gravity: 0.0,
                casing: self.casing(),
                rated_volts,
            }
        };
        parameters.check().map_err(Lack::Fault)?;
        if parameters.mechanical_time() < QUICKEST {
            let fault = if from_outside {
                let because = "in s: no motor is at its speed sooner";
                Fault::because("time_constant", parameters.mechanical_time(), Limit::Least(QUICKEST), because)
            } else {
                let because = "in kg m2: it would else be at its speed within 0.1 ms, as no motor is; or `torque_constant`, in N m/A, is too large: small motors have some thousandths";
                let least = Limit::Least(QUICKEST * parameters.damping());
                Fault::because("inertia", parameters.inertia, least, because)
            };
            return Err(Lack::Fault(fault));
        }
        if parameters.mechanical_time() > SLOWEST {
            let because = "in s, from its figures: no motor with an eccentric mass is that slow";
            let time = parameters.mechanical_time();
            return Err(Lack::Fault(Fault::because("time_constant", time, Limit::Most(SLOWEST), because)));
        }
        if parameters.electrical_time() > parameters.mechanical_time() {
            let because = "in H: its current would else be slower than its speed, as in no motor";
            let most = Limit::Most(parameters.mechanical_time() * parameters.resistance);
            return Err(Lack::Fault(Fault::because("inductance", parameters.inductance, most, because)));
        }
        Ok(parameters)
    }

    /// Whether torques of [`Actuator::rumble_motor`], amperes while it turns, joules, and what gravity does to it are real ones. From outside nobody
    /// can tell the torque of an ampere, nor how much of what slows it down is friction that grows with the speed: all of it counts as back-EMF.
    pub fn has_torques(&self) -> bool {
        !self.is_from_outside()
    }

    /// What of gravity acts in the plane of the mass of a motor that is held so, m/s²; 0 where nobody knows how it is held, or what the mass weighs
    /// beside its torques.
    pub fn gravity(&self, tilt: Option<f64>) -> f64 {
        tilt.filter(|_| self.has_torques()).map_or(0.0, |tilt| (GRAVITY * tilt.cos()).abs())
    }

    fn is_from_outside(&self) -> bool {
        self.value("time_constant").is_some() && self.value("torque_constant").is_none()
    }

    /// What of a motor can be told from outside, by what it is made of: `time_constant` and what goes with it.
    ///
    /// # Errors
    /// As [`Actuator::rumble_motor`].
    pub fn outside(&self) -> Result<[(&'static str, Option<f64>); 5], Lack> {
        let p = self.rumble_motor()?;
        Ok([
            ("time_constant", Some(p.mechanical_time())),
            ("speed_per_volt", Some(p.gain / (p.resistance * p.damping()))),
            ("running_volts", Some(p.running_volts())),
            ("start_volts", Some(p.stiction * p.resistance / p.gain)),
            ("eccentric_per_mass", p.casing.mass().map(|mass| p.eccentric / mass)),
        ])
    }

    fn casing(&self) -> Casing {
        let Some(mass) = self.value("mass") else { return Casing::Held };
        match self.value("mount_stiffness") {
            Some(stiffness) => {
                let spring = Suspension { stiffness, damping: self.value("mount_damping").unwrap_or(0.0) };
                Casing::Suspended { mass, across: spring, upright: spring }
            }
            None => Casing::Free { mass },
        }
    }

    /// The volts that amperes allow: of the motor's `max_amperes` what makes them at a standstill, as data sheets have it; of the amplifier's, what it
    /// still gives in a brake from the speed that they lead to, R I/(1 + k²/(k² + b R)). Infinite where nothing limits them, or the resistance is
    /// not known.
    pub(super) fn volts_of_amperes(&self, amplifier: &Amplifier, p: &Parameters) -> f64 {
        let Some(ohms) = self.value("resistance") else { return f64::INFINITY };
        let turning = p.gain * p.gain / (p.resistance * p.damping());
        let stands = self.value("max_amperes").map(|most| most * ohms);
        let brakes = amplifier.max_amperes.map(|most| most * ohms / (1.0 + turning));
        stands.into_iter().chain(brakes).fold(f64::INFINITY, f64::min)
    }

    /// The most it bears, V: `max_volts`, else what it is made for.
    pub fn most_volts(&self) -> Option<f64> {
        self.value("max_volts").or(self.value("rated_volts"))
    }
}

const FREE: Suspension = Suspension { stiffness: 0.0, damping: 0.0 };

impl Rig {
    /// The motor on an output of kind drive; `None` for other outputs.
    ///
    /// # Errors
    /// What is missing, or what on its way lets nothing steady through: with the reason and what would help.
    pub fn wiring(&self, output: &Output) -> Option<Result<Wiring, Problem>> {
        let OutputKind::Drive(turning) = output.kind else { return None };
        Some(self.wire(output, turning))
    }

    /// The motor of an output and the figure that it lacks.
    pub(super) fn lacking(&self, output: &Output) -> Option<(&Actuator, &'static str)> {
        let motor = output.actuator.as_ref().and_then(|name| self.actuator(name))?;
        match motor.rumble_motor() {
            Err(Lack::Figure(key)) if motor.model == Model::RumbleMotor => Some((motor, key)),
            _ => None,
        }
    }

    fn wire(&self, output: &Output, turning: Turning) -> Result<Wiring, Problem> {
        let name = &output.name;
        let lacks = |what: String, help: &str| Err(Problem::error(&output.span, what).help(help.to_string()));
        let Some(actuator) = output.actuator.as_ref().and_then(|name| self.actuator(name)) else {
            let help = "name a motor: actuator = \"NAME\", and describe it under [actuator.NAME]";
            return lacks(
                format!("output `{name}` is a drive without an actuator: what it turns is not known"),
                help,
            );
        };
        if actuator.model != Model::RumbleMotor {
            let what = format!(
                "output `{name}` is a drive, but its actuator `{}` is of model {}",
                actuator.name,
                actuator.model.word()
            );
            return lacks(
                what,
                "drives turn motors (model = \"rumble-motor\"); for all else write [[tactor]]",
            );
        }
        let mut parameters = actuator.rumble_motor().map_err(|lack| lack.of(actuator))?;
        let Some(amplifier) = output.amplifier.as_ref().and_then(|name| self.amplifier(name)) else {
            let help = "name what stands between card and motor, with its gain: a motor takes more current than a card gives";
            return lacks(format!("output `{name}` is a drive without an amplifier"), help);
        };
        if let Drive::Bridge { period } = amplifier.drive {
            return self.bridged(output, turning, actuator, amplifier, parameters, period);
        }
        if turning.direction.is_some() {
            let what = format!(
                "output `{name}` has `direction`, and its amplifier `{}` is no bridge: the sign of a voltage says which way",
                amplifier.name
            );
            return lacks(what, "leave it out, or say drive = \"bridge\" of the amplifier");
        }
        let Some(full_scale) = self.device.full_scale_volts else {
            let help =
                "play a full sine, hold a meter to the output, and write the peak: full_scale_volts = 1.4";
            return lacks(
                format!(
                    "output `{name}` is a drive, so `full_scale_volts` of the device must be known: a motor's model needs volts"
                ),
                help,
            );
        };
        if amplifier.gain == 0.0 {
            return lacks(
                format!("amplifier `{}` has a gain of 0: nothing reaches `{name}`", amplifier.name),
                "give its gain",
            );
        }
        let corners = self.corners(output);
        let known = self.device.coupling.is_some() && amplifier.coupling.is_some();
        let passes_clicks = turning.shaping == Shaping::Clicks && known;
        if !matches!(amplifier.drive, Drive::Carrier(_)) && !passes_clicks {
            self.passes_steady(output, amplifier)?;
        }
        parameters.gravity = actuator.gravity(turning.tilt);
        let is_current = amplifier.drive == Drive::Current;
        let per_sample = full_scale * amplifier.gain;
        let volts =
            [actuator.most_volts(), amplifier.max_volts].into_iter().flatten().fold(f64::INFINITY, f64::min);
        let share = self.max_level(output);
        let own = if is_current {
            let amperes = [actuator.value("max_amperes"), amplifier.max_amperes].into_iter().flatten();
            // What flows at a standstill with the most it bears.
            amperes.fold(volts / parameters.resistance, f64::min)
        } else {
            volts.min(actuator.volts_of_amperes(amplifier, &parameters))
        };
        let limit = own.min(per_sample.abs() * share);
        let compliance = amplifier.max_volts.unwrap_or(volts);
        let is_steady = corners.hertz().is_empty();
        let terminals = if is_steady { Terminals::Straight } else { Terminals::Coupled(corners) };
        if !is_steady && parameters.coulomb == 0.0 && !matches!(amplifier.drive, Drive::Carrier(_)) {
            return lacks(
                format!(
                    "nothing holds the motor of `{name}` where a click has turned it: what the coupling gives back would turn it back"
                ),
                "say what its friction is: `coulomb_friction`, or `running_volts` where it is known from outside",
            );
        }
        let wiring = Wiring { turning, parameters, is_current, per_sample, limit, compliance, terminals };
        if let Drive::Carrier(carrier) = amplifier.drive {
            return self.carried(output, turning, actuator, amplifier, wiring, carrier);
        }
        wiring.turns(output)
    }

    /// That nothing on the way keeps steady voltages off, which a motor needs.
    pub(super) fn passes_steady(&self, output: &Output, amplifier: &Amplifier) -> Result<(), Problem> {
        let name = &output.name;
        let help = match amplifier.drive {
            Drive::Bridge { .. } => {
                "a bridge is switched by steady voltages: take a DC-coupled card, and say coupling = \"dc\" of the device"
            }
            Drive::Voltage | Drive::Current | Drive::Carrier(_) => {
                "a motor turns by a steady voltage: take a DC-coupled card and a DC amplifier or a bridge, and say coupling = \"dc\" of both; or a rectifier before the motor and drive = \"carrier\" of the amplifier; for clicks alone shaping = \"clicks\" of the output will do, where both couplings are known"
            }
        };
        let what = match (self.device.coupling, amplifier.coupling) {
            (Some(Coupling::Dc), Some(Coupling::Dc)) => return Ok(()),
            (Some(Coupling::HighPass(hertz)), _) => {
                let lasts = 1e3 / (std::f64::consts::TAU * hertz);
                format!(
                    "the device lets nothing steady through to the motor of `{name}`: behind its high-pass at {hertz} Hz a voltage is at 37 % after {lasts:.0} ms"
                )
            }
            (None, _) => format!(
                "the device is not known to let a steady voltage through to the motor of `{name}`: most cards do not"
            ),
            (_, Some(Coupling::HighPass(hertz))) => {
                format!(
                    "amplifier `{}` is an AC amplifier: its high-pass at {hertz} Hz keeps steady voltages off the motor of `{name}`",
                    amplifier.name
                )
            }
            (_, None) => format!(
                "amplifier `{}` is not known to let a steady voltage through to the motor of `{name}`: audio amplifiers do not",
                amplifier.name
            ),
        };
        Err(Problem::error(&output.span, what).help(help.to_string()))
    }
}
