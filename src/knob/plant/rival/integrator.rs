//! Integrators of one inertia with viscous friction and stops, and dry friction as far as they can.

use crate::actuator::fault::{Fault, within};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::wave::Wave;

/// Rounds of the implicit ones: they halve what is left of a linear problem at once, and meet a corner in a few.
const ROUNDS: usize = 40;

/// How a step is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Explicit Euler: first order; makes energy at every step.
    ForwardEuler,
    /// Speed first, then the angle by the new speed: first order, bounded energy below 2 rad of the fastest a step.
    SymplecticEuler,
    /// Velocity Verlet: second order, as stable.
    Verlet,
    /// Runge and Kutta's of fourth order, stable below 2.8 rad a step.
    RungeKutta4,
    /// Stable at every step, second order; by Newton's method.
    ImplicitMidpoint,
    /// Stable at every step and takes energy away: first order.
    BackwardEuler,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::ForwardEuler,
        Self::SymplecticEuler,
        Self::Verlet,
        Self::RungeKutta4,
        Self::ImplicitMidpoint,
        Self::BackwardEuler,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::ForwardEuler => "forward Euler",
            Self::SymplecticEuler => "symplectic Euler",
            Self::Verlet => "Verlet",
            Self::RungeKutta4 => "Runge-Kutta 4",
            Self::ImplicitMidpoint => "implicit midpoint",
            Self::BackwardEuler => "backward Euler",
        }
    }
}

/// A knob of one inertia, stepped by a [`Method`].
///
/// Dry friction is Coulomb's with the sense of turning of the moment, at rest against what pushes, and of the step's beginning where the
/// step is implicit; a knob whose speed would change its sign within a step, and which
/// friction could hold, stops. It is finite as long as the method is stable; beyond, angle and speed are kept within ±1e12 and [`Rival::diverged`] tells it.
#[derive(Debug, Clone)]
pub struct Rival {
    parameters: Parameters,
    /// Torque over the angle, where there is any.
    cogging: Option<Wave>,
    method: Method,
    period: f64,
    angle: f64,
    speed: f64,
    diverged: bool,
}

const MOST: f64 = 1e12;

impl Rival {
    /// At rest at 0 rad, for `rate` steps a second, 1 to 1e8.
    ///
    /// # Errors
    /// The first parameter, or the rate, beyond its limits.
    pub fn new(parameters: &Parameters, method: Method, rate: f64) -> Result<Self, Fault> {
        parameters.check()?;
        within("rate", rate, (1.0, 1e8), "steps a second")?;
        Ok(Self {
            parameters: *parameters,
            cogging: None,
            method,
            period: 1.0 / rate,
            angle: 0.0,
            speed: 0.0,
            diverged: false,
        })
    }

    /// The same with a torque over the angle, N m.
    #[must_use]
    pub fn cogged(self, wave: &Wave) -> Self {
        Self { cogging: (!wave.is_flat()).then_some(*wave), ..self }
    }

    /// Puts it at an angle (rad) with a speed (rad/s).
    pub fn place(&mut self, angle: f64, speed: f64) {
        (self.angle, self.speed, self.diverged) = (angle, speed, false);
    }

    /// Angle, rad.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Speed, rad/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Whether it went beyond all bounds.
    pub fn diverged(&self) -> bool {
        self.diverged
    }

    /// The torque at an angle and a speed without dry friction, N m, and its derivatives by them.
    fn push(&self, torque: f64, angle: f64, speed: f64) -> [f64; 3] {
        let p = &self.parameters;
        let (mut sum, mut by_angle, mut by_speed) = (torque - p.viscous * speed, 0.0, -p.viscous);
        if let Some(wave) = &self.cogging {
            sum += wave.at(angle);
            by_angle += wave.slope(angle);
        }
        if let Some(stops) = p.stops {
            for (side, place) in [(1.0, stops.high), (-1.0, stops.low)] {
                let depth = side * (angle - place);
                let push = stops.stiffness * depth + stops.damping * side * speed;
                if depth > 0.0 && push > 0.0 {
                    sum -= side * push;
                    by_angle -= stops.stiffness;
                    by_speed -= stops.damping;
                }
            }
        }
        [sum, by_angle, by_speed]
    }

    /// What friction does against a push, N m: at rest it goes against that.
    fn rubs(&self, push: f64, speed: f64) -> f64 {
        let coulomb = self.parameters.coulomb;
        if speed == 0.0 { push.clamp(-coulomb, coulomb) } else { coulomb.copysign(speed) }
    }

    /// rad/s² at an angle and a speed.
    fn acceleration(&self, torque: f64, angle: f64, speed: f64) -> f64 {
        let push = self.push(torque, angle, speed)[0];
        (push - self.rubs(push, speed)) / self.parameters.inertia
    }

    /// Passes one step with a torque (N m) held over it; what is no number counts as none.
    pub fn step(&mut self, torque: f64) {
        let torque = if torque.is_finite() { torque } else { 0.0 };
        let (h, x, v) = (self.period, self.angle, self.speed);
        if v == 0.0 && self.parameters.stiction > 0.0 && self.holds(torque, x) {
            return;
        }
        let at = |x: f64, v: f64| self.acceleration(torque, x, v);
        let (angle, speed) = match self.method {
            Method::ForwardEuler => (x + h * v, v + h * at(x, v)),
            Method::SymplecticEuler => {
                let speed = v + h * at(x, v);
                (x + h * speed, speed)
            }
            Method::Verlet => {
                let half = v + 0.5 * h * at(x, v);
                let angle = x + h * half;
                (angle, half + 0.5 * h * at(angle, half))
            }
            Method::RungeKutta4 => {
                let (k1, l1) = (v, at(x, v));
                let (k2, l2) = (v + 0.5 * h * l1, at(x + 0.5 * h * k1, v + 0.5 * h * l1));
                let (k3, l3) = (v + 0.5 * h * l2, at(x + 0.5 * h * k2, v + 0.5 * h * l2));
                let (k4, l4) = (v + h * l3, at(x + h * k3, v + h * l3));
                (x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4), v + h / 6.0 * (l1 + 2.0 * (l2 + l3) + l4))
            }
            Method::ImplicitMidpoint => {
                let middle = self.implicit(torque, 0.5 * h);
                (x + h * middle, 2.0 * middle - v)
            }
            Method::BackwardEuler => {
                let speed = self.implicit(torque, h);
                (x + h * speed, speed)
            }
        };
        (self.angle, self.speed) = (angle, speed);
        if self.parameters.stiction > 0.0 && speed * v < 0.0 && self.holds(torque, angle) {
            self.speed = 0.0;
        }
        // So that what is no number is beyond too.
        if !(self.angle.abs() < MOST && self.speed.abs() < MOST) {
            self.diverged = true;
            (self.angle, self.speed) =
                ([angle, speed].map(|s| if s.is_nan() { 0.0 } else { s.clamp(-MOST, MOST) })).into();
        }
    }

    fn holds(&self, torque: f64, angle: f64) -> bool {
        self.push(torque, angle, 0.0)[0].abs() <= self.parameters.stiction
    }

    /// v with v = v0 + h a(x0 + h v, v), by Newton's method on what is linear in parts; dry friction keeps the sense that it has at the
    /// step's beginning, or the rounds would go to and fro between both.
    fn implicit(&self, torque: f64, h: f64) -> f64 {
        let (mut v, inertia) = (self.speed, self.parameters.inertia);
        let rubs = self.rubs(self.push(torque, self.angle, v)[0], v);
        for _ in 0..ROUNDS {
            let [push, by_angle, by_speed] = self.push(torque, self.angle + h * v, v);
            let off = v - self.speed - h * (push - rubs) / inertia;
            let change = off / (1.0 - h * (h * by_angle + by_speed) / inertia);
            v -= change;
            if change.abs() <= 1e-15 * v.abs() {
                break;
            }
        }
        v
    }
}

#[cfg(test)]
mod tests {
    use super::{Method, Parameters, Rival};
    use crate::knob::plant::rotor::Rotor;
    use crate::knob::plant::stops::Stops;

    fn rebound(method: Method, rate: f64, rim: f64) -> f64 {
        let stops = Stops { low: f64::NEG_INFINITY, high: 0.0, stiffness: rim * 4e-4, damping: 0.0 };
        let parameters = Parameters { viscous: 0.0, stops: Some(stops), ..Parameters::default() };
        let mut rival = Rival::new(&parameters, method, rate).unwrap();
        rival.place(-0.0503, 20.0);
        (0..(0.03 * rate) as usize).for_each(|_| rival.step(0.0));
        (rival.speed() / -20.0 - 1.0).abs()
    }

    /// A soft wall at 48 kHz: each method's error, as wide as others measured it.
    #[test]
    fn each_errs_at_a_wall_as_its_order_says() {
        for (method, least, most) in [
            (Method::ForwardEuler, 3e-3, 2e-2),
            (Method::SymplecticEuler, 0.0, 1e-5),
            (Method::Verlet, 0.0, 1e-5),
            (Method::RungeKutta4, 0.0, 1e-5),
            (Method::ImplicitMidpoint, 0.0, 1e-5),
            (Method::BackwardEuler, 3e-3, 2e-2),
        ] {
            let error = rebound(method, 48e3, 1e3);
            assert!((least..most).contains(&error), "{} {error:e}", method.name());
            // A stiff one in steps of more than its contact is beyond all of them.
            let error = rebound(method, 1e3, 1e6);
            assert!(error > 1e-2, "{} {error:e}", method.name());
        }
    }

    #[test]
    fn all_come_to_the_exact_one_where_steps_are_small() {
        let parameters = Parameters { coulomb: 1e-3, stiction: 1e-3, ..Parameters::default() };
        let mut exact = Rotor::<false>::new(&parameters, 1e3).unwrap();
        exact.place(0.0, 35.0).unwrap();
        (0..300).for_each(|_| exact.step(0.0));
        for method in Method::ALL {
            let mut rival = Rival::new(&parameters, method, 1e5).unwrap();
            rival.place(0.0, 35.0);
            (0..30_000).for_each(|_| rival.step(0.0));
            // Runge and Kutta's mixes both senses of friction within a step, and trembles about rest.
            assert!(rival.speed().abs() < 1e-2, "{}", method.name());
            assert!((rival.angle() / exact.angle() - 1.0).abs() < 1e-3, "{}", method.name());
        }
    }

    #[test]
    fn what_diverges_is_told_and_stays_a_number() {
        let stops = Stops { low: -0.01, high: 0.01, stiffness: 4e5, damping: 1.0 };
        let parameters =
            Parameters { stops: Some(stops), coulomb: 1e-3, stiction: 1e-3, ..Parameters::default() };
        for method in Method::ALL {
            let mut rival = Rival::new(&parameters, method, 1e3).unwrap();
            rival.place(0.0, 100.0);
            for n in 0..20_000 {
                rival.step(if n % 7 == 0 { f64::NAN } else { 0.3 });
                assert!(rival.angle().is_finite() && rival.speed().is_finite(), "{}", method.name());
            }
        }
    }
}
