//! Torque over angle: what effects do to a knob that is turned so slowly that speed has no part in it, there and back.
//!
//! What remembers (dry friction, snap) gives another torque on the way back; the area between is what a turn there and back takes. Beneath
//! lies the potential energy of those effects that have one, minus its slope being their torque.
//!
//! ```
//! use pacinian::knob::effect::detent::Detent;
//! use pacinian::report::knob::curve::Curve;
//!
//! let curve = Curve::new(vec![Detent::with_stiffness(24.0, 0.1).into()], [-0.3, 0.3], 601).map_err(|(_, fault)| fault)?;
//! assert!(!curve.remembers() && curve.loss().abs() < 1e-9);
//! assert!(curve.svg("Detents").contains("angle (rad)"));
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

#[cfg(test)]
mod tests;

use std::fmt::Write;

use crate::actuator::fault::{Fault, Limit, check, within};
use crate::knob::effect::Reading;
use crate::knob::effect::events::Events;
use crate::knob::effect::program::{Any, MOST_EFFECTS, Program};
use crate::report::plot::axis::short;
use crate::report::plot::colour::Ink;
use crate::report::plot::panels::{Across, Form, Panel, Panels, Shape, span};

/// Points of a curve, at most.
pub const MOST_POINTS: usize = 100_000;
/// Steps from point to point, so that what has corners is followed; seconds each of them takes.
const STEPS: usize = 8;
const SLOW: f64 = 0.5;
/// Both ways differ where they do by more than this share of the largest torque.
const SAME: f64 = 1e-9;
/// Points that are drawn at most each way, about twice as many as there are pixels.
const DRAWN: usize = 1400;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Angle, rad.
    pub angle: f64,
    /// Torque on the knob on the way to larger angles, N m.
    pub forward: f64,
    /// Torque on the way back, N m.
    pub backward: f64,
    /// Potential energy of the effects that have one, J.
    pub energy: f64,
}

/// Torque over angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    points: Vec<Point>,
}

impl Curve {
    /// Of effects over a range of angles (rad, within ±1e6), at so many points, 2 to [`MOST_POINTS`]. What remembers has been there
    /// and back once before.
    ///
    /// # Errors
    /// The number of the effect and its fault; with [`MOST_EFFECTS`] as number, the range's or that of the points.
    pub fn new(effects: Vec<Any>, [from, to]: [f64; 2], points: usize) -> Result<Self, (usize, Fault)> {
        let of_range = |fault| (MOST_EFFECTS, fault);
        within("from", from, (-1e6, 1e6), "rad").map_err(of_range)?;
        within("to", to, (-1e6, 1e6), "rad").map_err(of_range)?;
        check("to", to, Limit::Above(from)).map_err(of_range)?;
        within("points", points as f64, (2.0, MOST_POINTS as f64), "points").map_err(of_range)?;
        let mut program = Program::new(effects)?;
        let mut events = Events::default();
        let fine = (points - 1) * STEPS;
        let mut at = |step: usize| {
            let share = step as f64 / fine as f64;
            let angle = from + (to - from) * share;
            let reading = Reading { angle, velocity: 0.0, dt: SLOW };
            (angle, program.tick(&reading, 1.0, 1.0, &mut events))
        };
        for step in (0..=fine).chain((0..=fine).rev()) {
            at(step);
        }
        let mut all = vec![Point::default(); points];
        for step in 0..=fine {
            let (angle, torque) = at(step);
            if step % STEPS == 0 {
                (all[step / STEPS].angle, all[step / STEPS].forward) = (angle, torque);
            }
        }
        for step in (0..=fine).rev() {
            let (_, torque) = at(step);
            if step % STEPS == 0 {
                all[step / STEPS].backward = torque;
            }
        }
        all.iter_mut().for_each(|point| point.energy = program.energy(point.angle));
        Ok(Self { points: all })
    }

    /// Its points, by angle.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Whether it is another on the way back.
    pub fn remembers(&self) -> bool {
        let most =
            self.points.iter().fold(0.0, |most: f64, p| most.max(p.forward.abs()).max(p.backward.abs()));
        self.points.iter().any(|p| (p.forward - p.backward).abs() > SAME * most)
    }

    /// What a turn there and back takes out of the knob, J.
    pub fn loss(&self) -> f64 {
        let gap = |p: &Point| p.backward - p.forward;
        self.points.windows(2).map(|w| 0.5 * (gap(&w[0]) + gap(&w[1])) * (w[1].angle - w[0].angle)).sum()
    }

    /// Comma-separated values: `angle_rad,torque_forward_nm,torque_backward_nm,energy_j`.
    pub fn csv(&self) -> String {
        let mut out = String::from("angle_rad,torque_forward_nm,torque_backward_nm,energy_j\n");
        for Point { angle, forward, backward, energy } in &self.points {
            let _ = writeln!(out, "{angle},{forward},{backward},{energy}");
        }
        out
    }

    /// The picture as SVG, light, and dark where the reader prefers that: torque above, energy below. `title` is its first line.
    pub fn svg(&self, title: &str) -> String {
        let both = self.remembers();
        let range = [self.points[0].angle, self.points[self.points.len() - 1].angle];
        let group = (2 * self.points.len()).div_ceil(DRAWN).max(1);
        // Of each group the least and the greatest, in their order.
        let thin = |of: &dyn Fn(&Point) -> f64| -> Vec<(f64, f64)> {
            let of_group = |few: &[Point]| {
                let order = |a: &&Point, b: &&Point| of(a).total_cmp(&of(b));
                let ends = [few.iter().min_by(order), few.iter().max_by(order)];
                let mut ends: Vec<&Point> = ends.into_iter().flatten().collect();
                ends.sort_by(|a, b| a.angle.total_cmp(&b.angle));
                ends.dedup();
                ends.into_iter().map(|p| (p.angle, of(p))).collect::<Vec<_>>()
            };
            self.points.chunks(group).flat_map(of_group).collect()
        };
        let shape = |name: &str, index, form, points| Shape {
            name: name.into(),
            ink: Ink::Kind { index },
            form,
            points,
        };
        let mut torques = Vec::new();
        if both {
            torques.push(shape("to smaller angles", 1, Form::Dashed(1.6, "7 3"), thin(&|p| p.backward)));
        }
        let name = if both { "to larger angles" } else { "torque" };
        torques.push(shape(name, 0, Form::Line(1.6), thin(&|p| p.forward)));
        let energy = thin(&|p| p.energy);
        let floor = energy.iter().fold(f64::INFINITY, |least, p| least.min(p.1));
        let ends = energy.first().zip(energy.last());
        let under =
            ends.map_or(Vec::new(), |(a, b)| [&[(a.0, floor)][..], &energy, &[(b.0, floor)]].concat());
        let axis = |label: &str, range| Across { label: label.into(), range, log: false, rows: Vec::new() };
        let spread = |shapes: &[Shape]| span(shapes.iter().flat_map(|s| &s.points).map(|p| p.1), &[0.0]);
        let energies = vec![
            shape("", 2, Form::Area(0.14), under),
            shape("potential energy", 2, Form::Line(1.6), energy),
        ];
        let mut notes = Vec::new();
        if both {
            let loss = short(self.loss());
            notes.push((
                format!("There and back takes {loss} J; what remembers has no potential energy."),
                false,
            ));
        }
        Panels {
            title: title.into(),
            about: vec!["Turned so slowly that speed has no part in it.".into()],
            panels: vec![
                Panel {
                    frame: [104.0, 4.0, 620.0, 230.0],
                    x: axis("", range),
                    y: axis("torque on the knob (N m)", spread(&torques)),
                    shapes: torques,
                },
                Panel {
                    frame: [104.0, 254.0, 620.0, 130.0],
                    x: axis("angle (rad)", range),
                    y: axis("energy (J)", spread(&energies)),
                    shapes: energies,
                },
            ],
            notes,
            width: 760.0,
        }
        .svg()
    }
}
