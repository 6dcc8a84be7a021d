//! Small charts side by side over the same two logarithmic axes, each curve with its name beside it.

use super::axis::Scale;
use super::chart::{Axis, along, mark, scale};
use super::colour::Ink;
use super::path::Path;
use super::svg::{Anchor, Svg, Type, width};

/// Charts that share their axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sheet {
    /// The line above.
    pub title: String,
    /// What else must be known to read it, a line each.
    pub about: Vec<String>,
    /// The label of all horizontal axes, with a unit.
    pub x: String,
    /// The label of all vertical axes.
    pub y: String,
    /// How many charts stand side by side, at least 1.
    pub columns: usize,
    /// The charts.
    pub panels: Vec<Panel>,
}

/// One chart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// The line above.
    pub title: String,
    /// What it is of, in a smaller line.
    pub about: String,
    /// What is drawn. Curves of one name are alike in all charts.
    pub curves: Vec<Curve>,
    /// What it does not show, a line each below it.
    pub notes: Vec<String>,
}

/// Points joined by a line in the order given; those that are not above 0 both ways are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// What stands beside it.
    pub name: String,
    /// Whether it is what the sheet is about, and drawn so.
    pub strong: bool,
    /// Across, up, and whether the point is drawn large.
    pub points: Vec<(f64, f64, bool)>,
}

const WIDE: f64 = 460.0;
const HIGH: f64 = 330.0;
const MARGIN: f64 = 24.0;
/// Room of a chart left of, above and below what is drawn, and to the next one.
const LEFT: f64 = 62.0;
const TOP: f64 = 46.0;
const BOTTOM: f64 = 44.0;
const GAP: f64 = 18.0;
const LINE: f64 = 15.0;
const LETTER: f64 = 11.0;
/// A name farther off than this is joined to its curve.
const NEAR: f64 = 13.0;
/// Pixels farther off that a name may stand for not being nearer to another curve.
const MISTAKEN: f64 = 24.0;

type Frame = [f64; 4];

impl Sheet {
    /// The sheet as SVG, light, and dark where the reader prefers that.
    pub fn svg(&self) -> String {
        let columns = self.columns.max(1);
        let notes = self.panels.iter().map(|panel| panel.notes.len()).max().unwrap_or(0) as f64;
        let [across, down] = [LEFT + WIDE + GAP, TOP + HIGH + BOTTOM + LINE * notes + GAP];
        let head = MARGIN + 26.0 + LINE * self.about.len() as f64;
        let lines = self.panels.len().div_ceil(columns).max(1);
        let size = [2.0 * MARGIN + across * columns as f64 - GAP, head + down * lines as f64 + MARGIN - GAP];
        let mut svg = Svg::new(true);
        svg.rect([0.0, 0.0, size[0], size[1]], Ink::Page);
        let title = Type { bold: true, ..Type::new(17.0, Anchor::Start, Ink::Text) };
        svg.text_within(MARGIN, MARGIN + 12.0, title, &self.title, size[0] - 2.0 * MARGIN);
        for (n, line) in self.about.iter().enumerate() {
            let set = Type::new(12.0, Anchor::Start, Ink::Dim);
            let y = MARGIN + 32.0 + LINE * n as f64;
            svg.text_within(MARGIN, y, set, line, size[0] - 2.0 * MARGIN);
        }
        let names = self.names();
        for (n, panel) in self.panels.iter().enumerate() {
            let left = MARGIN + LEFT + across * (n % columns) as f64;
            let top = head + TOP + down * (n / columns) as f64;
            self.draw(&mut svg, panel, &names, [left, top, left + WIDE, top + HIGH]);
        }
        svg.finish(size[0], size[1], &self.title, &self.about.join(" "))
    }

    /// The names of all curves, each once.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for curve in self.panels.iter().flat_map(|panel| &panel.curves) {
            if !names.contains(&curve.name.as_str()) {
                names.push(&curve.name);
            }
        }
        names
    }

    fn draw(&self, svg: &mut Svg, panel: &Panel, names: &[&str], frame: Frame) {
        let [left, top, right, bottom] = frame;
        let log = Axis { log: true, ..Axis::default() };
        let all = || self.panels.iter().flat_map(|panel| &panel.curves).flat_map(Curve::shown);
        let x = scale(&log, all().map(|p| p.0), [left, right]);
        let y = scale(&log, all().map(|p| p.1), [bottom, top]);
        let bold = Type { bold: true, ..Type::new(13.0, Anchor::Start, Ink::Text) };
        svg.text_within(left, top - 24.0, bold, &panel.title, WIDE);
        svg.text_within(left, top - 9.0, Type::new(LETTER, Anchor::Start, Ink::Dim), &panel.about, WIDE);
        self.axes(svg, &x, &y, frame);
        for (n, note) in panel.notes.iter().enumerate() {
            let set = Type::new(LETTER, Anchor::Start, Ink::Limit);
            svg.text_within(left, bottom + BOTTOM + 4.0 + LINE * n as f64, set, note, WIDE);
        }
        let mut taken: Vec<(usize, Frame)> = Vec::new();
        let mut drawn = Vec::new();
        for (number, curve) in panel.curves.iter().enumerate() {
            let index = names.iter().position(|name| *name == curve.name).unwrap_or(0);
            let ink = Ink::Row { index, of: names.len() };
            let points: Vec<(f64, f64, bool)> =
                curve.shown().map(|(px, py, large)| (x.at(px), y.at(py), large)).collect();
            let mut path = Path::default();
            points.iter().for_each(|p| path.to(p.0, p.1));
            svg.stroke(&path, ink, if curve.strong { 2.6 } else { 1.2 });
            for pair in points.windows(2) {
                let between = along((pair[0].0, pair[0].1), (pair[1].0, pair[1].1));
                taken.extend(between.map(|own| (number, own)));
            }
            for (px, py, large) in &points {
                let half = if *large { 5.5 } else { 2.5 };
                if *large {
                    mark(svg, index, ink, *px, *py);
                } else {
                    svg.rect([px - 2.0, py - 2.0, 4.0, 4.0], ink);
                }
                taken.push((number, [px - half, py - half, px + half, py + half]));
            }
            drawn.push((curve, ink, points));
        }
        for (number, (curve, ink, points)) in drawn.into_iter().enumerate() {
            name(svg, &mut taken, (number, curve, ink), &points, frame);
        }
    }

    fn axes(&self, svg: &mut Svg, x: &Scale, y: &Scale, [left, top, right, bottom]: Frame) {
        let dim = |anchor| Type::new(LETTER, anchor, Ink::Dim);
        for (at, label) in x.ticks(8) {
            let at = x.at(at);
            svg.line([at, top, at, bottom], Ink::Grid, 0.8, 0.0);
            svg.text(at, bottom + 15.0, dim(Anchor::Middle), &label);
        }
        for (at, label) in y.ticks(10) {
            let at = y.at(at);
            svg.line([left, at, right, at], Ink::Grid, 0.8, 0.0);
            svg.text(left - 7.0, at + 4.0, dim(Anchor::End), &label);
        }
        svg.line([left, bottom, right, bottom], Ink::Axis, 1.0, 0.0);
        svg.line([left, top, left, bottom], Ink::Axis, 1.0, 0.0);
        let label = Type::new(LETTER, Anchor::Middle, Ink::Text);
        svg.text((left + right) / 2.0, bottom + 31.0, label, &self.x);
        svg.text_up(left - 48.0, (top + bottom) / 2.0, label, &self.y);
    }
}

impl Curve {
    fn shown(&self) -> impl Iterator<Item = (f64, f64, bool)> {
        let fits = |v: f64| v.is_finite() && v > 0.0;
        self.points.iter().copied().filter(move |(x, y, _)| fits(*x) && fits(*y))
    }
}

/// Writes the name of a curve at the nearest free place to one of its points, if there is one, not nearer to another curve; without
/// points there is none.
fn name(
    svg: &mut Svg,
    taken: &mut Vec<(usize, Frame)>,
    (number, curve, ink): (usize, &Curve, Ink),
    points: &[(f64, f64, bool)],
    frame: Frame,
) {
    let wide = LETTER * width(&curve.name) + 2.0;
    let apart = |a: &Frame, b: &Frame| a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1];
    let within = |a: &Frame| a[0] > frame[0] && a[2] < frame[2] && a[1] > frame[1] && a[3] < frame[3];
    let free = |own: &Frame| within(own) && taken.iter().all(|(_, other)| apart(own, other));
    let gap = |a: &Frame, b: &Frame| {
        let one = |low: f64, high: f64| (low - high).max(0.0);
        (one(b[0], a[2]) + one(a[0], b[2])).hypot(one(b[1], a[3]) + one(a[1], b[3]))
    };
    let strange = |own: &Frame| {
        let others = taken.iter().filter(|(of, _)| *of != number);
        others.map(|(_, other)| gap(own, other)).fold(f64::INFINITY, f64::min)
    };
    let order = points.last().into_iter().chain(points);
    let mut best: Option<(f64, Frame, (f64, f64))> = None;
    for (px, py, _) in order {
        for ring in 0..14 {
            let off = 9.0 + 9.0 * f64::from(ring);
            for turn in 0..16 {
                let (s, c) = (f64::from(turn) * std::f64::consts::TAU / 16.0).sin_cos();
                // The box touches a circle about the point.
                let middle = [px + c * (off + 0.5 * wide), py + s * (off + 0.5 * LETTER)];
                let own = [
                    middle[0] - 0.5 * wide,
                    middle[1] - 0.55 * LETTER,
                    middle[0] + 0.5 * wide,
                    middle[1] + 0.55 * LETTER,
                ];
                let nearest = (px.clamp(own[0], own[2]), py.clamp(own[1], own[3]));
                let far = (nearest.0 - px).hypot(nearest.1 - py);
                if best.as_ref().is_some_and(|(known, ..)| far >= known - 1e-9) || !free(&own) {
                    continue;
                }
                let cost = far + if strange(&own) < far { MISTAKEN } else { 0.0 };
                if best.as_ref().is_none_or(|(known, ..)| cost < known - 1e-9) {
                    best = Some((cost, own, (*px, *py)));
                }
            }
        }
    }
    let Some((cost, own, (px, py))) = best else { return };
    if cost > NEAR {
        let to = (px.clamp(own[0], own[2]), py.clamp(own[1], own[3]));
        svg.line([px, py, to.0, to.1], ink, 0.7, 2.0);
        taken.extend(along((px, py), to).map(|own| (number, own)));
    }
    let set = Type { bold: curve.strong, ..Type::new(LETTER, Anchor::Middle, ink) };
    svg.text((own[0] + own[2]) / 2.0, own[3] - 0.25 * LETTER, set, &curve.name);
    taken.push((number, own));
}

#[cfg(test)]
mod tests;
