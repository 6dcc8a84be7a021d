//! From what a voice orders to what the motors at its place are to do.

use std::sync::Arc;

use super::event::Play;
use super::stage::Stage;
use crate::actuator::driver::book::Book;
use crate::actuator::driver::order::{Order, Pieces, Switch};
use crate::actuator::driver::setup::{Setup, Shaping};
use crate::graph::Settings;
use crate::graph::command::Command;
use crate::graph::plan::Plan;
use crate::node::kernel::LEAD;
use crate::schedule::Instant;

/// The orders of a plan's voices, resolved against its motors.
#[derive(Debug, Default)]
pub struct Commander {
    /// By instrument.
    commands: Vec<Vec<Command>>,
    motors: Vec<Motor>,
}

#[derive(Debug)]
struct Motor {
    channel: u32,
    setup: Setup,
    /// By turns.
    clicks: Vec<(f64, Arc<Book>)>,
    home: Option<(Pieces, f64)>,
    /// By number.
    swells: Vec<Arc<Settings>>,
}

impl Commander {
    /// That of a plan.
    pub fn new(plan: &Plan) -> Self {
        let commands = plan.instruments.iter().map(|instrument| instrument.commands()).collect();
        let of = |drive: usize| {
            let own = plan.clicks.iter().filter(move |clicks| clicks.drive == drive);
            own.map(|clicks| (clicks.turns, Arc::clone(&clicks.book))).collect()
        };
        let motors = plan.drives.iter().enumerate().map(|(n, drive)| Motor {
            channel: drive.channel,
            setup: drive.setup,
            clicks: of(n),
            swells: plan.swells_of(n).map(|swell| Arc::clone(&swell.settings)).collect(),
            home: plan.homes.iter().find(|(drive, _)| *drive == n).map(|(_, home)| (home.pieces, home.angle)),
        });
        Self { commands, motors: motors.collect() }
    }

    /// Whether an instrument's voices order something.
    pub fn gives(&self, instrument: u32) -> bool {
        self.commands.get(instrument as usize).is_some_and(|commands| !commands.is_empty())
    }

    /// A voice begins: what it orders goes to the motors of its place.
    pub fn begin(&self, play: &Play, serial: u64, place: &[(u32, f64)], at: Instant, stage: &mut Stage) {
        let Some(commands) = self.commands.get(play.instrument as usize) else { return };
        for (channel, gain) in place {
            let Some(motor) = self.motors.iter().find(|motor| motor.channel == *channel) else { continue };
            for command in commands {
                if let Some(order) = motor.order(command, play.level * gain) {
                    stage.order(*channel, instant(at), serial, order);
                }
            }
        }
    }

    /// A voice is released: what it ordered and still holds ends.
    pub fn release(&self, instrument: usize, serial: u64, at: Instant, stage: &mut Stage) {
        if self.commands.get(instrument).is_some_and(|commands| !commands.is_empty()) {
            for motor in &self.motors {
                stage.order(motor.channel, instant(at), serial, Order::Release);
            }
        }
    }
}

impl Motor {
    /// What an order means for it; `None` where that is nothing.
    fn order(&self, command: &Command, level: f64) -> Option<Order> {
        match command {
            Command::Click(turns) => {
                let (_, book) = self.clicks.iter().find(|(of, _)| of == turns)?;
                let pieces = book.at(level)?;
                // Where nothing is brought home, it is never known where the mass hangs.
                Some(match self.home {
                    Some(_) => Order::Turn(pieces, turns * level.signum()),
                    None => Order::Click(pieces),
                })
            }
            Command::Spin(share, shaping) => {
                let speed = self.setup.speed_of(share * level);
                Some(match shaping {
                    Shaping::Overdrive => Order::Spin(speed),
                    other => Order::Keep(speed, *other),
                })
            }
            Command::On(share, by, after) => {
                let amount = (share * level).clamp(-1.0, 1.0) * self.setup.limit;
                Some(Order::On(Switch { amount, by: *by, after: *after }))
            }
            Command::Swell(settings, shaping) => {
                let number = self.swells.iter().position(|known| known.points == settings.points)?;
                let root = level.abs().min(1.0).sqrt().copysign(level);
                Some(Order::Swell(number as u32, root, *shaping))
            }
            Command::Home => {
                Some(self.home.map_or(Order::Homeless, |(pieces, angle)| Order::Home(pieces, angle)))
            }
            Command::Brake => Some(Order::Brake),
        }
    }
}

/// In samples, as late as voices are behind their events.
fn instant(at: Instant) -> f64 {
    at.sample as f64 + f64::from(at.fraction) / 4_294_967_296.0 + LEAD
}
