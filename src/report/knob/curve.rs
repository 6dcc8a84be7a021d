//! Torque over angle: what a slow sweep of a knob feels, up and down again, so that what remembers shows as two curves.

use crate::actuator::fault::Fault;
use crate::knob::effect::Reading;
use crate::knob::effect::events::Events;
use crate::knob::effect::program::{Any, Program};
use crate::report::plot::{Axis, Chart, Point, Series};

/// A sweep: angles (rad) and torques (N m), upwards and downwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// From the lowest angle to the highest.
    pub up: Vec<(f64, f64)>,
    /// And back.
    pub down: Vec<(f64, f64)>,
}

/// Steps each way, of which every so-manieth is kept.
const STEPS: usize = 12_000;
const KEPT: usize = 12;
/// Speed, rad/s: so slow that nothing viscous is felt.
const SPEED: f64 = 1e-3;

impl Sweep {
    /// Of effects between two angles (rad).
    ///
    /// # Errors
    /// The number of an effect that cannot be, and why.
    pub fn new(effects: &[Any], [from, to]: [f64; 2]) -> Result<Self, (usize, Fault)> {
        let mut program = Program::new(effects.to_vec())?;
        let mut events = Events::default();
        let step = (to - from) / STEPS as f64;
        let mut sweep = |from: f64, step: f64| -> Vec<(f64, f64)> {
            let mut all = Vec::with_capacity(STEPS / KEPT + 1);
            for n in 0..=STEPS {
                let angle = from + step * n as f64;
                let dt = (step.abs() / SPEED).clamp(1e-9, 0.5);
                let reading = Reading { angle, velocity: SPEED.copysign(step), dt };
                let torque = program.tick(&reading, 1.0, 1.0, &mut events);
                if n.is_multiple_of(KEPT) {
                    all.push((angle, torque));
                }
            }
            all
        };
        Ok(Self { up: sweep(from, step), down: sweep(to, -step) })
    }

    /// The picture.
    pub fn chart(&self, title: &str) -> Chart {
        let curve = |name: &str, points: &[(f64, f64)]| Series {
            name: name.into(),
            points: points.iter().map(|(x, y)| Point { x: *x, y: *y, label: String::new() }).collect(),
            smooth: true,
        };
        let apart =
            self.up.iter().zip(self.down.iter().rev()).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max);
        let most = self.up.iter().map(|(_, torque)| torque.abs()).fold(0.0, f64::max);
        let series = match apart > 1e-3 * most {
            true => vec![curve("turned up", &self.up), curve("turned down", &self.down)],
            false => vec![curve("", &self.up)],
        };
        Chart {
            title: title.into(),
            x: Axis { label: "angle (rad)".into(), ..Axis::default() },
            y: Axis { label: "torque (N m)".into(), ..Axis::default() },
            series,
            notes: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Sweep;
    use crate::knob::effect::{detent::Detent, friction, spring::Spring, wall::Stops};

    #[test]
    fn what_remembers_nothing_is_one_curve_and_friction_is_two() {
        let spring = Spring { stiffness: 0.1, centre: 0.5 };
        let stops = Stops { low: -1.0, high: 1.0, stiffness: 2.0, damping: 0.0 };
        let sweep = Sweep::new(&[spring.into(), stops.into()], [-1.5, 1.5]).unwrap();
        for (angle, torque) in sweep.up.iter().chain(&sweep.down) {
            let beyond = (angle.abs() - 1.0).max(0.0).copysign(*angle);
            assert!((torque + 0.1 * (angle - 0.5) + 2.0 * beyond).abs() < 1e-12, "{angle} {torque}");
        }
        assert_eq!(sweep.chart("").series.len(), 1);
        let friction = friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Adhesion };
        let sweep = Sweep::new(&[friction.into()], [-0.5, 0.5]).unwrap();
        assert_eq!(sweep.chart("").series.len(), 2);
        assert!(
            (sweep.up.last().unwrap().1 + 2e-3).abs() < 1e-9
                && (sweep.down.last().unwrap().1 - 2e-3).abs() < 1e-9
        );
    }

    #[test]
    fn notches_are_as_many_and_as_strong_as_they_say() {
        let sweep =
            Sweep::new(&[Detent::with_stiffness(12.0, 0.12).into()], [-0.1, std::f64::consts::TAU - 0.1])
                .unwrap();
        let most = sweep.up.iter().map(|(_, t)| *t).fold(0.0, f64::max);
        assert!((most - 0.01).abs() < 1e-5, "{most}");
        let falls = sweep.up.windows(2).filter(|w| w[0].1 > 0.0 && w[1].1 <= 0.0).count();
        assert_eq!(falls, 12);
    }
}
