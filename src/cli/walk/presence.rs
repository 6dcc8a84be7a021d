//! Whether the device that is walked over is there.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use pacinian::io::device::keeper::Fate;

/// Whether it is there, and how often it went.
#[derive(Debug, Default)]
pub struct Presence {
    away: AtomicBool,
    losses: AtomicU64,
}

impl Presence {
    /// What becomes of it.
    pub fn becomes(&self, fate: &Fate) {
        match fate {
            Fate::Lost(_) => {
                self.losses.fetch_add(1, Ordering::AcqRel);
                self.away.store(true, Ordering::Release);
            }
            Fate::Back => self.away.store(false, Ordering::Release),
            Fate::Moved | Fate::Lowered | Fate::Said(_) => {}
        }
    }

    /// Whether it is away.
    pub fn is_away(&self) -> bool {
        self.away.load(Ordering::Acquire)
    }

    /// How often it went.
    pub fn losses(&self) -> u64 {
        self.losses.load(Ordering::Acquire)
    }
}
