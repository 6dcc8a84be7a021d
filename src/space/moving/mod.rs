//! What tactors have of a point that moves, one engine sample after another.

mod boxes;
mod kernel;
mod stretch;
#[cfg(test)]
mod tests;
mod tour;
mod trail;
mod way;

use super::array::Shape;
use super::array::tile::Tile;
use super::law::Law;
use super::point::{Point, distance, tamed};
use super::row::Row;
use super::spot::Spread;
use boxes::{Boxes, Sums};
use kernel::{BRISK, COARSE, FINE, Kernel, QUICK, SLOW, SLOW_OF_WIDTH};
pub use stretch::Age;
use stretch::Stretch;
pub use trail::{LATE, Steps, Trail};
use way::{Span, Way, stays_in, turns};

/// How far a point is looked at before and after now, in engine samples.
pub const SEEN: i64 = 4;

/// The share of what a low pass takes from the power of the energy law that is given back: that is no band-limited gain, and at 50 m/s over 50 mm each
/// hundredth costs a tenth of a decibel of error.
const PULL: f64 = 0.04;

/// How often a box is halved where something is crossed within it.
const HALVED: usize = 5;
/// Rows for the two ends of a box, and the middle of each half.
const ROWS: usize = HALVED + 2;

/// Tactors that share points which move.
///
/// While a point stays in a piece of the array, between two tactors of a line or within a cell, its gains are those of the law where it
/// is. Where it crosses from one piece to the next, the gains of a law have corners, those of [`Law::Energy`] even √t: at some
/// metres a second they would fold back from above half the engine's rate at −40 to −70 dB. There, gains are the mean over a few samples
/// about now, by a low pass that leaves alone what signals of up to an eighth of the rate can meet of them, and keeps off what would fold onto these.
/// Within its boxes a gain is integrated in closed form, as if its weight went straight; boxes in which something is crossed are halved until it does.
#[derive(Debug, Clone)]
pub struct Mover {
    spread: Spread,
    now: Row,
    rows: [Row; ROWS],
    /// The gains of a box, and of a sample; boxes of samples before.
    part: Sums,
    sum: Sums,
    boxes: Boxes,
    stretch: Box<Stretch>,
}

impl Mover {
    /// For tactors on their channels.
    pub fn new(spread: &Spread) -> Self {
        let array = spread.array();
        Self {
            spread: spread.clone(),
            now: array.row(),
            rows: std::array::from_fn(|_| array.row()),
            part: Sums::new(array.tactors()),
            sum: Sums::new(array.tactors()),
            boxes: Boxes::default(),
            stretch: Box::default(),
        }
    }

    /// Calls `to` with each channel that sounds and its gain, of a point that is `at` so many whole engine samples and a share of one from now, of
    /// a width (m).
    ///
    /// `at` is asked within ±[`SEEN`] samples. `piece` is where the point was found last; on the edge between two pieces it tells which of them the
    /// point is in. `sample` says which one this is, where `at` tells of every instant the same from all of them: then what was worked out for one
    /// serves the next, until [`Mover::forget`]. For the audio thread.
    #[inline]
    pub fn gains(
        &mut self,
        at: impl Fn(i64, f64) -> Point,
        sample: Option<u64>,
        (width, law): (f64, Law),
        piece: &mut u32,
        mut to: impl FnMut(u32, f64),
    ) {
        let array = self.spread.array();
        let spacing = array.spacing();
        let (here, ends) = (at(0, 0.0), [at(-SEEN, 0.0), at(SEEN, 0.0)]);
        // What rests has the gains of a fixed point, to the bit.
        if ends != [here; 2]
            && let Some(tile) = self.tile(width, law, *piece)
            && stays_in(tile, ends, here, spacing)
        {
            let gains = tile.gains(here, law);
            for (tactor, share) in tile.corners().iter().zip(gains) {
                if let Some((channel, gain)) = self.spread.channels().get(*tactor as usize)
                    && share > 0.0
                {
                    to(*channel, gain * share);
                }
            }
            return;
        }
        let at = |whole: i64, share: f64| tamed(at(whole, share));
        let (here, ends) = (tamed(here), [tamed(ends[0]), tamed(ends[1])]);
        let rests = ends == [here; 2];
        let array = self.spread.array();
        self.now.hint = *piece;
        array.weights(here, width, law, &mut self.now);
        *piece = self.now.hint;
        let bent = turns(ends, here, spacing);
        let tile = self.tile(width, law, *piece);
        let (stays, has_tile) =
            (tile.is_some_and(|tile| stays_in(tile, ends, here, spacing)), tile.is_some());
        let plain = rests || stays || array.is_smooth(width) && !bent;
        // Of the two halves, the one in which it does not turn back.
        let way = if plain { 0.0 } else { distance(ends[0], here).max(distance(here, ends[1])) };
        let speed = way / SEEN as f64;
        let slow = speed < SLOW * spacing && (width == 0.0 || speed < SLOW_OF_WIDTH * width);
        // In a cloud a weight may have a corner anywhere, but none so sharp that it counts while the point is slow.
        let cloud = array.shape() == Shape::Cloud && law != Law::Nearest;
        let crosses = !(plain || cloud && slow)
            && (cloud || bent || width > 0.0 || has_tile || self.crosses(ends, law));
        let channels = self.spread.channels();
        if !crosses {
            for share in self.now.shares() {
                if let Some((channel, gain)) = channels.get(share.tactor as usize) {
                    to(*channel, gain * law.gain(share.weight));
                }
            }
            return;
        }
        let kernel = if slow { COARSE } else { FINE };
        self.smooth(kernel, sample, &Way { at, width, law, cloud, slow, bent: bent || sample.is_some() });
        let Self { sum, spread, .. } = self;
        let pulled = if law == Law::Energy { 1.0 + 0.5 * PULL * (1.0 - sum.power()) } else { 1.0 };
        sum.drain(|tactor, share| {
            if let Some((channel, gain)) = spread.channels().get(tactor as usize) {
                to(*channel, gain * (share * pulled));
            }
        });
    }

    /// That samples of another point come next, or of another law.
    pub fn forget(&mut self) {
        self.boxes.forget();
    }

    /// The piece by itself, if that is where gains are those of the law at every instant.
    #[inline(always)]
    fn tile(&self, width: f64, law: Law, piece: u32) -> Option<&Tile> {
        if width > 0.0 || law == Law::Nearest { None } else { self.spread.array().tile(piece) }
    }

    /// Whether others have a share at one of the ends.
    #[cold]
    fn crosses(&mut self, ends: [Point; 2], law: Law) -> bool {
        let array = self.spread.array();
        ends.into_iter().zip(&mut self.rows).any(|(end, row)| {
            row.hint = self.now.hint;
            array.weights(end, 0.0, law, row);
            !self.now.is_of_those_in(row)
        })
    }

    /// Adds up the gains over the boxes of a low pass.
    #[cold]
    fn smooth<A: Fn(i64, f64) -> Point>(&mut self, kernel: Kernel, sample: Option<u64>, way: &Way<A>) {
        let (mut near, mut far, mut looked) = (0, 1, None);
        for (k, weight) in kernel.weights.iter().enumerate() {
            let number = |sample: u64| sample.wrapping_mul(kernel.boxes as u64).wrapping_add(k as u64);
            let which = sample.map(|sample| (kernel.boxes, number(sample), way.width.to_bits()));
            if let Some(found) = which.and_then(|which| self.boxes.find(which)) {
                found.iter().for_each(|share| self.sum.add(share.tactor, weight * share.weight));
                continue;
            }
            let [from, to] = [kernel.edge(k), kernel.edge(k + 1)];
            let span = Span { base: from.0, from: from.1, to: (to.0 - from.0) as f64 + to.1 };
            if !self.tour(way, &span) {
                if looked != Some(k) {
                    self.look(near, from, way);
                }
                self.look(far, to, way);
                looked = Some(k + 1);
                let halved = self.halved(way, &span);
                self.span(way, &span, [near, far], 1.0, [HALVED, halved]);
                std::mem::swap(&mut near, &mut far);
            }
            let Self { part, sum, boxes, .. } = self;
            let mut kept = which.and_then(|which| boxes.keep(which));
            part.drain(|tactor, share| {
                sum.add(tactor, weight * share);
                if let Some(kept) = &mut kept {
                    kept.add(tactor, share);
                }
            });
        }
    }

    /// How often a box is halved whatever is in it: in a rectangle weights are parabolas, in a cloud they may have a corner anywhere, and of a
    /// width they are curved.
    fn halved<A: Fn(i64, f64) -> Point>(&self, way: &Way<A>, span: &Span) -> usize {
        let array = self.spread.array();
        let speed = || {
            let [from, to] = [span.from, span.to].map(|share| (way.at)(span.base, share));
            distance(from, to) / (span.to - span.from)
        };
        let below = |share: f64| speed() < share * array.spacing();
        match array.shape() {
            Shape::One => 0,
            _ if way.width > 0.0 && !way.slow => match () {
                () if below(BRISK) => 0,
                () if below(QUICK) => 1,
                () => 2,
            },
            Shape::Line => 0,
            _ if way.slow => 0,
            Shape::Cloud => 2,
            Shape::Surface if below(QUICK) => 1,
            Shape::Surface => 2,
        }
    }

    /// Finds the piece of a point.
    fn find(&mut self, at: Point, law: Law) {
        let [_, _, row, ..] = &mut self.rows;
        row.hint = self.now.hint;
        self.spread.array().weights(at, 0.0, law, row);
        self.now.hint = row.hint;
    }

    /// Fills a row with the shares of an instant.
    fn look<A: Fn(i64, f64) -> Point>(&mut self, row: usize, (whole, share): (i64, f64), way: &Way<A>) {
        if let Some(row) = self.rows.get_mut(row) {
            row.hint = self.now.hint;
            self.spread.array().weights((way.at)(whole, share), way.width, way.law, row);
            self.now.hint = row.hint;
        }
    }

    /// Adds the mean gains between two instants whose rows are filled, so many times.
    fn span<A: Fn(i64, f64) -> Point>(
        &mut self,
        way: &Way<A>,
        span: &Span,
        [near, far]: [usize; 2],
        weight: f64,
        [halvings, halved]: [usize; 2],
    ) {
        let (middle, row) = (0.5 * (span.from + span.to), ROWS - halvings);
        let at = |share: f64| (way.at)(span.base, share);
        if halvings > 0 && self.rows[near].is_of_those_in(&self.rows[far]) {
            let spacing = self.spread.array().spacing();
            let straight = !way.bent || !turns([at(span.from), at(span.to)], at(middle), spacing);
            if straight && !self.rows[near].falls(&self.rows[far]) && halvings + halved <= HALVED {
                self.add([near, far], way, weight);
                return;
            }
        }
        if halvings == 0 {
            self.add([near, far], way, weight);
            return;
        }
        self.look(row, (span.base, middle), way);
        if halvings + halved <= HALVED
            && !way.cloud
            && self.rows[row].is_between(&self.rows[near], &self.rows[far])
        {
            self.add([near, far], way, weight);
            return;
        }
        let [first, second] = [Span { to: middle, ..*span }, Span { from: middle, ..*span }];
        self.span(way, &first, [near, row], 0.5 * weight, [halvings - 1, halved]);
        self.span(way, &second, [row, far], 0.5 * weight, [halvings - 1, halved]);
    }

    /// Adds mean gains between one row and the other, of weights that go straight; of a cloud, whose weights begin and end as squares, of gains that do.
    fn add<A>(&mut self, [near, far]: [usize; 2], way: &Way<A>, weight: f64) {
        let mean = |from: f64, to: f64| {
            if way.cloud {
                0.5 * (way.law.gain(from) + way.law.gain(to))
            } else {
                way.law.mean(from, to, 0.0)
            }
        };
        let Self { rows, part, .. } = self;
        let mut add = |tactor: u32, gain: f64| part.add(tactor, weight * gain);
        let (near, far) = (&rows[near], &rows[far]);
        if near.is_of_those_in(far) {
            for (a, b) in near.shares().iter().zip(far.shares()) {
                add(a.tactor, mean(a.weight, b.weight));
            }
            return;
        }
        for share in near.shares() {
            add(share.tactor, mean(share.weight, far.weight_of(share.tactor)));
        }
        for share in far.shares().iter().filter(|share| near.weight_of(share.tactor) == 0.0) {
            add(share.tactor, mean(0.0, share.weight));
        }
    }
}
