//! The weights of one point, tactor by tactor.

/// What one tactor has of a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share {
    /// Which tactor, counted from 0 in the order in which the array was given them.
    pub tactor: u32,
    /// How much, above 0 and up to 1.
    pub weight: f64,
}

/// A weight that is no more counts as none: the square root of it is 140 dB down.
pub(super) const NOTHING: f64 = 1e-14;

/// Room for the weights of one point, made once by [`Array::row`](super::array::Array::row) and filled as often as wanted.
///
/// It keeps where the last point was, as a point that moves is mostly found there again. What comes out does not depend on it.
#[derive(Debug, Clone)]
pub struct Row {
    shares: Box<[Share]>,
    len: usize,
    /// As much room again, for sites whose tactors share.
    spare: Box<[Share]>,
    /// By site, for widths and distances.
    pub(super) dense: Box<[f64]>,
    /// The segment, cell or side of the last point.
    pub(super) hint: u32,
}

impl Row {
    pub(super) fn new(tactors: usize, sites: usize) -> Self {
        Self {
            shares: vec![Share::default(); tactors].into(),
            len: 0,
            spare: vec![Share::default(); if sites < tactors { sites } else { 0 }].into(),
            dense: vec![0.0; sites].into(),
            hint: 0,
        }
    }

    /// The tactors that have something of the point, none of them twice; empty until it was filled.
    #[inline]
    pub fn shares(&self) -> &[Share] {
        self.shares.get(..self.len).unwrap_or_default()
    }

    /// What the tactor has.
    pub(super) fn weight_of(&self, tactor: u32) -> f64 {
        self.shares().iter().find(|share| share.tactor == tactor).map_or(0.0, |share| share.weight)
    }

    /// Whether the same tactors have something, in the same order.
    pub(super) fn is_of_those_in(&self, other: &Self) -> bool {
        let same = |(a, b): (&Share, &Share)| a.tactor == b.tactor;
        self.len == other.len && self.shares().iter().zip(other.shares()).all(same)
    }

    /// Whether a weight to speak of comes from nearly nothing or goes there, in the row of a later instant with the same tactors: so
    /// near to 0 it may go otherwise than straight.
    pub(super) fn falls(&self, other: &Self) -> bool {
        self.shares().iter().zip(other.shares()).any(|(a, b)| {
            let (least, most) = (a.weight.min(b.weight), a.weight.max(b.weight));
            most > 1e-5 && least < 0.4 * most
        })
    }

    /// Whether each weight is half way between those of two other rows with the same tactors.
    pub(super) fn is_between(&self, one: &Self, other: &Self) -> bool {
        let half = |((own, a), b): ((&Share, &Share), &Share)| {
            (2.0 * own.weight - a.weight - b.weight).abs() <= 0.005 * a.weight.max(b.weight)
        };
        let rows = self.shares().iter().zip(one.shares()).zip(other.shares());
        self.is_of_those_in(one) && self.is_of_those_in(other) && rows.into_iter().all(half)
    }

    /// Empties it.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a tactor, or a site, if its weight is one. There is room for all of its array; of another one, what does not fit is left out.
    #[inline(always)]
    pub(super) fn push(&mut self, tactor: u32, weight: f64) {
        if weight > NOTHING
            && let Some(place) = self.shares.get_mut(self.len)
        {
            *place = Share { tactor, weight };
            self.len += 1;
        }
    }

    /// Makes the weights 1 in sum.
    #[inline(always)]
    pub(super) fn level(&mut self) {
        let all = self.shares.get_mut(..self.len).unwrap_or_default();
        let share = 1.0 / all.iter().map(|share| share.weight).sum::<f64>();
        all.iter_mut().for_each(|place| place.weight *= share);
    }

    /// Adds so much of each weight to those by site.
    pub(super) fn mix(&mut self, share: f64) {
        for place in self.shares.iter().take(self.len) {
            if let Some(weight) = self.dense.get_mut(place.tactor as usize) {
                *weight += share * place.weight;
            }
        }
    }

    /// Empties it, and goes through what was in it.
    pub(super) fn each(&mut self, mut take: impl FnMut(Share, &mut Self)) {
        let len = self.len.min(self.spare.len());
        self.spare[..len].copy_from_slice(&self.shares[..len]);
        self.len = 0;
        for k in 0..len {
            take(self.spare[k], self);
        }
    }
}
