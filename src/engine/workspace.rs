//! Memory that all voices share while they are computed.

use crate::dsp::lanes::{LANES, Real};

/// The most frames that are computed at a stretch.
pub const BLOCK: usize = 64;

/// A row for each frame of a block.
pub type Rows<R> = Vec<[R; LANES]>;

/// Buffers of ops, engine-wide signals, and the mix.
#[derive(Debug)]
pub struct Workspace<R> {
    /// What ops write and read; used by one group after another.
    pub buffers: Vec<Rows<R>>,
    /// Engine-wide signals, the same value in all lanes.
    pub shared: Vec<Rows<R>>,
    /// The sum of all voices: a group of eight channels each.
    pub mix: Vec<Rows<R>>,
    /// For each group of channels: whether a voice has written to it since it was last cleared.
    pub fed: Vec<bool>,
}

impl<R: Real> Workspace<R> {
    /// Room for so many buffers, signals and channels.
    pub fn new(buffers: usize, shared: usize, channels: usize) -> Self {
        let rows = |n: usize| (0..n).map(|_| vec![[R::ZERO; LANES]; BLOCK]).collect();
        let groups = channels.div_ceil(LANES);
        Self { buffers: rows(buffers), shared: rows(shared), mix: rows(groups), fed: vec![false; groups] }
    }

    /// Silence in all groups of channels that were fed.
    pub fn clear_mix(&mut self) {
        for (rows, fed) in self.mix.iter_mut().zip(&mut self.fed) {
            if std::mem::take(fed) {
                rows.fill([R::ZERO; LANES]);
            }
        }
    }
}
