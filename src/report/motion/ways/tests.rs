//! Ways side by side, against closed forms.

use crate::actuator::motor::{Drive, Level, Parameters, Plan};
use crate::report::motion::{Bench, Done, Envelope, Row, Way, Wish, bursts, clicks};

const RATE: f64 = 48_000.0;

/// Without inductance and gravity.
fn bench() -> Bench {
    let p = Parameters { inductance: 0.0, gravity: 0.0, ..Parameters::COIN };
    Bench::new(&p, Plan::whole(Level::Fine), RATE, 0.0).unwrap()
}

fn done(rows: &[Row], way: Way) -> &Done {
    rows.iter().find(|row| row.way == way).unwrap().done.as_ref().unwrap()
}

/// Half the rated vibration with the rated voltage as the most there is.
fn half(seconds: f64, envelope: Envelope) -> Vec<Row> {
    bursts(&bench(), &Wish { level: 0.5, seconds, envelope }, 3.0).unwrap()
}

/// The speed under a voltage that is not changed: ω_a (1 − exp(−t/τ)), so that √0.9 ω* is there after τ ln(ω_a/(ω_a − √0.9 ω*)).
#[test]
fn an_overdriven_burst_rises_and_stops_as_its_closed_form() {
    let (rows, p) = (half(0.2, Envelope::Rectangle), bench().parameters);
    let (tau, top) = (p.mechanical_time(), p.rated_speed());
    let speed = 0.5_f64.sqrt() * top;
    let rise = |most: f64| -tau * (1.0 - 0.9_f64.sqrt() * speed / most).ln();
    let overdrive = &done(&rows, Way::Overdrive).figures;
    assert!((overdrive.rise[1].unwrap() - rise(top)).abs() < 1e-3 * tau, "{overdrive:?}");
    // Plain: towards the wish itself, as slowly as the rotor is.
    let plain = &done(&rows, Way::Plain).figures;
    assert!((plain.rise[1].unwrap() - rise(speed)).abs() < 1e-3 * tau, "{plain:?}");
    // With all the voltage backward: τ ln(1 + ω*/ω_b).
    let backward = (p.stall_torque(3.0) + p.coulomb) / p.damping();
    let brake = tau * (speed / backward).ln_1p();
    assert!((overdrive.stop.unwrap() - brake).abs() < 2.0 / RATE, "{overdrive:?} {brake}");
    let switching = &done(&rows, Way::Switching).figures;
    assert!((switching.stop.unwrap() - brake).abs() < 0.03 * brake, "{switching:?} {brake}");
    // The inverse has stopped when it should, since it brakes that long before; its aim leaves two hundredths of the voltage aside.
    let inverse = done(&rows, Way::Inverse);
    let backward = (p.stall_torque(0.98 * 3.0) + p.coulomb) / p.damping();
    let brake = tau * (speed / backward).ln_1p();
    assert!((inverse.look_ahead - brake).abs() < 3.0 / RATE + 2e-3 * brake, "{} {brake}", inverse.look_ahead);
    assert!(inverse.figures.stop.unwrap() < 1e-3, "{:?}", inverse.figures);
    for way in [Way::Plain, Way::Overdrive, Way::Switching] {
        assert_eq!(done(&rows, way).look_ahead, 0.0, "{way:?}");
    }
}

/// What each is for.
#[test]
fn an_envelope_is_followed_by_those_that_can() {
    let rows = half(0.15, Envelope::RaisedCosine);
    let error = |way| done(&rows, way).figures.error.unwrap();
    assert!(error(Way::Inverse) < 0.01 && error(Way::Switching) < 0.02, "{rows:?}");
    assert!(error(Way::Plain) > 0.2, "{}", error(Way::Plain));
    // It falls no faster than the motor can be braked, so that nothing has to be known before.
    assert_eq!(done(&rows, Way::Inverse).look_ahead, 0.0);
    assert!(rows.iter().all(|row| row.way != Way::Overdrive));
}

/// At its own limit a motor is never as fast as that; it is driven towards it all the time.
#[test]
fn the_whole_level_without_any_room_is_driven_with_all_there_is() {
    let wish = Wish { level: 1.0, seconds: 0.1, envelope: Envelope::Rectangle };
    let rows = bursts(&bench(), &wish, 3.0).unwrap();
    let [plain, overdrive] = [Way::Plain, Way::Overdrive].map(|way| done(&rows, way).figures);
    assert_eq!(plain.rise, overdrive.rise);
    assert!(overdrive.stop.unwrap() < 0.5 * plain.stop.unwrap());
}

/// t2 = τ ln(1 + ω1/ω_b), a quarter of a turn, and it stands; a pulse of that length goes on.
#[test]
fn a_click_stands_when_it_is_over() {
    let (bench, rows) = (bench(), clicks(&bench(), 0.25, Drive::Voltage(3.0)).unwrap());
    let p = bench.parameters;
    let (click, pulse) = (done(&rows, Way::Click), done(&rows, Way::Pulse));
    assert!((click.run.turns - 0.25).abs() < 1e-4 && click.figures.stop.unwrap() < 1.0 / RATE);
    let [forward, backward, _] = click.click.as_ref().unwrap().seconds;
    let tau = p.mechanical_time();
    let at = |torque: f64| torque / p.damping();
    let fastest = -at(p.stall_torque(3.0) - p.coulomb) * (-forward / tau).exp_m1();
    let due = tau * (fastest / at(p.stall_torque(3.0) + p.coulomb)).ln_1p();
    assert!((backward - due).abs() < 1e-9, "{backward} {due}");
    // The pulse: faster for all of the time, then shorted.
    let fastest = -at(p.stall_torque(3.0) - p.coulomb) * (-(forward + backward) / tau).exp_m1();
    let due = tau * (fastest / at(p.coulomb)).ln_1p();
    assert!((pulse.figures.stop.unwrap() - due).abs() < 2.0 / RATE, "{:?} {due}", pulse.figures);
    assert!(pulse.run.turns > 1.0);
    let back = clicks(&bench, -0.25, Drive::Voltage(3.0)).unwrap();
    assert!((done(&back, Way::Click).run.turns + 0.25).abs() < 1e-4);
    assert!(done(&back, Way::Pulse).run.turns < -1.0);
    // By a current, too; where that ends nothing brakes any more.
    let rows = clicks(&bench, 0.25, Drive::Current { amperes: 0.08, limit: 5.0 }).unwrap();
    let (click, pulse) = (done(&rows, Way::Click), done(&rows, Way::Pulse));
    assert!((click.run.turns - 0.25).abs() < 1e-4 && click.figures.stop.unwrap() < 1.0 / RATE);
    assert!(pulse.run.turns > 1.0 && pulse.figures.stop.unwrap() > 0.01, "{:?}", pulse.figures);
}

#[test]
fn what_cannot_be_done_says_why() {
    let rows = clicks(&bench(), 0.25, Drive::Voltage(0.1)).unwrap();
    let why = rows[0].done.as_ref().unwrap_err().to_string();
    assert!(rows.len() == 1 && why.contains("0.1 V do not start the motor"), "{why}");
    assert_eq!(clicks(&bench(), 0.25, Drive::Voltage(f64::NAN)).unwrap_err().field, "volts");
    let wish = Wish { level: 2.0, seconds: 0.1, envelope: Envelope::Rectangle };
    assert_eq!(bursts(&bench(), &wish, 3.0).unwrap_err().field, "level");
    let rows = bursts(&bench(), &Wish { level: 0.5, ..wish }, 0.3).unwrap();
    let why = rows[1].done.as_ref().unwrap_err().to_string();
    assert!(rows[0].done.is_ok() && why.contains("0.3 V do not start the motor"), "{why}");
}
