//! Forward Euler: x + h f(x). Of first order; a decay of rate λ is stable for λ h < 2 only.

use super::equation::{Equation, State};
use super::method::Method;

/// It, with dry friction smoothed. `KIND`: which terms the equation has.
#[derive(Debug, Clone)]
pub struct Euler<const KIND: u8> {
    equation: Equation,
    period: f64,
    state: State,
}

impl<const KIND: u8> Euler<KIND> {
    /// At rest, so many seconds a sample.
    pub fn new(equation: &Equation, period: f64) -> Self {
        Self { equation: equation.ready(), period, state: [0.0; 3] }
    }
}

impl<const KIND: u8> Method for Euler<KIND> {
    fn restart(&mut self) {
        self.state = [0.0; 3];
    }

    #[inline(always)]
    fn step(&mut self, drive: f64) {
        let rates = self.equation.smooth_rates::<KIND>(self.state, drive);
        for n in 0..3 {
            self.state[n] += self.period * rates[n];
        }
    }

    fn state(&self) -> State {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::super::equation::{LINEAR, MOTOR};
    use super::{Equation, Euler, Method};

    const EQUATION: Equation = Equation {
        resistance: 2.0,
        inductance: 0.5,
        gain: 0.3,
        direct: 0.0,
        inertia: 0.2,
        damping: 0.1,
        stiffness: 1.5,
        weight: 0.0,
        coulomb: 0.0,
        stiction: 0.0,
        smooth: 1.0,
        falls: 0.0,
        cubic: 0.0,
        reach: f64::INFINITY,
        stroke: f64::INFINITY,
        stop_stiffness: 0.0,
        stop_damping: 0.0,
        inverse: [2.0, 5.0],
    };

    /// Two steps by hand: i = h u/L, then i (1 − hR/L) + h u/L; v = h B i/m.
    #[test]
    fn two_steps_are_those_done_by_hand() {
        let mut euler = Euler::<LINEAR>::new(&EQUATION, 0.1);
        euler.step(1.0);
        assert_eq!(euler.state(), [0.2, 0.0, 0.0]);
        euler.step(1.0);
        let expected = [0.2 * 0.6 + 0.2, 0.1 * 0.3 * 0.2 / 0.2, 0.0];
        for n in 0..3 {
            assert!((euler.state()[n] - expected[n]).abs() < 1e-15, "{n}");
        }
        euler.restart();
        assert_eq!(euler.state(), [0.0; 3]);
    }

    /// Smoothed friction never holds: a torque below it still turns the rotor, at ω_s atanh of its share.
    #[test]
    fn smoothed_friction_lets_it_creep() {
        let dry = Equation { coulomb: 0.5, stiction: 0.5, stiffness: 0.0, ..EQUATION };
        let mut euler = Euler::<MOTOR>::new(&dry, 1e-3);
        euler.run(&vec![1.0; 100_000]);
        // B i − c v − T_c tanh v/v_s = 0 with R i + B v = u, by bisection.
        let left = |v: f64| 0.3 * (1.0 - 0.3 * v) / 2.0 - 0.1 * v - 0.5 * v.tanh();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if left(middle) > 0.0 { low = middle } else { high = middle }
        }
        assert!(low > 0.1 && (euler.state()[1] - low).abs() < 1e-9, "{low} {:?}", euler.state());
    }
}
