//! The trapezoidal rule: x₁ = x₀ + h/2 (f(x₀) + f(x₁)). Of second order, stable for every step; what is much quicker than a step rings.

use super::equation::{Equation, LINEAR, MOTOR, State};
use super::method::Method;

/// Newton's corrections of a step, at most.
const MOST: usize = 12;

type Matrix = [State; 3];

/// It. What is linear is solved once beforehand; else each step by Newton's method. Dry friction is clamped: a torque over the step that
/// brings the speed at its end towards 0 and not beyond, of T_c at most, or T_s where it was at rest.
#[derive(Debug, Clone)]
pub struct Trapezoidal<const KIND: u8> {
    equation: Equation,
    period: f64,
    state: State,
    /// What a linear step makes of the state, and of the drive.
    step: (Matrix, State),
}

impl<const KIND: u8> Trapezoidal<KIND> {
    /// At rest, so many seconds a sample.
    pub fn new(equation: &Equation, period: f64) -> Self {
        let equation = equation.ready();
        let a = equation.jacobian::<KIND>([0.0; 3]);
        let implicit = inverse(&beside(&a, -0.5 * period));
        let explicit = beside(&a, 0.5 * period);
        let mut whole = [[0.0; 3]; 3];
        for j in 0..3 {
            for k in 0..3 {
                whole[j][k] = (0..3).map(|l| implicit[j][l] * explicit[l][k]).sum();
            }
        }
        let driven = [0, 1, 2].map(|j| implicit[j][0] * period / equation.inductance);
        Self { equation, period, state: [0.0; 3], step: (whole, driven) }
    }

    /// The end of a step under a further force, and what each newton of it adds to the speed there.
    #[inline]
    fn solve(&self, from: State, drive: f64, force: f64) -> (State, f64) {
        let (e, half) = (&self.equation, 0.5 * self.period);
        let begins = e.rates::<KIND>(self.state, drive);
        let (mut x, mut gives) = (from, 0.0);
        for _ in 0..MOST {
            let ends = e.rates::<KIND>(x, drive);
            let mut left = [0, 1, 2].map(|n| self.state[n] - x[n] + half * (begins[n] + ends[n]));
            left[1] += self.period * force * e.inverse[1];
            let inverse = inverse(&beside(&e.jacobian::<KIND>(x), -half));
            gives = inverse[1][1] * self.period * e.inverse[1];
            let mut settled = true;
            for n in 0..3 {
                let more = times(&inverse[n], &left);
                x[n] += more;
                settled &= more.abs() <= 1e-10 * x[n].abs() + 1e-14;
            }
            if settled {
                break;
            }
        }
        (x, gives)
    }
}

impl<const KIND: u8> Method for Trapezoidal<KIND> {
    fn restart(&mut self) {
        self.state = [0.0; 3];
    }

    #[inline(always)]
    fn step(&mut self, drive: f64) {
        if KIND == LINEAR {
            let (whole, driven) = &self.step;
            self.state = [0, 1, 2].map(|n| times(&whole[n], &self.state) + driven[n] * drive);
            return;
        }
        let (mut next, gives) = self.solve(self.state, drive, 0.0);
        if KIND == MOTOR && self.equation.stiction > 0.0 {
            let Equation { coulomb, stiction, .. } = self.equation;
            let needed = -next[1] / gives;
            let most = if self.state[1] == 0.0 { stiction } else { coulomb };
            let holds = needed.abs() <= most;
            let force = if holds { needed } else { coulomb.copysign(needed) };
            next = self.solve(next, drive, force).0;
            if holds {
                next[1] = 0.0;
            }
        }
        self.state = next;
    }

    fn state(&self) -> State {
        self.state
    }
}

#[inline(always)]
fn times(row: &State, x: &State) -> f64 {
    row[0] * x[0] + row[1] * x[1] + row[2] * x[2]
}

/// I + t A.
#[inline(always)]
fn beside(a: &Matrix, t: f64) -> Matrix {
    [0, 1, 2].map(|j| [0, 1, 2].map(|k| t * a[j][k] + if j == k { 1.0 } else { 0.0 }))
}

/// By cofactors.
#[inline(always)]
fn inverse(a: &Matrix) -> Matrix {
    let minor = |j: usize, k: usize| {
        let ([r, s], [p, q]) = ([(j + 1) % 3, (j + 2) % 3], [(k + 1) % 3, (k + 2) % 3]);
        a[r][p] * a[s][q] - a[r][q] * a[s][p]
    };
    let inverse = 1.0 / (a[0][0] * minor(0, 0) + a[0][1] * minor(0, 1) + a[0][2] * minor(0, 2));
    [0, 1, 2].map(|j| [0, 1, 2].map(|k| minor(k, j) * inverse))
}

#[cfg(test)]
mod tests {
    use super::super::equation::{LARGE, LINEAR, MOTOR};
    use super::{Equation, Method, Trapezoidal, inverse, times};

    const DRY: Equation = Equation {
        resistance: 2.0,
        inductance: 1e-3,
        gain: 0.5,
        direct: 0.0,
        inertia: 1e-2,
        damping: 0.01,
        stiffness: 3.0,
        weight: 0.4,
        coulomb: 0.1,
        stiction: 0.15,
        smooth: 0.01,
        falls: 4.0,
        cubic: 9.0,
        reach: 1.0,
        stroke: 0.2,
        stop_stiffness: 500.0,
        stop_damping: 0.3,
        inverse: [1e3, 1e2],
    };

    #[test]
    fn an_inverse_undoes_its_matrix() {
        let a = [[2.0, -1.0, 0.5], [0.3, 4.0, -2.0], [1.0, 0.0, 3.0]];
        let b = inverse(&a);
        for j in 0..3 {
            for k in 0..3 {
                let column = [b[0][k], b[1][k], b[2][k]];
                let expected = if j == k { 1.0 } else { 0.0 };
                assert!((times(&a[j], &column) - expected).abs() < 1e-14, "{j} {k}");
            }
        }
    }

    /// Whatever the terms, a step keeps to its definition.
    #[test]
    fn a_step_keeps_to_the_rule() {
        fn check<const KIND: u8>(equation: &Equation) {
            let h = 4e-3;
            let mut method = Trapezoidal::<KIND>::new(equation, h);
            for n in 0..400 {
                let (x, u) = (method.state(), 3.0 * (f64::from(n) * 0.07).sin());
                method.step(u);
                let (y, begins) = (method.state(), equation.rates::<KIND>(x, u));
                let ends = equation.rates::<KIND>(y, u);
                for k in 0..3 {
                    let left = x[k] + 0.5 * h * (begins[k] + ends[k]) - y[k];
                    assert!(left.abs() < 1e-11 * (1.0 + y[k].abs()), "{KIND} {n} {k}: {left}");
                }
            }
        }
        let smooth = Equation { coulomb: 0.0, stiction: 0.0, ..DRY };
        check::<LINEAR>(&Equation { weight: 0.0, ..smooth });
        check::<MOTOR>(&smooth);
        check::<LARGE>(&Equation { stop_damping: 0.0, ..smooth });
    }

    #[test]
    fn clamped_friction_holds_and_lets_go() {
        let dry = Equation { stiffness: 0.0, weight: 0.0, ..DRY };
        let mut method = Trapezoidal::<MOTOR>::new(&dry, 1e-3);
        // B u/R: 0.14 N m are held, 0.16 are not.
        method.run(&[0.56; 2000]);
        assert_eq!(method.state()[1], 0.0);
        method.run(&[0.64; 2000]);
        // B i − c v = T_c, R i + B v = u.
        let speed = (0.5 * 0.64 / 2.0 - 0.1) / (0.01 + 0.5 * 0.5 / 2.0);
        assert!((method.state()[1] - speed).abs() < 1e-9, "{:?} {speed}", method.state());
    }
}
