//! A knob of a patch on a serial line: between the line's thread and a session's callback.

use std::sync::mpsc::{Receiver, Sender};

use super::driver::{Running, run};
use super::lost::Lost;
use super::odrive::{self, ODrive};
use super::port::Port;
use super::servo::{News, Reading, Servo};
use super::smartknob::compile::{self, compile};
use super::smartknob::config::Config;
use super::smartknob::{self, Feel, Remote, SmartKnob};
use crate::actuator::fault::Fault;
use crate::knob::effect::program::Any;
use crate::live::remote::Line;
use crate::rig;
use crate::rig::knob::controller::{Controller, Kind};

/// Why a knob is not talked to.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused {
    /// What happened.
    pub message: String,
    /// What to do about it, where `message` does not say.
    pub help: Option<&'static str>,
    /// The exit code of a program that ends for it, as `sysexits.h` has them.
    pub exit_code: u8,
}

impl Refused {
    fn figure(fault: &Fault) -> Self {
        Self { message: fault.to_string(), help: None, exit_code: 65 }
    }
}

/// Talks to a rig's knob on its own thread until what it gives is dropped; `effects` are what a patch wants it to be, and `orders` brings what it
/// wants later; `says` hears what people should know.
///
/// # Errors
/// A port that cannot be opened; a figure that the device would refuse.
pub fn begin(
    knob: &rig::Knob,
    controller: &Controller,
    effects: &[Any],
    orders: Receiver<Vec<Any>>,
    line: Line,
    says: Sender<String>,
) -> Result<Running, Refused> {
    let open = || {
        Port::open(&controller.port, controller.baud).map_err(|error| Refused {
            exit_code: error.exit_code(),
            message: error.message,
            help: Some(error.help),
        })
    };
    let sign = if controller.inverted { -1.0 } else { 1.0 };
    let hands = |myself| Hands { line, says, sign, name: controller.port.clone(), myself, angle: None };
    let ran = match controller.kind {
        Kind::ODrive { axis, exchanges, watchdog, unwatched, .. } => {
            let settings = odrive::Settings {
                axis,
                most_torque: knob.peak,
                most_speed: knob.over_speed.clamp(0.1, 1e4),
                rate: exchanges,
                watchdog,
                patience: controller.patience,
                ramp: knob.release.min(0.02),
                unwatched,
            };
            let session = ODrive::new(settings).map_err(|fault| Refused::figure(&fault))?;
            run(open()?.say_ready(), session, hands(None))
        }
        Kind::SmartKnob(stiffness) => {
            let myself = Myself::new(effects, orders, stiffness).map_err(|fault| Refused::figure(&fault))?;
            let settings = smartknob::Settings { parting: Some(limp()), ..smartknob::Settings::default() };
            let (session, remote) = SmartKnob::new(settings).map_err(|fault| Refused::figure(&fault))?;
            run(open()?, session, hands(Some((remote, myself))))
        }
    };
    ran.map_err(|error| Refused {
        message: format!("no thread for the knob: {error}"),
        help: None,
        exit_code: 71,
    })
}

/// A SmartKnob that pulls to nowhere.
fn limp() -> Config {
    Config { text: "pacinian: torque off".into(), ..Config::default() }
}

/// What a knob that renders by itself is told to be.
struct Myself {
    effects: Vec<Any>,
    /// What it is to be in place of that.
    orders: Receiver<Vec<Any>>,
    device: compile::Device,
    /// Whether it is what the patch says, and between which angles that holds.
    on: bool,
    holds: Option<(f64, f64)>,
    /// Whether what it cannot be was told.
    told: bool,
    /// Whether it was told anything since it was there.
    known: bool,
}

impl Myself {
    fn new(effects: &[Any], orders: Receiver<Vec<Any>>, stiffness: f64) -> Result<Self, Fault> {
        let device = compile::Device { stiffness };
        // What cannot be is refused before anything turns.
        compile(effects, &device, 0.0, "").map_err(|(_, fault)| fault)?;
        let effects = effects.to_vec();
        Ok(Self { effects, orders, device, on: false, holds: None, told: false, known: false })
    }

    /// Takes what it is to be from now on, if that is something else.
    fn take_orders(&mut self) {
        let newest = self.orders.try_iter().last();
        if let Some(effects) = newest.filter(|effects| *effects != self.effects) {
            self.effects = effects;
            (self.told, self.known) = (false, false);
        }
    }

    /// Tells it what to be at an angle, if that is to change.
    fn follow(&mut self, wanted: bool, angle: f64, remote: &Remote, says: &Sender<String>) {
        let holds = self.holds.is_none_or(|(low, high)| (low..=high).contains(&angle));
        if self.known && wanted == self.on && (holds || !wanted) {
            return;
        }
        let again = self.known && self.on && wanted;
        (self.known, self.on, self.holds) = (true, wanted, None);
        if !wanted {
            // Where it is, so that it does not turn.
            let _ = remote.set(Feel { config: limp(), origin: angle, stay: false });
            return;
        }
        match compile(&self.effects, &self.device, angle, "pacinian") {
            Ok(made) => {
                if !std::mem::replace(&mut self.told, true) {
                    let remarks = made.near.iter().map(|of| ("is nearly", of));
                    for (how, of) in remarks.chain(made.left_out.iter().map(|of| ("is not", of))) {
                        let _ = says.send(format!(
                            "effect {} ({}) {how} rendered by the knob: {}",
                            of.effect + 1,
                            of.name,
                            of.why
                        ));
                    }
                }
                self.holds = made.holds;
                let _ = remote.set(Feel { stay: again, ..made.feel });
            }
            Err((_, fault)) => {
                let _ = says.send(format!("the knob would refuse what it is to be: {fault}"));
            }
        }
    }
}

/// What moves the knob: the callback, by its cells.
struct Hands {
    line: Line,
    says: Sender<String>,
    sign: f64,
    name: String,
    myself: Option<(Remote, Myself)>,
    /// Where it was when it said so last.
    angle: Option<f64>,
}

impl Hands {
    fn say(&self, what: &str) {
        // Where nobody listens any more, all is over.
        let _ = self.says.send(format!("the knob on {}: {what}", self.name));
    }
}

impl Servo for Hands {
    fn tick(&mut self, reading: &Reading) -> f64 {
        // What is inverted is turned round where it is heard; its torque is turned round here.
        self.line.put(reading.angle, reading.velocity.unwrap_or(0.0));
        self.angle = Some(reading.angle);
        if self.myself.is_some() {
            self.rest();
            // It renders by itself, and whether that comes in time is its own affair.
            return 0.0;
        }
        self.sign * self.line.torque()
    }

    fn newest(&mut self) -> Option<f64> {
        let torque = self.line.torque();
        self.line.note();
        Some(self.sign * torque)
    }

    fn rest(&mut self) {
        if let (Some((remote, myself)), Some(angle)) = (&mut self.myself, self.angle) {
            myself.take_orders();
            myself.follow(self.line.is_wanted(), angle, remote, &self.says);
        }
    }

    fn lost(&mut self, why: &Lost) {
        self.line.lose();
        if let Some((_, myself)) = &mut self.myself {
            myself.known = false;
        }
        self.angle = None;
        self.say(&why.to_string());
    }

    fn news(&mut self, news: &News) {
        match news {
            News::Ready(what) => self.say(&format!("it is there, {what}")),
            News::Note(what) => self.say(what),
            News::Refused(_, why) => self.say(&format!("it refused what it is to be: {why}")),
            News::Press(_) | News::InForce(_) => {}
        }
    }
}
