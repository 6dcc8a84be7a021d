//! Effects into what a SmartKnob can be, and what it cannot be.
//!
//! It has one pull: to the middle of equal positions, of a few of them, or to one place; and two ends. What is near but not the same is
//! said, and so is what is left out; nothing is dropped without a word.

mod magnets;

use std::f64::consts::TAU;

use super::config::{Config, MOST_STRENGTH};
use super::session::Feel;
use crate::actuator::fault::{Fault, positive};
use crate::knob::effect::detent::{Detent, Shape};
use crate::knob::effect::magnet::Magnet;
use crate::knob::effect::program::Any;
use crate::knob::effect::snap::Snap;
use crate::knob::effect::spring::Spring;

/// A knob as it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// Its stiffness at a strength of 1, N m/rad: by the firmware, four times the torque that its motor has for a volt. A weight on a lever
    /// tells it. Above 0.
    pub stiffness: f64,
}

/// What became of effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    /// What the knob is to be.
    pub feel: Feel,
    /// Effects that are not quite what they were, and in what.
    pub near: Vec<Remark>,
    /// Effects that it cannot be, and why.
    pub left_out: Vec<Remark>,
    /// Between which angles (radians) this holds: beyond, other magnets are nearer, and it is to be compiled anew, with
    /// [`Feel::stay`] where the magnets are on one grid. `None`: everywhere.
    pub holds: Option<(f64, f64)>,
}

/// Something about an effect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Which, by its place.
    pub effect: usize,
    /// What it is.
    pub name: &'static str,
    /// What is to be said of it.
    pub why: String,
}

/// An end that stands nowhere is so many positions away.
const FAR: i32 = 1_000_000;

/// Width where nothing asks for one, radians: that of the firmware's own free knob, and of its own return to centre.
const FREE: f64 = TAU / 36.0;
const ONE_PLACE: f64 = TAU / 6.0;

/// How far a magnet's place may be off the grid without a word, in widths.
const SMALL: f64 = 0.01;

/// The one pull.
enum Pull<'a> {
    None,
    Even { width: f64, centre: f64, stiffness: f64, snap: f64, effect: usize },
    Place(usize, &'a Spring),
    Magnets(Vec<(usize, &'a Magnet)>),
}

struct Ends {
    low: Option<f64>,
    high: Option<f64>,
    stiffness: f64,
    effects: Vec<(usize, &'static str)>,
}

struct Compiling<'a> {
    device: &'a Device,
    near: Vec<Remark>,
    left_out: Vec<Remark>,
}

/// What a knob that stands at `angle` (radians) is to be for these effects, with `text` on its screen.
///
/// # Errors
/// An effect that cannot be, by its place, or what the knob would refuse: a width beyond its limits, a text too long.
pub fn compile(
    effects: &[Any],
    device: &Device,
    angle: f64,
    text: &str,
) -> Result<Compiled, (Option<usize>, Fault)> {
    positive("stiffness", device.stiffness).map_err(|fault| (None, fault))?;
    let angle = if angle.is_finite() { angle } else { 0.0 };
    let mut compiling = Compiling { device, near: Vec::new(), left_out: Vec::new() };
    let mut pull = Pull::None;
    let mut ends = Ends { low: None, high: None, stiffness: 0.0, effects: Vec::new() };
    for (k, effect) in effects.iter().enumerate() {
        effect.check().map_err(|fault| (Some(k), fault))?;
        compiling.sort(k, effect, &mut pull, &mut ends);
    }
    let (config, origin, holds) = compiling.build(&pull, &ends, angle);
    let config = Config { text: text.into(), ..config };
    config.check().map_err(|fault| (None, fault))?;
    let Compiling { near, left_out, .. } = compiling;
    Ok(Compiled { feel: Feel { config, origin, stay: false }, near, left_out, holds })
}

impl<'a> Compiling<'a> {
    fn near(&mut self, effect: usize, name: &'static str, why: impl Into<String>) {
        self.near.push(Remark { effect, name, why: why.into() });
    }

    fn left_out(&mut self, effect: usize, name: &'static str, why: impl Into<String>) {
        self.left_out.push(Remark { effect, name, why: why.into() });
    }

    fn sort(&mut self, k: usize, effect: &'a Any, pull: &mut Pull<'a>, ends: &mut Ends) {
        const ONE: &str = "the knob has one pull, and an effect named before it has that";
        match (effect, &mut *pull) {
            (Any::Detent(detent), Pull::None) => *pull = self.detent(k, detent),
            (Any::Snap(snap), Pull::None) => *pull = self.snap(k, snap),
            (Any::Spring(spring), Pull::None) => *pull = Pull::Place(k, spring),
            (Any::Magnet(magnet), Pull::None) => *pull = Pull::Magnets(vec![(k, magnet)]),
            (Any::Magnet(magnet), Pull::Magnets(magnets)) => magnets.push((k, magnet)),
            (Any::Detent(_), _) => self.left_out(k, "detent", ONE),
            (Any::Snap(_), _) => self.left_out(k, "snap", ONE),
            (Any::Spring(_), _) => self.left_out(k, "spring", ONE),
            (Any::Magnet(_), _) => self.left_out(k, "magnet", ONE),
            (Any::Wall(wall), _) => {
                let stands = if wall.below { (Some(wall.angle), None) } else { (None, Some(wall.angle)) };
                self.end(k, "wall", stands, wall.stiffness, wall.damping, ends);
            }
            (Any::Stops(stops), _) => {
                let stands = (Some(stops.low), Some(stops.high));
                self.end(k, "stops", stands, stops.stiffness, stops.damping, ends);
            }
            (Any::Damper(_), _) => self.left_out(k, "damper", "the knob's damping is its own, by the width"),
            (Any::Friction(_), _) => self.left_out(k, "friction", "the knob has no effect that remembers"),
            (Any::Inertia(_), _) => self.left_out(k, "inertia", "the knob has no effect that moves on"),
            (Any::Constant(_), _) => {
                self.left_out(k, "constant", "the knob pulls to places, and never one way everywhere");
            }
            (Any::Spin(_), _) => self.left_out(k, "spin", "the knob holds no speed"),
            (Any::Ripple(_), _) => {
                self.left_out(k, "ripple", "finer than positions can be: the knob follows one at a time");
            }
            (Any::Fed(_), _) => self.left_out(k, "fed", "the line carries no signal, only what to be"),
            (Any::Table(_), _) => self.left_out(k, "table", "the knob's pull grows straight from its places"),
            (Any::Hertz(_), _) => self.left_out(k, "hertz", "the knob's ends push straight, not as p^3/2"),
            (Any::Transient(_), _) => {
                self.left_out(k, "transient", "the knob has a click of its own for presses only")
            }
        }
    }

    fn detent(&mut self, k: usize, detent: &Detent) -> Pull<'a> {
        let shape = match detent.shape {
            Shape::Sine => "sine",
            Shape::Triangle => "triangle",
            Shape::Table(_) => "table",
        };
        let why =
            format!("its {shape} becomes a straight pull, as stiff in the middle, up to where it snaps");
        self.near(k, "detent", why);
        Pull::Even {
            width: TAU / detent.count,
            centre: detent.centre,
            stiffness: detent.stiffness(),
            snap: 0.5 + detent.hysteresis,
            effect: k,
        }
    }

    fn snap(&mut self, k: usize, snap: &Snap) -> Pull<'a> {
        let Snap { width, stiffness, most, point, centre } = *snap;
        let strongest = stiffness * point * width;
        if strongest > most {
            self.near(k, "snap", format!("its pull goes on up to {strongest:.3} N m, beyond {most} N m"));
        }
        Pull::Even { width, centre, stiffness, snap: point, effect: k }
    }

    fn end(
        &mut self,
        k: usize,
        name: &'static str,
        (low, high): (Option<f64>, Option<f64>),
        stiffness: f64,
        damping: f64,
        ends: &mut Ends,
    ) {
        if damping > 0.0 {
            self.near(k, name, "its damping is the knob's own");
        }
        if !ends.effects.is_empty() && ends.stiffness != stiffness {
            self.near(k, name, "both ends are as stiff as the stiffest");
        }
        let inner = |a: Option<f64>, b: Option<f64>, pick: fn(f64, f64) -> f64| match (a, b) {
            (Some(a), Some(b)) => Some(pick(a, b)),
            (a, b) => a.or(b),
        };
        ends.low = inner(ends.low, low, f64::max);
        ends.high = inner(ends.high, high, f64::min);
        ends.stiffness = ends.stiffness.max(stiffness);
        ends.effects.push((k, name));
    }

    /// A strength for a stiffness, N m/rad.
    fn strength(&mut self, stiffness: f64, k: usize, name: &'static str) -> f32 {
        let (wanted, most) = (stiffness / self.device.stiffness, f64::from(MOST_STRENGTH));
        if wanted > most {
            let at_most = most * self.device.stiffness;
            self.near(k, name, format!("its stiffness is {at_most:.4} N m/rad at most, not {stiffness}"));
        }
        wanted.min(most) as f32
    }

    fn dead_zone(&mut self, k: usize, name: &'static str, width: f64) {
        let half = (0.2 * width).min(1_f64.to_radians());
        self.near(
            k,
            name,
            format!("within {:.2} degrees of the middle the knob does not pull", half.to_degrees()),
        );
    }

    /// The configuration, the angle of its position 0, and where it holds.
    fn build(&mut self, pull: &Pull<'a>, ends: &Ends, angle: f64) -> (Config, f64, Option<(f64, f64)>) {
        let free = Config::default();
        let (mut config, origin, holds) = match pull {
            Pull::None => {
                let (width, origin) = match (ends.low, ends.high) {
                    (Some(low), Some(high)) if high > low => {
                        ((high - low) / ((high - low) / FREE).round().max(1.0), low)
                    }
                    (low, high) => (FREE, low.or(high).unwrap_or(0.0)),
                };
                (Config { width: width as f32, ..free }, origin, None)
            }
            Pull::Even { width, centre, stiffness, snap, effect } => {
                let name = "detents";
                self.dead_zone(*effect, name, *width);
                let strength = self.strength(*stiffness, *effect, name);
                let (width, snap_point) = (*width as f32, *snap as f32);
                (Config { width, snap_point, detent_strength: strength, ..free }, *centre, None)
            }
            Pull::Place(k, spring) => {
                self.dead_zone(*k, "spring", ONE_PLACE);
                let endstop_strength = self.strength(spring.stiffness, *k, "spring");
                let width = ONE_PLACE as f32;
                (Config { width, endstop_strength, min: 0, max: 0, ..free }, spring.centre, None)
            }
            Pull::Magnets(magnets) => self.magnets(magnets, angle),
        };
        if let Pull::Place(..) = pull {
            for (k, name) in &ends.effects {
                self.left_out(*k, name, "the spring has both ends of the knob");
            }
        } else if let Some((k, name)) = ends.effects.first().copied() {
            let width = f64::from(config.width);
            let mut place = |stands: Option<f64>, far: i32| {
                let Some(at) = stands else { return far };
                let position = ((at - origin) / width).round().clamp(-f64::from(FAR), f64::from(FAR));
                let off = at - origin - position * width;
                if off.abs() > SMALL * width {
                    let why = format!("it stands on a position, {:.2} degrees away", off.abs().to_degrees());
                    self.near(k, name, why);
                }
                position as i32
            };
            config.min = place(ends.low, -FAR);
            config.max = place(ends.high, FAR).max(config.min);
            config.endstop_strength = self.strength(ends.stiffness, k, name);
        }
        let at = (angle - origin) / f64::from(config.width);
        let (least, most) = if config.has_ends() { (config.min, config.max) } else { (-FAR, FAR) };
        let position = at.round().clamp(f64::from(least), f64::from(most));
        config.position = position as i32;
        config.sub_position = (at - position).clamp(-10.0, 10.0) as f32;
        (config, origin, holds)
    }
}

#[cfg(test)]
mod tests;
