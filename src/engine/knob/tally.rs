//! What a knob did so far, in figures.

use crate::knob::safety::chain::{STAGES, Trip};

/// What an engine sample of a knob adds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moment {
    /// Of what is held, rad.
    pub angle: f64,
    /// rad/s.
    pub speed: f64,
    /// As the servo estimates it, rad/s.
    pub estimated: f64,
    /// Given, N m.
    pub torque: f64,
    /// Energy that went into the virtual world so far, J.
    pub absorbed: f64,
    /// How much warmer than the air its winding is, K, where that is known.
    pub warm: Option<f64>,
}

/// All of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tally {
    /// Least and greatest angle, rad; the least is the greater of the two before the first sample.
    pub angle: [f64; 2],
    /// rad/s.
    pub most_speed: f64,
    /// N m.
    pub most_torque: f64,
    /// Energy that went into the virtual world, and its least, J.
    pub absorbed: f64,
    /// Below 0 where more came out than had gone in.
    pub least_absorbed: f64,
    /// K above the air, of its winding, where that is known.
    pub most_warm: Option<f64>,
    /// Squares of the errors of the estimated speed, summed.
    squares: f64,
    /// Engine samples.
    pub samples: u64,
    /// In how many ticks each stage of the chain of safety acted.
    pub stages: [u64; STAGES],
    /// Why torque is latched at 0, if it is.
    pub trip: Option<Trip>,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            angle: [f64::INFINITY, f64::NEG_INFINITY],
            most_speed: 0.0,
            most_torque: 0.0,
            absorbed: 0.0,
            least_absorbed: 0.0,
            most_warm: None,
            squares: 0.0,
            samples: 0,
            stages: [0; STAGES],
            trip: None,
        }
    }
}

const TRIPS: [Trip; 4] = [Trip::Reading, Trip::Lost, Trip::OverSpeed, Trip::Panic];

impl Tally {
    /// Numbers that hold all of it.
    pub const NUMBERS: usize = 10 + STAGES;

    /// Root-mean-square error of the estimated speed, rad/s.
    pub fn speed_error(&self) -> f64 {
        (self.squares / self.samples.max(1) as f64).sqrt()
    }

    /// One more engine sample.
    pub fn add(&mut self, moment: &Moment) {
        let Moment { angle, speed, estimated, torque, absorbed, warm } = *moment;
        self.angle = [self.angle[0].min(angle), self.angle[1].max(angle)];
        self.most_speed = self.most_speed.max(speed.abs());
        self.most_torque = self.most_torque.max(torque.abs());
        (self.absorbed, self.least_absorbed) = (absorbed, self.least_absorbed.min(absorbed));
        if let Some(warm) = warm {
            self.most_warm = Some(self.most_warm.unwrap_or(warm).max(warm));
        }
        let off = estimated - speed;
        self.squares += if off.is_finite() { off * off } else { 0.0 };
        self.samples += 1;
    }

    /// As numbers, for a board that other threads read.
    pub fn numbers(&self) -> [u64; Self::NUMBERS] {
        let trip = self.trip.and_then(|trip| TRIPS.iter().position(|other| *other == trip));
        let mut all = [0; Self::NUMBERS];
        let first = [
            self.angle[0],
            self.angle[1],
            self.most_speed,
            self.most_torque,
            self.absorbed,
            self.least_absorbed,
            self.most_warm.unwrap_or(f64::NAN),
            self.squares,
        ];
        let rest = [self.samples, trip.map_or(0, |n| n as u64 + 1)];
        let numbers = first.map(f64::to_bits).into_iter().chain(rest).chain(self.stages);
        all.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number);
        all
    }

    /// Of [`Tally::numbers`].
    pub fn of(numbers: &[u64; Self::NUMBERS]) -> Self {
        let [low, high, speed, torque, absorbed, least, warm, squares, samples, trip, stages @ ..] = *numbers;
        let of = f64::from_bits;
        Self {
            angle: [of(low), of(high)],
            most_speed: of(speed),
            most_torque: of(torque),
            absorbed: of(absorbed),
            least_absorbed: of(least),
            most_warm: Some(of(warm)).filter(|warm| !warm.is_nan()),
            squares: of(squares),
            samples,
            stages,
            trip: (trip as usize).checked_sub(1).and_then(|n| TRIPS.get(n).copied()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Moment, TRIPS, Tally};

    #[test]
    fn it_comes_back_from_its_numbers_and_forgets_no_extreme() {
        let mut tally = Tally::default();
        assert_eq!(Tally::of(&tally.numbers()), tally);
        let moment =
            |angle: f64, speed: f64| Moment { angle, speed, estimated: speed + 0.5, ..Moment::default() };
        tally.add(&moment(-0.5, -3.0));
        tally.add(&Moment { torque: -0.02, absorbed: -1e-3, warm: Some(4.0), ..moment(1.5, 2.0) });
        tally.add(&Moment { absorbed: 2e-3, warm: Some(3.0), ..moment(0.0, 0.0) });
        tally.add(&Moment { estimated: f64::NAN, ..Moment::default() });
        tally.stages[3] = 7;
        assert_eq!((tally.angle, tally.most_speed, tally.most_torque), ([-0.5, 1.5], 3.0, 0.02));
        assert_eq!((tally.least_absorbed, tally.most_warm, tally.samples), (-1e-3, Some(4.0), 4));
        assert!((tally.speed_error() - (0.75f64 / 4.0).sqrt()).abs() < 1e-15);
        for trip in TRIPS.into_iter().map(Some).chain([None]) {
            tally.trip = trip;
            assert_eq!(Tally::of(&tally.numbers()), tally);
        }
    }
}
