//! What errors are told against, against trajectories of 19 digits.

use crate::common::cases;
use pacinian::actuator::motor::Drive;
use pacinian::report::actuators::Problem;
use pacinian::report::actuators::problem::{Signal, Subject};
use pacinian::report::actuators::truth::truth;

/// All trajectories under voltages that switch on samples of 4 kHz: 3e-16 of the rated speed and 6e-14 rad are reached. No line of code is common to the truth and the motor's model.
#[test]
fn the_truth_is_that_of_the_reference() {
    let rate = 4000.0;
    let mut seen = 0;
    for case in cases() {
        let volts = |(until, drive): &(f64, Drive)| match drive {
            Drive::Voltage(volts) => Some((*until, *volts)),
            _ => None,
        };
        let Some(pieces) = case.segments.iter().map(volts).collect::<Option<Vec<_>>>() else { continue };
        let whole = |x: f64| (x - x.round()).abs() < 1e-6;
        let (seconds, every) = (pieces[pieces.len() - 1].0, case.every * rate);
        if case.angle != 0.0 || !whole(every) || !pieces.iter().all(|(until, _)| whole(until * rate)) {
            continue;
        }
        let problem = Problem {
            model: "rumble motor",
            name: "reference",
            about: "",
            subject: Subject::Motor(case.parameters),
            signal: Signal::Pieces(pieces),
            seconds,
        };
        let (states, scale) = (truth(&problem, rate), case.parameters.rated_speed());
        let (mut speed, mut angle, mut rows) = (0.0f64, 0.0f64, 0);
        for (n, row) in case.rows.iter().enumerate().skip(1) {
            let Some(x) = states.get((n as f64 * every).round() as usize - 1) else { continue };
            speed = speed.max((x[1] - row[1]).abs() / scale);
            angle = angle.max((x[2] - row[2]).abs());
            rows += 1;
        }
        assert!(rows + 2 >= case.rows.len(), "{}: {rows} of {}", case.name, case.rows.len());
        assert!(speed < 6e-16 && angle < 1.2e-13, "{}: speed {speed:e}, angle {angle:e}", case.name);
        seen += 1;
    }
    assert_eq!(seen, 27);
}
