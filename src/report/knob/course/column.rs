//! A stretch of a run: the extremes of each quantity, and the way through the plane of angle and speed.

use super::QUANTITIES;

/// Angle and speed at an instant; `None` where no number has come.
type Place = Option<(f64, f64)>;

/// Which of the quantities are angle and speed.
const ANGLE: usize = 0;
const SPEED: usize = 1;

/// A stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Column {
    /// Least and greatest of each quantity; the least is above the greatest where no number has come.
    pub extremes: [[f64; 2]; QUANTITIES],
    /// Which of each pair came first.
    pub falls: [bool; QUANTITIES],
    /// Where it was with the least and the greatest angle and speed, and its first and last place.
    places: [Place; 6],
}

impl Column {
    /// Of one sample.
    pub fn of(values: &[f64; QUANTITIES]) -> Self {
        let place = (values[ANGLE].is_finite() && values[SPEED].is_finite())
            .then_some((values[ANGLE], values[SPEED]));
        let extremes =
            values.map(|x| if x.is_finite() { [x, x] } else { [f64::INFINITY, f64::NEG_INFINITY] });
        Self { extremes, falls: [false; QUANTITIES], places: [place; 6] }
    }

    /// Takes another sample.
    pub fn take(&mut self, values: &[f64; QUANTITIES]) {
        *self = self.with(&Self::of(values));
    }

    /// Of one column or two.
    pub fn joined(few: &[Self]) -> Self {
        few[1..].iter().fold(few[0], |all, next| all.with(next))
    }

    /// With one that comes later.
    fn with(&self, later: &Self) -> Self {
        let mut all = *self;
        for q in 0..QUANTITIES {
            let ([low, high], [next_low, next_high]) = (self.extremes[q], later.extremes[q]);
            all.extremes[q] = [low.min(next_low), high.max(next_high)];
            all.falls[q] = match (next_low < low, next_high > high) {
                // The later one has the lower end only: the greatest came first.
                (true, false) => true,
                (false, true) => false,
                (true, true) => later.falls[q],
                (false, false) => self.falls[q],
            };
        }
        let chosen =
            |n: usize, better: fn((f64, f64), (f64, f64)) -> bool| match (self.places[n], later.places[n]) {
                (Some(now), Some(next)) => Some(if better(next, now) { next } else { now }),
                (now, next) => now.or(next),
            };
        all.places = [
            self.places[0].or(later.places[0]),
            chosen(1, |a, b| a.0 < b.0),
            chosen(2, |a, b| a.0 > b.0),
            chosen(3, |a, b| a.1 < b.1),
            chosen(4, |a, b| a.1 > b.1),
            later.places[5].or(self.places[5]),
        ];
        all
    }

    /// The extremes of a quantity in the order in which they came.
    pub fn ends(&self, quantity: usize) -> [f64; 2] {
        let [low, high] = self.extremes[quantity];
        if self.falls[quantity] { [high, low] } else { [low, high] }
    }

    /// Its way through the plane: from its first place over its extremes to its last. Those lie in no known order; on a turn about a middle
    /// they are passed as its sense says.
    pub fn way(&self) -> Vec<(f64, f64)> {
        let [Some(first), least, most, slow, fast, Some(last)] = self.places else { return Vec::new() };
        if first == last && least == most && slow == fast {
            return vec![first];
        }
        // With a speed above 0 the angle rises: the way goes round clockwise, from the least angle over the greatest speed.
        let mut round: Vec<(f64, f64)> = [least, fast, most, slow].into_iter().flatten().collect();
        let nearest = |to: (f64, f64), of: &[(f64, f64)]| {
            let [wide, high] =
                [self.extremes[ANGLE], self.extremes[SPEED]].map(|[a, b]| (b - a).max(f64::MIN_POSITIVE));
            let far = |p: &(f64, f64)| ((p.0 - to.0) / wide).powi(2) + ((p.1 - to.1) / high).powi(2);
            (0..of.len()).min_by(|a, b| far(&of[*a]).total_cmp(&far(&of[*b]))).unwrap_or(0)
        };
        let from = nearest(first, &round);
        round.rotate_left(from);
        [&[first][..], &round, &[last]].concat()
    }
}
