//! A knob that is not there: a plant with its encoder and its delay, and a servo around it.

use super::setup::{Setup, Unfit};
use super::tick::Servo;
use crate::actuator::fault::Fault;
use crate::actuator::thermal::{Cooling, Thermal};
use crate::knob::plant::Plant;
use crate::knob::plant::encoder::{Delay, Encoder, MOST_DELAY};
use crate::knob::plant::heat::Heat;
use crate::knob::plant::parts::{Build, Hand};

/// What a simulated knob is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What turns, what turns it, and how a hand holds it.
    pub build: Build,
    /// What sees the angle; `None`: it is seen as it is.
    pub encoder: Option<Encoder>,
    /// Ticks by which what is seen is late.
    pub delay: usize,
    /// The same of what is worked out anew of the angle alone, where that does not wait for the servo.
    pub local: Option<usize>,
    /// Volts for 1 N m at a standstill, of a motor that is driven by a voltage.
    pub volts: Option<f64>,
    /// How its winding sheds its heat, and the current of 1 N m (A), where both are known.
    pub warms: Option<(Cooling, f64)>,
}

/// A simulated knob at work.
#[derive(Debug, Clone)]
pub struct Simulated {
    plant: Plant,
    encoder: Option<Encoder>,
    delay: Delay,
    local: Option<Delay>,
    /// The plant's command for 1 N m.
    command: f64,
    /// Work that the hand and the motor did, joules.
    by_hand: f64,
    by_motor: f64,
    /// How warm its winding is; the current of 1 N m of a motor whose current is not simulated; the current at the last tick.
    heat: Option<Heat>,
    amperes: Option<f64>,
    current: f64,
}

/// Seconds over which the square of the current is averaged before it warms.
const AVERAGED: f64 = 0.01;

impl Simulated {
    /// At rest at 0 rad, for ticks every `period` seconds.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(model: &Model, period: f64) -> Result<Self, Fault> {
        let heat = |(cooling, _): &(Cooling, f64)| {
            let every = (AVERAGED / period).round().clamp(1.0, 1e6) as u32;
            Heat::new(cooling, period, every)
        };
        // Where the winding is part of the plant, its own current warms it.
        let amperes = model.warms.filter(|_| model.build.winding().is_none()).map(|(_, amperes)| amperes);
        Ok(Self {
            heat: model.warms.as_ref().map(heat).transpose()?,
            amperes,
            current: 0.0,
            plant: Plant::new(&model.build, 1.0 / period)?,
            encoder: model.encoder,
            delay: Delay::new(model.delay.min(MOST_DELAY), 0.0)?,
            local: model.local.map(|ticks| Delay::new(ticks.min(MOST_DELAY), 0.0)).transpose()?,
            command: model.volts.unwrap_or(1.0),
            by_hand: 0.0,
            by_motor: 0.0,
        })
    }

    /// Puts it at an angle (radians), at rest.
    ///
    /// # Errors
    /// An angle beyond the plant's limits.
    pub fn place(&mut self, angle: f64) -> Result<(), Fault> {
        self.plant.place(angle, 0.0)?;
        let seen = self.seen();
        self.delay.reset(seen);
        if let Some(local) = &mut self.local {
            local.reset(seen);
        }
        Ok(())
    }

    /// The angle in counts.
    fn seen(&self) -> f64 {
        let angle = self.plant.angle();
        self.encoder.as_ref().map_or(angle, |encoder| encoder.read(angle))
    }

    /// Passes a tick with a torque (N m) held over it, and a hand.
    pub fn pass(&mut self, torque: f64, hand: &Hand) {
        let (knob, motor) = (self.plant.knob_angle(), self.plant.angle());
        self.plant.step(torque * self.command, hand);
        self.by_hand += hand.torque * (self.plant.knob_angle() - knob);
        self.by_motor += torque * (self.plant.angle() - motor);
        if let Some(heat) = &mut self.heat {
            let before = self.current;
            self.current = self.amperes.map_or_else(|| self.plant.current(), |amperes| torque * amperes);
            // A torque that is there at once is there from the tick's beginning on.
            if heat.pass(if self.amperes.is_some() { self.current } else { before }, self.current) {
                self.plant.warm(heat.thermal().resistance());
            }
        }
    }

    /// A whole tick: reading, servo, plant. Returns the torque of it, N m.
    pub fn tick(&mut self, servo: &mut Servo, hand: &Hand) -> f64 {
        let seen = self.seen();
        let angle = self.delay.pass(seen);
        let mut torque = servo.tick(Some(angle), true);
        if let Some(local) = &mut self.local {
            torque = servo.profile().at(local.pass(seen)).0;
        }
        self.pass(torque, hand);
        torque
    }

    /// What turns.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// How warm its winding and its housing are, where that is known. A warmer winding has more resistance: under a voltage it takes less
    /// current and brakes less, and a current loop comes to the end of its supply sooner.
    pub fn thermal(&self) -> Option<&Thermal> {
        self.heat.as_ref().map(Heat::thermal)
    }

    /// Work that a hand's torque did on the knob so far, joules; that of its grasp is not among it.
    pub fn by_hand(&self) -> f64 {
        self.by_hand
    }

    /// Work of the torque that was asked of the motor, joules.
    pub fn by_motor(&self) -> f64 {
        self.by_motor
    }
}

/// A simulated knob and its servo.
///
/// # Errors
/// What of either cannot be.
pub fn both(model: &Model, setup: &Setup) -> Result<(Simulated, Servo), Unfit> {
    Ok((Simulated::new(model, setup.period())?, Servo::new(setup)?))
}
