//! The voltage that starts a motor, from the ramp that the stimulus has for that.

use super::super::noise::Noise;
use super::super::stimulus::steps;
use super::identify;
use super::tests::{Run, simulate};
use crate::actuator::motor::Parameters;

/// What a stimulus for motors of a time constant makes a motor do whose mass spins in a level plane.
fn played(p: &Parameters, time: f64) -> Run {
    let rate = 8000.0;
    let volts = steps(p.rated_volts, time, rate).unwrap();
    // A hair more than a sample each, so that none is lost where it is counted.
    let course: Vec<_> = volts.iter().map(|v| (Some(v / p.rated_volts), 1.000_000_1 / rate)).collect();
    simulate(p, rate, 0.7, &course)
}

/// One that starts at 21 % of its rating and one at 35 %, by a stimulus for them and by one for motors of which nothing is known: of 12 draws as many
/// are inside of their intervals as 95 % say, and those are narrow.
#[test]
fn a_ramp_tells_what_starts_it() {
    let coin = Parameters { gravity: 0.0, ..Parameters::COIN };
    let late = Parameters { stiction: 3.3e-5, coulomb: 2e-5, ..coin };
    let (mut draws, mut inside) = (0, 0);
    for (p, time) in [(coin, coin.mechanical_time()), (coin, 0.1), (late, late.mechanical_time())] {
        let run = played(&p, time);
        for seed in 0..4 {
            let all = identify(&run.recording(&Noise::new(seed).add(&run.acceleration, 40.0))).unwrap();
            let told = all.get("start_volts").unwrap_or_else(|| panic!("{:?}", all.why_not("start_volts")));
            assert!((told.value / p.start_volts() - 1.0).abs() < 0.03, "{told} {}", p.start_volts());
            assert!(told.interval[1] - told.interval[0] < 0.1 * told.value, "{told}");
            (draws, inside) = (draws + 1, inside + u32::from(told.holds(p.start_volts())));
        }
    }
    assert!(inside + 1 >= draws, "{inside} of {draws}");
}

/// One that needs no more to start than to run hardly moves at first: the interval says so, and holds it.
#[test]
fn what_begins_unseen_is_inside_all_the_same() {
    let soft = Parameters { gravity: 0.0, coulomb: 2e-5, stiction: 2e-5, ..Parameters::COIN };
    let run = played(&soft, soft.mechanical_time());
    for seed in 0..4 {
        let all = identify(&run.recording(&Noise::new(seed).add(&run.acceleration, 40.0))).unwrap();
        let told = all.get("start_volts").unwrap();
        assert!(told.holds(soft.start_volts()), "{told} {}", soft.start_volts());
    }
}
