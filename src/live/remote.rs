//! A knob that another thread talks to: its angle is heard as an input is, its torque goes back.
//!
//! Two cells hold the newest of each, and neither side ever waits for the other. What goes back is torque over the angle near where the knob is
//! ([`Profile`]), so that the line's thread gives that of the angle it has just read ([`local`](super::local)). It carries the time of the
//! angle that it was made of. One that is older than was allowed for is none: so whatever stops, the line, the callback or a thread, torque does not outlast it.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::intake::Hearing;
use super::local::{Bounds, Count, Counts, Local, Told};
use super::stamp::nanoseconds;
use crate::knob::angle::decoder::NOT_HEARD;
use crate::knob::local_model::link::{Cell, Seen};
use crate::knob::local_model::profile::Profile;

#[derive(Debug, Default)]
struct Shared {
    /// Nanoseconds and angle, written by the line's thread.
    angle: Cell,
    /// Nanoseconds of the angle, and the torques that it gave, written by the callback.
    torque: Cell<{ Told::WORDS }>,
    /// Nanoseconds of the angle that the callback hears, 0: none; and that angle.
    heard: AtomicU64,
    heard_at: AtomicU64,
    /// Whether torque came too late at the line's end, and whether it is wanted at all.
    late: AtomicBool,
    wanted: AtomicBool,
    /// How often torque was so many [`STEP`]s older than its angle when it was written; the last place is for all that were older.
    ages: Ages,
    /// The same of the angle that the torque was taken of from a profile.
    local_ages: Ages,
    counts: Counts,
}

/// How finely ages are told apart, nanoseconds, and into how many steps.
const STEP: u64 = 50_000;
const STEPS: usize = 2000;

#[derive(Debug)]
struct Ages([AtomicU64; STEPS]);

impl Default for Ages {
    fn default() -> Self {
        Self([const { AtomicU64::new(0) }; STEPS])
    }
}

impl Ages {
    fn note(&self, age: Option<u64>) {
        let place = age.map(|age| usize::try_from(age / STEP).unwrap_or(STEPS).min(STEPS - 1));
        if let Some(count) = place.and_then(|place| self.0.get(place)) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn within(&self, share: f64) -> Option<f64> {
        let ages = || self.0.iter().map(|count| count.load(Ordering::Relaxed));
        let wanted = share * ages().sum::<u64>() as f64;
        let mut sum = 0;
        let place = ages().position(|count| {
            sum += count;
            sum > 0 && sum as f64 >= wanted
        })?;
        (place + 1 < STEPS).then(|| ((place as u64 + 1) * STEP) as f64 * 1e-9)
    }
}

/// How late torque was written, as long as a knob was on its line.
#[derive(Debug, Clone)]
pub struct Lateness(Arc<Shared>);

impl Lateness {
    /// Seconds within which the given share of torques was written after their angles were read, to 0.05 ms; `None`: none was, or they took
    /// more than 0.1 s.
    pub fn within(&self, share: f64) -> Option<f64> {
        self.0.ages.within(share)
    }

    /// The same of the angle of which the line's own thread made it.
    pub fn local_within(&self, share: f64) -> Option<f64> {
        self.0.local_ages.within(share)
    }

    /// What became of the profiles that were sent.
    pub fn profiles(&self) -> Count {
        self.0.counts.now()
    }
}

/// The end of the thread that talks to the knob.
#[derive(Debug)]
pub struct Line {
    shared: Arc<Shared>,
    /// The oldest that an angle may be when its torque is there, nanoseconds.
    oldest: u64,
    local: Local,
    /// When it was read last, and what: angle and speed.
    read: Option<(u64, [f64; 2])>,
    /// How old the torque was that was asked for last, nanoseconds; and the angle that it was taken of.
    age: Option<u64>,
    local_age: Option<u64>,
}

/// The callback's end: what it hears.
pub struct Heard {
    shared: Arc<Shared>,
    /// The oldest that an angle may be when it is heard, nanoseconds.
    oldest: u64,
    amplitude: f64,
    channels: [usize; 2],
    /// What is heard on all other channels.
    beside: Option<Box<dyn Hearing>>,
    seen: Seen,
    /// The angle at the end of the last block.
    before: Option<f64>,
}

/// The callback's end: what it gives.
#[derive(Debug)]
pub struct Given {
    shared: Arc<Shared>,
    /// How often it did.
    sent: u64,
}

/// Whole nanoseconds of so many seconds.
fn whole(seconds: f64) -> u64 {
    (seconds * 1e9).clamp(0.0, 1e18) as u64
}

/// Both ends of a knob that may take `allowance` seconds from an angle to its torque, and `patience` until the next angle. It is heard as
/// sine and cosine of `amplitude` on two `channels`, and its line keeps to `bounds`.
pub fn remote(
    allowance: f64,
    patience: f64,
    amplitude: f64,
    channels: [usize; 2],
    bounds: Bounds,
) -> (Heard, Line) {
    let shared = Arc::<Shared>::default();
    let line = Line {
        shared: Arc::clone(&shared),
        oldest: whole(allowance),
        local: Local::new(bounds),
        read: None,
        age: None,
        local_age: None,
    };
    let oldest = whole(patience);
    let heard =
        Heard { shared, oldest, amplitude, channels, beside: None, seen: Seen::default(), before: None };
    (heard, line)
}

impl Line {
    /// The angle, radians, read just now, and the speed with it, rad/s.
    pub fn put(&mut self, angle: f64, speed: f64) {
        self.put_at(nanoseconds(), angle, speed);
    }

    fn put_at(&mut self, now: u64, angle: f64, speed: f64) {
        self.read = Some((now, [angle, speed]));
        // 0 stands for none.
        self.shared.angle.write(&Seen { tick: now.max(1), angle, ..Seen::default() });
    }

    /// There is no angle any more.
    pub fn lose(&mut self) {
        self.read = None;
        self.shared.angle.write(&Seen::default());
    }

    /// The torque to give now, N m.
    pub fn torque(&mut self) -> f64 {
        self.torque_at(nanoseconds())
    }

    fn torque_at(&mut self, now: u64) -> f64 {
        // While it is being written it is the one before.
        if let Some(words) = self.shared.torque.read_words() {
            self.local.take(&Told::of_words(&words), &self.shared.counts);
        }
        let Told { stamp, profile, .. } = *self.local.told();
        self.age = (stamp != 0).then(|| now.saturating_sub(stamp));
        let late = stamp == 0 || now.saturating_sub(stamp) > self.oldest;
        // Before the first there is nothing to be late.
        self.shared.late.store(late && stamp != 0, Ordering::Relaxed);
        self.local_age = self.read.filter(|_| !profile.is_flat()).map(|(then, _)| now.saturating_sub(then));
        match self.read {
            Some((_, [angle, speed])) if !late => self.local.torque(now, angle, speed, &self.shared.counts),
            read => {
                let angle = read.map_or(f64::NAN, |(_, [angle, _])| angle);
                self.local.nothing(now, angle, &self.shared.counts)
            }
        }
    }

    /// Counts how old the torque was that was asked for last: it is written now.
    pub fn note(&self) {
        self.shared.ages.note(self.age);
        self.shared.local_ages.note(self.local_age);
    }

    /// How late it is written.
    pub fn lateness(&self) -> Lateness {
        Lateness(Arc::clone(&self.shared))
    }

    /// Whether somebody wants torque, and nothing has taken it away.
    pub fn is_wanted(&self) -> bool {
        self.shared.wanted.load(Ordering::Relaxed)
    }
}

impl Heard {
    /// What the callback gives back.
    pub fn given(&self) -> Given {
        Given { shared: Arc::clone(&self.shared), sent: 0 }
    }

    /// What `other` hears is heard as well, on the channels before those of the knob.
    pub fn beside(self, other: Box<dyn Hearing>) -> Self {
        Self { beside: Some(other), ..self }
    }

    /// The first of its channels, from 0.
    pub fn first(&self) -> usize {
        let [a, b] = self.channels;
        a.min(b)
    }

    fn hear_at(&mut self, now: u64, due: f64, channels: usize, frames: &mut [f32]) {
        match &mut self.beside {
            Some(other) => other.hear(due, channels, frames),
            None => frames.fill(0.0),
        }
        self.seen = self.shared.angle.read().unwrap_or(self.seen);
        let Seen { tick, angle, .. } = self.seen;
        let channels = channels.max(1);
        let put = |frame: &mut [f32], values: [f32; 2]| {
            for (channel, value) in self.channels.into_iter().zip(values) {
                if let Some(slot) = frame.get_mut(channel) {
                    *slot = value;
                }
            }
        };
        if tick == 0 || now.saturating_sub(tick) > self.oldest || !angle.is_finite() {
            self.before = None;
            self.shared.heard.store(0, Ordering::Relaxed);
            frames.chunks_exact_mut(channels).for_each(|frame| put(frame, [NOT_HEARD; 2]));
            return;
        }
        self.shared.heard.store(tick, Ordering::Relaxed);
        self.shared.heard_at.store(angle.to_bits(), Ordering::Relaxed);
        // Straight from one reading to the next, so that speeds are no steps.
        let from = self.before.replace(angle).unwrap_or(angle);
        let count = (frames.len() / channels) as f64;
        for (n, frame) in frames.chunks_exact_mut(channels).enumerate() {
            let (sine, cosine) = (from + (angle - from) * (n + 1) as f64 / count).sin_cos();
            put(frame, [sine, cosine].map(|value| (self.amplitude * value) as f32));
        }
    }
}

impl Hearing for Heard {
    fn hear(&mut self, due: f64, channels: usize, frames: &mut [f32]) {
        self.hear_at(nanoseconds(), due, channels, frames);
    }

    /// Its own are filled here.
    fn mark(&mut self, _channels: &[usize]) {}
}

impl Given {
    /// The torques that came of what is heard now.
    pub fn put(&mut self, profile: &Profile, wanted: bool) {
        self.sent += 1;
        let stamp = self.shared.heard.load(Ordering::Relaxed);
        let heard = f64::from_bits(self.shared.heard_at.load(Ordering::Relaxed));
        self.shared.wanted.store(wanted, Ordering::Relaxed);
        let told = Told { number: self.sent, stamp, heard, profile: *profile };
        self.shared.torque.write_words(&told.words());
    }

    /// How many were sent.
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// Whether what was given came in time.
    pub fn in_time(&self) -> bool {
        !self.shared.late.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::{Bounds, Heard, Line, NOT_HEARD};
    use crate::knob::local_model::profile::Profile;
    use crate::knob::safety::budget::Budget;

    fn remote(allowance: f64, patience: f64, amplitude: f64, channels: [usize; 2]) -> (Heard, Line) {
        let budget = Budget::new(1e3, 12.0, 1.0, 1e-3).unwrap();
        let bounds = Bounds { slew: 1e3, over_speed: 60.0, inverted: false, budget };
        super::remote(allowance, patience, amplitude, channels, bounds)
    }

    const MS: u64 = 1_000_000;

    /// Frames that were heard, as angles; `None`: not heard.
    fn angles(frames: &[f32]) -> Vec<Option<f64>> {
        let of = |frame: &[f32]| match frame[1] {
            NOT_HEARD => None,
            _ => Some(f64::from(frame[0]).atan2(f64::from(frame[1]))),
        };
        frames.chunks(2).map(of).collect()
    }

    #[test]
    fn an_angle_is_heard_straight_from_the_one_before_and_no_longer_than_patience_lasts() {
        let (mut heard, mut line) = remote(0.01, 0.004, 0.5, [0, 1]);
        let mut hear = |now: u64| {
            let mut frames = [0.0; 8];
            heard.hear_at(now * MS, 0.0, 2, &mut frames);
            angles(&frames)
        };
        assert_eq!(hear(1), [None; 4], "nothing was read yet");
        line.put_at(2 * MS, 0.2, 0.0);
        let near = |got: Vec<Option<f64>>, want: [f64; 4]| {
            got.iter().zip(want).all(|(got, want)| got.is_some_and(|got| (got - want).abs() < 1e-6))
        };
        assert!(near(hear(3), [0.2; 4]));
        line.put_at(4 * MS, 0.6, 0.0);
        assert!(near(hear(5), [0.3, 0.4, 0.5, 0.6]));
        assert!(near(hear(8), [0.6; 4]));
        assert_eq!(hear(9), [None; 4], "5 ms old");
        line.put_at(10 * MS, 1.0, 0.0);
        // Where it was lost it begins anew.
        assert!(near(hear(10), [1.0; 4]));
        line.lose();
        assert_eq!(hear(10), [None; 4]);
        line.put_at(11 * MS, f64::NAN, 0.0);
        assert_eq!(hear(11), [None; 4]);
    }

    #[test]
    fn no_torque_outlasts_the_angle_that_it_was_made_of() {
        let (mut heard, mut line) = remote(0.01, 0.004, 0.5, [0, 1]);
        let mut given = heard.given();
        assert_eq!((line.torque_at(0), given.in_time(), line.is_wanted()), (0.0, true, false));
        line.put_at(5 * MS, 0.2, 0.0);
        heard.hear_at(6 * MS, 0.0, 2, &mut [0.0; 8]);
        // One that comes meanwhile is not the one that was heard.
        line.put_at(7 * MS, 0.3, 0.0);
        given.put(&Profile::flat(0.03), true);
        assert_eq!((line.torque_at(15 * MS), given.in_time(), line.is_wanted()), (0.03, true, true));
        assert_eq!((line.torque_at(16 * MS), given.in_time()), (0.0, false));
        heard.hear_at(10 * MS, 0.0, 2, &mut [0.0; 8]);
        given.put(&Profile::flat(f64::NAN), true);
        assert_eq!((line.torque_at(16 * MS), given.in_time()), (0.0, true), "it is no number");
        // What was made of nothing is none, and not late.
        heard.hear_at(30 * MS, 0.0, 2, &mut [0.0; 8]);
        given.put(&Profile::flat(0.02), false);
        assert_eq!((line.torque_at(30 * MS), given.in_time(), line.is_wanted()), (0.0, true, false));
    }

    #[test]
    fn how_late_torque_is_written_is_counted() {
        let (mut heard, mut line) = remote(0.01, 1.0, 0.5, [0, 1]);
        let (mut given, lateness) = (heard.given(), line.lateness());
        line.note();
        assert_eq!(lateness.within(1.0), None, "none was written");
        for (count, late) in [(90, 2), (9, 3), (1, 150)] {
            for _ in 0..count {
                line.put_at(5 * MS, 0.2, 0.0);
                heard.hear_at(6 * MS, 0.0, 2, &mut [0.0; 8]);
                given.put(&Profile::flat(0.03), true);
                line.torque_at((5 + late) * MS);
                line.note();
            }
        }
        let within =
            [0.0, 0.9, 0.99, 0.991].map(|share| lateness.within(share).map(|s| (1e5 * s).round() as u32));
        // To the next 0.05 ms; what takes longer than 0.1 s is told as nothing.
        assert_eq!(within, [Some(205), Some(205), Some(305), None]);
    }

    /// Counts on every channel, and says when it was due.
    struct Counting;

    impl super::Hearing for Counting {
        fn hear(&mut self, due: f64, channels: usize, frames: &mut [f32]) {
            assert_eq!((due, channels), (0.25, 5));
            frames.iter_mut().enumerate().for_each(|(n, slot)| *slot = n as f32);
        }

        fn mark(&mut self, _channels: &[usize]) {}
    }

    #[test]
    fn what_a_card_hears_is_heard_beside_it_whether_it_is_there_or_not() {
        let (heard, mut line) = remote(0.01, 0.004, 0.5, [3, 4]);
        let mut heard = heard.beside(Box::new(Counting));
        assert_eq!(heard.first(), 3);
        let mut frames = [0.0; 10];
        heard.hear_at(MS, 0.25, 5, &mut frames);
        assert_eq!(frames, [0.0, 1.0, 2.0, NOT_HEARD, NOT_HEARD, 5.0, 6.0, 7.0, NOT_HEARD, NOT_HEARD]);
        line.put_at(2 * MS, 0.0, 0.0);
        heard.hear_at(3 * MS, 0.25, 5, &mut frames);
        assert_eq!(frames, [0.0, 1.0, 2.0, 0.0, 0.5, 5.0, 6.0, 7.0, 0.0, 0.5]);
    }
}
