//! How a meter moves: up at once, down slowly, with a mark at the highest that falls after a while.

/// Where a bar begins, dB; it ends at 0, full scale.
pub const LEAST: f32 = -60.0;

/// dB a second by which the bar falls.
const FALL: f32 = 60.0;

/// Seconds that the mark stays, and dB a second by which it falls then.
const HOLD: f64 = 1.2;
const SINK: f32 = 30.0;

/// Seconds that a meter says that full scale was reached.
const FULL: f64 = 3.0;

/// A meter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meter {
    /// The bar, dB.
    pub level: f32,
    /// The mark, dB.
    pub mark: f32,
    /// The highest ever, as a magnitude.
    pub most: f32,
    /// Seconds since the mark was set, and since full scale was reached.
    held: f64,
    full: f64,
}

impl Default for Meter {
    fn default() -> Self {
        let none = f32::NEG_INFINITY;
        Self { level: none, mark: none, most: 0.0, held: 0.0, full: f64::INFINITY }
    }
}

impl Meter {
    /// In the last `seconds` the largest magnitude was `peak`.
    pub fn hear(&mut self, peak: f32, seconds: f64) {
        let now = if peak > 0.0 { 20.0 * peak.log10() } else { f32::NEG_INFINITY };
        let sunk = |from: f32, by: f32| if from - by < LEAST { f32::NEG_INFINITY } else { from - by };
        self.level = now.max(sunk(self.level, FALL * seconds as f32));
        self.held += seconds;
        if now >= self.mark {
            (self.mark, self.held) = (now, 0.0);
        } else if self.held > HOLD {
            self.mark = self.level.max(sunk(self.mark, SINK * seconds as f32));
        }
        self.full = if peak >= 1.0 { 0.0 } else { self.full + seconds };
        self.most = self.most.max(peak);
    }

    /// Whether it reached full scale a moment ago: the output was cut there, or just not.
    pub fn is_full(&self) -> bool {
        self.full < FULL
    }
}

#[cfg(test)]
mod tests {
    use super::{FALL, Meter};

    #[test]
    fn it_rises_at_once_and_falls_at_its_pace() {
        let mut meter = Meter::default();
        meter.hear(0.5, 0.05);
        assert!((meter.level + 6.0206).abs() < 1e-3 && meter.level == meter.mark);
        for frame in 1..=10 {
            meter.hear(0.0, 0.05);
            assert!((meter.level - (-6.0206 - FALL * 0.05 * frame as f32)).abs() < 1e-3);
            assert!((meter.mark + 6.0206).abs() < 1e-3, "the mark stays");
        }
        for _ in 0..100 {
            meter.hear(0.0, 0.05);
            assert!(meter.mark >= meter.level);
        }
        assert_eq!((meter.level, meter.mark), (f32::NEG_INFINITY, f32::NEG_INFINITY));
        assert_eq!(meter.most, 0.5);
    }

    #[test]
    fn the_pace_does_not_depend_on_how_often_it_is_looked_at() {
        let after = |steps: i32| {
            let mut meter = Meter::default();
            meter.hear(1.0, 0.0);
            (0..steps).for_each(|_| meter.hear(0.0, 0.5 / f64::from(steps)));
            meter.level
        };
        assert!((after(1) - after(50)).abs() < 1e-3);
    }

    #[test]
    fn full_scale_is_told_for_a_while() {
        let mut meter = Meter::default();
        assert!(!meter.is_full());
        meter.hear(1.0, 0.05);
        meter.hear(0.0, 2.9);
        assert!(meter.is_full());
        meter.hear(0.999, 0.2);
        assert!(!meter.is_full());
        meter.hear(f32::NAN, 0.05);
        assert!(meter.level.is_finite() && meter.most == 1.0);
    }
}
