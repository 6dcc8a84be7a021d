//! Envelopes as a chain of segments with closed forms, played on lanes.
//!
//! A segment is level + slope·x + swing·e^(bend·x), x in samples from its start. Nothing is accumulated from one segment to
//! the next: each starts at an exact instant, mostly between samples, and what jumps there (the value, the slope, and for
//! curved segments the derivatives above) is corrected by [`crate::dsp::corner`].

use super::kernel::Io;
use crate::dsp::corner::{Corrections, ORDERS, TAPS};
use crate::dsp::lanes::{LANES, Real};

/// Steepest exponential, e-folds a second: a segment's |curve| is at most this times its length. What is steeper differs
/// beyond 1 kHz.
pub const STEEPEST: f64 = 16_000.0;

/// Segments shorter than this, in samples, are a jump in their middle: the difference is beyond −90 dB within 1 kHz, and
/// slopes keep a size whose rounding errors do not show.
const SHORTEST: f64 = 1.0 / 32.0;

/// Samples after which a running form is computed anew from the closed one.
const RUN: u64 = 4096;

/// One segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    level: f64,
    slope: f64,
    swing: f64,
    bend: f64,
    /// Samples; may be infinite.
    length: f64,
    /// Nothing follows.
    last: bool,
}

impl Segment {
    /// Zero for ever.
    pub fn end() -> Self {
        Self { last: true, ..Self::hold(0.0, f64::INFINITY) }
    }

    /// Stays at `value` for `length` samples.
    pub fn hold(value: f64, length: f64) -> Self {
        Self { level: value, slope: 0.0, swing: 0.0, bend: 0.0, length, last: false }
    }

    /// Goes from one value to another in `seconds`, as (e^(curve·u) − 1) / (e^curve − 1) of the way at the share u of the
    /// time: 0 is a straight line, below 0 fast at first, above 0 slow at first.
    pub fn ramp(from: f64, to: f64, seconds: f64, curve: f64, rate: f64) -> Self {
        let length = seconds * rate;
        let steepest = STEEPEST * seconds;
        let curve = curve.clamp(-steepest, steepest);
        if length == 0.0 || from == to {
            return Self::hold(to, length);
        }
        if curve.abs() < 1e-6 {
            return Self { slope: (to - from) / length, ..Self::hold(from, length) };
        }
        let swing = (to - from) / curve.exp_m1();
        Self { level: from - swing, swing, bend: curve / length, ..Self::hold(0.0, length) }
    }

    /// Falls from `from` towards zero as e^(−t/time), for `seconds`.
    pub fn decay(from: f64, time: f64, seconds: f64, rate: f64) -> Self {
        Self { swing: from, bend: -1.0 / (time * rate), ..Self::hold(0.0, seconds * rate) }
    }

    /// The value `x` samples from its start.
    pub fn at(&self, x: f64) -> f64 {
        let curve = if self.swing == 0.0 { 0.0 } else { self.swing * (self.bend * x).exp() };
        self.level + self.slope * x + curve
    }

    /// The value and its derivatives by samples.
    fn derivatives(&self, x: f64) -> [f64; ORDERS] {
        let mut all = [0.0; ORDERS];
        if self.swing != 0.0 {
            let mut curve = self.swing * (self.bend * x).exp();
            for derivative in &mut all {
                *derivative = curve;
                curve *= self.bend;
            }
        }
        all[0] += self.level + self.slope * x;
        all[1] += self.slope;
        all
    }
}

/// Where a track's segments come from.
pub trait Script {
    /// The segment that follows on `lane`, where the last one ended at `value`. It comes to an infinite one after a
    /// finite number of calls.
    fn next(&mut self, lane: usize, value: f64) -> Segment;
}

/// Segments under way on a group of lanes.
///
/// A correction begins up to two samples before its instant, so the segments are evaluated two samples ahead, and what
/// they give comes out two samples later.
#[derive(Debug, Clone)]
pub struct Track<R> {
    /// What is evaluated: base + slope·n + (level + curve), n counted within the run; level and curve are 0 for straight
    /// segments and base and slope for curved ones.
    base: [R; LANES],
    slope: [R; LANES],
    n: [R; LANES],
    level: [f64; LANES],
    curve: [f64; LANES],
    ratio: [f64; LANES],
    curved: bool,
    /// Whether no lane moves before the next one is due.
    flat: bool,
    late: [[R; LANES]; 2],
    corrections: Corrections<R>,
    /// Samples computed, and for each lane the count at which it needs looking after.
    clock: u64,
    due: [u64; LANES],
    next_due: u64,
    lanes: [Place; LANES],
}

/// Where a lane is.
#[derive(Debug, Clone, Copy)]
struct Place {
    segment: Segment,
    /// Voice time of the segment's start, in samples.
    start: f64,
    /// Second half of a segment too short to be one.
    rest: Option<Segment>,
    /// Voice time of the value evaluated at `since`.
    age: f64,
    since: u64,
    /// The count at which the last segment has come out and nothing else; `u64::MAX` before it begins.
    silent: u64,
}

impl Place {
    /// Voice time of what is evaluated at `clock`.
    fn time(&self, clock: u64) -> f64 {
        self.age + (clock - self.since) as f64
    }
    fn end(&self) -> f64 {
        self.start + self.segment.length
    }
}

impl<R: Real> Track<R> {
    /// Silent lanes.
    pub fn new() -> Self {
        let place = Place { segment: Segment::end(), start: 0.0, rest: None, age: 0.0, since: 0, silent: 0 };
        Self {
            base: [R::ZERO; LANES],
            slope: [R::ZERO; LANES],
            n: [R::ZERO; LANES],
            level: [0.0; LANES],
            curve: [0.0; LANES],
            ratio: [1.0; LANES],
            curved: false,
            flat: true,
            late: [[R::ZERO; LANES]; 2],
            corrections: Corrections::new(),
            clock: 0,
            due: [u64::MAX; LANES],
            next_due: u64::MAX,
            lanes: [place; LANES],
        }
    }

    /// A voice begins: `age` is the voice time of the next sample, −2 to −1. It is at zero until voice time 0, when the
    /// script is asked for the first segment.
    pub fn start(&mut self, lane: usize, age: f64) {
        self.corrections.clear(lane);
        for row in &mut self.late {
            row[lane] = R::ZERO;
        }
        let age = if age > -2.0 { age.min(-1.0) } else { -2.0 };
        self.lanes[lane] = Place {
            segment: Segment::hold(0.0, 0.0),
            start: 0.0,
            rest: None,
            age: age + 2.0,
            since: self.clock,
            silent: u64::MAX,
        };
        self.look_after(lane);
    }

    /// After [`Track::start`], before anything is computed: it has been at `value` all the time, not at zero.
    pub fn since_ever(&mut self, lane: usize, value: f64) {
        for row in &mut self.late {
            row[lane] = R::of(value);
        }
        self.lanes[lane].segment = Segment::hold(value, 0.0);
    }

    /// Goes through what ends on `lane` up to the voice time `at`, which lies one to two samples after the next sample.
    pub fn reach<S: Script>(&mut self, lane: usize, at: f64, script: &mut S) {
        while self.lanes[lane].end() <= at {
            self.turn(lane, self.lanes[lane].end(), script);
        }
    }

    /// Ends the segment on `lane` at the voice time `at`, up to which it has been [reached](Self::reach).
    pub fn cut<S: Script>(&mut self, lane: usize, at: f64, script: &mut S) {
        self.lanes[lane].rest = None;
        self.turn(lane, at, script);
        self.look_after(lane);
    }

    /// The next segment begins at the voice time `at`.
    fn turn<S: Script>(&mut self, lane: usize, at: f64, script: &mut S) {
        let place = &mut self.lanes[lane];
        let before = place.segment.derivatives(at - place.start);
        place.start = at;
        place.segment = match place.rest.take() {
            Some(rest) => rest,
            None => {
                let mut next = script.next(lane, before[0]);
                // What takes no time leaves its last value.
                while next.length == 0.0 {
                    next = script.next(lane, next.at(0.0));
                }
                if next.length < SHORTEST {
                    place.rest = Some(Segment::hold(next.at(next.length), next.length / 2.0));
                    Segment::hold(next.at(0.0), next.length / 2.0)
                } else {
                    next
                }
            }
        };
        if place.segment.last && place.silent == u64::MAX {
            place.silent = self.clock + TAPS as u64;
        }
        let after = place.segment.derivatives(0.0);
        let heights: [f64; ORDERS] = std::array::from_fn(|k| after[k] - before[k]);
        let ahead = at - (place.time(self.clock) - 2.0);
        self.corrections.add(lane, ahead, &heights);
    }

    fn look_after(&mut self, lane: usize) {
        self.due[lane] = self.clock;
        self.next_due = self.clock;
    }

    /// Takes up what is due at this sample.
    #[inline(never)]
    fn attend<S: Script>(&mut self, script: &mut S) {
        for lane in 0..LANES {
            if self.due[lane] > self.clock {
                continue;
            }
            let time = self.lanes[lane].time(self.clock);
            self.reach(lane, time, script);
            let place = &self.lanes[lane];
            // Not before its start, whoever says that it starts later: a slope would lead anywhere from there.
            let (segment, x) = (place.segment, (time - place.start).max(0.0));
            self.n[lane] = R::ZERO;
            if segment.swing == 0.0 {
                // Never −0, so that adding a neighbour's curved form changes no bit.
                self.base[lane] = R::of(segment.at(x)) + R::ZERO;
                self.slope[lane] = R::of(segment.slope);
                (self.level[lane], self.curve[lane], self.ratio[lane]) = (0.0, 0.0, 1.0);
            } else {
                (self.base[lane], self.slope[lane]) = (R::ZERO, R::ZERO);
                self.level[lane] = segment.level;
                self.curve[lane] = segment.swing * (segment.bend * x).exp();
                self.ratio[lane] = segment.bend.exp();
            }
            let moves = segment.swing != 0.0 || segment.slope != 0.0;
            // The first sample at or after the segment's end; the cast saturates.
            let mut left = (place.end() - time).ceil() as u64;
            if left < 1 << 40 {
                while left > 1 && place.time(self.clock + left - 1) >= place.end() {
                    left -= 1;
                }
                while place.time(self.clock + left) < place.end() {
                    left += 1;
                }
            }
            if moves {
                left = left.min(RUN);
            }
            self.due[lane] = self.clock.saturating_add(left.max(1));
        }
        self.next_due = self.due.iter().copied().min().unwrap_or(u64::MAX);
        self.curved = self.curve.iter().any(|c| *c != 0.0);
        self.flat = !self.curved && self.slope == [R::ZERO; LANES];
    }

    /// The next samples.
    #[inline(always)]
    pub fn run<S: Script>(&mut self, io: &mut Io<R>, script: &mut S) {
        let frames = io.output.len() as u64;
        let mut under_way = false;
        for l in 0..LANES {
            under_way |= (self.late[0][l] != self.base[l]) | (self.late[1][l] != self.base[l]);
        }
        if self.flat && !under_way && self.next_due - self.clock >= frames && self.corrections.are_over() {
            io.output[0] = self.base;
            io.still = true;
            self.clock += frames;
        } else {
            self.move_on(io.output, script);
        }
    }

    #[inline(always)]
    fn move_on<S: Script>(&mut self, output: &mut [[R; LANES]], script: &mut S) {
        let mut done = 0;
        while done < output.len() {
            if self.next_due <= self.clock {
                self.attend(script);
            }
            let frames = ((output.len() - done) as u64).min(self.next_due - self.clock) as usize;
            let chunk = &mut output[done..done + frames];
            if self.curved {
                self.run_curved(chunk);
            } else {
                self.run_straight(chunk);
            }
            self.corrections.apply(chunk);
            self.clock += frames as u64;
            done += frames;
        }
    }

    #[inline(always)]
    fn run_straight(&mut self, chunk: &mut [[R; LANES]]) {
        let (base, slope, mut n, mut late) = (self.base, self.slope, self.n, self.late);
        for out in chunk {
            *out = late[0];
            late[0] = late[1];
            for l in 0..LANES {
                late[1][l] = base[l] + slope[l] * n[l];
                n[l] += R::ONE;
            }
        }
        (self.n, self.late) = (n, late);
    }

    #[inline(always)]
    fn run_curved(&mut self, chunk: &mut [[R; LANES]]) {
        let (base, slope, mut n, mut late) = (self.base, self.slope, self.n, self.late);
        let (level, mut curve, ratio) = (self.level, self.curve, self.ratio);
        for out in chunk {
            *out = late[0];
            late[0] = late[1];
            for l in 0..LANES {
                late[1][l] = base[l] + slope[l] * n[l] + R::of(level[l] + curve[l]);
                n[l] += R::ONE;
                curve[l] *= ratio[l];
            }
        }
        (self.n, self.late, self.curve) = (n, late, curve);
    }

    /// Whether `lane` has not yet ended at zero for good.
    pub fn sounding(&self, lane: usize) -> bool {
        self.clock < self.lanes[lane].silent
    }

    /// The value on `lane`, two samples ahead.
    pub fn value(&self, lane: usize) -> f64 {
        let place = &self.lanes[lane];
        place.segment.at((place.time(self.clock) - place.start).min(place.segment.length))
    }
}

impl<R: Real> Default for Track<R> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    /// Times over five decades, releases anywhere, all fractions of a sample.
    #[test]
    fn any_envelope_is_exact_within_the_band_bounded_and_ends_at_zero() {
        let mut state = 1_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for round in 0..60 {
            let mut bench = Bench::new("envelope", 8000.0).age(-2.0 + 1e-9 + random() * 0.999_999);
            for time in ["attack", "decay", "release"] {
                bench = bench.steady(time, 0.03 * 10_f64.powf(-5.0 * random()));
            }
            for curve in ["attack_curve", "decay_curve", "release_curve"] {
                bench = bench.steady(curve, 10.0 * random() - 5.0);
            }
            bench = bench.steady("sustain", random()).released(0.05 * random());
            let samples = bench.kernel::<f32>(1000, &[64]);
            // Band-limited jumps overshoot, pulses of a fraction of a sample more than others.
            assert!(samples.iter().all(|v| (-1.0..2.0).contains(v)), "{round}: {samples:?}");
            let end = bench.ends::<f32>(1000).unwrap_or(usize::MAX);
            assert!(samples[end..].iter().all(|v| v.to_bits() == 0), "{round}");
            let error = bench.band_error_db::<f32>(1000, 64);
            assert!(error < -64.0, "{round}: {error}");
        }
    }
}
