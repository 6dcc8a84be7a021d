//! A motor whose friction is not what the law says.

use super::super::noise::Noise;
use super::identify;
use super::tests::{Run, STAIRS, groups};
use crate::actuator::motor::Parameters;

/// Dry friction that wanders by a tenth, slowly and at random, as that of bearings does; no inductance, no gravity. The means lie inside.
#[test]
fn friction_that_wanders_widens_the_intervals() {
    wandering(10);
}

fn wandering(seeds: u64) {
    let p = Parameters { gravity: 0.0, inductance: 0.0, ..Parameters::COIN };
    let (rate, fine) = (6000.0, 8);
    let (mut inside, mut wide) = ([0; 3], 0.0);
    for seed in 0..seeds {
        let mut noise = Noise::new(500 + seed);
        let (mut speed, mut angle, mut wanders) = (0.0_f64, 0.3_f64, 0.0);
        let (mut drive, mut x) = (vec![], vec![]);
        for (share, seconds) in STAIRS {
            for _ in 0..(seconds * rate) as usize {
                let volts = share.unwrap() * p.rated_volts;
                let bend = |speed: f64, wanders: f64| {
                    let torque = p.stall_torque(volts) - p.coulomb * (1.0 + wanders);
                    if speed <= 0.0 && torque <= 0.0 {
                        0.0
                    } else {
                        (torque - p.damping() * speed) / p.effective_inertia()
                    }
                };
                drive.push(volts);
                x.push(7.3e-6 * (speed * speed * angle.sin() - bend(speed, wanders) * angle.cos()));
                // Connected over 5 ms.
                let keeps = (-1.0 / (0.005 * rate)).exp();
                wanders = keeps * wanders + 0.1 * (1.0 - keeps * keeps).sqrt() * noise.normal();
                for _ in 0..fine {
                    let h = 1.0 / (rate * f64::from(fine));
                    let middle = speed + 0.5 * h * bend(speed, wanders);
                    angle += h * middle;
                    speed = (speed + h * bend(middle, wanders)).max(0.0);
                }
            }
        }
        let run = Run { rate, acceleration: x, drive, current: vec![], voltage: vec![], open: vec![] };
        let all = identify(&run.recording(&noise.add(&run.acceleration, 40.0))).unwrap();
        for (count, (name, truth)) in inside.iter_mut().zip(groups(&p)) {
            let found = all.get(name).unwrap();
            assert!((found.value / truth - 1.0).abs() < 0.15, "{found}, but it is {truth:e}");
            *count += u64::from(found.holds(truth));
        }
        let tau = all.get("time_constant").unwrap();
        wide += (tau.interval[1] - tau.interval[0]) / tau.value / seeds as f64;
    }
    let least = if seeds < 50 { 7 * seeds / 10 } else { 9 * seeds / 10 };
    assert!(inside.iter().all(|n| *n >= least), "of {seeds}: {inside:?}");
    assert!((0.003..0.2).contains(&wide), "{wide}");
}
