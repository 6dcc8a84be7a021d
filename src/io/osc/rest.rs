//! A thread that runs before others lets them run as well.

use std::time::Duration;

use crate::live::stamp::Stamp;

/// So many datagrams in less than so many seconds are a flood, in which it rests that long each time.
const MANY: u32 = 1 << 12;
const FLOOD: f64 = 0.05;
const REST: Duration = Duration::from_micros(500);

/// In a flood, those without priority would never run on a machine of one core.
#[derive(Debug, Default)]
pub(super) struct Rest {
    datagrams: u32,
    rested: Stamp,
}

impl Rest {
    /// After one more, now.
    pub fn after_one(&mut self, now: Stamp) {
        self.datagrams += 1;
        if self.datagrams < MANY {
            return;
        }
        if now.since(self.rested) < FLOOD {
            std::thread::sleep(REST);
        }
        *self = Self { datagrams: 0, rested: now };
    }
}
