//! Whatever comes, a session neither panics nor grows.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use pacinian::io::knob::odrive::{ODrive, Settings};
use pacinian::io::knob::session::{Session, Turn};
use pacinian::io::knob::smartknob::{self, SmartKnob};
use proptest::collection::vec;
use proptest::prelude::{Strategy, any, prop_oneof};
use proptest::{prop_assert, proptest, test_runner::Config};

use crate::frames::{SEEN, frame, hex};
use crate::hand::Hand;

/// Counts the bytes that a thread holds.
struct Counting;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
}

fn count(by: isize) {
    // A thread that ends has no more counter.
    let _ = HELD.try_with(|held| held.set(held.get() + by));
}

// SAFETY: all is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn sessions() -> [Box<dyn Session>; 2] {
    let settings = smartknob::Settings { seed: 1, parting: None };
    [Box::new(ODrive::new(Settings::default()).unwrap()), Box::new(SmartKnob::new(settings).unwrap().0)]
}

/// Bytes that may be something: noise, right lines, right frames, and their pieces.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let lines: Vec<Vec<u8>> =
        ["0.1 0.2*35", "0*48", "8*56", "invalid property*41", "inf*97", "1*49", "0.05*43", "-1*28"]
            .iter()
            .map(|line| [line.as_bytes(), b"\r\n"].concat())
            .collect();
    let frames: Vec<Vec<u8>> = SEEN.iter().map(|(_, wire)| hex(wire)).collect();
    prop_oneof![
        vec(any::<u8>(), 0..300),
        vec(prop_oneof![proptest::sample::select(b"0123456789.-+*einfa \r\n".to_vec())], 0..80),
        proptest::sample::select([lines, frames].concat()),
        vec(any::<u8>(), 1..60).prop_map(|message| frame(&[vec![8, 1], message].concat())),
    ]
}

proptest! {
    #![proptest_config(Config { cases: 400, failure_persistence: None, ..Config::default() })]

    #[test]
    fn noise_ends_in_nothing_worse_than_a_loss(pieces in vec((bytes(), 0.0..0.05_f64), 1..200)) {
        for mut session in sessions() {
            let (mut hand, mut now, mut lost) = (Hand::default(), 0.0, 0);
            hand.forced = Some(f64::NAN);
            session.begin(now);
            for (piece, pause) in &pieces {
                now += pause;
                session.hear(piece, now, &mut hand);
                let mut out = Vec::new();
                match session.turn(now, &mut hand, &mut out) {
                    Turn::Until { time, .. } => prop_assert!(time.is_finite() && time < now + 3.0),
                    Turn::Done => prop_assert!(false, "nobody stopped it"),
                    Turn::Lost(_) => {
                        lost += 1;
                        prop_assert!(session.torque() == 0.0);
                        session.begin(now);
                    }
                }
                prop_assert!(out.len() < 600, "{}", out.len());
                prop_assert!(session.torque().is_finite());
            }
            prop_assert!(session.counts().lost == lost);
        }
    }
}

/// A quick stream of bytes that repeat after 2^64.
struct Stream(u64);

impl Stream {
    fn fill(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            *byte = (self.0 >> 56) as u8;
        }
    }
}

#[test]
fn megabytes_of_noise_take_no_memory() {
    for mut session in sessions() {
        let (mut hand, mut now, mut bytes, mut stream) = (Hand::default(), 0.0, [0; 1024], Stream(1));
        let mut out = Vec::with_capacity(4096);
        session.begin(now);
        let mut after_the_first = None;
        for k in 0..20_000 {
            // Slow enough to be borne for a while.
            now += 0.3;
            stream.fill(&mut bytes);
            if k % 3 == 0 {
                bytes.fill(b'1' + (k % 2) as u8);
            }
            session.hear(&bytes, now, &mut hand);
            out.clear();
            if let Turn::Lost(_) = session.turn(now, &mut hand, &mut out) {
                session.begin(now);
            }
            hand.news.clear();
            hand.lost.clear();
            let held = HELD.with(Cell::get);
            if k == 50 {
                after_the_first = Some(held);
            }
            if let Some(first) = after_the_first {
                assert!((held - first).abs() < 8_192, "{first} {held} after {k}");
            }
        }
    }
}

#[test]
fn what_never_ends_takes_no_memory() {
    for (mut session, chunk) in sessions().into_iter().zip([vec![b'x'; 400], vec![0x55; 1_500]]) {
        let (mut hand, mut now, mut most) = (Hand::default(), 0.0, 0);
        let mut out = Vec::with_capacity(4096);
        hand.news.reserve(64);
        session.begin(now);
        session.turn(now, &mut hand, &mut out);
        session.hear(&[0, b'\n'], now, &mut hand);
        now += 0.03;
        session.turn(now, &mut hand, &mut out);
        let before = HELD.with(Cell::get);
        for _ in 0..400 {
            now += 0.1;
            session.hear(&chunk, now, &mut hand);
            out.clear();
            if let Turn::Lost(_) = session.turn(now, &mut hand, &mut out) {
                session.begin(now);
                session.hear(&[0], now, &mut hand);
            }
            most = most.max(HELD.with(Cell::get) - before);
        }
        assert!(most < 2_048, "{most}");
    }
}
