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
    /// Of the voices that began last, by their numbers: which motors may hold what they ordered, a bit each.
    held: Vec<(u64, u64)>,
}

/// So many voices; of one before them every motor is told that it is released.
const KNOWN: usize = 1 << 10;

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
        let motors: Vec<Motor> = motors.collect();
        // Beyond 64 motors there are no bits.
        let known = if (1..=64).contains(&motors.len()) { KNOWN } else { 0 };
        Self { commands, motors, held: vec![(u64::MAX, 0); known] }
    }

    /// Whether an instrument's voices order something.
    pub fn gives(&self, instrument: u32) -> bool {
        self.commands.get(instrument as usize).is_some_and(|commands| !commands.is_empty())
    }

    /// A voice begins: what it orders goes to the motors of its place.
    pub fn begin(&mut self, play: &Play, serial: u64, place: &[(u32, f64)], at: Instant, stage: &mut Stage) {
        let Some(commands) = self.commands.get(play.instrument as usize) else { return };
        let mut held = 0;
        for (channel, gain) in place {
            let Some(number) = self.motors.iter().position(|motor| motor.channel == *channel) else {
                continue;
            };
            for command in commands {
                if let Some(order) = self.motors[number].order(command, play.level * gain) {
                    held |= u64::from(order.holds()) << (number % 64);
                    stage.order(*channel, instant(at), serial, order);
                }
            }
        }
        if let Some(known) = self.known(serial) {
            *known = (serial, held);
        }
    }

    /// Voices of another engine come in, which has numbered them: of none is it known any more what it ordered.
    pub fn forget(&mut self) {
        self.held.fill((u64::MAX, 0));
    }

    fn known(&mut self, serial: u64) -> Option<&mut (u64, u64)> {
        let number = serial.checked_rem(self.held.len() as u64)?;
        self.held.get_mut(number as usize)
    }

    /// A voice is released: what it ordered and still holds ends.
    pub fn release(&mut self, instrument: usize, serial: u64, at: Instant, stage: &mut Stage) {
        if self.gives(instrument as u32) {
            let held = self.known(serial).filter(|known| known.0 == serial).map_or(u64::MAX, |known| known.1);
            for (number, motor) in self.motors.iter().enumerate() {
                if held >> (number % 64) & 1 == 1 {
                    stage.order(motor.channel, instant(at), serial, Order::Release);
                }
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
