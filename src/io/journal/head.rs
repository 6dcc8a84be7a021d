//! What a journal says before its lines: of the session, and of each plan.

use serde::{Deserialize, Serialize};

use crate::live::provenance::Provenance;
use crate::space::path::Route;
use crate::space::point::Point;

/// The format, and its major version.
pub const FORMAT: &str = "pacinian-journal/1";

/// What a journal says of its session, in its first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// [`FORMAT`].
    pub format: String,
    /// The version of pacinian that played.
    pub pacinian: String,
    /// The device, as it is called.
    pub device: String,
    /// What names it for good, with its host, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device_id: Option<String>,
    /// Frames a second.
    pub rate: f64,
    /// Channels of a frame.
    pub channels: usize,
    /// The gain of the output at the beginning.
    pub gain: f64,
    /// Seconds from an event to the middle of what it makes at the output, at 250 Hz.
    pub delay: f64,
    /// When the session began, RFC 3339.
    pub utc: String,
    /// The system's monotonic clock then, in seconds, where it has one that other programs share (`CLOCK_MONOTONIC`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub monotonic: Option<f64>,
    /// The recording of what was heard, if the patch listens to an input: a file beside the journal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
    /// The device or the file that was listened to, as it is called.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heard: Option<String>,
    /// The latency of the loop from an output to an input, seconds, where the rig has it (`pacinian latency`). The times of events do not take it
    /// into account: what of it lies behind the output, and what in front of the input, nobody has measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loop_latency: Option<f64>,
    /// The recording of what was sent, if there is one, by its path as the person wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
}

/// What a journal says of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanHead {
    /// Which, from 0.
    pub plan: u64,
    /// The seed of everything random.
    pub seed: u64,
    /// Engine samples a second.
    pub engine_rate: f64,
    /// What voices that move go along, which the `place` of theirs names by its number, from 1.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub paths: Vec<PathHead>,
    /// What it was made of; `None` for what a program has put together.
    pub made_of: Option<Provenance>,
}

/// What a journal says of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathHead {
    /// Its points, in metres.
    pub points: Vec<Point>,
    /// What it takes, in seconds, where a voice does not go along it in the time of its event.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// When it is at each point, in seconds, where that was said; in the time of an event, all of them in proportion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub times: Vec<f64>,
    /// Whether it goes from rest to rest (`timing = "smooth"`).
    #[serde(default)]
    pub smooth: bool,
}

impl PathHead {
    pub(super) fn of(route: &Route) -> Self {
        let path = &route.path;
        Self {
            points: path.points().to_vec(),
            seconds: (!route.stretched).then(|| path.seconds()),
            times: path.times().to_vec(),
            smooth: path.is_smooth(),
        }
    }
}
