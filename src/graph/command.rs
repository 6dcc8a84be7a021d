//! What a voice orders of the motors at its place.

use std::sync::Arc;

use super::Settings;
use crate::actuator::driver::order::{After, By};
use crate::actuator::driver::setup::Shaping;
use crate::node::{NodeKind, drive_on, drive_spin, drive_swell};

/// An order, as a patch has it: what it means in volts depends on the motor.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// A click of so many turns, as strong as the event's level says.
    Click(f64),
    /// To a speed whose vibration is this share of the rated one, times the event's level, while the event lasts; shaped like that.
    Spin(f64, Shaping),
    /// This share of the most that there may be, times the event's level, while the event lasts; held by that, and what follows.
    On(f64, By, After),
    /// An envelope, times the event's level: that of these settings of its node.
    Swell(Arc<Settings>, Shaping),
    /// To where gravity catches the mass.
    Home,
    /// To rest.
    Brake,
}

impl Command {
    /// Whether a motor that is there for clicks alone heeds it.
    pub fn is_heeded_for_clicks(&self) -> bool {
        matches!(self, Self::Click(_) | Self::Brake)
    }

    /// That of a node, if it is one that orders something.
    pub fn of(kind: NodeKind, settings: &Arc<Settings>) -> Option<Self> {
        let first = settings.constants.first().copied();
        let choice = |place: usize| settings.choices.get(place).copied().unwrap_or(0);
        match kind {
            NodeKind::DRIVE_CLICK => first.map(Self::Click),
            NodeKind::DRIVE_SPIN => first.map(|share| Self::Spin(share, drive_spin::shaping(choice(0)))),
            NodeKind::DRIVE_ON => {
                first.map(|share| Self::On(share, drive_on::by(choice(0)), drive_on::after(choice(1))))
            }
            NodeKind::DRIVE_SWELL => Some(Self::Swell(Arc::clone(settings), drive_swell::shaping(choice(0)))),
            NodeKind::DRIVE_HOME => Some(Self::Home),
            NodeKind::DRIVE_BRAKE => Some(Self::Brake),
            _ => None,
        }
    }
}
