//! Levels, orders and bounds of stability; what measures and what is measured.

use super::super::equation::{LINEAR, State};
use super::super::euler::Euler;
use super::super::method::{Contender, Method};
use super::super::ours::{Exact, Rumble, Split};
use super::super::problem::{Problem, Subject, listed};
use super::super::rk4::Rk4;
use super::super::trapezoidal::Trapezoidal;
use super::{Course, Measured, RATES, Wish, race};
use crate::actuator::motor::Level;
use crate::report::cost::Outcome;

fn problem(model: &str, name: &str) -> Problem {
    listed().into_iter().find(|p| p.model == model && p.name == name).expect("one that is listed")
}

fn motor(course: &Course, level: Level) -> [f64; 2] {
    let (speed, angle) = course.errors(&mut Rumble::new(&course.problem, level, course.rate).unwrap());
    [speed, angle]
}

#[test]
fn levels_differ_as_they_say() {
    for name in ["gravity", "full"] {
        let [slow, middle, quick] =
            [4e3, 16e3, 48e3].map(|rate| Course::new(&problem("rumble motor", name), rate));
        let of = |level| [&slow, &middle, &quick].map(|course| motor(course, level));
        let (fine, default) = (of(Level::Fine), of(Level::Default));
        let economy = motor(&quick, Level::Economy);
        for n in 0..2 {
            assert!(1e3 * fine[2][n] < default[2][n] && 1e3 * default[2][n] < economy[n], "{name} {n}");
            let order = |e: &[[f64; 2]; 3]| (e[0][n] / e[2][n]).ln() / 12f64.ln();
            assert!((1.8..2.6).contains(&order(&default)), "{name} {n}: {}", order(&default));
            assert!((3.0..4.5).contains(&order(&fine)), "{name} {n}: {}", order(&fine));
        }
        // What gravity asks at this rate.
        assert!(default[2][0] < 3e-7 && default[2][1] < 1e-5 && fine[2][0] < 1e-9 && fine[2][1] < 3e-8);
        // Without inductance it is late by L/R: 2 τ_e/τ_m of the speed in a reversal, and no better for being quick.
        let Subject::Motor(p) = quick.problem.subject else { unreachable!() };
        let late = 2.0 * p.electrical_time() / p.mechanical_time();
        assert!((0.3 * late..1.5 * late).contains(&economy[0]), "{name}: {economy:?} {late}");
    }
}

#[test]
fn what_is_linear_is_exact() {
    for rate in RATES {
        let course = Course::new(&problem("rumble motor", "linear"), rate);
        for level in [Level::Fine, Level::Default] {
            let [speed, angle] = motor(&course, level);
            assert!(speed < 1e-11 && angle < 1e-11, "{level:?} {rate}: {speed} {angle}");
        }
        for model in ["tactor", "inertial motor"] {
            let course = Course::new(&problem(model, "burst"), rate);
            let (error, _) = course.errors(&mut Exact::new(&course.problem, rate).unwrap());
            assert!(error < 1e-11, "{model} {rate}: {error}");
        }
    }
}

/// Real poles λ: Euler is stable for |λ|T < 2, RK4 for |λ|T < 2.785294, where 1 − z/2 + z²/6 − z³/24 = 0.
#[test]
fn plain_methods_diverge_where_theory_says() {
    let problem = problem("rumble motor", "linear");
    let e = problem.equation();
    let [mean, product] = [
        0.5 * (e.resistance / e.inductance + e.damping / e.inertia),
        (e.resistance * e.damping + e.gain * e.gain) / (e.inductance * e.inertia),
    ];
    let fastest = mean + (mean * mean - product).sqrt();
    assert!((fastest * 1e-5 - 1.0).abs() < 1e-2, "about R/L");
    let z: f64 = 2.785_293_563_405_282;
    assert!((1.0 - z / 2.0 + z * z / 6.0 - z * z * z / 24.0).abs() < 1e-12);
    let held = |rate: f64, bound: f64| {
        let course = Course::new(&problem, rate);
        let h = 1.0 / rate;
        let error = if bound == 2.0 {
            course.errors(&mut Euler::<LINEAR>::new(&e, h)).0
        } else {
            course.errors(&mut Rk4::<LINEAR>::new(&e, h)).0
        };
        error < 0.1
    };
    for bound in [2.0, z] {
        assert!(!held(0.97 * fastest / bound, bound), "{bound}");
        assert!(held(1.03 * fastest / bound, bound), "{bound}");
    }
}

/// RK4 and the trapezoidal rule have their orders where all is smooth.
#[test]
fn plain_methods_have_their_orders() {
    let problem = problem("inertial motor", "burst");
    let e = problem.equation();
    let [slow, quick] = [48e3, 192e3].map(|rate| {
        let course = Course::new(&problem, rate);
        let h = 1.0 / rate;
        [
            course.errors(&mut Euler::<LINEAR>::new(&e, h)).0,
            course.errors(&mut Trapezoidal::<LINEAR>::new(&e, h)).0,
            course.errors(&mut Rk4::<LINEAR>::new(&e, h)).0,
        ]
    });
    for (n, order) in [1.0, 2.0, 4.0].into_iter().enumerate() {
        let is = (slow[n] / quick[n]).log2() / 2.0;
        assert!((is - order).abs() < 0.35, "{n}: {is}");
    }
}

/// In large motion errors fall with the square of the step, whether a sample or its parts are steps.
#[test]
fn large_motion_is_of_second_order() {
    let problem = problem("tactor", "large");
    let error = |rate: f64, steps: u8| {
        let course = Course::new(&problem, rate);
        course.errors(&mut Split::new(&course.problem, steps, rate).unwrap()).0
    };
    let [one, four, sixteen] = [1, 4, 16].map(|steps| error(48e3, steps));
    for (coarse, fine) in [(one, four), (four, sixteen)] {
        let order = (coarse / fine).log2() / 2.0;
        assert!((1.8..2.2).contains(&order), "{order}");
    }
    assert!(one < 3e-4 && sixteen < 1e-6, "{one} {sixteen}");
}

/// The way that is timed does what the way that is looked at does.
#[test]
fn runs_are_the_same_as_steps() {
    fn check<M: Method>(course: &Course, mut method: M) {
        let mut last = [0.0; 3];
        method.trace(&course.drives, &mut |x| last = x);
        method.restart();
        method.run(&course.drives);
        assert_eq!(method.state(), last, "{}", course.problem.name);
        method.restart();
        assert_eq!(method.state(), [0.0; 3]);
    }
    for problem in listed() {
        let (rate, course) = (4000.0, Course::new(&problem, 4000.0));
        match problem.subject {
            Subject::Motor(_) => {
                for level in [Level::Fine, Level::Default, Level::Economy] {
                    let mut method = Rumble::new(&problem, level, rate).unwrap();
                    method.run(&[3.0; 100]);
                    method.restart();
                    check(&course, method);
                }
            }
            Subject::Large(..) => check(&course, Split::new(&problem, 4, rate).unwrap()),
            _ => check(&course, Exact::new(&problem, rate).unwrap()),
        }
    }
}

/// Plays a truth, in some samples with something added to speed and place; then what was played so far.
struct Played(Vec<State>, std::ops::Range<usize>, f64, usize);

impl Method for Played {
    fn restart(&mut self) {
        self.3 = 0;
    }

    fn step(&mut self, _: f64) {
        self.3 += 1;
    }

    fn state(&self) -> State {
        let mut x = self.0[(self.3.max(1) - 1).min(self.0.len() - 1)];
        if self.1.contains(&(self.3.max(1) - 1)) {
            x[1] += self.2;
            x[2] += self.2;
        }
        x
    }
}

#[test]
fn errors_are_what_is_between_it_and_the_truth() {
    for problem in [problem("rumble motor", "full"), problem("tactor", "burst")] {
        let course = Course::new(&problem, 1000.0);
        let all = course.truth.len();
        let played = |from, more| course.errors(&mut Played(course.truth.clone(), from, more, 0));
        assert_eq!(played(0..all, 0.0), (0.0, 0.0));
        // In the last sample alone.
        let (error, place) = played(all - 1..all, -0.25 * course.scale);
        assert!((error - 0.25).abs() < 1e-12 && (place - 0.25 * course.scale).abs() < 1e-9 * course.scale);
        // What is no number once is no number.
        let (error, place) = played(5..6, f64::NAN);
        assert!(error.is_nan() && place.is_nan());
        for (more, outcome) in [
            (9.9, Outcome::Held),
            (10.1, Outcome::Diverged),
            (f64::INFINITY, Outcome::Diverged),
            (f64::NAN, Outcome::Diverged),
        ] {
            let measured = course.measure(&mut Played(course.truth.clone(), 3..9, more * course.scale, 0));
            let row = course.row("played", false, Ok(measured));
            assert_eq!(row.outcome, outcome, "{more}");
            assert_eq!(row.ns.is_some(), outcome == Outcome::Held);
        }
    }
}

/// Says nothing of half of what it was given.
struct Half;

impl Method for Half {
    fn restart(&mut self) {}

    fn step(&mut self, _: f64) {}

    fn state(&self) -> State {
        [0.0; 3]
    }

    fn trace(&mut self, drives: &[f64], see: &mut dyn FnMut(State)) {
        drives[drives.len() / 2..].iter().for_each(|_| see([0.0; 3]));
    }
}

#[test]
fn what_is_not_told_is_not_right() {
    let course = Course::new(&problem("tactor", "burst"), 1000.0);
    let Measured { error, ns, .. } = course.measure(&mut Half);
    assert!(error.is_nan() && ns.is_none());
}

#[test]
fn a_race_shows_every_row_once_and_refuses_bad_rates() {
    let wish = Wish {
        problems: vec![problem("tactor", "large"), problem("rumble motor", "full")],
        rates: vec![1e3, 2e3],
    };
    let mut seen = Vec::new();
    let rows = race(&wish, &mut |row| seen.push(row.clone())).unwrap();
    assert_eq!(rows.len(), wish.rows());
    // What is no number is not equal to itself.
    assert_eq!(format!("{rows:?}"), format!("{seen:?}"));
    for row in &rows {
        assert_eq!(row.ns.is_some(), row.outcome == Outcome::Held);
        assert!(row.ns.is_none_or(|ns| ns > 0.0 && row.load() == Some(ns * 1e-9 * row.rate)));
        assert_eq!(row.angle.is_some(), row.model == "rumble motor");
    }
    assert!(rows.iter().any(|row| row.method == "Euler" && row.diverged()));
    for rate in [0.0, f64::NAN, 99.0, 1e9] {
        let wish = Wish { rates: vec![rate], ..Wish::default() };
        assert_eq!(race(&wish, &mut |_| ()).unwrap_err().field, "rate");
    }
}

#[test]
fn a_method_refuses_a_problem_that_is_not_its_own() {
    let course = Course::new(&problem("tactor", "burst"), 1000.0);
    for method in [Contender::Motor(Level::Fine), Contender::Split(4)] {
        let run = method.run(&course);
        assert_eq!(course.row(method.name(), true, run).outcome, Outcome::Refused);
    }
    let course = Course::new(&problem("rumble motor", "linear"), 1000.0);
    assert!(Contender::Exact.run(&course).is_err());
}
