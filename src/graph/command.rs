//! What a voice orders of the motors at its place.

use super::Settings;
use crate::node::NodeKind;

/// An order, as a patch has it: what it means in volts depends on the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// A click of so many turns, as strong as the event's level says.
    Click(f64),
    /// To a speed whose vibration is this share of the rated one, times the event's level, while the event lasts.
    Spin(f64),
    /// This share of the most that there may be, times the event's level, while the event lasts.
    On(f64),
    /// To where gravity catches the mass.
    Home,
    /// To rest.
    Brake,
}

impl Command {
    /// Whether a motor that is there for clicks alone heeds it.
    pub fn is_heeded_for_clicks(self) -> bool {
        matches!(self, Self::Click(_) | Self::Brake)
    }

    /// That of a node, if it is one that orders something.
    pub fn of(kind: NodeKind, settings: &Settings) -> Option<Self> {
        let first = settings.constants.first().copied();
        match kind {
            NodeKind::DRIVE_CLICK => first.map(Self::Click),
            NodeKind::DRIVE_SPIN => first.map(Self::Spin),
            NodeKind::DRIVE_ON => first.map(Self::On),
            NodeKind::DRIVE_HOME => Some(Self::Home),
            NodeKind::DRIVE_BRAKE => Some(Self::Brake),
            _ => None,
        }
    }
}
