//! Kinds of lines of a journal.

use serde::{Deserialize, Serialize};

/// What a line tells of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A voice is to sound.
    Voice,
    /// The voices of an id are released.
    Release,
    /// All voices are.
    ReleaseAll,
    /// All voices fall silent at once whose ids agree with this one but for the lowest bits, as many as `value` says.
    Silence,
    /// Voices and markers that are still to begin do not, whose ids agree with this one but for the lowest bits, as many as `value` says: their
    /// pattern was stopped.
    Cancel,
    /// The voices of an id are moved by the hand that holds them.
    Touch,
    /// A control is sent to a value.
    Control,
    /// A marker.
    Marker,
    /// The voice of an id fades, since another began for which there was no room; `message` is the id of that. All of them are counted as `stolen`.
    Stolen,
    /// Periodic tasks above the rank `value` rest, and the others run.
    Shed,
    /// A hand pushes the simulated knob with `value` newton metres.
    Push,
    /// The knob's torque may rise (`value` 1) or goes (0).
    Arm,
    /// The knob took a world that a slow thread has sent.
    Model,
    /// The card keeps to the time that a knob's governor was told of (`value` 1), or not (0).
    Deadline,
    /// The gate was told something.
    Gate,
    /// From here on, the device takes whole numbers of `value` bits, to which samples are rounded; 0: floating point, as at the beginning.
    Steps,
    /// The plan that was written down last and has not played yet takes over.
    Swap,
    /// Something came in.
    In,
    /// Something that was asked for cannot be done.
    Refused,
    /// Something became of the device.
    Device,
    /// Where blocks came too late, `value` times since the last such line: for the device, or for the `input`.
    Xrun,
    /// How frames and time belong together, and what was counted so far.
    Clock,
    /// Lines are missing here, as many as `value` says.
    Lost,
    /// The session ended.
    End,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 24] = [
        Self::Voice,
        Self::Release,
        Self::ReleaseAll,
        Self::Silence,
        Self::Cancel,
        Self::Touch,
        Self::Control,
        Self::Marker,
        Self::Stolen,
        Self::Shed,
        Self::Push,
        Self::Arm,
        Self::Model,
        Self::Deadline,
        Self::Gate,
        Self::Steps,
        Self::Swap,
        Self::In,
        Self::Refused,
        Self::Device,
        Self::Xrun,
        Self::Clock,
        Self::Lost,
        Self::End,
    ];

    /// As it is written.
    pub fn word(self) -> &'static str {
        match self {
            Self::Voice => "voice",
            Self::Release => "release",
            Self::ReleaseAll => "release-all",
            Self::Silence => "silence",
            Self::Cancel => "cancel",
            Self::Touch => "touch",
            Self::Control => "control",
            Self::Marker => "marker",
            Self::Stolen => "stolen",
            Self::Shed => "shed",
            Self::Push => "push",
            Self::Arm => "arm",
            Self::Model => "model",
            Self::Deadline => "deadline",
            Self::Gate => "gate",
            Self::Steps => "steps",
            Self::Swap => "swap",
            Self::In => "in",
            Self::Refused => "refused",
            Self::Device => "device",
            Self::Xrun => "xrun",
            Self::Clock => "clock",
            Self::Lost => "lost",
            Self::End => "end",
        }
    }

    /// Whether it is one of a few on which others depend, so that room is kept for it however many of those there are.
    pub fn is_rare(self) -> bool {
        matches!(
            self,
            Self::Gate | Self::Steps | Self::Swap | Self::Device | Self::Clock | Self::Lost | Self::End
        )
    }

    /// Whether a replay needs it.
    pub fn is_played(self) -> bool {
        matches!(
            self,
            Self::Voice
                | Self::Release
                | Self::ReleaseAll
                | Self::Silence
                | Self::Cancel
                | Self::Touch
                | Self::Control
                | Self::Marker
                | Self::Shed
                | Self::Push
                | Self::Arm
                | Self::Model
                | Self::Deadline
                | Self::Gate
                | Self::Steps
                | Self::Swap
        )
    }
}
