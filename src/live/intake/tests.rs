//! Two simulated devices with clocks of their own.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::super::board::Board;
use super::super::clock::Follower;
use super::super::stamp::{Epoch, Stamp};
use super::{Ears, Hearing, bridge};
use crate::knob::angle::decoder::NOT_HEARD;

/// A device: its rate as it thinks it is, by how much its clock is fast, frames a block, and how late its callbacks may be, seconds.
#[derive(Clone, Copy)]
struct Card {
    rate: f64,
    fast: f64,
    block: usize,
    jitter: f64,
}

/// Numbers from 0 to 1 that look random.
fn noise(n: u64) -> f64 {
    let n = (n ^ (n >> 31)).wrapping_add(0x1234_5678).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11) as f64 / (1_u64 << 53) as f64
}

fn stamp(seconds: f64) -> Stamp {
    Stamp((seconds * 1e9).round() as u64)
}

/// A tone, at a moment.
fn tone(hertz: f64, time: f64) -> f64 {
    0.5 * (TAU * hertz * time).sin()
}

/// What the one that plays is given of a tone that the other hears, until `seconds`. While `pause` says so, no callback comes.
fn run(
    ears: Card,
    mouth: Card,
    hertz: f64,
    seconds: f64,
    away: impl Fn(f64) -> bool,
) -> (Vec<f32>, Arc<Board>) {
    let board = Arc::new(Board::new(1));
    let said = Ears { rate: ears.rate, channels: 2, block: ears.block };
    let (mut intake, mut feed) = bridge(said, mouth.rate, mouth.block, Epoch::begin(), &board);
    let (mut follower, _clock) = Follower::new(mouth.rate, mouth.block as u64);
    let due = |card: Card, n: u64| 1.0 + (n as f64 * card.block as f64) / (card.rate * (1.0 + card.fast));
    // A callback late comes no later than the next one.
    let comes = |card: Card, n: u64, salt: u64| due(card, n) + card.jitter * noise(n.wrapping_mul(3) ^ salt);
    let (mut heard, mut played, mut out) = (1_u64, 0_u64, Vec::new());
    let (mut output, mut gone) = (vec![0.0; mouth.block], false);
    while due(mouth, played) < 1.0 + seconds {
        let (hears, plays) = (comes(ears, heard, 1 << 40), comes(mouth, played, 0));
        if hears < plays {
            // What was heard since the last one.
            let first = (heard - 1) as f64 * ears.block as f64;
            let frames: Vec<f32> = (0..ears.block)
                .flat_map(|n| {
                    let time = (first + n as f64) / (ears.rate * (1.0 + ears.fast));
                    let x = tone(hertz, time) as f32;
                    [x, -0.5 * x]
                })
                .collect();
            heard += 1;
            // It says so when it is there again.
            let was = std::mem::replace(&mut gone, away(hears - 1.0));
            board.input.xruns.add(u64::from(was && !gone));
            if !gone {
                intake.take(stamp(hears), 0.0, &frames);
            }
        } else {
            follower.callback(stamp(plays), mouth.block as u64);
            feed.hear(follower.due(), 1, &mut output);
            out.extend(&output);
            played += 1;
        }
    }
    (out, board)
}

/// What is left of a signal when the best tone of `hertz` is taken out, dB below it.
fn residue(signal: &[f32], rate: f64, hertz: f64) -> f64 {
    let phase = |n: usize| TAU * hertz * n as f64 / rate;
    let (mut ss, mut sc, mut cc, mut sx, mut cx) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (n, x) in signal.iter().enumerate() {
        let (s, c) = phase(n).sin_cos();
        let x = f64::from(*x);
        (ss, sc, cc, sx, cx) = (ss + s * s, sc + s * c, cc + c * c, sx + s * x, cx + c * x);
    }
    let det = ss * cc - sc * sc;
    let (a, b) = ((sx * cc - cx * sc) / det, (cx * ss - sx * sc) / det);
    let (mut rest, mut whole) = (0.0, 0.0);
    for (n, x) in signal.iter().enumerate() {
        let (s, c) = phase(n).sin_cos();
        rest += (f64::from(*x) - a * s - b * c).powi(2);
        whole += f64::from(*x).powi(2);
    }
    10.0 * (rest / whole).log10()
}

/// 50 microseconds are what a machine at rest has.
const MICROPHONE: Card = Card { rate: 48_000.0, fast: 100e-6, block: 128, jitter: 50e-6 };
const SPEAKER: Card = Card { rate: 48_000.0, fast: -100e-6, block: 64, jitter: 50e-6 };

#[test]
fn a_tone_passes_between_clocks_that_differ_by_200_millionths() {
    let mut figures = Vec::new();
    for (ears, mouth, most) in [
        (Card { jitter: 0.0, ..MICROPHONE }, Card { jitter: 0.0, ..SPEAKER }, -100.0),
        (MICROPHONE, SPEAKER, -60.0),
        (Card { jitter: 200e-6, ..MICROPHONE }, Card { jitter: 200e-6, ..SPEAKER }, -48.0),
        (Card { jitter: 1e-3, ..MICROPHONE }, Card { jitter: 1e-3, ..SPEAKER }, -34.0),
        (Card { rate: 44_100.0, ..MICROPHONE }, SPEAKER, -60.0),
        (Card { rate: 96_000.0, block: 256, ..MICROPHONE }, Card { rate: 44_100.0, ..SPEAKER }, -60.0),
    ] {
        let (out, board) = run(ears, mouth, 250.0, 90.0, |_| false);
        let steady = &out[(60.0 * mouth.rate) as usize..];
        let rest = residue(steady, mouth.rate * (1.0 + mouth.fast), 250.0);
        let latency = board.input.latency.get() as f64 * 1e-6;
        figures.push(format!("{} to {} Hz: {rest:.1} dB, {latency:.2} ms", ears.rate, mouth.rate));
        assert!(rest < most, "{figures:?}");
        assert_eq!((board.input.dry.get(), board.input.jumps.get(), board.input.lost.get()), (0, 0, 0));
    }
    println!("{figures:#?}");
}

#[test]
fn the_latency_is_what_it_says() {
    for (ears, mouth) in
        [(MICROPHONE, SPEAKER), (Card { rate: 44_100.0, fast: -1e-4, ..MICROPHONE }, SPEAKER)]
    {
        let (out, board) = run(ears, mouth, 3.0, 60.0, |_| false);
        // A slow tone: by its phase at the end.
        let last = out.len() - 1;
        let time = last as f64 / (mouth.rate * (1.0 + mouth.fast));
        let said = board.input.latency.get() as f64 * 1e-9;
        let best = (0..40_000).map(|n| f64::from(n) * 1e-6).min_by(|a, b| {
            let off = |late: f64| -> f64 {
                [0, 4000, 8000]
                    .iter()
                    .map(|n| {
                        let then = time - *n as f64 / (mouth.rate * (1.0 + mouth.fast));
                        (tone(3.0, then - late) - f64::from(out[last - n])).abs()
                    })
                    .sum()
            };
            off(*a).total_cmp(&off(*b))
        });
        let found = best.unwrap();
        // Callbacks come, on the average, half their jitter late on both sides.
        assert!((found - said).abs() < 150e-6, "{found} s, said {said} s");
        assert!(said < 0.0085, "{said}");
    }
}

/// The largest step from one frame to the next.
fn jump(signal: &[f32]) -> f32 {
    signal.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max)
}

#[test]
fn a_device_that_goes_away_and_comes_back_leaves_no_click() {
    let away = |t: f64| (10.0..11.0).contains(&t) || (20.0..20.012).contains(&t);
    let (out, board) = run(MICROPHONE, SPEAKER, 50.0, 30.0, away);
    let at = |t: f64| (t * 48_000.0) as usize;
    assert!(out[at(10.1)..at(11.0)].iter().all(|x| *x == 0.0), "silence while it is away");
    assert!(out[at(11.5)..at(19.5)].iter().any(|x| *x > 0.45), "and it comes back");
    assert!(out[at(20.5)..].iter().any(|x| *x > 0.45));
    assert!((1..=2).contains(&board.input.dry.get()), "{}", board.input.dry.get());
    // The slope of the tone is 0.0033 a frame, that of a fade at most 0.0042 for it.
    assert!(jump(&out) < 0.009, "{}", jump(&out));
}

#[test]
fn a_player_that_stands_still_goes_on_with_what_is_new() {
    let board = Arc::new(Board::new(1));
    let ears = Ears { rate: 48_000.0, channels: 1, block: 480 };
    let (mut intake, mut feed) = bridge(ears, 48_000.0, 480, Epoch::begin(), &board);
    let mut output = vec![0.0_f32; 480];
    let mut out: Vec<f32> = Vec::new();
    for n in 0..600_u32 {
        let now = 1.0 + f64::from(n) * 0.01;
        // Each block is as loud as it is late.
        let level = f64::from(n) / 1000.0;
        intake.take(stamp(now), 0.0, &[level as f32; 480]);
        if !(100..400).contains(&n) {
            feed.hear(now, 1, &mut output);
            out.extend(&output);
        }
    }
    // Two seconds were too much for the ring.
    assert!(board.input.lost.get() > 48_000);
    let last = f64::from(*out.last().unwrap());
    assert!((last - 0.597).abs() < 0.003, "{last}");
    assert!(out.iter().all(|x| x.is_finite()));
}

/// A channel that a knob's sensor is heard by has what was heard, or nothing; the others fade.
#[test]
fn a_marked_channel_has_what_was_heard_or_nothing() {
    let board = Arc::new(Board::new(1));
    let ears = Ears { rate: 48_000.0, channels: 2, block: 64 };
    let (mut intake, mut feed) = bridge(ears, 48_000.0, 64, Epoch::begin(), &board);
    feed.mark(&[1, 2]);
    let mut all = Vec::new();
    for n in 0..1500_u64 {
        // It is away for a while.
        let at = 1.0 + n as f64 * 64.0 / 48_000.0;
        if !(700..800).contains(&n) {
            intake.take(stamp(at), 0.0, &[0.5; 128]);
        }
        let mut frames = [0.0; 3 * 64];
        feed.hear(at, 3, &mut frames);
        all.extend(frames.chunks(3).map(|frame| [frame[0], frame[1], frame[2]]));
    }
    assert!(all.iter().all(|frame| frame[2] == NOT_HEARD), "the device has no such channel");
    let near = |x: f32| (x - 0.5).abs() < 1e-3;
    let (mut known, mut fades) = (0, 0);
    for frame in &all {
        assert!(near(frame[1]) || frame[1] == NOT_HEARD, "{frame:?}");
        assert!(frame[1] == NOT_HEARD || near(frame[0]), "{frame:?}");
        known += usize::from(frame[1] != NOT_HEARD);
        fades += usize::from(frame[0] > 0.01 && frame[0] < 0.49);
    }
    assert!(known > 60_000 && known < 92_000 && fades > 300, "{known} {fades}");
    assert!(all[(700 + 10) * 64..800 * 64].iter().all(|frame| frame[1] == NOT_HEARD));
}
