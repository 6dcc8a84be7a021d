//! Whether the cable is still there.

/// How long a cable that has said 0xFE may be silent: MIDI 1.0 Detailed Specification, "Active Sensing".
pub const SILENCE_SECONDS: f64 = 0.3;

/// Watches for silence, from the first 0xFE on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sensing {
    last: f64,
    promised: bool,
}

impl Sensing {
    /// Whether the silence up to now is too long. It is said once; then nothing is promised any more.
    pub fn lost(&mut self, now: f64) -> bool {
        let lost = self.promised && now - self.last > SILENCE_SECONDS;
        self.promised &= !lost;
        lost
    }
    /// Something came.
    pub fn heard(&mut self, now: f64) {
        self.last = now;
    }
    /// The promise came.
    pub fn promise(&mut self) {
        self.promised = true;
    }
    /// Nothing is promised.
    pub fn forget(&mut self) {
        self.promised = false;
    }
}
