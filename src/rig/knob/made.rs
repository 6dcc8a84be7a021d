//! What a knob is made of, for its servo and its simulation.

use super::{Imposed, Knob, controller};
use crate::actuator::thermal::{COPPER, Cooling};
use crate::knob::angle::decoder::Sensor;
use crate::knob::governor::device::{Delay, Device, Resonance};
use crate::knob::passivity::Cap;
use crate::knob::plant::encoder::Encoder;
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{Build, Drive, Grasp, Shaft, Winding};
use crate::knob::plant::wave::Wave;
use crate::knob::safety::chain::Limits;
use crate::knob::servo::setup::Setup;
use crate::knob::servo::simulated::Model;
use std::f64::consts::TAU;

/// How a simulated hand holds a knob: some 2 Hz with a fist's inertia behind it, N m/rad and N m s/rad.
const GRASP: Grasp = Grasp { stiffness: 0.3, damping: 2e-3 };
/// The angle of a count where the angle is known exactly: what 24 bits a turn tell apart.
const EXACT: f64 = TAU / 16_777_216.0;
/// Below this speed passivity does not brake, rad/s.
const LEAST_SPEED: f64 = 1e-3;
/// Where nobody has measured how late a card's torque is: blocks, two in and two out, and seconds of what evens out two clocks.
const BLOCKS: f64 = 4.0;
const INTAKE: f64 = 4e-3;
/// Kelvins that a winding bears above the air.
const BORNE: f64 = 100.0;

/// At which pace a knob's servo runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Ticks a second.
    pub rate: f64,
    /// Frames of the device in a tick.
    pub frames: u32,
    /// Ticks in an engine sample.
    pub ticks: u32,
    /// Frames of the device in a block, where blocks are waited for.
    pub block: u32,
}

impl Pace {
    /// Of a servo that waits for no blocks, a tick a frame.
    pub fn of(rate: f64) -> Self {
        Self { rate, frames: 1, ticks: 1, block: 0 }
    }
}

/// What turns.
pub(super) fn build(knob: &Knob) -> Build {
    let shaft = knob.resonance.filter(|_| knob.knob_inertia > 0.0).map(|(hertz, damping)| Shaft {
        inertia: knob.knob_inertia,
        viscous: 0.0,
        stiffness: Shaft::stiffness_of(knob.inertia, hertz),
        damping,
    });
    let winding = knob.winding.map(|[gain, resistance, inductance, supply]| Winding {
        resistance,
        inductance,
        gain,
        supply,
    });
    let drive = match (knob.drive, winding) {
        (Imposed::Current(hertz), Some(winding)) => {
            Drive::Current { winding, bandwidth: TAU * hertz, peak: knob.peak / winding.gain }
        }
        (Imposed::Voltage, Some(winding)) => Drive::Voltage(winding),
        _ => Drive::Torque,
    };
    let inertia = if shaft.is_some() { knob.inertia } else { knob.inertia + knob.knob_inertia };
    let parameters = Parameters {
        inertia,
        viscous: knob.viscous,
        coulomb: knob.friction.unwrap_or(0.0),
        stiction: knob.stiction,
        stops: knob.stops,
    };
    Build { parameters, shaft, drive, grasp: Some(GRASP), cogging: knob.cogging, ripple: knob.ripple }
}

impl Knob {
    /// What turns, what turns it, and a hand that holds it.
    pub fn build(&self) -> Build {
        build(self)
    }

    /// Viscous friction under the drive that it has: a short circuit's is there under voltage drive alone, N m s/rad.
    pub fn damping(&self) -> f64 {
        let shorted = if self.drive == Imposed::Voltage { self.viscous_shorted } else { 0.0 };
        self.viscous + shorted
    }

    /// Seconds that card and system may take from the angle to its torque, in blocks of so many frames of so many a second; 0 of a knob
    /// that is simulated and whose `delay` nobody has measured.
    pub fn allowance(&self, block: u32, rate: f64) -> f64 {
        let blocks = || match (&self.controller, &self.sensor) {
            (Some(of), _) => of.late() + controller::BLOCKS * f64::from(block) / rate,
            (None, Some(_)) => INTAKE + BLOCKS * f64::from(block) / rate,
            (None, None) => 0.0,
        };
        self.delay.unwrap_or_else(blocks)
    }

    /// Seconds from an angle to the torque that the line's own thread makes of it, where one does: behind a low-pass none may be sooner than another,
    /// and what brakes by energy must know all torque.
    pub fn local(&self) -> Option<f64> {
        let alone = self.controller.as_ref().and_then(controller::Controller::alone);
        alone.filter(|_| self.reconstruction.is_none() && self.passivity == 0.0)
    }

    fn delay_at(&self, pace: &Pace) -> Delay {
        let frames = f64::from(pace.frames.max(1));
        // An engine sample is computed from what was heard until it began.
        let own =
            |sensor: &Sensor| f64::from(pace.ticks.max(1)) - 1.0 + sensor.late(pace.frames as usize) / frames;
        let own = self.sensor.as_ref().map_or(0.0, own);
        let (late, blocks) = match (&self.controller, &self.sensor) {
            (Some(of), _) => (of.late(), controller::BLOCKS),
            (None, Some(_)) => (INTAKE, BLOCKS),
            (None, None) => (0.0, 0.0),
        };
        let local = self.local().map(|seconds| seconds * pace.rate);
        match self.delay {
            None if blocks > 0.0 => {
                Delay { fixed: own + late * pace.rate, block: pace.block, frames, blocks, local }
            }
            seconds => Delay { local, ..Delay::ticks(own + seconds.unwrap_or(0.0) * pace.rate) },
        }
    }

    /// What must be known to say what it bears.
    pub fn device(&self, pace: &Pace) -> Device {
        let resonance = self.resonance.filter(|_| self.knob_inertia > 0.0);
        Device {
            inertia: self.inertia + self.knob_inertia,
            damping: self.damping(),
            friction: self.friction,
            count: self.counts.map_or(EXACT, |counts| TAU / counts),
            period: 1.0 / pace.rate,
            delay: self.delay_at(pace),
            resonance: resonance.map(|(clamped, loss)| Resonance { clamped, knob: self.knob_inertia, loss }),
            low_pass: self.reconstruction,
            velocity: self.velocity,
            peak: self.peak,
        }
    }

    /// What its chain of safety keeps to, at `rate` hertz.
    pub fn limits(&self, rate: f64) -> Limits {
        let period = 1.0 / rate;
        Limits {
            period,
            slew: self.slew,
            low_pass: self.reconstruction,
            continuous: self.continuous,
            winding: self.winding_time.max(100.0 * period),
            peak: self.peak,
            soft_start: self.soft_start,
            stale: (self.stale * rate).round().clamp(0.0, 1e9) as u32,
            release: self.release,
            over_speed: self.over_speed,
        }
    }

    /// Its servo, without effects.
    pub fn servo(&self, pace: &Pace) -> Setup {
        let device = self.device(pace);
        let flat = Wave::default();
        let cap = Cap { inertia: device.inertia, share: self.passivity, least_speed: LEAST_SPEED };
        Setup {
            margin: self.margin,
            passivity: (self.passivity > 0.0).then_some(cap),
            cogging: if self.compensate { self.cogging } else { flat },
            ripple: if self.compensate { self.ripple } else { flat },
            ..Setup::new(Vec::new(), device, self.limits(pace.rate))
        }
    }

    /// The same knob, simulated: its readings are as late as they are measured to be.
    pub fn model(&self, pace: &Pace) -> Model {
        let volts = match (self.drive, self.winding) {
            (Imposed::Voltage, Some([gain, resistance, ..])) => Some(resistance / gain),
            _ => None,
        };
        let delay = self.delay_at(pace);
        let ticks = |ticks: f64| ticks.round().clamp(0.0, 1e6) as usize;
        Model {
            build: build(self),
            encoder: self.counts.and_then(|counts| Encoder::of_counts(counts).ok()),
            delay: ticks(delay.total()),
            local: delay.local.map(|_| ticks(delay.spring())),
            volts,
            warms: self.cooling().zip(self.winding).map(|(cooling, [gain, ..])| (cooling, 1.0 / gain)),
        }
    }

    /// How warm its winding gets, where that is known. What the housing takes from the winding is not in a data sheet's time constants: the
    /// continuous torque is taken to end at 100 K, a fifth of it between winding and housing.
    pub fn cooling(&self) -> Option<Cooling> {
        let ([gain, resistance, ..], housing_time) = (self.winding?, self.housing_time?);
        let watts = (self.continuous / gain).powi(2) * resistance * (1.0 + COPPER * BORNE);
        let all = BORNE / watts;
        Some(Cooling {
            resistance,
            rise: COPPER,
            to_housing: 0.2 * all,
            to_air: 0.8 * all,
            winding_time: self.winding_time,
            housing_time,
            most: BORNE,
        })
    }
}
