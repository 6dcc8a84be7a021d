//! Where in the block to come something shuts and opens.

use super::workspace::BLOCK;

/// Edges at engine samples of the next block: of two at the same sample the last one told counts.
#[derive(Debug, Clone, Default)]
pub(super) struct Edges {
    /// The next sample in the lowest bit.
    shuts: u64,
    opens: u64,
    /// The next engine sample.
    clock: u64,
}

impl Edges {
    /// It shuts at this engine sample.
    pub fn shut(&mut self, clock: u64) {
        let bit = self.bit(clock);
        (self.shuts, self.opens) = (self.shuts | bit, self.opens & !bit);
    }

    /// It opens at this engine sample.
    pub fn open(&mut self, clock: u64) {
        let bit = self.bit(clock);
        (self.shuts, self.opens) = (self.shuts & !bit, self.opens | bit);
    }

    fn bit(&self, clock: u64) -> u64 {
        1 << clock.saturating_sub(self.clock).min(BLOCK as u64 - 1)
    }

    /// Where it shuts and where it opens in a block of so many samples, the first in the lowest bit. Those told from here on are of the next.
    pub fn take(&mut self, samples: usize) -> [u64; 2] {
        self.clock += samples as u64;
        [std::mem::take(&mut self.shuts), std::mem::take(&mut self.opens)]
    }
}
