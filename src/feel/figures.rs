//! The figures of what was felt.

/// What an actuator did so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// The largest magnitude of what is felt, in the unit of its traces: of a rumble motor both axes together.
    pub peak: f64,
    /// The frame in which that was, in seconds.
    pub peak_at: f64,
    /// Root mean square of that magnitude, in the same unit.
    pub rms: f64,
    /// The farthest that what the coil moves was from rest at the end of a frame, m: the contactor in its housing, the slug in its casing. `None`
    /// for a motor.
    pub farthest: Option<f64>,
    /// The same as a share of the stroke, where that is known. The model has no end stops: beyond 1 a real one hits its own.
    pub of_stroke: Option<f64>,
    /// The fastest that a rumble motor turned at the end of a frame, either way, rad/s.
    pub fastest: Option<f64>,
    /// What is felt at the end, in the unit of its traces: the largest magnitude of the last 50 to 100 ms, a crest of anything above 10 Hz.
    pub last: f64,
    /// Drawn from the amplifier, less what came back, J; `None` of a motor that is known from outside alone.
    pub energy: Option<f64>,
    /// The warmest that the winding became, K above the air; `None` where its cooling is not known. The resistance in the model stays the cold
    /// one.
    pub warmest: Option<f64>,
    /// What card and amplifier could not do.
    pub counts: Counts,
}

/// What card and amplifier could not do, in samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Beyond full scale, and cut there.
    pub clipped: u64,
    /// Of which the amplifier gave less than was asked for.
    pub limited: u64,
    /// That were no numbers, asked for more volts or amperes than a model takes, or led to what is no number: they became 0.
    pub masked: u64,
}

/// What takes the figures of magnitudes.
#[derive(Debug, Clone, Default)]
pub(super) struct Meter {
    frames: u64,
    peak: f64,
    peak_frame: u64,
    squares: f64,
    /// The largest squares of this window and of the one before, the frames of a window, and those of this one so far.
    windows: [f64; 2],
    window: u64,
    passed: u64,
}

/// Seconds of a window, at least half a period of what is felt.
const WINDOW: f64 = 0.05;

impl Meter {
    /// At so many frames a second.
    pub fn new(rate: f64) -> Self {
        Self { window: (WINDOW * rate) as u64, ..Self::default() }
    }

    /// The square of a magnitude, a frame.
    #[inline]
    pub fn take(&mut self, square: f64) {
        if square > self.peak {
            (self.peak, self.peak_frame) = (square, self.frames);
        }
        if self.passed >= self.window {
            (self.windows, self.passed) = ([0.0, self.windows[0]], 0);
        }
        self.windows[0] = self.windows[0].max(square);
        self.passed += 1;
        self.squares += square;
        self.frames += 1;
    }

    /// So many frames of nothing.
    pub fn rest(&mut self, frames: u64) {
        self.frames += frames;
    }

    /// What is felt now.
    pub fn last(&self) -> f64 {
        self.windows[0].max(self.windows[1]).sqrt()
    }

    /// Peak, its time (s) and root mean square.
    pub fn read(&self, rate: f64) -> [f64; 3] {
        let mean = self.squares / self.frames.max(1) as f64;
        [self.peak.sqrt(), self.peak_frame as f64 / rate, mean.sqrt()]
    }
}

#[cfg(test)]
mod tests {
    use super::Meter;

    #[test]
    fn a_meter_reads_by_definition() {
        let mut meter = Meter::default();
        assert_eq!(meter.read(100.0), [0.0; 3]);
        [9.0, 0.0].into_iter().for_each(|square| meter.take(square));
        meter.rest(0);
        [25.0, 25.0, 16.0].into_iter().for_each(|square| meter.take(square));
        assert_eq!(meter.read(100.0), [5.0, 0.02, 15.0_f64.sqrt()]);
        meter.rest(10);
        meter.take(100.0);
        assert_eq!(meter.read(100.0), [10.0, 0.15, (175.0_f64 / 16.0).sqrt()]);
    }

    #[test]
    fn what_is_felt_now_is_the_crest_of_the_last_windows() {
        // Windows of 50 frames: a crest counts for 50 to 100 of them.
        for at in 0..50 {
            let mut meter = Meter::new(1000.0);
            (0..at).for_each(|_| meter.take(1.0));
            meter.take(9.0);
            let gone = (0..200).position(|_| {
                meter.take(1.0);
                meter.last() < 3.0
            });
            assert!(gone.is_some_and(|frames| (49..100).contains(&frames)), "{at} {gone:?}");
            assert_eq!(meter.last(), 1.0);
        }
    }
}
