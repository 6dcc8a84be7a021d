//! What an actuator does at the end of a frame.

/// What an actuator does at the end of the last frame that was computed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Now {
    /// What it was given in that frame on average, V; A where its amplifier imposes a current. Before diodes, what stands before them.
    pub drive: f64,
    /// How fast a rumble motor turns, rad/s; `None` for what is none.
    pub speed: Option<f64>,
    /// How far it has turned, rad from where its mass hangs straight down; likewise.
    pub turned: Option<f64>,
    /// What its coil and its friction do to the casing about the shaft, N m; `None` for what is none, or is known from outside
    /// alone.
    pub reaction: Option<f64>,
    /// Drawn so far, J; `None` of a motor that is known from outside alone.
    pub energy: Option<f64>,
}
