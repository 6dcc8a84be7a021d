//! Runs and their figures against closed forms.

use std::f64::consts::TAU;

use crate::actuator::motor::{Casing, Drive, Level, Parameters, Plan};
use crate::actuator::shape::Course;
use crate::report::motion::{Bench, Envelope, Felt, Figures, Given, Run, Wish};

const RATE: f64 = 48_000.0;
const FULL: Wish = Wish { level: 1.0, seconds: 0.4, envelope: Envelope::Rectangle };

/// No inductance, no gravity, no dry friction: one exponential.
fn linear() -> Parameters {
    Parameters { inductance: 0.0, gravity: 0.0, coulomb: 0.0, stiction: 0.0, ..Parameters::COIN }
}

/// With dry friction.
fn dry() -> Parameters {
    Parameters { inductance: 0.0, gravity: 0.0, ..Parameters::COIN }
}

fn bench(parameters: &Parameters) -> Bench {
    Bench::new(parameters, Plan::whole(Level::Fine), RATE, 0.0).unwrap()
}

fn run(bench: &Bench, course: Course) -> Run {
    bench.run(&Given::Course(course), 0.0).unwrap()
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a} {b}");
}

/// ω = ω_ss (1 − exp(−t/τ)), and vibration with its square: 50 % after 1.228 τ, 90 % after 2.970 τ.
#[test]
fn a_step_rises_in_its_time_constants() {
    let p = linear();
    let (bench, tau) = (bench(&p), p.mechanical_time());
    let run = run(&bench, Course::on(p.rated_volts, FULL.seconds));
    let figures = Figures::new(&bench, &run, Some(&FULL), FULL.seconds);
    let [half, most] = figures.rise.map(Option::unwrap);
    near(half, 1.2279 * tau, 2e-4 * tau);
    near(most, 2.9697 * tau, 2e-4 * tau);
    // A tenth of it from the first on.
    near(figures.felt.unwrap()[0], -tau * (1.0 - 0.1_f64.sqrt()).ln(), 2e-4 * tau);
    // And down again with the same constant: ω = √0.1 of what it was.
    let reached = -(-FULL.seconds / tau).exp_m1();
    near(figures.felt.unwrap()[1], FULL.seconds - tau * (0.1_f64.sqrt() / reached).ln(), 2.0 / RATE);
    // e = −2x + x², x = exp(−t/τ), squared and averaged over the burst.
    let x = |n: i32| -(-f64::from(n) * FULL.seconds / tau).exp_m1();
    let square = tau / FULL.seconds * (2.0 * x(2) - 4.0 / 3.0 * x(3) + 0.25 * x(4));
    near(figures.error.unwrap(), square.sqrt(), 1e-3 * square.sqrt());
}

/// A mass that is not eccentric cannot be felt, and misses nothing of what is wanted.
#[test]
fn of_what_cannot_be_felt_there_is_neither_rise_nor_error() {
    let bench = bench(&Parameters { eccentric: 0.0, ..dry() });
    let run = run(&bench, Course::on(3.0, FULL.seconds));
    let figures = Figures::new(&bench, &run, Some(&FULL), FULL.seconds);
    assert_eq!((figures.rise, figures.error, figures.felt, figures.peak), ([None; 2], None, None, 0.0));
    assert!(figures.stop.unwrap() > 0.01);
}

/// |a| = (m_e r/M_t) √(ω⁴ + α²), at every step.
#[test]
fn the_peak_has_the_rotors_own_acceleration_in_it() {
    let p = linear();
    let (bench, tau, top) = (bench(&p), p.mechanical_time(), p.rated_speed());
    let run = run(&bench, Course::on(p.rated_volts, 0.01));
    for n in [0, 100, 300] {
        let t = run.time(n);
        let (speed, rises) = (-top * (-t / tau).exp_m1(), top / tau * (-t / tau).exp());
        let due = p.eccentric / 0.1 * (speed.powi(4) + rises * rises).sqrt();
        near(run.traces.felt[n], due, 1e-9 * due);
    }
    let figures = Figures::new(&bench, &run, None, 0.01);
    // At the end of the pulse the rotor is fastest, and brakes no less than it sped up before.
    near(figures.peak_at, 0.01, 1.5 / RATE);
    assert_eq!((figures.rise, figures.error), ([None; 2], None));
}

/// Shorted, with dry friction: ω = (ω0 + T_c/B) exp(−t/τ) − T_c/B, until τ ln(1 + B ω0/T_c).
#[test]
fn a_shorted_rotor_stands_when_friction_has_stopped_it() {
    let p = dry();
    let (bench, tau) = (bench(&p), p.mechanical_time());
    let wish = Wish { seconds: 1.0, ..FULL };
    let at_top = run(&bench, Course::on(p.rated_volts, wish.seconds));
    let due = tau * (1.0 + p.damping() * p.rated_speed() / p.coulomb).ln();
    let stop = Figures::new(&bench, &at_top, Some(&wish), wish.seconds).stop.unwrap();
    near(stop, due, 1.5 / RATE);
    // Open: without back-EMF, J/b in place of τ.
    let open = Course::ending_in(Drive::Open).then(wish.seconds, Drive::Voltage(p.rated_volts));
    let alone = p.effective_inertia() / p.viscous;
    let due = alone * (1.0 + p.viscous * p.rated_speed() / p.coulomb).ln();
    let stop = Figures::new(&bench, &run(&bench, open), Some(&wish), wish.seconds).stop.unwrap();
    near(stop, due, 1.5 / RATE);
}

/// What comes in is V ∫i, what goes out is heat, friction and what is stored; and all of it is told.
#[test]
fn energy_is_that_of_the_closed_form() {
    let p = linear();
    let (t, tau, volts) = (0.05, p.mechanical_time(), p.rated_volts);
    let course = Course::ending_in(Drive::Voltage(volts));
    let run = bench(&p).run(&Given::Course(course), t).unwrap();
    let t = run.traces.speeds.len() as f64 / RATE;
    let turned = p.rated_speed() * (t + tau * (-t / tau).exp_m1());
    let due = volts * (volts * t - p.gain * turned) / p.resistance;
    near(run.energy.supplied, due, 1e-9 * due);
    near(run.energy.missing(run.stored), 0.0, 1e-9 * due);
    near(run.turns, turned / TAU, 1e-9 * turned);
    assert_eq!(run.stands, None, "it is driven on");
}

#[test]
fn a_motor_that_is_held_is_felt_by_its_force() {
    let p = Parameters { casing: Casing::Held, ..dry() };
    let bench = bench(&p);
    assert_eq!(bench.felt(), Felt::Force);
    near(bench.rated(), p.eccentric * p.rated_speed().powi(2), 1e-12);
    let run = run(&bench, Course::on(p.rated_volts, 0.5));
    let peak = Figures::new(&bench, &run, None, 0.5).peak;
    assert!((peak / bench.rated() - 1.0).abs() < 0.02, "{peak}");
}

#[test]
fn what_never_starts_is_never_felt() {
    let p = dry();
    let bench = bench(&p);
    let wish = Wish { level: 0.5, seconds: 0.05, envelope: Envelope::Rectangle };
    let run = run(&bench, Course::on(0.5 * p.start_volts(), 0.05));
    let figures = Figures::new(&bench, &run, Some(&wish), 0.05);
    assert_eq!((figures.rise, figures.felt, figures.stop), ([None; 2], None, Some(0.0)));
    assert_eq!((figures.peak, figures.peak_at, run.turns), (0.0, 0.0, 0.0));
    near(figures.error.unwrap(), 1.0, 1e-12);
    assert_eq!(Figures::new(&bench, &run, None, 0.05).felt, None);
}

#[test]
fn a_bench_that_cannot_be_is_refused_by_name() {
    let field =
        |p: Parameters, rate, angle| Bench::new(&p, Plan::whole(Level::Fine), rate, angle).unwrap_err().field;
    assert_eq!(field(Parameters { gain: 0.0, ..dry() }, RATE, 0.0), "gain");
    assert_eq!(field(dry(), 10.0, 0.0), "rate");
    assert_eq!(field(dry(), RATE, f64::NAN), "angle");
}
