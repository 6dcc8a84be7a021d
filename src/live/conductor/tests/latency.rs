//! When what arrives is played: later by the same time for all of it.

use super::{Bench, Deed, Event, KEYS, Note, Signal, compiled_with, midi};

#[test]
fn what_arrives_within_a_block_is_played_a_block_later_to_the_sample() {
    let mut bench = Bench::new(&["a"]);
    let mut expected = Vec::new();
    for n in 0..40_u64 {
        // Between the callback that came last and the next.
        let offset = 49_999 * n;
        let arrived = bench.next() - 2_000_000 + offset;
        bench.take(arrived, Signal::Play(n, "a".into(), Note::default()));
        let first = (bench.blocks - 1) * 96;
        // A block, and the three frames that it may take to the callback.
        expected.push(first as f64 + 96.0 + 3.0 + offset as f64 * 48e-6);
        bench.block();
    }
    // As many that come 10 us before a callback, and are found by the next.
    for n in 40..80_u64 {
        let arrived = bench.next() - 10_000;
        expected.push(bench.blocks as f64 * 96.0 + 96.0 + 3.0 - 0.48);
        bench.block();
        bench.take(arrived, Signal::Play(n, "a".into(), Note::default()));
        bench.block();
    }
    let played = bench.played();
    assert_eq!(played.len(), 80);
    for ((due, at, _), expected) in played.iter().zip(expected) {
        assert!((due - expected).abs() < 0.1 && due == at, "{due}, {at} for {expected}");
    }
}

/// The card stands still for 40 ms, and what arrives meanwhile is put where it would have been by then; the clock is set anew, and what arrives
/// then takes effect no earlier, or a release would find nothing to release.
#[test]
fn nothing_overtakes_what_came_before_when_the_clock_is_set_anew() {
    let mut bench = Bench::new(&["a", "b"]);
    let due = bench.next();
    bench.take(due + 39_000_000, Signal::Play(1, "a".into(), Note::default()));
    bench.block_of(96, due + 40_000_000);
    bench.take(due + 40_100_000, Signal::Play(2, "b".into(), Note::default()));
    // What arrived before either, and is only found now, is where it belongs.
    bench.take(due + 1_000_000, Signal::Play(3, "a".into(), Note::default()));
    for n in 1..60 {
        bench.block_of(96, due + 40_000_000 + n * 2_000_000);
    }
    let played = bench.played();
    let at = |n: usize| played[n].0;
    assert_eq!(played.len(), 3, "{played:?}");
    let instruments: Vec<u32> = played.iter().map(|(.., instrument)| *instrument).collect();
    assert_eq!(instruments, [0, 1, 0], "{played:?}");
    assert!(at(0) <= at(1) && at(1) - at(0) < 1.0 && at(2) < at(0) - 1_000.0, "{played:?}");
}

/// When callbacks come that are due as evenly as frames pass.
struct Jitter {
    /// Frames of a block, and by how many it is longer or shorter at most.
    block: u64,
    uneven: u64,
    /// From how much too early to how much too late they come, in blocks, every moment between as likely.
    from: f64,
    to: f64,
    /// Seconds after which the latency is to stand.
    settled: f64,
}

impl Jitter {
    /// Lets a minute pass in which something arrives every few milliseconds: the longest and the shortest way, in frames, from where a
    /// signal arrives to where it is played, and how many there were.
    fn latency(&self, seed: u64) -> (f64, f64, usize) {
        // A converter that is 80 millionths fast.
        const RATE: f64 = 48_000.0 * 1.000_08;
        let mut state = seed;
        let mut noise = move || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let n = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            ((n ^ (n >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let osc =
            "[[trigger]]\non = \"osc./hit\"\nplay = \"b\"\nset = { level = \"value\", duration = 0.001 }\n";
        let mut bench = Bench::of(compiled_with(&["a", "b"], &format!("{KEYS}{osc}")));
        bench.follower.forget(self.block + self.uneven);
        let (first, begin) = (bench.callback.frames(), bench.next() as f64 * 1e-9 + 1.0);
        let begun = begin + 2.0 * self.block as f64 / RATE;
        // When each signal arrives, in frames of the converter.
        let (mut arrivals, mut next, mut before) = (Vec::new(), begun, 0.0_f64);
        loop {
            let frames = bench.callback.frames() - first;
            if frames as f64 > (60.0 + self.settled) * RATE {
                break;
            }
            let late = (self.from + (self.to - self.from) * noise()) * self.block as f64 / RATE;
            // None comes before the one before it has gone.
            let at = (begin + frames as f64 / RATE + late).max(before + 5e-6);
            while next < at {
                let number = arrivals.len() as u64 + 1;
                let short = Note { duration: Some(0.001), ..Note::default() };
                let signal = match number % 3 {
                    0 => Signal::Play(number, "a".into(), short),
                    1 => midi(0, (number % 100) as u8, true),
                    _ => Signal::Osc("/hit".into(), vec![1.0]),
                };
                bench.take_as(number, (next * 1e9) as u64, signal);
                arrivals.push(first as f64 + (next - begin) * RATE);
                next += 0.002 + 0.01 * noise();
            }
            let uneven = ((2.0 * noise() - 1.0) * (self.uneven as f64 + 0.5)).round() as i64;
            bench.block_of((self.block as i64 + uneven) as usize, (at * 1e9) as u64);
            bench.conductor.go_on();
            before = at;
        }
        let reports = std::mem::take(&mut *bench.reports.lock().unwrap());
        let (mut least, mut most, mut count) = (f64::MAX, f64::MIN, 0);
        for report in reports {
            let Deed::Event { at, event: Event::Play(_), cause: number @ 1.., .. } = report.deed else {
                continue;
            };
            let arrived = arrivals[number as usize - 1];
            if arrived < first as f64 + self.settled * RATE {
                continue;
            }
            let way = at.since(crate::schedule::Instant::default()) * 6.0 - arrived;
            (least, most, count) = (least.min(way), most.max(way), count + 1);
        }
        // All but those that wait for their block.
        let settled = arrivals.iter().filter(|at| **at >= first as f64 + self.settled * RATE).count();
        assert!(settled - count < 3, "{count} of {settled}");
        (least, most, count)
    }
}

/// Whatever arrives in a minute, over MIDI, over OSC and from the program, is played the same while later, to within an engine sample, which
/// is six frames: the longest way is no more than so much longer than the shortest. The device asks for its blocks unevenly: for 64
/// frames at any moment until the next would be due, as where a thread waits for the processor and the card has room for two; also
/// where blocks are longer and shorter by a third; for them up to a block too early as well; a little too late for large ones, and up to
/// twice their time for small ones. The loop averages: it is settled after two seconds, with twice the spread after ten. Of blocks of
/// many milliseconds that come at any moment no loop would find so fine a phase in so short a time.
#[test]
fn uneven_callbacks_become_one_latency_for_all_that_arrives() {
    let late = || Jitter { block: 64, uneven: 0, from: 0.0, to: 1.0, settled: 2.0 };
    let cases = [
        late(),
        Jitter { uneven: 20, ..late() },
        Jitter { from: -1.0, settled: 10.0, ..late() },
        Jitter { uneven: 20, from: -1.0, settled: 10.0, ..late() },
        Jitter { block: 1024, to: 0.02, settled: 10.0, ..late() },
        Jitter { block: 32, uneven: 8, to: 2.0, ..late() },
    ];
    for (seed, case) in cases.iter().enumerate() {
        let (least, most, count) = case.latency(seed as u64);
        let Jitter { block, uneven, from, to, .. } = *case;
        let told =
            format!("{block} frames and {uneven}, from {from} to {to}: {least} to {most} frames, of {count}");
        assert!(count > 8_000 && most - least <= 6.0, "{told}");
        // The longest block, and as much as one comes before it is due.
        let wanted = (block + uneven) as f64 - from * block as f64;
        assert!((least - wanted).abs() < 12.0, "{told}, for {wanted}");
    }
}
