//! What of levels is out of a motor's reach is counted.

use crate::common::COIN;
use crate::turner::setup;
use pacinian::actuator::driver::setup::{Setup, Shaping};
use pacinian::actuator::driver::turner::{Counts, Turner};

const RATE: f64 = 8000.0;
const LIMIT: f64 = 3.0;

fn counted(levels: &[f64], one_way: bool) -> Counts {
    let setup = Setup { one_way, ordered: false, limit: LIMIT, rate: RATE, ..setup(COIN, Shaping::Inverse) };
    let mut turner = Turner::new(&setup, 0).unwrap();
    for level in levels.iter().chain(&vec![0.0; 4000]) {
        turner.step(*level, &mut [0.0; 2]);
    }
    turner.counts()
}

fn held(level: f64, seconds: f64) -> Vec<f64> {
    vec![level; (seconds * RATE) as usize]
}

/// Full vibration from one instant to another: forward it rises as J w' = 0.98 k V/R - B w - c has it, backward from its end it falls as fast as
/// the same torque, damping and friction brake it; the lesser of both is within reach.
#[test]
fn what_a_rectangle_asks_too_much_is_that_of_the_closed_form() {
    for seconds in [0.03, 0.1, 0.5] {
        let counts = counted(&held(1.0, seconds), false);
        let (torque, b, j) = (0.98 * COIN.stall_torque(LIMIT), COIN.damping(), COIN.effective_inertia());
        let full = COIN.rated_speed();
        let to = |torque: f64, rate: f64, t: f64| torque / rate * -(-rate / j * t).exp_m1();
        let steps = 100_000;
        let missing = |n: i32| {
            let t = seconds * f64::from(n) / f64::from(steps);
            let rises = to(torque - COIN.coulomb, b, t);
            let falls = to(torque + COIN.coulomb, -b, seconds - t);
            1.0 - rises.min(falls).min(full) / full
        };
        let due = (0..steps).map(missing).sum::<f64>() / f64::from(steps);
        let is = counts.missed / counts.played;
        assert!((is / due - 1.0).abs() < 0.02, "{seconds}: {is} {due}");
        assert!((counts.played / (seconds * RATE) - 1.0).abs() < 1e-9, "{counts:?}");
        // Never quite at its full speed, and nowhere within 1 % of it before 4.6 time constants.
        let least = (seconds.min(0.1) * RATE) as u64;
        assert!((least - 20..=(seconds * RATE) as u64 + 1).contains(&counts.limited), "{counts:?}");
    }
}

#[test]
fn what_is_within_reach_misses_nothing() {
    let n = (0.3 * RATE) as usize;
    let cosine: Vec<f64> =
        (0..n).map(|k| 0.15 * (1.0 - (std::f64::consts::TAU * k as f64 / n as f64).cos())).collect();
    for one_way in [false, true] {
        let counts = counted(&cosine, one_way);
        assert!(counts.played > 100.0 && counts.missed < 1e-3 * counts.played, "{counts:?}");
        assert_eq!(counts.limited, 0);
    }
    assert_eq!(counted(&[], false), Counts::default());
    // Behind diodes a rise is out of reach, and what rolls on is no shortfall.
    let counts = counted(&held(1.0, 0.03), true);
    assert!(
        counts.limited > 200 && counts.limited <= 241 && counts.missed > 0.3 * counts.played,
        "{counts:?}"
    );
    assert!((counts.played - 240.0).abs() < 1e-6, "{counts:?}");
}
