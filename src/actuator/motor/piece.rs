//! A time in which nothing switches, and where in it a limit is met.

use super::flow::{Flow, Motion, Push, Way};

/// Halvings and Newton steps towards a crossing.
const TRIES: usize = 40;
/// How near, as a share of the time searched.
const NEAR: f64 = 1e-15;

/// A time in which nothing switches: where it begins and what acts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece<'a> {
    pub flow: &'a Flow,
    pub from: Motion,
    pub rates: Motion,
    pub push: Push,
}

/// A limit: what is kept above 0 is a share of the current, one of the speed, and a number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Guard {
    pub current: f64,
    pub speed: f64,
    pub offset: f64,
}

impl Guard {
    #[inline]
    fn of(&self, x: Motion) -> f64 {
        self.current * x.current + self.speed * x.speed + self.offset
    }

    #[inline]
    fn slope(&self, rates: Motion) -> f64 {
        self.current * rates.current + self.speed * rates.speed
    }
}

impl<'a> Piece<'a> {
    pub fn new(flow: &'a Flow, from: Motion, push: Push) -> Self {
        Self { flow, from, rates: flow.rates(from, &push), push }
    }

    /// Where it is at a time, and how far it turned, rad.
    pub fn at(&self, t: f64) -> (Motion, f64) {
        self.by(&self.flow.over(t))
    }

    /// The same by the way to that time.
    pub fn by(&self, way: &Way) -> (Motion, f64) {
        let change = way.change(self.rates, self.from.speed, &self.push);
        let to =
            Motion { current: self.from.current + change.current, speed: self.from.speed + change.speed };
        (to, change.angle)
    }

    /// Derivatives there.
    pub fn rates_at(&self, t: f64, x: Motion) -> Motion {
        let push = &self.push;
        let torque = push.torque + t * (push.slope + 0.5 * t * push.curve);
        self.flow.rates(x, &Push { torque, ..*push })
    }

    /// The first time within `from` to `to` at which the guard is no longer above 0. What begins on the limit and goes off it on the
    /// right side does not meet it there.
    pub fn meets(&self, guard: &Guard, from: (f64, Motion), to: (f64, Motion)) -> Option<f64> {
        let (y0, y1) = (guard.of(from.1), guard.of(to.1));
        let slope = |(t, x)| guard.slope(self.rates_at(t, x));
        let (d0, d1) = (slope(from), slope(to));
        if y0 > 0.0 && y1 <= 0.0 {
            return Some(self.crossing(guard, from.0, (to.0, y1, d1)));
        }
        if y0 > 0.0 || y1 > 0.0 {
            // Above at one end at least: it may dip in between.
            if y0 <= 0.0 || d0 >= 0.0 || d1 <= 0.0 {
                return None;
            }
            let (low, y) = self.level(guard, from.0, to.0);
            return (y <= 0.0).then(|| self.crossing(guard, from.0, (low, y, 0.0)));
        }
        if d0 > 0.0 {
            let (high, y) = self.level(guard, from.0, to.0);
            if y > 0.0 {
                return Some(self.crossing(guard, high, (to.0, y1, d1)));
            }
        }
        Some(from.0)
    }

    /// Where the guard, above 0 at `low` and not at the other, crosses: Newton's method, kept between both.
    fn crossing(&self, guard: &Guard, mut low: f64, (mut high, y, d): (f64, f64, f64)) -> f64 {
        let least = NEAR * (high - low);
        let (mut t, mut step) = (high, if d < 0.0 { y / d } else { f64::INFINITY });
        for _ in 0..TRIES {
            if step.abs() <= least {
                return t - step;
            }
            let next = t - step;
            t = if next > low && next < high { next } else { 0.5 * (low + high) };
            if high - low <= least {
                return t;
            }
            let x = self.at(t).0;
            let y = guard.of(x);
            if y > 0.0 {
                low = t
            } else {
                high = t
            }
            let d = guard.slope(self.rates_at(t, x));
            step = if d < 0.0 { y / d } else { f64::INFINITY };
        }
        t
    }

    /// Where the guard is level within a time at whose ends it slopes to different sides, and how high it is there.
    fn level(&self, guard: &Guard, mut from: f64, mut to: f64) -> (f64, f64) {
        let slope = |t: f64| {
            let x = self.at(t).0;
            (guard.slope(self.rates_at(t, x)), guard.of(x))
        };
        let rises = slope(from).0 > 0.0;
        let (mut t, mut y) = (from, guard.of(self.from));
        for _ in 0..TRIES {
            t = 0.5 * (from + to);
            let (d, at) = slope(t);
            y = at;
            if (d > 0.0) == rises { from = t } else { to = t }
        }
        (t, y)
    }
}

#[cfg(test)]
mod tests {
    use super::super::flow::Rotor;
    use super::{Flow, Guard, Motion, Piece, Push};

    const COIN: Rotor =
        Rotor { resistance: 30.0, inductance: 3e-4, gain: 0.955e-3, inertia: 1.8e-9, viscous: 2.15e-8 };
    const STOPS: Guard = Guard { current: 0.0, speed: 1.0, offset: 0.0 };

    /// A shorted rotor without inductance: its stop has a closed form.
    #[test]
    fn a_stop_is_found_to_the_last_digits() {
        let flow = Flow::of_voltage(&Rotor { inductance: 0.0, ..COIN });
        let from = Motion { current: -COIN.gain * 500.0 / 30.0, speed: 500.0 };
        let piece = Piece::new(&flow, from, Push { torque: -1.5e-5, ..Push::default() });
        let damping = COIN.viscous + COIN.gain * COIN.gain / 30.0;
        let exact = COIN.inertia / damping * (damping * 500.0 / 1.5e-5).ln_1p();
        let t = piece.meets(&STOPS, (0.0, from), (0.2, piece.at(0.2).0)).unwrap();
        assert!((t - exact).abs() < 1e-15, "{t} {exact}");
        assert_eq!(piece.meets(&STOPS, (0.0, from), (0.03, piece.at(0.03).0)), None);
    }

    /// The current pulls backward at first, so the speed dips below 0 and comes back within the time searched.
    #[test]
    fn a_dip_is_found_though_both_ends_are_above() {
        let flow = Flow::of_voltage(&Rotor { inductance: 3e-2, ..COIN });
        let from = Motion { current: -0.1, speed: 10.0 };
        let piece = Piece::new(&flow, from, Push { volts: 3.0, ..Push::default() });
        let end = piece.at(4e-3).0;
        assert!(end.speed > 0.0);
        let t = piece.meets(&STOPS, (0.0, from), (4e-3, end)).unwrap();
        assert!(t < 1e-3 && piece.at(t).0.speed.abs() < 1e-11, "{t}");
        let deep = Guard { offset: 100.0, ..STOPS };
        assert_eq!(piece.meets(&deep, (0.0, from), (4e-3, end)), None);
    }

    #[test]
    fn what_begins_on_the_limit_leaves_it_or_meets_it_at_once() {
        let flow = Flow::of_voltage(&COIN);
        let rest = |current| Motion { current, speed: 0.0 };
        let ahead = Piece::new(&flow, rest(0.1), Push { volts: 3.0, ..Push::default() });
        assert_eq!(ahead.meets(&STOPS, (0.0, ahead.from), (1e-4, ahead.at(1e-4).0)), None);
        let back = Piece::new(&flow, rest(-0.1), Push { volts: -3.0, ..Push::default() });
        assert_eq!(back.meets(&STOPS, (0.0, back.from), (1e-4, back.at(1e-4).0)), Some(0.0));
        // Forward at first, then the voltage pulls it back through where it began.
        let over = Piece::new(&flow, rest(0.05), Push { volts: -3.0, ..Push::default() });
        let t = over.meets(&STOPS, (0.0, over.from), (1e-3, over.at(1e-3).0)).unwrap();
        assert!(t > 1e-6 && over.at(t).0.speed.abs() < 1e-14, "{t}");
    }
}
