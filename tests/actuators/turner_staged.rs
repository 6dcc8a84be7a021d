//! Levels that switch a drive on and off, and drives that are let go while the motor is to be slower.

use crate::common::COIN;
use crate::turner::{PARTS, plant, setup};
use pacinian::actuator::drive::Drive;
use pacinian::actuator::driver::order::{After, By};
use pacinian::actuator::driver::setup::{Setup, Shaping, Stage};
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::motor::Parameters;

/// What is sent for a level at each sample, and the current and the speed of a real motor then.
fn played(setup: &Setup, levels: impl Iterator<Item = f64>) -> (usize, Vec<[f64; 3]>) {
    let mut turner = Turner::new(setup, 0).unwrap();
    let mut plant = plant(&setup.parameters, 0.0);
    let step = |level: f64| {
        let mut parts = [0.0; PARTS];
        turner.step(level, &mut parts);
        for amount in parts {
            plant.drive(setup.drive(amount));
            plant.step();
        }
        [parts[PARTS - 1], plant.current(), plant.speed()]
    };
    let all = levels.map(step).collect();
    (turner.late(), all)
}

fn flat(imposes: Drive, shaping: Shaping, stage: Stage) -> Setup {
    let volts = setup(Parameters { inductance: 0.0, ..COIN }, shaping);
    let limit = if imposes == Drive::Current { volts.limit / COIN.resistance } else { volts.limit };
    Setup { imposes, limit, compliance: 3.0 * volts.limit, stage, ..volts }
}

/// Up to 0.6 and down again, with a wavering of 0.1 about both thresholds: it is on once, from the one to the other, at either sign.
#[test]
fn a_level_that_wavers_switches_once() {
    for sign in [1.0, -1.0] {
        let setup =
            flat(Drive::Voltage, Shaping::OnOff, Stage { on_at: 0.5, off_at: 0.3, ..Stage::default() });
        let level = |n: usize| {
            let rise = 0.6 * (n as f64 / 800.0).min(2.0 - n as f64 / 800.0).max(0.0);
            sign * (rise + 0.05 * (n as f64 * 0.9).sin() * f64::from(u8::from(rise > 0.06)))
        };
        let (late, all) = played(&setup, (0..2000).map(level));
        let mut on = false;
        for n in 0..2000 - late {
            // By its definition.
            on = if on { sign * level(n) > 0.3 } else { sign * level(n) >= 0.5 };
            let due = if on { sign * setup.limit } else { 0.0 };
            assert_eq!(all[n + late][0], due, "{n} {}", level(n));
        }
        let edges = all.windows(2).filter(|w| w[0][0] != w[1][0]).count();
        assert_eq!(edges, 2);
    }
}

/// Held by a current the torque is the same at every speed; let go, nothing flows, or what a short circuit makes flow, whatever the amplifier imposes.
#[test]
fn what_is_held_and_what_follows_is_what_was_said() {
    for imposes in [Drive::Voltage, Drive::Current] {
        for by in By::ALL {
            for after in After::ALL {
                let stage = Stage { by, after, share: 0.3, ..Stage::default() };
                let setup = flat(imposes, Shaping::OnOff, stage);
                let (late, all) = played(&setup, (0..1600).map(|n| f64::from(u8::from(n < 400))));
                let p = &setup.parameters;
                let place = format!("{imposes:?} {by:?} {after:?}");
                let by_current = by == By::Current || (by, imposes) == (By::Amplifier, Drive::Current);
                let full = if imposes == Drive::Voltage {
                    0.3 * setup.limit
                } else {
                    0.3 * setup.limit * p.resistance
                };
                for [_, current, speed] in &all[late + 2..late + 400] {
                    let due = if by_current { full } else { full - p.gain * speed } / p.resistance;
                    assert!((current - due).abs() < 2e-3 * full / p.resistance, "{place}: {current} {due}");
                }
                let opens = after == After::Open || (after, imposes) == (After::Nothing, Drive::Current);
                for [_, current, speed] in
                    all[late + 402..].iter().filter(|x| x[2] > 0.02 * all[late + 400][2])
                {
                    let due = if opens { 0.0 } else { -p.gain * speed / p.resistance };
                    let most = p.gain * all[late + 400][2] / p.resistance;
                    assert!((current - due).abs() < 0.01 * most, "{place}: {current} {due}");
                }
                assert!(all.last().unwrap()[0] == 0.0 && all.last().unwrap()[2] == 0.0, "{place}");
            }
        }
    }
}

/// A level that falls: it is let go until it is as slow as it is to be, and then held there.
#[test]
fn a_plain_drive_is_let_go_while_it_is_to_be_slower() {
    for (after, by) in [(After::Open, By::Current), (After::Open, By::Amplifier), (After::Short, By::Voltage)]
    {
        let setup = flat(Drive::Voltage, Shaping::Plain, Stage { by, after, ..Stage::default() });
        let levels = (0..6400).map(|n| if n < 3200 { 0.8 } else { 0.2 });
        let (late, all) = played(&setup, levels);
        let [high, low] = [0.8, 0.2].map(|level| setup.speed_of(level));
        let p = &setup.parameters;
        let before = all[late + 3199];
        assert!((before[2] / high - 1.0).abs() < 0.02, "{after:?} {by:?}: {} {high}", before[2]);
        let falls: Vec<&[f64; 3]> = all[late + 3202..].iter().take_while(|x| x[2] > 1.02 * low).collect();
        assert!(falls.len() > 80, "{after:?}");
        for [_, current, speed] in falls {
            let due = if after == After::Open { 0.0 } else { -p.gain * speed / p.resistance };
            assert!(
                (current - due).abs() < 0.01 * p.gain * high / p.resistance,
                "{after:?} {by:?}: {current} {due}"
            );
        }
        let last = all.last().unwrap()[2];
        assert!((last / low - 1.0).abs() < 0.03, "{after:?} {by:?}: {last} {low}");
    }
}
