//! The beats of a clock from outside, and when they fall.
//!
//! A MIDI clock says 24 times a beat that time has passed. Each message comes a little late or early, so a delay-locked loop of second order
//! (F. Adriaensen, "Using a DLL to filter time", Linux Audio Conference 2005) says where the beats are: its phase follows the messages,
//! which are counted, so that it never drifts away from the sender, and its period is smooth. A song from a file says where its beats are
//! beforehand.

use std::collections::VecDeque;
use std::f64::consts::{SQRT_2, TAU};

/// Clocks a beat: MIDI 1.0 Detailed Specification, "Timing Clock".
pub(super) const CLOCKS: f64 = 24.0;

/// Bandwidth of the loop, Hz, and in its first beat.
const BANDWIDTH: f64 = 0.8;
const EAGER: f64 = 4.0;

/// Off by more clocks than this, the loop begins anew: the sender has jumped, or messages came late all at once.
const LOST: f64 = 2.5;

/// Clocks that are remembered, by which a loop that begins anew knows the period; and a pause, in seconds, behind which none before counts.
const KNOWN: usize = 13;
const PAUSE: f64 = 2.0 * PERIODS[1];

/// A clock that is this long overdue, in clocks, has stopped by itself: nothing is played beyond.
const TRUSTED: f64 = 24.0;

/// Seconds from one clock to the next: from 1,000 to 10 beats a minute.
const PERIODS: [f64; 2] = [0.0025, 0.25];

/// When beats fall.
#[derive(Debug, Clone, Default)]
pub(super) enum Beats {
    /// Nobody says.
    #[default]
    None,
    /// A clock does, as it comes.
    Clock(Clock),
    /// A song does: from these seconds on, at this beat, so many beats a second; and when it ends.
    Song(Vec<(f64, f64, f64)>, f64),
}

/// A clock that comes.
#[derive(Debug, Clone, Default)]
pub(super) struct Clock {
    /// Whether the song runs.
    running: bool,
    /// Whether no clock has come since it does. The sender may have stopped its clocks meanwhile, so until then nobody knows when its
    /// beats are.
    awaited: bool,
    /// When it was told to, seconds.
    told: f64,
    /// Clocks since the beginning of the song, up to the one that comes next.
    count: f64,
    /// When that is expected, seconds; `None` before the first.
    next: Option<f64>,
    /// Seconds from one to the next; 0 before it is known.
    period: f64,
    /// Clocks since the loop began.
    age: u32,
    /// When the last ones came.
    came: VecDeque<f64>,
}

impl Clock {
    /// A clock came at `now` seconds.
    pub fn tick(&mut self, now: f64) {
        if self.came.back().is_some_and(|last| now - last > PAUSE) {
            self.came.clear();
        }
        if self.came.len() == KNOWN {
            self.came.pop_front();
        }
        self.came.push_back(now);
        match self.next {
            Some(next) if self.age > 1 && (now - next).abs() <= LOST * self.period => {
                let late = now - next;
                let bandwidth = if f64::from(self.age) < CLOCKS { EAGER } else { BANDWIDTH };
                // Natural frequency in radians a clock; below 0.3 it is well damped.
                let omega = (TAU * bandwidth * self.period).min(0.3);
                self.next = Some(next + SQRT_2 * omega * late + self.period);
                self.period = (self.period + omega * omega * late).clamp(PERIODS[0], PERIODS[1]);
            }
            _ => {
                // The mean of what is known; after a pause it goes on at the tempo that it had, until the next one tells.
                if let (Some(first), more @ 1..) = (self.came.front(), self.came.len() - 1) {
                    self.period = ((now - first) / more as f64).clamp(PERIODS[0], PERIODS[1]);
                }
                self.next = Some(now + self.period);
                self.age = if self.period > 0.0 { 2 } else { 0 };
            }
        }
        self.age = self.age.saturating_add(1);
        if self.running {
            self.count += 1.0;
            self.awaited = false;
        }
    }

    /// The song plays on from so many beats, with the clock that comes next; so it is told at `now` seconds.
    pub fn run(&mut self, beats: f64, now: f64) {
        (self.running, self.awaited, self.count, self.told) = (true, true, beats * CLOCKS, now);
    }

    /// The song stops. Gives where it stands if it ran.
    pub fn stop(&mut self) -> Option<f64> {
        std::mem::take(&mut self.running).then_some(self.count / CLOCKS)
    }

    /// Whether the song runs, and its clocks still come, or may yet.
    pub fn runs(&self, now: f64) -> bool {
        let overdue = TRUSTED * if self.period > 0.0 { self.period } else { PERIODS[1] };
        let due = if self.awaited { self.told } else { self.next.unwrap_or(self.told) };
        self.running && now - due <= overdue
    }

    /// When a beat falls, and how many there are a second; `usual` where nothing is known of that yet.
    fn at(&self, beat: f64, usual: f64) -> Option<(f64, f64)> {
        let next = self.next.filter(|_| self.running && !self.awaited)?;
        let period = if self.period > 0.0 { self.period } else { 1.0 / (CLOCKS * usual) };
        // With one clock only, the next is expected where it was.
        let next = if self.age == 1 { next + period } else { next };
        let clocks = beat * CLOCKS - self.count;
        (clocks < TRUSTED).then(|| (next + clocks * period, 1.0 / (CLOCKS * period)))
    }
}

impl Beats {
    /// Of a song that begins after `lead` seconds: where its tempo changes, in its own seconds, and what to, in beats a minute; 120 until
    /// then. It ends at its `seconds`.
    pub fn of_song(tempi: &[(f64, f64)], seconds: f64, lead: f64) -> Self {
        let first = (lead, 0.0, 2.0);
        let mut map = vec![first];
        for &(at, tempo) in tempi {
            let at = lead + at;
            let &(from, beat, speed) = map.last().unwrap_or(&first);
            let tempo = tempo.clamp(1.0, 10_000.0) / 60.0;
            if at <= from {
                map.pop();
                map.push((from, beat, tempo));
            } else {
                map.push((at, beat + (at - from) * speed, tempo));
            }
        }
        Self::Song(map, lead + seconds)
    }

    /// The clock that comes, made if there was none.
    pub fn clock(&mut self) -> &mut Clock {
        if !matches!(self, Self::Clock(_)) {
            *self = Self::Clock(Clock::default());
        }
        match self {
            Self::Clock(clock) => clock,
            _ => unreachable!("it was made"),
        }
    }

    /// When a beat falls, in seconds, and how many there are a second; `usual` where a clock has not said that yet. `None` where that is
    /// not known: nobody counts, the song stands, or its clocks have stopped coming.
    pub fn at(&self, beat: f64, usual: f64) -> Option<(f64, f64)> {
        match self {
            Self::None => None,
            Self::Clock(clock) => clock.at(beat, usual),
            Self::Song(map, seconds) => {
                let step = map.partition_point(|(_, from, _)| *from <= beat).saturating_sub(1);
                let &(at, from, speed) = map.get(step)?;
                Some((at + (beat - from) / speed, speed)).filter(|(at, _)| at < seconds)
            }
        }
    }

    /// The same where its clocks still come, or may yet.
    pub fn runs(&self, seconds: f64) -> Option<f64> {
        match self {
            Self::Clock(clock) if !clock.runs(seconds) => None,
            _ => self.beat(seconds),
        }
    }

    /// The beat that falls at `seconds`, where the song runs.
    pub fn beat(&self, seconds: f64) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Clock(clock) => {
                if !clock.running {
                    return None;
                }
                let Some(next) = clock.next.filter(|_| !clock.awaited) else {
                    return Some(clock.count / CLOCKS);
                };
                let period = clock.period;
                let ahead = if period > 0.0 { (seconds - next) / period } else { 0.0 };
                Some(((clock.count + ahead) / CLOCKS).max(0.0))
            }
            Self::Song(map, _) => {
                let step = map.partition_point(|(at, ..)| *at <= seconds).saturating_sub(1);
                let &(at, from, speed) = map.get(step)?;
                Some(from + (seconds - at) * speed)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Beats, CLOCKS};
    use proptest::prelude::{ProptestConfig, prop_assert, proptest};

    #[test]
    fn the_map_of_a_song_is_the_integral_of_its_tempo() {
        // 60 a minute for two seconds, then 120, then 30.
        let beats = Beats::of_song(&[(0.0, 60.0), (2.0, 120.0), (4.0, 30.0)], 10.0, 0.0);
        for (beat, seconds, speed) in
            [(0.0, 0.0, 1.0), (1.5, 1.5, 1.0), (2.0, 2.0, 2.0), (5.0, 3.5, 2.0), (7.0, 6.0, 0.5)]
        {
            assert_eq!(beats.at(beat, 2.0), Some((seconds, speed)));
            assert_eq!(beats.beat(seconds), Some(beat));
        }
        assert_eq!(beats.at(9.5, 2.0), None, "it has ended");
        assert_eq!(
            Beats::of_song(&[], 10.0, 0.0).at(3.0, 1.0),
            Some((1.5, 2.0)),
            "120 where nothing is said"
        );
    }

    #[test]
    fn an_exact_clock_is_followed_exactly() {
        let mut beats = Beats::None;
        for (beat, at) in [(0.0, 1.0), (0.5, 1.25)] {
            assert_eq!((beats.at(beat, 2.0), at > 0.0), (None, true));
        }
        beats.clock().run(0.0, 0.0);
        assert_eq!(beats.at(0.0, 2.0), None, "before the first clock");
        for n in 0..200 {
            beats.clock().tick(1.0 + f64::from(n) * 0.5 / CLOCKS);
            let beat = f64::from(n / 12) / 2.0 + 0.5;
            let (at, speed) = beats.at(beat, 2.0).unwrap();
            assert!((at - 1.0 - 0.5 * beat).abs() < 1e-9 && (speed - 2.0).abs() < 1e-6, "{n}: {at}");
        }
        // Clocks that come no more: a beat is trusted, and no more than that.
        let now = 199.0 / CLOCKS;
        assert!(beats.at(now + 0.9, 2.0).is_some() && beats.at(now + 1.1, 2.0).is_none());
        let stood = beats.clock().stop().unwrap();
        assert!((stood - 200.0 / CLOCKS).abs() < 1e-12);
        assert_eq!((beats.at(9.0, 2.0), beats.clock().stop()), (None, None), "it stands already");
    }

    /// A sender that sends no clocks while its song stands: the loop knows its tempo still, and not when it goes on.
    #[test]
    fn after_a_pause_the_first_clock_says_when() {
        let mut beats = Beats::None;
        beats.clock().run(0.0, 0.0);
        let clocks = |beats: &mut Beats, from: f64| {
            (0..36).for_each(|n| beats.clock().tick(from + f64::from(n) * 0.5 / CLOCKS));
        };
        clocks(&mut beats, 1.0);
        beats.clock().stop();
        for (from, begin) in [(20.0, 0.0), (40.0, 2.5)] {
            beats.clock().run(begin, 0.0);
            assert_eq!((beats.at(begin, 2.0), beats.beat(from)), (None, Some(begin)));
            beats.clock().tick(from);
            let (at, speed) = beats.at(begin + 0.5, 2.0).unwrap();
            assert!((at - from - 0.25).abs() < 1e-3 && (speed - 2.0).abs() < 1e-3, "{at} and {speed}");
        }
        assert!(beats.clock().runs(40.4) && !beats.clock().runs(41.0), "its clocks have stopped");
    }

    #[test]
    fn a_new_tempo_is_followed_within_two_seconds() {
        for (before, after) in [(120.0, 90.0), (90.0, 180.0), (60.0, 200.0), (200.0, 60.0)] {
            let (mut beats, mut now, mut n) = (Beats::None, 0.0, 0.0);
            beats.clock().run(0.0, 0.0);
            while now < 6.0 {
                beats.clock().tick(now);
                if now > 5.0 {
                    // The next beat, as it will be.
                    let beat = (n / CLOCKS + 1.0_f64).floor();
                    let due = now + (beat * CLOCKS - n) * 60.0 / after / CLOCKS;
                    let (at, _) = beats.at(beat, 2.0).unwrap();
                    assert!((at - due).abs() < 0.004, "{before} to {after}: {at} for {due}");
                }
                now += 60.0 / CLOCKS / if now < 3.0 { before } else { after };
                n += 1.0;
            }
        }
    }

    /// Whatever has come before: clocks that stood still and came all at once, two at a time with every period of a server, a tempo that is another by
    /// far, a first that came twice.
    #[test]
    fn the_tempo_is_found_again_whatever_came_before() {
        let regular = |bpm: f64, from: f64| (0..1440).map(move |n| from + f64::from(n) * 60.0 / bpm / CLOCKS);
        let mut cases: Vec<(String, f64, Vec<f64>)> = Vec::new();
        for (before, after) in [(120.0, 34.0), (160.0, 45.0), (300.0, 20.0), (20.0, 300.0)] {
            let clocks = regular(before, 0.0).take(480).chain(regular(after, 480.0 * 60.0 / before / CLOCKS));
            cases.push((format!("{before} to {after}"), after, clocks.collect()));
        }
        for bpm in [30.0, 60.0, 90.0, 120.0, 180.0] {
            for stall in [0.1, 0.3, 0.5, 1.0, 2.0] {
                let late = |at: f64| if (5.003..5.003 + stall).contains(&at) { 5.003 + stall } else { at };
                cases.push((format!("{bpm}, {stall} s late"), bpm, regular(bpm, 0.0).map(late).collect()));
            }
            for first in [0.0, 0.002, 0.0058] {
                let clocks = std::iter::once(0.0).chain(regular(bpm, first));
                cases.push((format!("{bpm}, {first} s behind a first"), bpm, clocks.collect()));
            }
            for period in [0.001, 1024.0 / 48_000.0, 2048.0 / 48_000.0] {
                let quantised = |at: f64| ((at + 0.013) / period).ceil() * period;
                cases.push((
                    format!("{bpm}, every {period} s"),
                    bpm,
                    regular(bpm, 0.0).map(quantised).collect(),
                ));
            }
        }
        for (what, bpm, clocks) in cases {
            let mut beats = Beats::None;
            beats.clock().run(0.0, 0.0);
            clocks.iter().for_each(|at| beats.clock().tick(*at));
            let (_, speed) = beats.at(clocks.len() as f64 / CLOCKS, 2.0).unwrap();
            assert!((60.0 * speed / bpm - 1.0).abs() < 0.1, "{what}: {} a minute", 60.0 * speed);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn jitter_is_smoothed_and_nothing_drifts(
            jitter in proptest::collection::vec(-0.002_f64..0.002, 480),
            bpm in 60.0_f64..180.0,
        ) {
            let mut beats = Beats::None;
            beats.clock().run(0.0, 0.0);
            let (mut worst, mut energy, mut count) = (0.0_f64, 0.0, 0.0);
            for (n, j) in jitter.iter().enumerate() {
                let due = 1.0 + n as f64 * 60.0 / bpm / CLOCKS;
                beats.clock().tick(due + j);
                if n >= 96 {
                    let (at, _) = beats.at((n + 1) as f64 / CLOCKS, 2.0).unwrap_or_default();
                    let off = at - due - 60.0 / bpm / CLOCKS;
                    (worst, energy, count) = (worst.max(off.abs()), energy + off * off, count + 1.0);
                }
            }
            // Two milliseconds to either side, 1.15 in the mean square, become half of that; the worst may be a little more than it was.
            let mean = f64::sqrt(energy / count);
            prop_assert!(worst < 0.003 && mean < 0.0008, "{} and {} at {}", worst, mean, bpm);
        }
    }
}
