//! Mean gains over pieces of time.

use super::super::row::Share;

/// Boxes that are kept: those of one sample, and some more.
const KEPT: usize = 32;
/// Tactors that a kept box may have gains of.
const MOST: usize = 32;

/// Gains by tactor, most of them 0.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    gains: Box<[f64]>,
    marked: Box<[bool]>,
    touched: Vec<u32>,
}

impl Sums {
    /// Of so many tactors.
    pub(super) fn new(tactors: usize) -> Self {
        Self {
            gains: vec![0.0; tactors].into(),
            marked: vec![false; tactors].into(),
            touched: Vec::with_capacity(tactors),
        }
    }

    /// Adds to one of them.
    #[inline]
    pub(super) fn add(&mut self, tactor: u32, gain: f64) {
        let at = tactor as usize;
        if let (Some(sum), Some(mark)) = (self.gains.get_mut(at), self.marked.get_mut(at)) {
            if !std::mem::replace(mark, true) {
                self.touched.push(tactor);
            }
            *sum += gain;
        }
    }

    /// The sum of their squares.
    #[inline]
    pub(super) fn power(&self) -> f64 {
        self.touched.iter().map(|tactor| self.gains[*tactor as usize]).map(|gain| gain * gain).sum()
    }

    /// Empties it, and tells what was in it, in the order in which it came.
    #[inline]
    pub(super) fn drain(&mut self, mut each: impl FnMut(u32, f64)) {
        for tactor in self.touched.drain(..) {
            let at = tactor as usize;
            self.marked[at] = false;
            each(tactor, std::mem::take(&mut self.gains[at]));
        }
    }
}

/// Which one it is: how many of its kind there are to a sample, its number among them, and the bits of the width of the point.
type Which = (usize, u64, u64);

/// Boxes by their time, the last that were worked out.
#[derive(Debug, Clone)]
pub(super) struct Boxes {
    kept: Box<[Kept; KEPT]>,
}

/// The mean gains of a box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    /// None where nothing is kept, or not all of it could be.
    which: Option<Which>,
    len: usize,
    shares: [Share; MOST],
}

impl Default for Boxes {
    fn default() -> Self {
        let nothing = Kept { which: None, len: 0, shares: [Share::default(); MOST] };
        Self { kept: Box::new([nothing; KEPT]) }
    }
}

impl Boxes {
    /// All of them are of another point.
    pub(super) fn forget(&mut self) {
        self.kept.iter_mut().for_each(|kept| kept.which = None);
    }

    /// The gains of a box, if they are there.
    #[inline]
    pub(super) fn find(&self, which: Which) -> Option<&[Share]> {
        let kept = self.kept.get(which.1 as usize % KEPT)?;
        if kept.which == Some(which) { kept.shares.get(..kept.len) } else { None }
    }

    /// Room for a box.
    #[inline]
    pub(super) fn keep(&mut self, which: Which) -> Option<&mut Kept> {
        let kept = self.kept.get_mut(which.1 as usize % KEPT)?;
        (kept.which, kept.len) = (Some(which), 0);
        Some(kept)
    }
}

impl Kept {
    /// Takes the gain of one more tactor; of one too many, it keeps none.
    #[inline]
    pub(super) fn add(&mut self, tactor: u32, gain: f64) {
        match self.shares.get_mut(self.len) {
            Some(place) => {
                *place = Share { tactor, weight: gain };
                self.len += 1;
            }
            None => self.which = None,
        }
    }
}
