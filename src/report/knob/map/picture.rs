//! The map as SVG.

use super::{Map, Point};
use crate::knob::governor::limit::Remedy;
use crate::report::plot::axis::{short, whole};
use crate::report::plot::colour::Ink;
use crate::report::plot::panels::{Across, Form, Panel, Panels, Shape};

const WIDTH: f64 = 860.0;
/// Decades that the map shows at most, and the least.
const DECADES: f64 = 6.0;
const FEWEST: f64 = 1.5;
/// A limit so many times above all else is told, not drawn.
const FAR: f64 = 30.0;
/// Remedies that are told.
const TOLD: usize = 4;

impl Map {
    /// The picture as SVG, light, and dark where the reader prefers that. `title` is its first line.
    pub fn svg(&self, title: &str) -> String {
        let right = self.points.last().map_or(1.0, |p| p.damping);
        let range = self.range();
        let bottom = range[0];
        let line = |of: &dyn Fn(&Point) -> Option<f64>| -> Vec<(f64, f64)> {
            self.points.iter().map(|p| (p.damping, of(p).unwrap_or(f64::NAN))).collect()
        };
        let shape = |name: &str, ink, form, points| Shape { name: name.into(), ink, form, points };
        let under = |curve: &[(f64, f64)]| -> Vec<(f64, f64)> {
            let curve: Vec<(f64, f64)> = curve.iter().copied().filter(|(_, k)| *k > 0.0).collect();
            match (curve.first(), curve.last()) {
                (Some(first), Some(last)) => {
                    let (first, last) = ((first.0, bottom), (last.0, bottom));
                    [&[first][..], &curve, &[last]].concat()
                }
                _ => Vec::new(),
            }
        };
        let edge = line(&|p| Some(p.edge.gain));
        let governed = line(&|p| p.governed);
        let whole = vec![(0.0, range[0]), (0.0, range[1]), (right, range[1]), (right, range[0])];
        let mut shapes = vec![
            shape("swings by itself", Ink::Limit, Form::Area(0.10), whole),
            // What is stable hides what is not.
            shape("", Ink::Page, Form::Area(1.0), under(&edge)),
            shape("comes to rest", Ink::Kind { index: 4 }, Form::Area(0.16), under(&edge)),
            shape("granted", Ink::Kind { index: 4 }, Form::Area(0.34), under(&governed)),
        ];
        let rule = line(&|p| Some(p.rule).filter(|k| *k <= range[1]));
        shapes.push(shape("(b + B) / (T / 2 + t_d)", Ink::Dim, Form::Dashed(1.4, "6 4"), rule));
        let level = |k: f64| vec![(0.0, k), (right, k)];
        let kind = |index| Ink::Kind { index };
        if self.shown(self.covered, range) {
            let name = "dry friction covers a count: 2 f_c / δ";
            shapes.push(shape(name, kind(2), Form::Dashed(1.6, "2 3"), level(self.covered)));
        }
        if self.shown(self.peak, range) {
            let name = "a count asks for the peak torque";
            shapes.push(shape(name, kind(0), Form::Dashed(1.6, "10 3 2 3"), level(self.peak)));
        }
        shapes.push(shape("governor's limit", Ink::Kind { index: 4 }, Form::Line(1.8), governed));
        shapes.push(shape("edge, exact", Ink::Limit, Form::Line(2.2), edge));
        if let (Some(asked), Some(granted)) = (self.asked, self.granted) {
            let ends = [(asked.damping, asked.stiffness), (granted.damping, granted.stiffness)];
            if ends[0] != ends[1] {
                shapes.push(shape("", Ink::Text, Form::Line(1.2), ends.to_vec()));
                shapes.push(shape("asked", Ink::Heat, Form::Marks(2), vec![ends[0]]));
            }
            let name = if ends[0] == ends[1] { "asked, and granted" } else { "what is left of it" };
            shapes.push(shape(name, Ink::Text, Form::Marks(0), vec![ends[1]]));
        }
        let axis = |label: &str, range, log| Across { label: label.into(), range, log, rows: Vec::new() };
        Panels {
            title: title.into(),
            about: self.about(),
            panels: vec![Panel {
                frame: [96.0, 4.0, WIDTH - 136.0, 380.0],
                x: axis("Computed damping B (N m s/rad)", [0.0, right], false),
                y: axis("Stiffness K (N m/rad)", range, true),
                shapes,
            }],
            notes: self.notes(range),
            width: WIDTH,
        }
        .svg()
    }

    /// Stiffnesses from the lower to the upper end.
    pub(super) fn range(&self) -> [f64; 2] {
        let edges = || self.points.iter().map(|p| p.edge.gain);
        let governed = self.points.iter().filter_map(|p| p.governed);
        let bounds = [self.asked, self.granted].into_iter().flatten().map(|b| b.stiffness);
        let sound = |k: &f64| *k > 0.0 && k.is_finite();
        let most = |of: &mut dyn Iterator<Item = f64>| of.filter(sound).fold(0.0, f64::max);
        let least = |of: &mut dyn Iterator<Item = f64>| of.filter(sound).fold(f64::INFINITY, f64::min);
        let mut high = most(&mut edges().chain(bounds.clone()).chain(governed));
        if !sound(&high) {
            // Nothing is stable and nothing was asked: the rule is all there is to show.
            high = most(&mut self.points.iter().map(|p| p.rule));
        }
        if !sound(&high) {
            return [1e-3, 1.0];
        }
        for limit in [self.covered, self.peak] {
            if limit > high && limit < FAR * high {
                high = limit;
            }
        }
        // At no damping, and what was asked and granted; the edge falls to nothing at its end.
        let first = self.points.first();
        let starts = first.into_iter().flat_map(|p| [Some(p.edge.gain), p.governed, Some(p.rule)]).flatten();
        let low = least(&mut starts.chain(bounds));
        let low = if low.is_finite() { low } else { high };
        let high = 1.6 * high;
        let low = (0.5 * low).clamp(high * 10f64.powf(-DECADES), high * 10f64.powf(-FEWEST));
        [low, high]
    }

    fn shown(&self, level: f64, [low, high]: [f64; 2]) -> bool {
        level >= low && level <= high
    }

    fn about(&self) -> Vec<String> {
        let d = &self.device;
        let ticks = d.delay.total();
        let mut about = vec![format!(
            "J {} kg m², b {} N m s/rad, T {} s ({} Hz), delay {} T ({} s) beside the hold's half tick",
            short(d.inertia),
            short(d.damping),
            short(d.period),
            whole(1.0 / d.period),
            short(ticks),
            short(ticks * d.period),
        )];
        let counts = std::f64::consts::TAU / d.count;
        let mut more =
            format!("Encoder of {} counts a turn, peak torque {} N m, ", whole(counts), short(d.peak));
        more += &match d.friction {
            Some(friction) => format!("dry friction {} N m", short(friction)),
            None => "dry friction not known".into(),
        };
        if let Some(shaft) = &d.resonance {
            more += &format!(", shaft at {} Hz clamped", short(shaft.clamped));
        }
        if let Some(hertz) = d.low_pass {
            more += &format!(", low-pass at {} Hz", short(hertz));
        }
        about.push(more);
        about
    }

    /// Figures, and what the map does not show.
    fn notes(&self, range: [f64; 2]) -> Vec<(String, bool)> {
        let mut notes = Vec::new();
        let e = &self.explanation;
        let beside = short(self.granted.map_or(0.0, |b| b.damping));
        if e.edge.0 > 0.0 {
            notes.push((
                format!(
                    "Beside B = {beside} N m s/rad the edge is {} N m/rad, where it swings at {} Hz.",
                    short(e.edge.0),
                    short(e.edge.1),
                ),
                false,
            ));
            let granted = short(e.stiffness);
            notes.push((format!("Granted up to {granted} N m/rad, bound by {}.", e.binds), false));
        } else {
            notes.push((format!("Beside B = {beside} N m s/rad no stiffness comes to rest."), true));
        }
        for (remedy, times) in e.remedies.iter().take(TOLD) {
            let what = match remedy {
                Remedy::Damping(b) => format!("a damping of {} N m s/rad in the device", short(*b)),
                Remedy::HalfDamping(b) => format!("a computed damping of {} N m s/rad", short(*b)),
                other => other.to_string(),
            };
            notes.push((format!("– {what} would allow {} times that", short(*times)), false));
        }
        if let (Some(asked), Some(granted)) = (self.asked, self.granted) {
            let percent = |share: f64| format!("{} %", short((1e3 * share).round() / 10.0));
            notes.push((
                format!(
                    "Asked: K {} N m/rad, B {} N m s/rad. Left: K {} ({}), B {} ({}).",
                    short(asked.stiffness),
                    short(asked.damping),
                    short(granted.stiffness),
                    percent(self.allowed.stiffness),
                    short(granted.damping),
                    percent(self.allowed.damping),
                ),
                self.allowed.acted(),
            ));
        }
        for (name, limit) in [
            ("Dry friction covers a count up to", self.covered),
            ("A count asks for the peak torque at", self.peak),
        ] {
            if limit.is_finite() && !self.shown(limit, range) {
                let side = if limit > range[1] { "above" } else { "below" };
                notes.push((
                    format!("{name} {} N m/rad, {side} what is drawn.", short(limit)),
                    limit < range[0],
                ));
            }
        }
        if self.damping_edge.gain > 0.0 && self.damping_edge.gain.is_finite() {
            notes.push((
                format!(
                    "Without a spring it swings from B = {} N m s/rad on, at {} Hz.",
                    short(self.damping_edge.gain),
                    short(self.damping_edge.hertz)
                ),
                false,
            ));
        } else if self.damping_edge.gain == 0.0 {
            notes.push(("No computed damping comes to rest.".into(), true));
        }
        notes
    }
}
