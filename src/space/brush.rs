//! Tactile Brush: a stroke over an array as bursts that overlap.
//!
//! Israr & Poupyrev, "Tactile Brush: drawing on skin with a tactile grid display", CHI 2011. Where the path crosses an edge between
//! tactors, and at its ends, a virtual point is felt between the tactors of that edge: a phantom, by their shares. The point moves from
//! one to the next where the second burst begins before the first is over: apparent motion, by [`onset`].
//!
//! With τ the times at which the virtual points are reached, a burst rises for d⁻ to its point's τ, and falls for d⁺. Its onset is S, that
//! of the next S + SOA. Both hold where
//!
//! ```text
//! SOA_i = (0.32 (d_i⁻ + τ_{i+1} − S_i) + 47.3 ms) / 1.32,   d_i⁺ = τ_{i+1} − S_{i+1},   d_{i+1}⁻ = d_i⁺,   d_0⁻ = 0
//! ```
//!
//! **Too fast.** With the time g from one point to the next, d⁺ = (g + 0.68 d⁻ − 47.3 ms) / 1.32: below 47.3 ms it falls from burst to
//! burst until it is nothing. A virtual point that would leave a flank shorter than [`SHORTEST_FLANK`] is left out, and the motion goes
//! from the one before it to the one after; the ends stay. So a stroke that is too fast for its points has fewer of them, and a stroke
//! from end to end remains down to 47.3 ms. Even steps hold from 60.1 ms on (and a first one of 73.7 ms).

use super::apparent::{FIXED, SLOPE, onset};
use super::array::Array;
use super::fault::{Fault, MOST_BURSTS, bursts};
use super::path::Path;
use super::point::Point;

/// Durations of a burst, in seconds, for which the law of onsets is held to be measured.
///
/// From the accounts of Israr & Poupyrev's experiments (CHI 2011; "Control space of apparent haptic motion", World Haptics 2011), whose
/// full texts could not be read for this: take the ends as about right.
pub const MEASURED: (f64, f64) = (0.04, 0.2);
/// The shortest rise or fall of a burst, in seconds: half of the shortest burst measured.
pub const SHORTEST_FLANK: f64 = 0.02;
/// Virtual points nearer along the path than this share of it are one.
const ONE_POINT: f64 = 1e-9;
/// A stroke over a cloud has no more steps.
const MOST_STEPS: f64 = 2048.0;

/// One burst of a stroke, at one virtual point.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// Its point.
    pub place: Point,
    /// When it begins, in seconds.
    pub start: f64,
    /// How long it rises, in seconds; 0 for the first.
    pub rise: f64,
    /// How long it falls, in seconds; 0 for the last.
    pub fall: f64,
}

impl Burst {
    /// What it lasts, in seconds.
    pub fn seconds(&self) -> f64 {
        self.rise + self.fall
    }

    /// When the stroke is at its point, in seconds from its beginning: where the rise ends.
    pub fn arrival(&self) -> f64 {
        self.start + self.rise
    }
}

/// A stroke, burst by burst.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// In the order in which they begin; two at least.
    pub bursts: Vec<Burst>,
    /// Virtual points that were left out, as the stroke is too fast for them.
    pub left_out: Vec<Point>,
    /// The farthest that a point of the path lies outside the array, in metres. What is outside counts as on the rim.
    pub outside: f64,
}

impl Stroke {
    /// The stroke of a path over an array.
    ///
    /// Over a line the virtual points are at its tactors, over a surface where the path crosses the edges of its cells, or passes a tactor of
    /// the hull outside of it, over a cloud at even steps of at most its spacing.
    ///
    /// # Errors
    /// [`Fault::TooFast`] where not even the two ends remain, which is at 47.3 ms; [`Fault::TooManyBursts`] where it passes between tactors too often.
    pub fn new(array: &Array, path: &Path) -> Result<Self, Fault> {
        let along = virtual_points(array, path)?;
        let times: Vec<f64> = along.iter().map(|way| path.when(*way)).collect();
        let (kept, left_out) = thinned(&times)?;
        let mut bursts: Vec<Burst> = Vec::with_capacity(kept.len());
        let (mut start, mut rise) = (0.0, 0.0);
        let begin = times[0];
        for (k, &number) in kept.iter().enumerate() {
            let next = kept.get(k + 1).map(|&next| times[next] - begin);
            let fall = next.map_or(0.0, |next| next - start - soa(rise, next - start));
            let place = path.point(along[number]);
            bursts.push(Burst { place, start: begin + start, rise, fall });
            start += next.map_or(0.0, |next| soa(rise, next - start));
            rise = fall;
        }
        let place = |number: usize| path.point(along[number]);
        let outside = path.points().iter().map(|point| array.outside(*point)).fold(0.0, f64::max);
        Ok(Self { bursts, left_out: left_out.into_iter().map(place).collect(), outside })
    }

    /// When it is over, in seconds.
    pub fn seconds(&self) -> f64 {
        self.bursts.last().map_or(0.0, |burst| burst.start + burst.seconds())
    }

    /// The shortest and the longest burst, in seconds.
    pub fn range(&self) -> (f64, f64) {
        let lengths = self.bursts.iter().map(Burst::seconds);
        lengths.fold((f64::INFINITY, 0.0), |(least, most), s| (least.min(s), most.max(s)))
    }

    /// How many bursts are outside [`MEASURED`]: what they feel like has not been tried.
    pub fn unmeasured(&self) -> usize {
        let (least, most) = MEASURED;
        self.bursts.iter().filter(|burst| !(least..=most).contains(&burst.seconds())).count()
    }
}

/// From an onset to the next, for a burst that rises for `rise`; the next arrival is so long after its own onset.
fn soa(rise: f64, to_the_next_arrival: f64) -> f64 {
    (SLOPE * (rise + to_the_next_arrival) + FIXED) / (1.0 + SLOPE)
}

/// Ways along the path, rising, of its ends and of the edges it crosses.
fn virtual_points(array: &Array, path: &Path) -> Result<Vec<f64>, Fault> {
    let length = path.length();
    let mut all = Vec::new();
    if array.shape() == super::array::Shape::Cloud {
        let steps = (length / array.spacing()).ceil().clamp(1.0, MOST_STEPS);
        all.extend((1..steps as usize).map(|k| length * k as f64 / steps));
    }
    let mut way = 0.0;
    for pair in path.points().windows(2) {
        let piece = super::point::distance(pair[0], pair[1]);
        let mut shares = Vec::new();
        array.crossings(pair[0], pair[1], &mut shares);
        all.extend(shares.into_iter().map(|share| way + share * piece));
        way += piece;
        // Where cells meet, an edge is told once for each of them.
        if all.len() > 8 * MOST_BURSTS {
            return Err(Fault::TooManyBursts(all.len(), MOST_BURSTS));
        }
    }
    let near = ONE_POINT * length;
    all.retain(|way| *way > near && *way < length - near);
    all.sort_by(f64::total_cmp);
    all.dedup_by(|next, last| *next - *last < near);
    all.insert(0, 0.0);
    all.push(length);
    bursts(all.len())?;
    Ok(all)
}

/// Which of the virtual points the law of onsets leaves time for, and which not: the first and the last, and of the others each that
/// leaves flanks that are long enough, from the first on; of these the last ones go where the end of the stroke comes too soon after them.
fn thinned(times: &[f64]) -> Result<(Vec<usize>, Vec<usize>), Fault> {
    let last = times.len() - 1;
    let step = |kept: &[(usize, f64)], next: usize| {
        let (from, rise) = kept[kept.len() - 1];
        (times[next] - times[from] + (1.0 - SLOPE) * rise - FIXED) / (1.0 + SLOPE)
    };
    let mut kept = vec![(0, 0.0)];
    for number in 1..last {
        let fall = step(&kept, number);
        if fall >= SHORTEST_FLANK {
            kept.push((number, fall));
        }
    }
    while kept.len() > 1 && step(&kept, last) < SHORTEST_FLANK {
        kept.pop();
    }
    let fall = step(&kept, last);
    if fall <= 0.0 {
        return Err(Fault::TooFast(times[last] - times[0], onset(0.0)));
    }
    kept.push((last, fall));
    let kept: Vec<usize> = kept.into_iter().map(|(number, _)| number).collect();
    let left_out = (0..times.len()).filter(|number| kept.binary_search(number).is_err()).collect();
    Ok((kept, left_out))
}

#[cfg(test)]
mod tests;
