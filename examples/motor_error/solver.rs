//! A well-kept crate of solvers, `ode_solvers`, on the same problems.
//!
//! Dormand and Prince's methods of order 5 and 8, restarted at every sample, as a drive that changes at every sample wants, and running free
//! from one change of the drive to the next. They are given the plain equations with smoothed dry friction. A name says
//! the tolerance, relative, and absolute as a share of what the problem does at most.

use ode_solvers::{Dop853, Dopri5, OutputType, System, Vector3};
use pacinian::actuator::fault::{Fault, Limit};
use pacinian::report::actuators::equation::{Equation, LARGE, LINEAR, MOTOR, State};
use pacinian::report::actuators::{Course, Method, Row, Wish};

/// The equations under a held drive, in shares of what the problem does at most, so that one absolute tolerance suits all.
#[derive(Debug, Clone, Copy)]
struct Held {
    equation: Equation,
    scale: State,
    drive: f64,
}

impl System<f64, Vector3<f64>> for Held {
    fn system(&self, _: f64, y: &Vector3<f64>, dy: &mut Vector3<f64>) {
        let x = [y[0] * self.scale[0], y[1] * self.scale[1], y[2] * self.scale[2]];
        let rates = match self.equation.kind() {
            MOTOR => self.equation.smooth_rates::<MOTOR>(x, self.drive),
            LARGE => self.equation.smooth_rates::<LARGE>(x, self.drive),
            _ => self.equation.smooth_rates::<LINEAR>(x, self.drive),
        };
        for n in 0..3 {
            dy[n] = rates[n] / self.scale[n];
        }
    }
}

/// Which of the crate's methods.
#[derive(Debug, Clone, Copy)]
enum Order {
    Five,
    Eight,
}

/// One of them.
struct Solver {
    held: Held,
    order: Order,
    tolerance: f64,
    free: bool,
    period: f64,
    state: Vector3<f64>,
    gave_up: bool,
}

impl Solver {
    fn new(course: &Course, order: Order, tolerance: f64, free: bool) -> Self {
        let most = |n: usize| course.truth.iter().map(|x| x[n].abs()).fold(0.0, f64::max);
        let held = Held { equation: course.problem.equation(), scale: [0, 1, 2].map(most), drive: 0.0 };
        Self {
            held,
            order,
            tolerance,
            free,
            period: 1.0 / course.rate,
            state: Vector3::zeros(),
            gave_up: false,
        }
    }

    /// Over so many samples under one drive; the state at the end of each, or not a number where it gives up.
    fn hold(&mut self, drive: f64, samples: usize, see: &mut dyn FnMut(State)) {
        let system = Held { drive, ..self.held };
        let (end, dx, tolerance) = (samples as f64 * self.period, self.period, self.tolerance);
        // A single sample needs no dense output.
        let output = if samples == 1 { OutputType::Sparse } else { OutputType::Dense };
        macro_rules! solve {
            ($method:ident) => {{
                let mut solver = $method::new(system, 0.0, end, dx, self.state, tolerance, tolerance);
                solver.set_output(output);
                let whole = solver.integrate().is_ok();
                (whole, solver.results().get().1.clone())
            }};
        }
        let (whole, states) = match self.order {
            Order::Five => solve!(Dopri5),
            Order::Eight => solve!(Dop853),
        };
        let last = states.last().copied().unwrap_or(self.state);
        self.gave_up |= !whole;
        self.state = if whole { last } else { Vector3::repeat(f64::NAN) };
        // The dense output begins with the first state, and rounding may leave out the last but one or add one.
        for n in 1..samples {
            see(self.unscaled(states.get(n).filter(|_| whole).unwrap_or(&self.state)));
        }
        see(self.unscaled(&self.state));
    }

    fn unscaled(&self, y: &Vector3<f64>) -> State {
        [0, 1, 2].map(|n| y[n] * self.held.scale[n])
    }
}

impl Method for Solver {
    fn restart(&mut self) {
        self.state = Vector3::zeros();
    }

    fn step(&mut self, drive: f64) {
        self.hold(drive, 1, &mut |_| ());
    }

    fn state(&self) -> State {
        self.unscaled(&self.state)
    }

    fn run(&mut self, drives: &[f64]) {
        self.trace(drives, &mut |_| ());
    }

    fn trace(&mut self, drives: &[f64], see: &mut dyn FnMut(State)) {
        let mut left = drives;
        while let Some(drive) = left.first() {
            let same = if self.free { left.iter().take_while(|other| *other == drive).count() } else { 1 };
            self.hold(*drive, same, see);
            left = &left[same..];
        }
    }
}

const SOLVERS: [(&str, Order, f64, bool); 4] = [
    ("Dopri5 1e-6, each sample", Order::Five, 1e-6, false),
    ("Dop853 1e-9, each sample", Order::Eight, 1e-9, false),
    ("Dopri5 1e-6, free", Order::Five, 1e-6, true),
    ("Dop853 1e-12, free", Order::Eight, 1e-12, true),
];

/// How many rows they come to.
pub fn count(wish: &Wish) -> usize {
    SOLVERS.len() * wish.problems.len() * wish.rates.len()
}

/// All of them on all problems at all rates.
pub fn race(wish: &Wish, progress: &mut dyn FnMut(&Row)) -> Vec<Row> {
    let mut rows = Vec::new();
    for problem in &wish.problems {
        let courses: Vec<Course> = wish.rates.iter().map(|rate| Course::new(problem, *rate)).collect();
        for (name, order, tolerance, free) in SOLVERS {
            for course in &courses {
                let mut solver = Solver::new(course, order, tolerance, free);
                let measured = course.measure(&mut solver);
                // It ends with an error where it takes a problem for stiff.
                let refused =
                    Fault { field: "rate", value: course.rate, limit: Limit::Absent, because: None };
                let row = course.row(name, false, if solver.gave_up { Err(refused) } else { Ok(measured) });
                progress(&row);
                rows.push(row);
            }
        }
    }
    rows
}

/// For each problem at 48 kHz: how many times longer the quickest of these takes that is as exact as a model.
pub fn print_faster(rows: &[Row]) {
    println!(
        "48 kHz: the quickest row of the crate with no larger error than a model's, and how many times longer it takes"
    );
    for own in rows.iter().filter(|row| row.own && row.rate == 48e3) {
        let others = rows.iter().filter(|row| {
            row.title() == own.title()
                && row.rate == 48e3
                && row.method.starts_with("Dop")
                && row.error <= own.error
        });
        let best = others.min_by(|a, b| a.ns.unwrap_or(f64::MAX).total_cmp(&b.ns.unwrap_or(f64::MAX)));
        let said = match (best, own.ns) {
            (Some(best), Some(ns)) => {
                format!("{}, {:.1}", best.method, best.ns.unwrap_or(f64::NAN) / ns)
            }
            _ => "none is as exact".into(),
        };
        println!("  {:24} {:16} {said}", own.title(), own.method);
    }
}
