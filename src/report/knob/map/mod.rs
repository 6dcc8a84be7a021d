//! Stability map: which stiffness a device bears beside which computed damping, and what was asked of it.
//!
//! The edge is exact ([`Loop::edge`](crate::knob::stability::sampled::Loop::edge)): below it every eigenvalue of the sampled loop lies
//! within the unit circle, at it the first one leaves. Beside it stand what the governor grants, the closed form
//! (b + B) / (T / 2 + t_d) (Gil et al. 2009), and the stiffness up to which dry friction covers a count of the encoder, 2 f_c / δ (Abbott &
//! Okamura 2005).
//!
//! ```
//! use pacinian::knob::effect::Bound;
//! use pacinian::knob::governor::{MARGIN, device::{Delay, Device}};
//! use pacinian::knob::velocity::choice::Choice;
//! use pacinian::report::knob::map::Map;
//!
//! let device = Device {
//!     inertia: 6e-6, damping: 2e-5, friction: None, count: 1.57e-3, period: 1e-4, delay: Delay::ticks(1.0),
//!     resonance: None, low_pass: None, velocity: Choice::Difference, peak: 0.15,
//! };
//! let map = Map::new(&device, MARGIN, Some(Bound { stiffness: 0.5, damping: 0.0 }))?;
//! let granted = map.granted.expect("what was asked is a number");
//! assert!(granted.stiffness > 0.06 && granted.stiffness < 0.07);
//! assert!(map.svg("A knob").contains("Stiffness K"));
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

mod picture;
#[cfg(test)]
mod tests;

use std::fmt::Write;

use crate::actuator::fault::Fault;
use crate::knob::effect::Bound;
use crate::knob::governor::device::Device;
use crate::knob::governor::limit::Explanation;
use crate::knob::governor::{Allowed, Governor};
use crate::knob::stability::edge::Edge;
use crate::knob::stability::rules::gil;

/// Points across, at most: one is at no damping, and one at the damping's edge if that is on the map.
pub const POINTS: usize = 97;

/// A point of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Computed damping B, N m s/rad.
    pub damping: f64,
    /// Up to which stiffness (N m/rad) the knob comes to rest, and at which frequency (hertz) it swings there; a gain of 0: up to none.
    pub edge: Edge,
    /// What the governor grants at most, N m/rad; `None` beyond the damping that it grants.
    pub governed: Option<f64>,
    /// (b + B) / (T / 2 + t_d), N m/rad.
    pub rule: f64,
}

/// A stability map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// What it is of.
    pub device: Device,
    /// The share of the edge that the governor grants.
    pub margin: f64,
    /// From no damping on, [`POINTS`] of them, or one less where two fell together.
    pub points: Vec<Point>,
    /// The computed damping (N m s/rad) at which the knob swings without any spring, and its frequency there.
    pub damping_edge: Edge,
    /// The stiffness up to which dry friction covers a count, N m/rad; infinite where friction is not known.
    pub covered: f64,
    /// The stiffness at which a count asks for the peak torque, N m/rad.
    pub peak: f64,
    /// What effects ask; `None` if nothing was asked, or what is no number.
    pub asked: Option<Bound>,
    /// What of that is granted.
    pub granted: Option<Bound>,
    /// Shares of stiffness and damping that are granted; nothing of what is no number.
    pub allowed: Allowed,
    /// Which limit binds beside the granted damping, and what would lift it.
    pub explanation: Explanation,
}

impl Map {
    /// Of a device, with a governor that grants a share `margin` of its edge (above 0, at most 1), and what effects ask, if anything. It
    /// reaches to two and a half times the damping that was asked, and to all that is stable where none was.
    ///
    /// # Errors
    /// A figure of the device that cannot be; `margin`.
    pub fn new(device: &Device, margin: f64, asked: Option<Bound>) -> Result<Self, Fault> {
        let most = device.sampled()?.damping_edge().gain;
        let sound = asked.filter(|ask| number(ask.stiffness) && number(ask.damping));
        let wish = sound.map_or(0.0, |ask| ask.damping);
        let dome = 1.06 * most;
        let right = match (wish > 0.0, dome > 0.0 && dome.is_finite()) {
            (true, true) => f64::max(1.15 * wish, f64::min(dome, f64::max(2.5 * wish, 4.0 * device.damping))),
            (true, false) => 2.5 * wish,
            (false, true) => dome,
            (false, false) => f64::max(10.0 * device.damping, 1e-4),
        };
        Self::up_to(device, margin, asked, right)
    }

    /// The same up to a computed damping, N m s/rad.
    ///
    /// # Errors
    /// As [`Map::new`]; a damping that is not above 0.
    pub fn up_to(device: &Device, margin: f64, asked: Option<Bound>, right: f64) -> Result<Self, Fault> {
        crate::actuator::fault::positive("damping", right)?;
        let governor = Governor::new(device, margin)?;
        let sampled = device.sampled()?;
        let damping_edge = sampled.damping_edge();
        let late = device.delay.spring() * device.period;
        let at = |damping: f64| Point {
            damping,
            edge: match damping {
                0.0 => sampled.edge(0.0),
                b if b < damping_edge.gain => sampled.edge_within(b),
                _ => Edge::NONE,
            },
            governed: (damping <= governor.most_damping()).then(|| governor.most_stiffness(damping)),
            rule: gil(device.damping, damping, device.period, late),
        };
        // Closer together at both ends, where the edge is steep.
        let share = |n: usize| 0.5 - 0.5 * (std::f64::consts::PI * n as f64 / (POINTS - 1) as f64).cos();
        let mut dampings: Vec<f64> = (0..POINTS).map(|n| right * share(n)).collect();
        // Where the stable region ends, and where the governor does, whatever the steps are.
        for edge in [damping_edge.gain, governor.most_damping()] {
            if edge > 0.0 && edge < right {
                let above = dampings.partition_point(|b| *b < edge).clamp(1, POINTS - 2);
                dampings[above] = edge;
            }
        }
        dampings.sort_by(f64::total_cmp);
        dampings.dedup();
        let asked = asked.filter(|ask| number(ask.stiffness) && number(ask.damping));
        let allowed = asked.map_or(Allowed { stiffness: 0.0, damping: 0.0 }, |ask| governor.allow(&ask));
        let granted = asked.map(|ask| Bound {
            stiffness: ask.stiffness * allowed.stiffness,
            damping: ask.damping * allowed.damping,
        });
        Ok(Self {
            device: device.clone(),
            margin,
            points: dampings.into_iter().map(at).collect(),
            damping_edge,
            covered: device.covered(),
            peak: device.peak / device.count,
            asked,
            granted,
            allowed,
            explanation: governor.explain(granted.map_or(0.0, |bound| bound.damping))?,
        })
    }

    /// The map as comma-separated values under a line of names, `kind,damping_nms_per_rad,stiffness_nm_per_rad,hertz`. Kinds are `edge`,
    /// `governor`, `rule`, `quantisation`, `peak`, `asked` and `granted`; what there is not has no line.
    pub fn csv(&self) -> String {
        let mut out = String::from("kind,damping_nms_per_rad,stiffness_nm_per_rad,hertz\n");
        let mut line = |kind: &str, damping: Option<f64>, stiffness: f64, hertz: Option<f64>| {
            let cell = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.6e}"));
            if stiffness.is_finite() {
                let _ = writeln!(out, "{kind},{},{stiffness:.6e},{}", cell(damping), cell(hertz));
            }
        };
        for p in &self.points {
            line("edge", Some(p.damping), p.edge.gain, (p.edge.gain > 0.0).then_some(p.edge.hertz));
        }
        for p in &self.points {
            if let Some(governed) = p.governed {
                line("governor", Some(p.damping), governed, None);
            }
        }
        self.points.iter().for_each(|p| line("rule", Some(p.damping), p.rule, None));
        line("quantisation", None, self.covered, None);
        line("peak", None, self.peak, None);
        for (kind, bound) in [("asked", self.asked), ("granted", self.granted)] {
            if let Some(bound) = bound {
                line(kind, Some(bound.damping), bound.stiffness, None);
            }
        }
        out
    }
}

/// Whether a demand is one.
fn number(x: f64) -> bool {
    x.is_finite() && x >= 0.0
}
