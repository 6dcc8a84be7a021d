//! Panels placed freely, each with its own two axes, under one key: what curves over time and small charts have no form for.

use super::axis::Scale;
use super::chart::mark;
use super::colour::Ink;
use super::path::Path;
use super::svg::{Anchor, Svg, Type, width};

/// A picture of panels.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::report) struct Panels {
    /// The line above.
    pub title: String,
    /// Small lines below it.
    pub about: Vec<String>,
    /// What is drawn, below the key; frames count from there.
    pub panels: Vec<Panel>,
    /// Lines below everything, and whether each is a warning.
    pub notes: Vec<(String, bool)>,
    /// Width of the whole, pixels.
    pub width: f64,
}

/// One panel.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::report) struct Panel {
    /// Left, top, width and height of what lies within its axes, pixels. Labels need 80 to the left, and 36 below where x has one.
    pub frame: [f64; 4],
    /// What runs across.
    pub x: Across,
    /// What runs up.
    pub y: Across,
    /// From the back to the front.
    pub shapes: Vec<Shape>,
}

/// An axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::report) struct Across {
    /// What it shows, with its unit; empty: ticks without numbers.
    pub label: String,
    /// From and to.
    pub range: [f64; 2],
    /// By decades.
    pub log: bool,
    /// Names in place of numbers, where it has rows.
    pub rows: Vec<(f64, String)>,
}

/// Something drawn.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Shape {
    /// What the key says; empty: nothing. Of shapes of one name the key has the first.
    pub name: String,
    pub ink: Ink,
    pub form: Form,
    /// Points in the axes' units. Those beyond an axis are drawn at its end; a point that is not a number parts a line.
    pub points: Vec<(f64, f64)>,
}

/// How it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) enum Form {
    /// A line so broad.
    Line(f64),
    /// A line with dashes of these lengths.
    Dashed(f64, &'static str),
    /// A closed area of an opacity.
    Area(f64),
    /// Marks of a shape, by its number.
    Marks(usize),
    /// Short upright lines.
    Ticks,
}

const MARGIN: f64 = 28.0;
const LETTER: f64 = 11.0;
const LINE: f64 = 17.0;

impl Panels {
    /// The picture as SVG, light, and dark where the reader prefers that.
    pub fn svg(&self) -> String {
        let inner = self.width - 2.0 * MARGIN;
        let key = self.key();
        let rows = key.last().map_or(0.0, |entry| entry.1 + 1.0);
        let head = 52.0 + 15.0 * self.about.len() as f64;
        let top = head + 20.0 * rows + 14.0;
        let foot = |p: &Panel| p.frame[1] + p.frame[3] + if p.x.label.is_empty() { 8.0 } else { 46.0 };
        let below = top + self.panels.iter().map(foot).fold(0.0, f64::max);
        let height = below + 16.0 + LINE * self.notes.len() as f64;
        let mut svg = Svg::new(true);
        svg.rect([0.0, 0.0, self.width, height], Ink::Page);
        let title = Type { bold: true, ..Type::new(17.0, Anchor::Start, Ink::Text) };
        svg.text_within(MARGIN, 36.0, title, &self.title, inner);
        for (n, line) in self.about.iter().enumerate() {
            let set = Type::new(12.0, Anchor::Start, Ink::Dim);
            svg.text_within(MARGIN, 56.0 + 15.0 * n as f64, set, line, inner);
        }
        for (x, row, shape) in key {
            let y = head + 12.0 + 20.0 * row;
            shape.sample(&mut svg, x, y);
            svg.text(x + 34.0, y + 4.0, Type::new(12.0, Anchor::Start, Ink::Text), &shape.name);
        }
        for panel in &self.panels {
            let [left, up, wide, high] = panel.frame;
            panel.draw(&mut svg, [left, top + up, left + wide, top + up + high]);
        }
        for (n, (note, warns)) in self.notes.iter().enumerate() {
            let set = Type::new(12.0, Anchor::Start, if *warns { Ink::Limit } else { Ink::Text });
            svg.text_within(MARGIN, below + 10.0 + LINE * n as f64, set, note, inner);
        }
        svg.finish(self.width, height, &self.title, &self.about.join(" "))
    }

    /// Where each entry of the key begins, its row, and what it shows.
    fn key(&self) -> Vec<(f64, f64, &Shape)> {
        let mut entries: Vec<(f64, f64, &Shape)> = Vec::new();
        let (mut x, mut row) = (MARGIN, 0.0);
        for shape in self.panels.iter().flat_map(|panel| &panel.shapes) {
            if shape.name.is_empty() || entries.iter().any(|(_, _, known)| known.name == shape.name) {
                continue;
            }
            let wide = 58.0 + 12.0 * width(&shape.name);
            if x + wide > self.width - MARGIN + 24.0 && x > MARGIN {
                (x, row) = (MARGIN, row + 1.0);
            }
            entries.push((x, row, shape));
            x += wide;
        }
        entries
    }
}

impl Across {
    fn scale(&self, low: f64, high: f64) -> Scale {
        if self.log { Scale::log(self.range, low, high) } else { Scale::linear(self.range, low, high) }
    }

    fn ticks(&self, scale: &Scale, most: usize) -> Vec<(f64, String)> {
        if self.rows.is_empty() { scale.ticks(most) } else { self.rows.clone() }
    }
}

impl Panel {
    fn draw(&self, svg: &mut Svg, [left, top, right, bottom]: [f64; 4]) {
        let (x, y) = (self.x.scale(left, right), self.y.scale(bottom, top));
        let dim = |anchor| Type::new(LETTER, anchor, Ink::Dim);
        for (at, label) in self.x.ticks(&x, ((right - left) / 74.0) as usize) {
            let at = x.at(at);
            svg.line([at, top, at, bottom], Ink::Grid, 0.8, 0.0);
            if !self.x.label.is_empty() {
                svg.text(at, bottom + 16.0, dim(Anchor::Middle), &label);
            }
        }
        for (at, label) in self.y.ticks(&y, ((bottom - top) / 22.0).max(2.0) as usize) {
            let at = y.at(at);
            svg.line([left, at, right, at], Ink::Grid, 0.8, 0.0);
            svg.text(left - 7.0, at + 4.0, dim(Anchor::End), &label);
        }
        let whole = |scale: &Scale, value: f64, ends: [f64; 2]| {
            let pixel = scale.at(value);
            let least = ends[0].min(ends[1]);
            // A logarithm of nothing lies at the lower end.
            if pixel.is_nan() { ends[0] } else { pixel.clamp(least, ends[0].max(ends[1])) }
        };
        for shape in &self.shapes {
            let parts = shape.points.split(|(a, b)| a.is_nan() || b.is_nan());
            for part in parts.filter(|part| !part.is_empty()) {
                let pixels: Vec<(f64, f64)> = part
                    .iter()
                    .map(|(a, b)| (whole(&x, *a, [left, right]), whole(&y, *b, [bottom, top])))
                    .collect();
                shape.draw(svg, &pixels);
            }
        }
        if !self.y.log && self.y.rows.is_empty() && self.y.range[0] < 0.0 && self.y.range[1] > 0.0 {
            svg.line([left, y.at(0.0), right, y.at(0.0)], Ink::Axis, 1.0, 0.0);
        }
        svg.line([left, bottom, right, bottom], Ink::Axis, 1.0, 0.0);
        svg.line([left, top, left, bottom], Ink::Axis, 1.0, 0.0);
        let label = Type::new(12.0, Anchor::Middle, Ink::Text);
        if !self.x.label.is_empty() {
            svg.text((left + right) / 2.0, bottom + 34.0, label, &self.x.label);
        }
        svg.text_up(left - 56.0, (top + bottom) / 2.0, label, &self.y.label);
    }
}

impl Shape {
    fn draw(&self, svg: &mut Svg, pixels: &[(f64, f64)]) {
        let mut path = Path::default();
        pixels.iter().for_each(|(x, y)| path.to(*x, *y));
        match self.form {
            Form::Line(broad) => svg.stroke(&path, self.ink, broad),
            Form::Dashed(broad, dashes) => svg.dashed(&path, self.ink, broad, dashes),
            Form::Area(opacity) => svg.area(&path, self.ink, opacity, 0.0),
            Form::Marks(number) => pixels.iter().for_each(|(x, y)| mark(svg, number, self.ink, *x, *y)),
            Form::Ticks => {
                pixels.iter().for_each(|(x, y)| svg.line([*x, y - 4.5, *x, y + 4.5], self.ink, 1.4, 0.0));
            }
        }
    }

    /// What the key shows of it, from `x` on, about the height `y`.
    fn sample(&self, svg: &mut Svg, x: f64, y: f64) {
        match self.form {
            Form::Area(_) => {
                let corners = [(x, y - 6.0), (x + 26.0, y - 6.0), (x + 26.0, y + 6.0), (x, y + 6.0)];
                self.draw(svg, &corners);
            }
            Form::Marks(_) | Form::Ticks => self.draw(svg, &[(x + 13.0, y)]),
            _ => self.draw(svg, &[(x, y), (x + 26.0, y)]),
        }
    }
}

/// From and to of all values, and a little more: never the same, and always numbers. `held` are values that must lie within.
pub(in crate::report) fn span(values: impl IntoIterator<Item = f64>, held: &[f64]) -> [f64; 2] {
    let all = values.into_iter().chain(held.iter().copied()).filter(|v| v.is_finite());
    let [least, most] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    // Nothing at all is least above most.
    if least > most || !(most - least).is_finite() {
        return [0.0, 1.0];
    }
    let room = 0.04 * (most - least);
    if room > 1e-12 * most.abs().max(least.abs()) {
        [least - room, most + room]
    } else {
        match most == 0.0 && least == 0.0 {
            true => [0.0, 1.0],
            false => [least - 0.5 * least.abs(), most + 0.5 * most.abs()],
        }
    }
}

#[cfg(test)]
mod tests;
