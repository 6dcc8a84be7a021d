//! What a servo that ticks block by block leaves to a thread that reads the knob oftener: its torque over the angle near where the knob is.
//!
//! Between two blocks that thread gives the torque of the angle that it has just read. Springs, walls and notches are then as late as the
//! thread is, and only what is made of the speed waits for a block. Straight lines between the points are nowhere steeper
//! than what they are taken from, so that a stiffness that was granted is not exceeded. Points lie close together near the centre, where the knob
//! mostly is, and ever wider apart from there, as the squares of the whole numbers.

#[cfg(test)]
mod tests;

/// Points on each side of the centre, and all of them.
pub const SIDE: usize = 16;
/// All points: the centre among them.
pub const POINTS: usize = 2 * SIDE + 1;

/// Torque over angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// Torque that the servo gave at the centre, N m.
    pub torque: f64,
    /// The angle of that, radians.
    pub centre: f64,
    /// How far it holds to either side of the centre, radians; 0: torque does not depend on the angle.
    pub reach: f64,
    /// By how much torque is more at each point than at the centre, N m.
    pub more: [f64; POINTS],
    /// Potential energy at the centre, joules.
    pub energy: f64,
    /// Seconds of the servo's ticks so far.
    pub time: f64,
}

impl Profile {
    /// The same torque at any angle.
    pub const fn flat(torque: f64) -> Self {
        Self { torque, centre: 0.0, reach: 0.0, more: [0.0; POINTS], energy: 0.0, time: 0.0 }
    }

    /// A share of it.
    #[must_use]
    pub fn scaled(&self, share: f64) -> Self {
        let more = self.more.map(|more| more * share);
        Self { torque: self.torque * share, more, energy: self.energy * share, ..*self }
    }

    /// Whether torque does not depend on the angle.
    pub fn is_flat(&self) -> bool {
        self.reach == 0.0
    }

    /// The way of a point from the centre, radians.
    pub fn away(&self, point: usize) -> f64 {
        let share = point as f64 / SIDE as f64 - 1.0;
        self.reach * share * share.abs()
    }

    /// The piece in which an angle lies, how far in (0 to 1), and whether the angle is beyond the range.
    fn piece(&self, angle: f64) -> (usize, f64, bool) {
        let away = angle - self.centre;
        let within = away.clamp(-self.reach, self.reach);
        let from = SIDE as f64 * (1.0 + (within.abs() / self.reach).sqrt().copysign(within));
        let piece = (from as usize).min(POINTS - 2);
        let [left, right] = [piece, piece + 1].map(|point| self.away(point));
        // The root is rounded, and may lie in the piece beside.
        (piece, ((within - left) / (right - left)).clamp(0.0, 1.0), within != away)
    }

    /// Torque at an angle, N m, and whether that is beyond the range, where it stays what it is at the range's end. At the centre it is
    /// what the servo gave, to the bit. An angle that is no number is beyond, and has none.
    pub fn at(&self, angle: f64) -> (f64, bool) {
        if !angle.is_finite() {
            return (0.0, true);
        }
        if self.is_flat() {
            return (self.torque, false);
        }
        let (piece, share, beyond) = self.piece(angle);
        let [left, right] = [self.more[piece], self.more[piece + 1]];
        (self.torque + (left + (right - left) * share), beyond)
    }

    /// Potential energy at an angle, joules: torque is its fall.
    pub fn energy(&self, angle: f64) -> f64 {
        let away = angle - self.centre;
        if self.is_flat() {
            return self.energy - self.torque * away;
        }
        let (piece, share, _) = self.piece(angle);
        // The area from the centre to the point before, and on to the angle.
        let width = |k: usize| self.away(k + 1) - self.away(k);
        let whole = |k: usize| 0.5 * width(k) * (self.more[k] + self.more[k + 1]);
        let before: f64 = if piece >= SIDE {
            (SIDE..piece).map(whole).sum()
        } else {
            -(piece..SIDE).map(whole).sum::<f64>()
        };
        let [left, right] = [self.more[piece], self.more[piece + 1]];
        let within = width(piece) * (left * share + 0.5 * (right - left) * share * share);
        let held = self.more[if away < 0.0 { 0 } else { POINTS - 1 }];
        let beyond = f64::max(away.abs() - self.reach, 0.0).copysign(away);
        self.energy - self.torque * away - (before + within) - held * beyond
    }

    /// The steepest fall of torque over the angle, N m/rad.
    pub fn stiffness(&self) -> f64 {
        if self.is_flat() {
            return 0.0;
        }
        let fall = |k: usize| (self.more[k] - self.more[k + 1]) / (self.away(k + 1) - self.away(k));
        (0..POINTS - 1).map(fall).fold(0.0, f64::max)
    }

    /// Numbers that hold all of it.
    pub const NUMBERS: usize = 5 + POINTS;

    /// As numbers.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let mut all = [0.0; Self::NUMBERS];
        all[..5].copy_from_slice(&[self.torque, self.centre, self.reach, self.energy, self.time]);
        all[5..].copy_from_slice(&self.more);
        all
    }

    /// That of numbers.
    pub fn of_numbers(all: &[f64; Self::NUMBERS]) -> Self {
        let [torque, centre, reach, energy, time] = [0, 1, 2, 3, 4].map(|n| all[n]);
        let mut more = [0.0; POINTS];
        more.copy_from_slice(&all[5..]);
        Self { torque, centre, reach, more, energy, time }
    }
}
