//! What happened to a motor that is turned.

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Samples in which the limit kept the motor from what was played.
    pub limited: u64,
    /// Levels that were no numbers, and counted as 0.
    pub masked: u64,
    /// Orders that found no room.
    pub dropped: u64,
    /// Samples (of a level beyond 0.02) and orders that were for the way that diodes do not let, and are nothing.
    pub backward: u64,
    /// Of a motor that is there for clicks alone: samples of levels and orders that were none.
    pub unplayed: u64,
    /// Clicks of which some did not arrive, and which so turn the mass less far.
    pub cut: u64,
    /// Clicks that began weaker than they were ordered, as the motor had become warm, and so turn the mass less far.
    pub weakened: u64,
    /// Clicks that were not begun, as the motor was too warm for what would turn it.
    pub refused: u64,
}
