//! Whether a steady tone went on: watched at what a session sends to the virtual card, which keeps time.
#![allow(dead_code)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pacinian::live::board::Board;
use ringbuf::HeapCons;
use ringbuf::traits::Consumer;

/// Hertz of the tone, whole periods of which a whole number of frames is, and the rate.
pub const HERTZ: usize = 100;
const RATE: usize = 48_000;

/// Fetches what is recorded, and looks at the card's clock, in a thread of its own.
pub struct Watch {
    over: Arc<AtomicBool>,
    thread: JoinHandle<(Vec<f32>, Vec<Look>)>,
}

/// A look at the card: frames just before a moment and just behind it, and before and behind those the card's gaps.
struct Look {
    frames: [u64; 2],
    at: Instant,
    xruns: [u64; 2],
}

impl Watch {
    pub fn start(mut recording: HeapCons<f32>, board: Arc<Board>) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&over);
        let thread = std::thread::spawn(move || {
            let (mut all, mut looks) = (Vec::new(), Vec::new());
            loop {
                let last = told.load(Ordering::Acquire);
                all.extend(recording.pop_iter());
                let before = (board.xruns.get(), board.frames.get());
                let at = Instant::now();
                let behind = (board.frames.get(), board.xruns.get());
                looks.push(Look { frames: [before.1, behind.0], at, xruns: [before.0, behind.1] });
                if last {
                    return (all, looks);
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        Self { over, thread }
    }

    /// After the session has stopped: the tone on `channel` (from 0) of `channels`, of this amplitude, sounded from frame `begin` on until
    /// the card was told to stop, and what was given out is what the card's clock says, blocks of so many frames.
    pub fn finish(
        self,
        board: &Board,
        channel: usize,
        channels: usize,
        amplitude: f32,
        begin: usize,
        block: u64,
    ) {
        self.over.store(true, Ordering::Release);
        let (all, looks) = self.thread.join().unwrap();
        assert_eq!(board.unrecorded.get(), 0, "the recording is whole");
        assert_eq!((all.len() / channels) as u64, board.frames.get());
        let tone: Vec<f32> = all.iter().skip(channel).step_by(channels).copied().collect();
        // 5 ms in which the gate closes.
        let end = tone.iter().rposition(|x| *x != 0.0).unwrap() - 240;
        assert!(end > begin + RATE / 2, "{end} frames");
        // What the engine's high-pass leaves of it.
        let peak = tone[begin..begin + RATE / HERTZ].iter().fold(0.0_f32, |most, x| most.max(*x));
        assert!((peak / amplitude - 1.0).abs() < 0.05, "{peak}");
        if let Err(why) = is_steady(&tone[begin..end], peak) {
            panic!("{why}, of {} frames", end - begin);
        }
        // Between two looks between which the card has not been late, it has asked for what the time makes, but for the block that it is at
        // and the one before. Whoever looks may be kept waiting: then more frames came than are counted on.
        let mut sure = 0;
        for pair in looks.windows(4) {
            let [first, .., next, last] = pair else { unreachable!() };
            // What is late while one looks is known two looks later, if blocks have passed by then.
            if last.xruns[1] != first.xruns[0] || last.frames[0] < next.frames[1] + 2 * block {
                continue;
            }
            let due = (next.at - first.at).as_secs_f64() * RATE as f64;
            let came = next.frames[1] - first.frames[0];
            assert!(came as f64 + 3.0 * block as f64 >= due, "{came} frames of {due}");
            sure += 1;
        }
        assert!(sure > 0, "the card was late at every look");
        let (first, last) = (&looks[0], &looks[looks.len() - 1]);
        let most = (last.at - first.at).as_secs_f64() * RATE as f64 + 3.0 * block as f64;
        let came = last.frames[0] - first.frames[1];
        assert!(came as f64 <= most, "{came} frames, and no more than {most} were due");
    }
}

/// Whether a sine of 100 Hz and this amplitude goes on without a gap, a jump or a bump.
fn is_steady(tone: &[f32], amplitude: f32) -> Result<(), String> {
    // Where it passes through 0, one sample may be there.
    if let Some(at) = tone.windows(3).position(|w| w.iter().all(|x| *x == 0.0)) {
        return Err(format!("silence at frame {at}"));
    }
    let steepest = amplitude * std::f32::consts::TAU * HERTZ as f32 / RATE as f32;
    if let Some(at) = tone.windows(2).position(|w| (w[1] - w[0]).abs() > 1.01 * steepest) {
        return Err(format!("a jump from {} to {} at frame {at}", tone[at], tone[at + 1]));
    }
    for (n, period) in tone.chunks_exact(RATE / HERTZ).enumerate() {
        let most = period.iter().fold(f32::MIN, |most, x| most.max(*x));
        let least = period.iter().fold(f32::MAX, |least, x| least.min(*x));
        if (most / amplitude - 1.0).abs() > 0.01 || (least / amplitude + 1.0).abs() > 0.01 {
            return Err(format!("from {least} to {most} in the period at frame {}", n * RATE / HERTZ));
        }
    }
    Ok(())
}

#[test]
fn a_gap_a_jump_and_a_dip_are_seen() {
    let sine = |n: usize| 0.4 * (std::f32::consts::TAU * HERTZ as f32 * n as f32 / RATE as f32).sin();
    let tone: Vec<f32> = (0..9_600).map(sine).collect();
    assert_eq!(is_steady(&tone, 0.4), Ok(()));
    let spoilt = |spoil: &dyn Fn(&mut [f32])| {
        let mut tone = tone.clone();
        spoil(&mut tone[4_807..]);
        is_steady(&tone, 0.4).unwrap_err()
    };
    // At a crest a sample that is missing jumps no further than the tone itself, so that what is silent is looked for, too.
    assert!(spoilt(&|rest| rest[..64].fill(0.0)).contains("silence"));
    assert!(spoilt(&|rest| rest[..64].copy_from_slice(&tone[4_743..4_807])).contains("a jump"));
    assert!(spoilt(&|rest| rest.copy_from_slice(&tone[4_807 - 240..][..4_793])).contains("a jump"));
    let dip = |rest: &mut [f32]| {
        rest.iter_mut().enumerate().for_each(|(n, x)| *x *= 1.0 - 0.1 * (n as f32 / 960.0).min(1.0));
    };
    assert!(spoilt(&dip).contains("in the period"));
}
