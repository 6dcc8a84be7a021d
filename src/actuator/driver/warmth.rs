//! How warm a motor becomes by what is sent to it, and what of that is held back so that it bears it.
//!
//! What flows is known from the model that runs beside it: of a voltage, R i = V − k ω − L i' on average over every piece of a sample, and what
//! ripples about that; of a current, what was ordered, within the volts of its amplifier. A motor that is blocked draws more than that.
//!
//! A drive that is too much is made as much smaller as its root mean square ([`Effective`]) has to be. A click is not cut while it is under way, or
//! its brake might be lost: at its beginning, heat is set aside for both its halves, as much as there is, and both are as much weaker as that takes;
//! what then would not turn the motor is not begun.

use super::order::Pieces;
use super::setup::Setup;
use crate::actuator::drive::Drive;
use crate::actuator::fault::Fault;
use crate::actuator::link::effective::Effective;
use crate::actuator::motor::Motor;
use crate::actuator::protect::budget::{Bears, Budget};
use crate::actuator::protect::counts::Counts;

/// Of a click, what is none any more.
const LEAST: f64 = 0.1;

/// Keeps a motor as cool as it must be.
#[derive(Debug, Clone)]
pub struct Warmth {
    budget: Budget,
    effective: Effective,
    drive: Drive,
    one_way: bool,
    /// Of the model, H, N m/A, s; and amperes for each volt on its winding.
    inductance: f64,
    gain: f64,
    period: f64,
    amperes: f64,
    /// What turns the motor at all, and how long it takes to its speed, s.
    starts: f64,
    quickens: f64,
    /// What is let out of the click that is under way, and for how long there is heat set aside for it, s.
    click: Option<[f64; 2]>,
    by_heat: bool,
    /// Of the piece that is under way: mean squares wanted and let out.
    held: [f64; 2],
}

/// A model's state at the beginning of a piece.
#[derive(Debug, Clone, Copy)]
pub struct Before {
    current: f64,
    turned: f64,
}

impl Before {
    /// As it is.
    pub fn of(motor: &Motor) -> Self {
        Self { current: motor.current(), turned: motor.turned() }
    }
}

impl Warmth {
    /// Cold.
    ///
    /// # Errors
    /// What the motor bears cannot be kept to.
    pub fn new(setup: &Setup, bears: &Bears, effective: Effective) -> Result<Self, Fault> {
        let p = &setup.parameters;
        // What is known of a motor from outside alone has a resistance of 1 in its model: what warms it is that of its cooling.
        let ohms = bears.heat.map_or(p.resistance, |cooling| cooling.resistance);
        Ok(Self {
            budget: Budget::new(bears, setup.imposes, p.resistance, setup.rate)?,
            effective,
            drive: setup.imposes,
            one_way: setup.one_way,
            inductance: p.inductance,
            gain: p.gain,
            period: 1.0 / setup.rate,
            amperes: 1.0 / ohms,
            starts: p.stiction / p.gain * if setup.imposes == Drive::Voltage { p.resistance } else { 1.0 },
            quickens: p.mechanical_time(),
            click: None,
            by_heat: true,
            held: [0.0; 2],
        })
    }

    /// As warm as another motor was on the same output.
    pub fn warm_as(&mut self, other: &Self) {
        self.budget.warm_as(&other.budget);
    }

    /// What it did so far.
    pub fn counts(&self) -> Counts {
        self.budget.counts()
    }

    /// The winding, kelvins above the air; `None` where its heat is not watched.
    pub fn temperature(&self) -> Option<f64> {
        self.budget.temperature()
    }

    /// Ends the sample that is under way, of so many frames of the device.
    #[inline]
    pub fn pass(&mut self, frames: usize) {
        self.budget.pass(frames as u64);
    }

    /// That a click begins: what of it is let out, 1 for all and 0 where what there is would not turn the motor.
    pub fn click(&mut self, pieces: &Pieces) -> f64 {
        let [(forward, drive), (back, _), (again, _)] = pieces.list;
        let root = self.effective.of(drive.abs());
        // Weaker, it is slowed sooner than it was made fast: friction helps. Meanwhile its own voltage adds to what drives it.
        let (brakes, turning) = match (self.one_way, self.drive) {
            (true, _) => (0.0, 0.0),
            (false, Drive::Current) => (forward.max(back + again), 0.0),
            (false, Drive::Voltage) => (forward.max(back + again), (forward / self.quickens).min(1.0)),
        };
        let seconds = (forward + brakes).max(self.period);
        let square = root * root * (forward + brakes * (1.0 + turning).powi(2)) / seconds;
        let (share, by_heat) = self.budget.share(square, seconds);
        let left = if share < 1.0 { self.effective.mean(share * root) } else { drive.abs() };
        let is_none = share < 1.0 && (share < LEAST || left <= self.starts);
        self.click = (!is_none).then_some([share, seconds + self.period]);
        self.by_heat = by_heat;
        if is_none { 0.0 } else { share }
    }

    /// That no click is under way.
    #[inline]
    pub fn no_click(&mut self) {
        self.click = None;
    }

    /// What of a drive is let out.
    #[inline]
    pub fn hold(&mut self, drive: f64) -> f64 {
        let wanted = self.effective.of(drive.abs());
        let (left, by_heat) = match self.click {
            Some([share, _]) => {
                self.budget.reserve();
                (share * wanted, self.by_heat)
            }
            None => self.budget.hold(wanted),
        };
        self.held = [wanted * wanted, left * left];
        if left == wanted {
            return drive;
        }
        let smaller = self.effective.mean(left).min(drive.abs()).copysign(drive);
        self.budget.changed(drive, smaller, by_heat);
        smaller
    }

    /// Takes note of what a drive made flow for a share of a sample in a model that was so before; `blocked`: its diodes did not let it in.
    pub fn note(&mut self, drive: f64, share: f64, before: Before, motor: &Motor, blocked: bool) {
        let resistance = motor.parameters().resistance;
        let (from, to) = (resistance * before.current, resistance * motor.current());
        let emf = self.gain * (motor.turned() - before.turned) / (share * self.period);
        let of_volts = |volts: f64| {
            let stored = self.inductance * (motor.current() - before.current) / (share * self.period);
            volts - emf - stored
        };
        let square = if self.drive == Drive::Current {
            let flows = if motor.current() == drive { drive } else { of_volts(motor.voltage()) / resistance };
            flows * flows
        } else if blocked {
            // What the coil still has dies away.
            if self.inductance > 0.0 {
                0.5 * (from * from + to * to) * self.amperes * self.amperes
            } else {
                0.0
            }
        } else {
            let flows = of_volts(drive);
            // Within the piece it goes from the one to the other.
            let within = if self.inductance > 0.0 { (to - from) * (to - from) / 12.0 } else { 0.0 };
            (self.effective.square(drive, emf, flows) + within) * self.amperes * self.amperes
        };
        if let Some([_, seconds]) = &mut self.click {
            *seconds -= share * self.period;
            if *seconds <= 0.0 {
                self.click = None;
            }
        }
        let [wanted, left] = self.held;
        self.budget.note(share, [wanted, left, square]);
    }

    /// What of the sample that was taken last flows, of a current, in equal parts.
    pub fn flowed(&mut self, parts: &[f64]) {
        if self.drive == Drive::Current && !parts.is_empty() {
            let square = parts.iter().map(|part| part * part).sum::<f64>() / parts.len() as f64;
            self.budget.flowed(square);
        }
    }
}
