//! A live parameter on its way to a value.

use super::workspace::Buffer;
use crate::dsp::lanes::{LANES, Real};
use crate::node::kernel::LEAD;
use crate::schedule::Instant;

/// A value that moves in a straight line to where it was last sent, and then stays there exactly.
#[derive(Debug)]
pub struct Ramp<R> {
    from: f64,
    to: f64,
    since: Instant,
    samples: f64,
    /// What [`Ramp::samples`] is from the next value on: it differs while it goes on with what another began.
    usual: f64,
    least: f64,
    most: f64,
    /// Whether what it fills already holds `to`.
    settled: bool,
    _real: std::marker::PhantomData<R>,
}

impl<R: Real> Ramp<R> {
    /// Rests at `value`, moves within `least` and `most`, and takes `samples` to reach a new value.
    pub fn new(value: f64, least: f64, most: f64, samples: f64) -> Self {
        let samples = if samples > 1.0 { samples } else { 1.0 };
        let since = Instant::default();
        Self {
            from: value,
            to: value,
            since,
            samples,
            usual: samples,
            least,
            most,
            settled: false,
            _real: std::marker::PhantomData,
        }
    }

    /// Sends it to `value`, from wherever it is at `at`. Not-a-number is ignored.
    pub fn send(&mut self, value: f64, at: Instant) {
        if !value.is_nan() {
            self.from = self.value(at.since(self.since));
            self.to = value.clamp(self.least, self.most);
            self.since = at;
            self.samples = self.usual;
            self.settled = false;
        }
    }

    /// Sends it there within so many samples, 1 at least. What is no number is ignored.
    pub fn glide(&mut self, value: f64, samples: f64, at: Instant) {
        if !samples.is_nan() {
            self.send(value, at);
            self.samples = samples.max(1.0);
        }
    }

    /// Goes on as `other`, within its own range, and takes its own time to the next value.
    pub fn follow(&mut self, other: &Self) {
        (self.from, self.since) = (other.from, other.since);
        self.to = other.to.clamp(self.least, self.most);
        self.samples = other.samples;
        self.settled = false;
    }

    fn value(&self, age: f64) -> f64 {
        let x = age / self.samples;
        if x >= 1.0 {
            self.to
        } else if x <= 0.0 {
            self.from
        } else {
            self.from + (self.to - self.from) * x
        }
    }

    /// Its values from engine sample `clock` on, the same in all lanes.
    pub fn fill(&mut self, signal: &mut Buffer<R>, frames: usize, clock: u64) {
        if self.settled {
            return;
        }
        let age = self.since.until(clock) - LEAD;
        if age >= self.samples {
            signal.hold(R::of(self.to));
            self.settled = true;
            return;
        }
        signal.still = false;
        for (frame, row) in signal.rows[..frames].iter_mut().enumerate() {
            *row = [R::of(self.value(age + frame as f64)); LANES];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Buffer, Instant, LANES, Ramp};

    #[test]
    fn it_arrives_and_stays() {
        let mut ramp = Ramp::<f64>::new(0.0, 0.0, 2.0, 10.0);
        let mut signal = Buffer::silent();
        ramp.send(1.0, Instant::of_samples(4.5));
        ramp.fill(&mut signal, 20, 0);
        assert_eq!(signal.at(6)[0], 0.0);
        assert!((signal.at(7)[0] - 0.05).abs() < 1e-12 && (signal.at(16)[7] - 0.95).abs() < 1e-12);
        assert_eq!(signal.at(17)[3], 1.0);
        ramp.fill(&mut signal, 1, 20);
        assert!(signal.still && signal.at(63) == [1.0; LANES]);
        ramp.send(9.0, Instant::of_samples(40.0));
        assert_eq!(ramp.to, 2.0);
        ramp.send(f64::NAN, Instant::of_samples(41.0));
        assert_eq!(ramp.to, 2.0);
    }

    #[test]
    fn it_glides_as_long_as_it_is_told_and_then_takes_its_own_time() {
        let mut ramp = Ramp::<f64>::new(0.0, 0.0, 2.0, 4.0);
        let mut signal = Buffer::silent();
        ramp.glide(1.0, 20.0, Instant::default());
        ramp.glide(f64::NAN, 20.0, Instant::default());
        ramp.glide(0.5, f64::NAN, Instant::default());
        ramp.fill(&mut signal, 60, 0);
        // A voice's clock lags by two samples.
        assert!((signal.at(12)[0] - 0.5).abs() < 1e-12 && signal.at(22)[0] == 1.0);
        ramp.send(2.0, Instant::of_samples(60.0));
        ramp.fill(&mut signal, 60, 60);
        assert!((signal.at(4)[0] - 1.5).abs() < 1e-12 && signal.at(6)[0] == 2.0);
    }

    #[test]
    fn it_finishes_what_another_began_and_then_takes_its_own_time() {
        let mut old = Ramp::<f64>::new(0.0, 0.0, 2.0, 10.0);
        old.send(1.0, Instant::of_samples(0.0));
        let mut new = Ramp::<f64>::new(0.0, 0.0, 2.0, 40.0);
        new.follow(&old);
        let mut signal = Buffer::silent();
        new.fill(&mut signal, 60, 0);
        // A voice's clock lags by two samples.
        assert!((signal.at(7)[0] - 0.5).abs() < 1e-12 && signal.at(12)[0] == 1.0);
        new.send(2.0, Instant::of_samples(100.0));
        new.fill(&mut signal, 60, 100);
        assert!((signal.at(22)[0] - 1.5).abs() < 1e-12 && signal.at(42)[0] == 2.0);
    }

    #[test]
    fn cutting_time_changes_nothing() {
        let run = |cuts: &[usize]| {
            let mut ramp = Ramp::<f32>::new(0.3, 0.0, 1.0, 33.0);
            ramp.send(0.9, Instant::of_samples(1.25));
            let (mut clock, mut all) = (0, Vec::new());
            for &frames in cuts {
                let mut signal = Buffer::silent();
                // A settled ramp relies on the buffer it filled: keep one.
                ramp.settled = false;
                ramp.fill(&mut signal, frames, clock);
                all.extend((0..frames).map(|frame| signal.at(frame)[0].to_bits()));
                clock += frames as u64;
            }
            all
        };
        assert_eq!(run(&[60]), run(&[1, 7, 20, 2, 30]));
    }
}
