//! Which frame of the output belongs to which moment of wall time.
//!
//! A callback comes when the system gets round to it: a little late, or much. The frames it asks for do not jitter, so a delay-locked
//! loop (F. Adriaensen, "Using a DLL to filter time", Linux Audio Conference 2005) follows when callbacks would come if they came
//! evenly. An event that arrives between two callbacks is played as many frames into the next block as it arrived after the first,
//! so that the jitter of callbacks and the length of a block become one constant latency: [`Moment::ahead`]. That holds as much besides as
//! callbacks have come early, or what arrives just after such a one would be asked for before its time.

#![deny(clippy::disallowed_methods)]

use std::f64::consts::{SQRT_2, TAU};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering, fence};

use super::lately::Lately;
use super::stamp::Stamp;

/// Bandwidth of the loop, Hz, once it is settled. It follows the drift of a converter's clock, and averages so many callbacks that blocks
/// of 64 which come at any moment of their time move the phase by some 6 us (root mean square), a twentieth of an engine sample.
const BANDWIDTH: f64 = 0.03;

/// The same for the first moments, in which the loop finds its phase.
const EAGER: f64 = 8.0;

/// In between it falls as the loop ages, this many Hz after a second: about what the straight line through all callbacks so far would
/// give the last of them (of N callbacks 4 / N, which is the loop's square root of 2 times 2 pi times the bandwidth over theirs).
const NARROWING: f64 = 0.45;

/// From this age on, in seconds and in callbacks, the phase is known well enough to tell by how much a callback is early.
const FOUND: f64 = 0.25;
const FOUND_BLOCKS: f64 = 16.0;

/// A callback that is further off than this, in seconds and in blocks, begins the loop anew: the device stood still. Servers of large
/// blocks ask for two at once.
const LOST: f64 = 0.02;
const LOST_BLOCKS: f64 = 1.5;

/// A device that has gone on from elsewhere, and has not said so, is followed there: by what all callbacks of so long were off the same way,
/// if there were so many, where that is more than this, in seconds. Neither chance nor a short load makes the same of uneven ones.
const MOVED: f64 = 0.25;
const MOVED_BLOCKS: usize = 32;
const AWAY: f64 = 2e-4;

/// Seconds that an event may take from where it arrives to where the callback finds it, or it would be late where it arrives just before one.
pub const HASTE: f64 = 6e-5;

/// No callback yet, at the age of 0.
const NONE: (f64, f64, usize, f64) = (f64::INFINITY, f64::NEG_INFINITY, 0, 0.0);

/// The loop, on the audio thread.
#[derive(Debug)]
pub struct Follower {
    rate: f64,
    /// Frames asked for before the callback that is at hand.
    frames: u64,
    /// When that callback should come, and seconds a frame.
    next: f64,
    frame: f64,
    /// When the callback at hand should have come.
    due: f64,
    /// Seconds since the loop began.
    age: f64,
    /// What an event may take to the callback, the longest block, and the most by which a callback has come early, in frames. A device whose callbacks
    /// come otherwise than before, and which did not say so, has its latency back after a while.
    haste: u64,
    longest: Lately,
    lead: Lately,
    /// How long the device has played by now, gaps or not, in seconds.
    played: f64,
    /// The least and the most by which callbacks were late, in seconds, how many there were, and since which age.
    off: (f64, f64, usize, f64),
    running: bool,
    face: Arc<Face>,
}

/// What the loop shows to other threads: a sequence lock, whose writer never waits.
#[derive(Debug, Default)]
struct Face {
    turn: AtomicU64,
    frames: AtomicU64,
    time: AtomicU64,
    frame: AtomicU64,
    ahead: AtomicU64,
}

/// Shows other threads how frames and wall time belong together.
#[derive(Debug, Clone)]
pub struct StreamClock(Arc<Face>);

/// How frames and wall time belonged together at the last callback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Frames asked for before that callback.
    pub frames: u64,
    /// When it should have come, seconds since the session began.
    pub time: f64,
    /// Seconds a frame, as the device has it.
    pub frame: f64,
    /// Frames by which events are played later than they arrive: the longest block of late, the most by which a callback has come early,
    /// and [`HASTE`].
    pub ahead: u64,
}

impl Moment {
    /// The frame at which an event is played that arrived at `stamp`, or is meant for then, where it is `now`. Time that has passed while the device
    /// stood still does not count: what arrives then is played when it goes on, which nobody knows beforehand.
    pub fn frame_of(&self, stamp: Stamp, now: Stamp) -> f64 {
        let most = (LOST / self.frame).max(LOST_BLOCKS * self.ahead as f64);
        let (come, to_come) = (stamp.min(now).seconds() - self.time, stamp.seconds() - now.seconds());
        let since = (come / self.frame).min(most) + to_come.max(0.0) / self.frame;
        (self.frames as f64 + self.ahead as f64 + since).max(0.0)
    }

    /// Seconds since the session began when the device asks for a frame, if its callbacks came evenly.
    pub fn time_of(&self, frame: f64) -> f64 {
        self.time + (frame - self.frames as f64) * self.frame
    }
}

impl Follower {
    /// For a device of `rate` frames a second that is expected to ask for blocks of `block` frames; both are found out as it runs.
    pub fn new(rate: f64, block: u64) -> (Self, StreamClock) {
        let haste = (HASTE * rate).ceil() as u64;
        let face = Arc::new(Face { ahead: AtomicU64::new(block + haste), ..Face::default() });
        let clock = StreamClock(Arc::clone(&face));
        let frame = 1.0 / rate;
        (
            Self {
                rate,
                frames: 0,
                next: 0.0,
                frame,
                due: 0.0,
                age: 0.0,
                haste,
                longest: Lately::new(block),
                lead: Lately::default(),
                played: 0.0,
                off: NONE,
                running: false,
                face,
            },
            clock,
        )
    }

    /// A callback came at `stamp` that asks for `frames`. Gives by how much it was late, in seconds.
    pub fn callback(&mut self, stamp: Stamp, frames: u64) -> f64 {
        let now = stamp.seconds();
        let late = now - self.next;
        let most = LOST.max(LOST_BLOCKS * self.longest.get() as f64 * self.frame);
        if !self.running || late.abs() > most {
            (self.running, self.next, self.frame) = (true, now, 1.0 / self.rate);
            (self.age, self.off) = (0.0, NONE);
        } else {
            // The loop's natural frequency in radians a callback; below 0.3 it is well damped.
            let block = frames.max(1) as f64 * self.frame;
            let bandwidth = (NARROWING / self.age).clamp(BANDWIDTH, EAGER);
            let omega = (TAU * bandwidth * block).min(0.3);
            self.next += SQRT_2 * omega * late;
            // No crystal is off by more than a thousandth.
            let frame = self.frame + omega * omega * late / frames.max(1) as f64;
            self.frame = frame.clamp(0.999 / self.rate, 1.001 / self.rate);
            if self.age >= FOUND.max(FOUND_BLOCKS * block) {
                let early = ((self.next - now) * self.rate).round().max(0.0);
                self.lead.hear(early as u64, self.played);
            }
            self.next += self.moved(late);
        }
        self.longest.hear(frames, self.played);
        self.show();
        self.due = self.next;
        self.frames += frames;
        let block = frames as f64 * self.frame;
        self.next += block;
        self.age += block;
        self.played += block;
        late
    }

    /// When the callback that is at hand should have come, seconds since the session began.
    pub fn due(&self) -> f64 {
        self.due
    }

    /// Seconds a frame, as the device has it.
    pub fn frame(&self) -> f64 {
        self.frame
    }

    /// The device left something out: the next callback begins the loop anew.
    pub fn restart(&mut self) {
        self.running = false;
    }

    /// So many frames were asked for and given: of a block that was to come, no more will be.
    pub fn gave(&mut self, frames: u64) {
        self.frames = frames;
    }

    /// The device was away: the next callback begins the loop anew, and its blocks may have another length and other times.
    pub fn forget(&mut self, block: u64) {
        (self.running, self.longest, self.lead) = (false, Lately::new(block), Lately::default());
        self.played = 0.0;
    }

    /// By how much the device has moved on, with a callback that was `late` by so much, seconds.
    fn moved(&mut self, late: f64) -> f64 {
        let (least, most, count, since) = self.off;
        let (least, most) = (least.min(late), most.max(late));
        self.off = (least, most, count + 1, since);
        if count + 1 < MOVED_BLOCKS || self.age - since < MOVED {
            return 0.0;
        }
        (self.off.0, self.off.1, self.off.2, self.off.3) = (NONE.0, NONE.1, NONE.2, self.age);
        let moved = least.max(0.0) + most.min(0.0);
        if moved.abs() <= AWAY {
            return 0.0;
        }
        if moved < 0.0 {
            // They were not early, but where they are now.
            self.lead.forget();
        }
        moved
    }

    fn show(&self) {
        let Face { turn, frames, time, frame, ahead } = &*self.face;
        let before = turn.load(Ordering::Relaxed);
        turn.store(before + 1, Ordering::Relaxed);
        fence(Ordering::Release);
        frames.store(self.frames, Ordering::Relaxed);
        time.store(self.next.to_bits(), Ordering::Relaxed);
        frame.store(self.frame.to_bits(), Ordering::Relaxed);
        ahead.store(self.longest.get() + self.lead.get() + self.haste, Ordering::Relaxed);
        turn.store(before + 2, Ordering::Release);
    }
}

impl StreamClock {
    /// How things stood at the last callback; `None` before the first. Not for the audio thread: it looks again where a callback
    /// came in between.
    pub fn moment(&self) -> Option<Moment> {
        loop {
            if self.0.turn.load(Ordering::Acquire) == 0 {
                return None;
            }
            let glimpse = self.glimpse();
            if glimpse.is_some() {
                return glimpse;
            }
            std::hint::spin_loop();
        }
    }

    /// [`Moment::ahead`]; before the first callback, what was expected.
    pub fn ahead(&self) -> u64 {
        self.0.ahead.load(Ordering::Relaxed)
    }

    /// As [`StreamClock::moment`], for the audio thread: `None` as well where a callback came in between.
    pub fn glimpse(&self) -> Option<Moment> {
        let Face { turn, frames, time, frame, ahead } = &*self.0;
        let before = turn.load(Ordering::Acquire);
        let moment = Moment {
            frames: frames.load(Ordering::Relaxed),
            time: f64::from_bits(time.load(Ordering::Relaxed)),
            frame: f64::from_bits(frame.load(Ordering::Relaxed)),
            ahead: ahead.load(Ordering::Relaxed),
        };
        fence(Ordering::Acquire);
        let whole = before != 0 && before.is_multiple_of(2) && turn.load(Ordering::Relaxed) == before;
        whole.then_some(moment)
    }
}

#[cfg(test)]
mod tests {
    use super::{Follower, Stamp};

    /// Numbers from 0 to 1 that look random.
    fn noise(n: u64) -> f64 {
        let n = (n ^ (n >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn stamp(seconds: f64) -> Stamp {
        Stamp((seconds * 1e9).round() as u64)
    }

    /// Callbacks of a card of `rate` whose blocks are `block` frames, each up to `jitter` seconds late.
    fn run(rate: f64, block: u64, jitter: f64, callbacks: u64) -> (Follower, super::StreamClock) {
        let (mut follower, clock) = Follower::new(48_000.0, block);
        for n in 0..callbacks {
            let due = 1.0 + (n * block) as f64 / rate;
            follower.callback(stamp(due + jitter * noise(n)), block);
        }
        (follower, clock)
    }

    #[test]
    fn jitter_is_averaged_and_drift_is_followed() {
        // A quarter of a millisecond of jitter, and a converter that is 80 millionths fast.
        let rate = 48_000.0 * 1.000_08;
        let (_, clock) = run(rate, 64, 250e-6, 30_000);
        let moment = clock.moment().unwrap();
        let due = 1.0 + moment.frames as f64 / rate + 125e-6;
        assert!((moment.time - due).abs() < 20e-6, "{} s off", moment.time - due);
        assert!((moment.frame * rate - 1.0).abs() < 60e-6, "{}", moment.frame * rate);
    }

    #[test]
    fn an_event_keeps_its_place_within_the_block() {
        let (_, clock) = run(48_000.0, 128, 0.0, 2000);
        let moment = clock.moment().unwrap();
        for offset in [0.0, 1.0, 63.5, 127.0] {
            let arrived = 1.0 + (moment.frames as f64 + offset) / 48_000.0;
            let played = moment.frame_of(stamp(arrived), stamp(arrived));
            // A block, and three frames.
            assert!((played - (moment.frames as f64 + 128.0 + 3.0 + offset)).abs() < 0.01, "{offset}");
        }
    }

    /// For a tenth of a second all come late, as something else has the machine: that is not where the device is. And a gap does not make
    /// forgotten that callbacks come early.
    #[test]
    fn neither_a_load_nor_a_gap_changes_the_latency() {
        let (mut follower, clock) = Follower::new(48_000.0, 64);
        let due = |n: u64| 1.0 + (n * 64) as f64 / 48_000.0;
        for n in 0..20_000 {
            let load = if (10_000..10_075).contains(&n) { 6e-4 } else { 0.0 };
            let late = if n == 5_000 { -5e-4 } else { load };
            follower.callback(stamp(due(n) + late), 64);
            if n > 5_000 {
                let moment = clock.moment().unwrap();
                assert!((moment.time - due(n)).abs() < 1e-4, "{n}: {}", moment.time - due(n));
            }
            if n == 6_000 {
                follower.restart();
            }
            if (5_001..12_000).contains(&n) {
                assert!(clock.ahead().abs_diff(64 + 3 + 24) <= 1, "{n}: {}", clock.ahead());
            }
        }
    }

    /// A gap that nobody has told of: from then on all comes later, or earlier.
    #[test]
    fn a_device_that_goes_on_from_elsewhere_is_followed() {
        for moved in [3e-3, 0.5e-3, -1e-3] {
            let (mut follower, clock) = Follower::new(48_000.0, 64);
            let due = |n: u64| 1.0 + (n * 64) as f64 / 48_000.0;
            // Up to 50 us late, as on a machine at rest.
            let late = |n: u64| (n * 7 % 11) as f64 * 5e-6;
            for n in 0..20_000 {
                follower.callback(stamp(due(n) + late(n)), 64);
            }
            for n in 20_000..20_000 + 400 {
                follower.callback(stamp(due(n) + late(n) + moved), 64);
            }
            let moment = clock.moment().unwrap();
            let off = moment.time - (due(20_000 + 400 - 1) + 25e-6 + moved);
            assert!(off.abs() < 5e-5, "{moved}: {off}");
        }
    }

    #[test]
    fn callbacks_that_came_early_once_are_forgotten_after_a_while() {
        let (mut follower, clock) = Follower::new(48_000.0, 64);
        let due = |n: u64| 1.0 + (n * 64) as f64 / 48_000.0;
        let mut before = 0;
        for n in 0..60_000 {
            // After 2.7 s by half a block, after 26.7 s by a little more: 0.8 ms.
            let early = match n {
                2_000 => 32.0 / 48_000.0,
                20_000 => 0.8e-3,
                _ => 0.0,
            };
            follower.callback(stamp(due(n) - early), 64);
            let more = clock.ahead() - 64 - 3;
            assert!(more + 1 >= before, "what comes later is played later");
            before = more;
            let expected = match n {
                ..2_000 => 0,
                // Until it is as old as twice the time before, 8 s, and then for half a minute at least.
                2_000..5_900 => 32,
                6_100..20_000 => 0,
                20_000..45_000 => 38,
                47_000.. => 0,
                _ => continue,
            };
            assert!(more.abs_diff(expected) <= 1, "{more} at {n}");
        }
        let (mut follower, clock) = Follower::new(48_000.0, 64);
        for n in 0..1_000 {
            follower.callback(stamp(due(n) - if n == 999 { 0.8e-3 } else { 0.0 }), 64);
        }
        assert!(clock.ahead() > 100);
        // Its next stream gets time anew.
        follower.forget(64);
        follower.callback(stamp(5.0), 64);
        assert_eq!(clock.ahead(), 64 + 3);
    }

    #[test]
    fn blocks_of_any_length_and_a_device_that_stood_still() {
        let (mut follower, clock) = Follower::new(48_000.0, 64);
        assert_eq!(clock.moment(), None);
        let mut frames = 0;
        for n in 0..5000 {
            let block = 111 + (noise(n) * 40.0) as u64;
            follower.callback(stamp(frames as f64 / 48_000.0), block);
            frames += block;
        }
        let moment = clock.moment().unwrap();
        assert!((moment.time - moment.frames as f64 / 48_000.0).abs() < 50e-6);
        assert!((148 + 3..=151 + 3).contains(&moment.ahead), "{}", moment.ahead);
        // Three seconds in which nobody asked for anything.
        let pause = frames as f64 / 48_000.0 + 3.0;
        assert!(follower.callback(stamp(pause), 128) > 2.9);
        assert!((clock.moment().unwrap().time - pause).abs() < 1e-9);
    }

    #[test]
    fn a_server_that_asks_for_two_blocks_at_once_stands_still_never() {
        let (mut follower, clock) = Follower::new(48_000.0, 2048);
        let block = 2048.0 / 48_000.0;
        for n in 0..400 {
            // The first of two comes when the second does.
            follower.callback(stamp(1.0 + (n | 1) as f64 * block), 2048);
        }
        // Half a block later than an even one would be, in the middle.
        let moment = clock.moment().unwrap();
        let due = 1.0 + moment.frames as f64 / 48_000.0 + 0.5 * block;
        assert!((moment.time - due).abs() < 0.15 * block, "{} s off", moment.time - due);
    }

    /// A server's first block may be a double one, and its blocks may become shorter.
    #[test]
    fn a_long_block_is_forgotten_after_a_while() {
        let (mut follower, clock) = Follower::new(48_000.0, 256);
        let (mut frames, mut before) = (0, 2048 + 3);
        for n in 0..20_000 {
            let block = if n == 0 { 2048 } else { 256 };
            follower.callback(stamp(1.0 + frames as f64 / 48_000.0), block);
            frames += block;
            assert!(clock.ahead() + 1 >= before, "what comes later is played later");
            before = clock.ahead();
            assert!(n > 90 || before > 1900, "{n}: {before}");
        }
        assert_eq!(before, 256 + 3);
    }

    /// Callbacks stop for seconds: what arrives then is played soon after they go on, and in order.
    #[test]
    fn what_arrives_while_the_device_stands_still_waits_for_no_longer() {
        let (mut follower, clock) = run(48_000.0, 128, 0.0, 2000);
        let stood = clock.moment().unwrap();
        let arrivals = (0..300).map(|n| stamp(stood.time + 0.01 * f64::from(n)));
        let frames: Vec<f64> = arrivals.map(|at| stood.frame_of(at, at)).collect();
        assert!(frames.is_sorted());
        let goes_on = stamp(stood.time + 3.0);
        follower.callback(goes_on, 128);
        let moment = clock.moment().unwrap();
        let latest = moment.frame_of(goes_on, goes_on) + 0.021 * 48_000.0;
        assert!(frames.iter().all(|frame| *frame <= latest), "{:?} {latest}", frames.last());
        // What was sent ahead of its time keeps it.
        let now = stamp(stood.time + 0.001);
        let ahead = stood.frame_of(stamp(stood.time + 0.101), now) - stood.frame_of(now, now);
        assert!((ahead - 0.1 * 48_000.0).abs() < 0.01, "{ahead}");
    }

    #[test]
    fn readers_never_see_half_of_it() {
        let (mut follower, clock) = Follower::new(48_000.0, 1);
        std::thread::scope(|scope| {
            let writer = scope.spawn(move || {
                // One frame a callback, on time: frames and time tell the same.
                for n in 0..300_000_u64 {
                    follower.callback(stamp(n as f64 / 48_000.0), 1);
                }
            });
            while !writer.is_finished() {
                if let Some(moment) = clock.moment() {
                    assert!((moment.time - moment.frames as f64 / 48_000.0).abs() < 5e-9, "{moment:?}");
                }
            }
        });
    }
}
