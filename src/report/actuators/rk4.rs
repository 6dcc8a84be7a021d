//! The classical Runge-Kutta method. Of fourth order; a decay of rate λ is stable for λ h < 2.785 only.

use super::equation::{Equation, State};
use super::method::Method;

/// It, with dry friction smoothed. `KIND`: which terms the equation has.
#[derive(Debug, Clone)]
pub struct Rk4<const KIND: u8> {
    equation: Equation,
    period: f64,
    state: State,
}

impl<const KIND: u8> Rk4<KIND> {
    /// At rest, so many seconds a sample.
    pub fn new(equation: &Equation, period: f64) -> Self {
        Self { equation: equation.ready(), period, state: [0.0; 3] }
    }
}

impl<const KIND: u8> Method for Rk4<KIND> {
    fn restart(&mut self) {
        self.state = [0.0; 3];
    }

    #[inline(always)]
    fn step(&mut self, drive: f64) {
        let (x, h) = (self.state, self.period);
        let rates = |x: State| self.equation.smooth_rates::<KIND>(x, drive);
        let along = |k: &State, t: f64| [x[0] + t * k[0], x[1] + t * k[1], x[2] + t * k[2]];
        let a = rates(x);
        let b = rates(along(&a, 0.5 * h));
        let c = rates(along(&b, 0.5 * h));
        let d = rates(along(&c, h));
        for n in 0..3 {
            self.state[n] += h / 6.0 * (a[n] + 2.0 * (b[n] + c[n]) + d[n]);
        }
    }

    fn state(&self) -> State {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::super::equation::LINEAR;
    use super::{Equation, Method, Rk4};

    /// Of a decay a step makes 1 − z + z²/2 − z³/6 + z⁴/24.
    #[test]
    fn a_decay_is_the_exponential_to_its_fourth_power() {
        let coil = Equation { resistance: 3.0, inductance: 2.0, inertia: 1.0, ..Equation::default() };
        let mut method = Rk4::<LINEAR>::new(&coil, 0.4);
        method.state = [1.0, 0.0, 0.0];
        method.step(0.0);
        let z: f64 = 0.6;
        let expected = 1.0 - z + z * z / 2.0 - z * z * z / 6.0 + z * z * z * z / 24.0;
        assert!((method.state()[0] - expected).abs() < 1e-15);
    }
}
