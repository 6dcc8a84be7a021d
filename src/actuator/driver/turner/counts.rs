//! What happened to a motor that is turned.

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counts {
    /// Samples in which the limit kept the motor from what was played: by more than 1 % of its full speed, or at all where it was planned otherwise.
    pub limited: u64,
    /// Speeds that were played, summed up over samples as shares of the full one, and what plans within the limit miss of them; 0 where no speeds are
    /// planned.
    pub played: f64,
    /// See `played`.
    pub missed: f64,
    /// Levels that were no numbers, and counted as 0.
    pub masked: u64,
    /// Orders that found no room.
    pub dropped: u64,
    /// Samples (of a level beyond 0.02) and orders that were for the way that diodes do not let, and are nothing.
    pub backward: u64,
    /// Of a motor that is there for clicks alone: samples of levels and orders that were none.
    pub unplayed: u64,
    /// Orders home of a motor that cannot be brought there, and which are nothing.
    pub homeless: u64,
    /// Clicks of which some did not arrive, and which so turn the mass less far.
    pub cut: u64,
    /// Clicks that began weaker than they were ordered, as the motor had become warm, and so turn the mass less far.
    pub weakened: u64,
    /// Clicks that were not begun, as the motor was too warm for what would turn it.
    pub refused: u64,
}
