//! Far more orders than a motor can follow.

use super::*;

/// Bursts of voices on two motors, many at the same instant or in the same sample, by numbers that look random.
fn bursts(seed: u64, rate: f64) -> Vec<(f64, Event)> {
    let mut state = seed;
    let mut next = |most: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % most
    };
    let (mut events, mut at, mut id) = (Vec::new(), 100.0, 0);
    while events.len() < 2_500 {
        for _ in 0..[1, 5, 60, 200][next(4) as usize] {
            at += [0.0, 0.02, 0.3][next(3) as usize];
            let instrument = [SWITCH, SPIN, CLICK, STOP][next(16).saturating_sub(12) as usize];
            let (place, duration) = ([COIN, PAD][next(2) as usize], [0.002, 0.01, 0.1][next(3) as usize]);
            id += 1;
            let play = Play { id, ..play(instrument, place, 0.2 + 0.1 * next(8) as f64, duration) };
            events.push((at / rate, Event::Play(play)));
        }
        at += [1.0, 30.0, 400.0][next(3) as usize];
    }
    events
}

/// What finds no room is the same in calls of any length: else a session could not be played again.
#[test]
fn what_is_left_out_of_a_crowd_is_the_same_in_any_cut() {
    let plan = compiled(MOTORS);
    for seed in 1..=6 {
        let events = bursts(seed, plan.engine_rate());
        let seconds = events.last().unwrap().0 + 0.4;
        let run = |calls: &[usize]| {
            let mut engine = Engine::new(&plan).unwrap();
            for (at, event) in &events {
                let at = Instant::of_samples(at * plan.engine_rate());
                assert!(engine.schedule(at, Source::Program, *event));
            }
            let frames = run(&mut engine, (seconds * RATE) as usize, calls);
            let counts = [0, 2].map(|channel| engine.stage().drives().counts_of(channel).unwrap());
            // Whoever was ordered to turn was let go of as well.
            let tail = &frames[frames.len() - 3 * 480..];
            assert!(tail.iter().all(|x| *x == 0.0), "seed {seed} in calls of {calls:?}");
            (frames.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), counts)
        };
        let whole = run(&[1 << 20]);
        assert!(whole.1.iter().all(|counts| counts.dropped > 0), "{:?}", whole.1);
        for calls in [&[1][..], &[64], &[128], &[480], &[3, 1000, 1, 17, 250, 64]] {
            let cut = run(calls);
            assert_eq!(cut.1, whole.1, "seed {seed} in calls of {calls:?}");
            assert!(cut.0 == whole.0, "seed {seed} in calls of {calls:?}");
        }
    }
}
