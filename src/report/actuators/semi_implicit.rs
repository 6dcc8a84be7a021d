//! Semi-implicit Euler: each equation sees what those before it have just become. Of first order; swings keep their size, the coil's
//! current is as unstable as with forward Euler.

use super::equation::{Equation, State};
use super::method::Method;

/// It, with dry friction clamped: it takes h T_c/J off the speed, but not beyond rest, and holds at rest what is below T_s.
#[derive(Debug, Clone)]
pub struct SemiImplicit<const KIND: u8> {
    equation: Equation,
    period: f64,
    state: State,
}

impl<const KIND: u8> SemiImplicit<KIND> {
    /// At rest, so many seconds a sample.
    pub fn new(equation: &Equation, period: f64) -> Self {
        Self { equation: equation.ready(), period, state: [0.0; 3] }
    }
}

impl<const KIND: u8> Method for SemiImplicit<KIND> {
    fn restart(&mut self) {
        self.state = [0.0; 3];
    }

    #[inline(always)]
    fn step(&mut self, drive: f64) {
        let (e, h, [current, speed, place]) = (&self.equation, self.period, self.state);
        let current = current + h * e.rates::<KIND>(self.state, drive)[0];
        let push = e.rates::<KIND>([current, speed, place], drive)[1];
        let mut next = speed + h * push;
        if e.stiction > 0.0 {
            let holds = speed == 0.0 && (push * e.inertia).abs() <= e.stiction;
            let left = if holds { 0.0 } else { (next.abs() - h * e.coulomb * e.inverse[1]).max(0.0) };
            next = left.copysign(next);
        }
        self.state = [current, next, place + h * next];
    }

    fn state(&self) -> State {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::super::equation::{LINEAR, MOTOR};
    use super::{Equation, Method, SemiImplicit};

    /// A mass on a spring without losses: v² + ω²y² + ωh·ω v y is kept, so it swings on for ever.
    #[test]
    fn swings_keep_their_size() {
        let spring = Equation {
            resistance: 1.0,
            inductance: 1.0,
            inertia: 2.0,
            stiffness: 50.0,
            ..Equation::default()
        };
        let mut method = SemiImplicit::<LINEAR>::new(&spring, 0.02);
        method.state = [0.0, 1.0, 0.0];
        let kept = |[_, v, y]: [f64; 3]| v * v + 25.0 * y * y - 25.0 * 0.02 * v * y;
        for _ in 0..100_000 {
            method.step(0.0);
            assert!((kept(method.state()) - 1.0).abs() < 1e-9, "{:?}", method.state());
        }
    }

    #[test]
    fn clamped_friction_stops_it_and_holds_it() {
        let dry = Equation {
            resistance: 1.0,
            inductance: 1e-3,
            gain: 1.0,
            inertia: 1.0,
            coulomb: 0.5,
            stiction: 0.8,
            ..Equation::default()
        };
        let mut method = SemiImplicit::<MOTOR>::new(&dry, 1e-3);
        method.state = [0.0, 1e-4, 0.0];
        method.step(0.0);
        assert_eq!(method.state()[1], 0.0);
        method.run(&[0.79; 1000]);
        assert_eq!(method.state()[1], 0.0);
        method.step(1.0);
        assert!((method.state()[0] - 1.0).abs() < 1e-12);
        // Of 1 N m half is left.
        assert!((method.state()[1] - 5e-4).abs() < 1e-12, "{:?}", method.state());
    }
}
