//! How it stands with the torque of a knob that is there.

#![deny(clippy::disallowed_methods)]

use crate::engine::knob::Knob;
use crate::knob::safety::chain::Trip;
use std::fmt;

/// Whether torque flows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Torque {
    /// There is no knob.
    #[default]
    None,
    /// It is simulated, and has it.
    Simulated,
    /// Nobody has asked for it.
    Off,
    /// It rises as soon as the angle is known.
    Asked,
    /// It flows.
    On,
    /// It has fallen, and stays so until somebody asks again.
    Fallen(Trip),
}

const ALL: [Torque; 9] = [
    Torque::None,
    Torque::Simulated,
    Torque::Off,
    Torque::Asked,
    Torque::On,
    Torque::Fallen(Trip::Reading),
    Torque::Fallen(Trip::Lost),
    Torque::Fallen(Trip::OverSpeed),
    Torque::Fallen(Trip::Panic),
];

impl Torque {
    /// That of a knob.
    pub(super) fn of(knob: Option<&Knob>) -> Self {
        let Some(knob) = knob else { return Self::None };
        let chain = knob.servo().chain();
        match chain.trip() {
            _ if knob.is_asked() => Self::Asked,
            None if chain.armed() && !knob.is_attached() => Self::Simulated,
            Some(trip) => Self::Fallen(trip),
            None if chain.armed() => Self::On,
            None => Self::Off,
        }
    }

    /// As a figure of a board.
    pub(super) fn figure(self) -> u64 {
        ALL.iter().position(|torque| *torque == self).unwrap_or(0) as u64
    }

    /// That of a figure of a board.
    pub fn of_figure(figure: u64) -> Self {
        usize::try_from(figure).ok().and_then(|place| ALL.get(place)).copied().unwrap_or_default()
    }

    /// Whether somebody wants it, and nothing has taken it away.
    pub fn is_wanted(self) -> bool {
        matches!(self, Self::Asked | Self::On | Self::Simulated)
    }
}

impl fmt::Display for Torque {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no knob is read",
            Self::Simulated => "the simulated knob has its torque",
            Self::Off => "the knob's torque is off",
            Self::Asked => "the knob's torque rises as soon as its angle is known",
            Self::On => "the knob's torque is on",
            Self::Fallen(Trip::Reading) => "the knob's torque has fallen: its angle was no number",
            Self::Fallen(Trip::Lost) => {
                "the knob's torque has fallen: its angle was lost, or came later than `delay` of the rig says"
            }
            Self::Fallen(Trip::OverSpeed) => {
                "the knob's torque has fallen: it was faster than `over_speed` of the rig, and stays away until it is asked for"
            }
            Self::Fallen(Trip::Panic) => "the knob's torque has fallen: somebody asked for it",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{ALL, Torque};

    #[test]
    fn figures_lead_back_to_what_they_are_of() {
        for torque in ALL {
            assert_eq!(Torque::of_figure(torque.figure()), torque);
        }
        assert_eq!(Torque::of_figure(u64::MAX), Torque::None);
    }
}
