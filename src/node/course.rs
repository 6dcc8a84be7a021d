//! The slow, exact course of an envelope, for twins: pieces in order, each from a value to a value in a time.

/// Limit of |curve| a second of a piece's length: part of the definition of a curved piece.
const STEEPEST: f64 = 16_000.0;

/// One piece.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: f64,
    end: f64,
    from: f64,
    to: f64,
    curve: f64,
}

impl Piece {
    fn at(&self, t: f64) -> f64 {
        if self.end.is_infinite() {
            return self.from;
        }
        let share = (t - self.start) / (self.end - self.start);
        let limit = STEEPEST * (self.end - self.start);
        let curve = self.curve.clamp(-limit, limit);
        let way = if curve.abs() < 1e-6 { share } else { (curve * share).exp_m1() / curve.exp_m1() };
        self.from + (self.to - self.from) * way
    }
}

/// An envelope in seconds of voice time: 0 before its first piece and after its last.
#[derive(Debug, Clone, Default)]
pub struct Course {
    pieces: Vec<Piece>,
}

impl Course {
    /// Begins at zero at t = 0.
    pub fn new() -> Self {
        Self::default()
    }
    fn end(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.end)
    }
    fn last(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.to)
    }
    /// Goes on to `to` in `seconds`.
    pub fn ramp(&mut self, to: f64, seconds: f64, curve: f64) {
        let (start, from) = (self.end(), self.last());
        self.pieces.push(Piece { start, end: start + seconds, from, to, curve });
    }
    /// Falls as e^(−t/time) to `to`, which has the sign of the value before.
    pub fn fall(&mut self, to: f64, time: f64) {
        let (start, from) = (self.end(), self.last());
        let end = start + time * (from / to).ln();
        self.pieces.push(Piece { start, end, from, to, curve: (to / from).ln() });
    }
    /// Stays where it is.
    pub fn hold(&mut self, seconds: f64) {
        self.ramp(self.last(), seconds, 0.0);
    }
    /// Forgets what comes after `t`, where the course then ends, at the value it has there.
    pub fn cut(&mut self, t: f64) {
        let value = self.at(t);
        self.pieces.retain(|piece| piece.start < t);
        if let Some(piece) = self.pieces.last_mut().filter(|piece| piece.end > t) {
            // The first part of an exponential is one itself, with that share of the curve.
            let whole = *piece;
            *piece = Piece { end: t, to: value, ..whole };
            if whole.end.is_finite() {
                let share = (t - whole.start) / (whole.end - whole.start);
                let limit = STEEPEST * (whole.end - whole.start);
                piece.curve = whole.curve.clamp(-limit, limit) * share;
            }
        }
        let start = self.end();
        self.pieces.push(Piece { start, end: t.max(start), from: value, to: value, curve: 0.0 });
    }
    /// Forgets what has ended before `t`, of which nothing is asked any more.
    pub fn forget(&mut self, t: f64) {
        if self.pieces.len() > 8 {
            self.pieces.retain(|piece| piece.end >= t);
        }
    }
    /// The value at `t`; where it jumps, the one after.
    pub fn at(&self, t: f64) -> f64 {
        let piece = self.pieces.iter().rev().find(|piece| piece.start <= t && t < piece.end);
        piece.map_or(0.0, |piece| piece.at(t))
    }
    /// Whether it has ended.
    pub fn is_over(&self, t: f64) -> bool {
        t >= self.end()
    }
    /// A sample at `t` of samples `width` apart. A sampled jump would be moved to the grid, so a sample interval (`t` in its
    /// middle) that holds a jump, or a piece as short as a jump, is averaged; all others are read in their middle.
    pub fn sample(&self, t: f64, width: f64) -> f64 {
        let (from, to) = (t - width / 2.0, t + width / 2.0);
        let mut cuts = vec![from];
        let mut jumps = 0;
        let mut before = 0.0;
        for piece in self.pieces.iter().filter(|piece| piece.end > piece.start) {
            if piece.start > from && piece.start < to {
                jumps += usize::from(piece.from != before);
                cuts.push(piece.start);
            }
            before = piece.to;
        }
        if self.end() > from && self.end() < to {
            jumps += usize::from(before != 0.0);
            cuts.push(self.end());
        }
        if jumps == 0 && cuts.len() < 3 {
            return self.at(t);
        }
        cuts.push(to);
        let mut mean = 0.0;
        for span in cuts.windows(2) {
            let (middle, half) = ((span[0] + span[1]) / 2.0, (span[1] - span[0]) / 2.0);
            // Gauss's rule with three points.
            let reach = half * 0.6_f64.sqrt();
            let sum = 5.0 * self.at(middle - reach) + 8.0 * self.at(middle) + 5.0 * self.at(middle + reach);
            mean += half * sum / 9.0;
        }
        mean / width
    }
}
