//! Memory that all voices share while they are computed.

use crate::dsp::lanes::{LANES, Real};
use crate::node::kernel::Input;
use crate::space::moving::Mover;

/// The most frames that are computed at a stretch.
pub const BLOCK: usize = 64;

/// A row for each frame of a block.
pub type Rows<R> = Vec<[R; LANES]>;

/// A signal over one block.
#[derive(Debug, Clone)]
pub struct Buffer<R> {
    /// A row for each frame.
    pub rows: Rows<R>,
    /// Whether the first row holds for the whole block; the others may then be anything.
    pub still: bool,
}

impl<R: Real> Buffer<R> {
    /// Silence.
    pub fn silent() -> Self {
        Self { rows: vec![[R::ZERO; LANES]; BLOCK], still: false }
    }

    /// As the input of a node; `base` is the part known at the onset.
    #[inline(always)]
    pub(crate) fn input<'a>(&'a self, frames: usize, base: &'a [f64; LANES]) -> Input<'a, R> {
        Input { rows: &self.rows[..frames], step: usize::from(!self.still), steady: false, base }
    }

    /// Its rows, all of them written; for what is computed anew in every block.
    #[inline(always)]
    pub fn spelt_out(&mut self, frames: usize) -> &mut [[R; LANES]] {
        let rows = &mut self.rows[..frames];
        if std::mem::take(&mut self.still) {
            let row = rows[0];
            rows.fill(row);
        }
        rows
    }

    /// The row of a frame.
    #[inline(always)]
    pub fn at(&self, frame: usize) -> [R; LANES] {
        self.rows[if self.still { 0 } else { frame }]
    }

    /// The same value in all lanes and frames.
    pub fn hold(&mut self, value: R) {
        self.rows[0] = [value; LANES];
        self.still = true;
    }
}

/// Buffers of ops, engine-wide signals, and the mix.
#[derive(Debug)]
pub struct Workspace<R> {
    /// What ops write and read; used by one group after another.
    pub buffers: Vec<Buffer<R>>,
    /// Engine-wide signals, the same value in all lanes.
    pub shared: Vec<Buffer<R>>,
    /// The sum of all voices: for each group of eight channels, `stride` rows.
    pub mix: Rows<R>,
    /// Rows of a group in the mix: the samples of the block that is being computed.
    pub stride: usize,
    /// For each group of channels: whether a voice has written to it since it was last cleared.
    pub fed: Vec<bool>,
    /// The tactors among which voices move, if any may.
    pub mover: Option<Mover>,
}

impl<R: Real> Workspace<R> {
    /// Room for so many buffers, signals and channels.
    pub fn new(buffers: usize, shared: usize, channels: usize) -> Self {
        let groups = channels.div_ceil(LANES);
        Self {
            buffers: vec![Buffer::silent(); buffers],
            shared: vec![Buffer::silent(); shared],
            mix: vec![[R::ZERO; LANES]; groups * BLOCK],
            stride: BLOCK,
            fed: vec![false; groups],
            mover: None,
        }
    }

    /// Silence in the mix, for a block of `samples`.
    pub fn clear_mix(&mut self, samples: usize) {
        self.stride = samples.clamp(1, BLOCK);
        // What no voice feeds is not looked at, and is cleared by the first that does.
        self.fed.fill(false);
    }

    /// The mix.
    pub fn bus(&mut self) -> Bus<'_, R> {
        Bus { rows: &mut self.mix, stride: self.stride, fed: &mut self.fed }
    }

    /// The rows of a group of channels, from `offset` on; silence if nothing fed them in this block.
    #[inline(always)]
    pub fn channels(&mut self, group: usize, offset: usize, frames: usize) -> &mut [[R; LANES]] {
        let Self { mix, fed, stride, .. } = self;
        let rows = &mut mix[group * *stride..][..*stride];
        if !std::mem::replace(&mut fed[group], true) {
            rows.fill([R::ZERO; LANES]);
        }
        &mut rows[offset..offset + frames]
    }

    /// Adds another mix of the same block.
    pub fn add_mix(&mut self, other: &Self) {
        for group in 0..self.fed.len().min(other.fed.len()) {
            if other.fed[group] {
                let rows = &other.mix[group * other.stride..][..other.stride];
                for (sum, row) in self.channels(group, 0, other.stride).iter_mut().zip(rows) {
                    for l in 0..LANES {
                        sum[l] += row[l];
                    }
                }
            }
        }
    }
}

/// The mix, apart from the rest of the workspace.
#[derive(Debug)]
pub struct Bus<'a, R> {
    /// As [`Workspace::mix`].
    pub rows: &'a mut [[R; LANES]],
    /// As [`Workspace::stride`].
    pub stride: usize,
    /// As [`Workspace::fed`].
    pub fed: &'a mut [bool],
}

impl<R: Real> Bus<'_, R> {
    /// As [`Workspace::channels`].
    #[inline(always)]
    pub fn channels(&mut self, group: usize, offset: usize, frames: usize) -> &mut [[R; LANES]] {
        let rows = &mut self.rows[group * self.stride..][..self.stride];
        if !std::mem::replace(&mut self.fed[group], true) {
            rows.fill([R::ZERO; LANES]);
        }
        &mut rows[offset..offset + frames]
    }

    /// The rows in which a channel has a lane, and which it is; of a channel that is not there none.
    #[inline(always)]
    pub fn run(&mut self, channel: usize, offset: usize, frames: usize) -> (&mut [[R; LANES]], usize) {
        let (group, lane) = (channel / LANES, channel % LANES);
        (if group < self.fed.len() { self.channels(group, offset, frames) } else { &mut [] }, lane)
    }

    /// Adds to one channel in one row; to none that is not there.
    #[inline(always)]
    pub fn add(&mut self, channel: usize, row: usize, value: R) {
        let (rows, lane) = self.run(channel, row, 1);
        rows.iter_mut().for_each(|row| row[lane] += value);
    }

    /// All rows of a group of channels, if nothing fed them in this block and all of them are now written.
    #[inline(always)]
    pub fn fresh(&mut self, group: usize, frames: usize) -> Option<&mut [[R; LANES]]> {
        if self.fed[group] || frames != self.stride {
            return None;
        }
        self.fed[group] = true;
        Some(&mut self.rows[group * frames..][..frames])
    }
}
