//! A small chart of points with labels, such as error against run time.

use super::axis::{Scale, nice};
use super::colour::Ink;
use super::path::Path;
use super::svg::{Anchor, Svg, Type, width};

/// One direction of a chart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// What it shows, with its unit: "run time (s)".
    pub label: String,
    /// Whether it runs by decades; values not above 0 are then left out, and the chart says how many.
    pub log: bool,
    /// How much it spans at least, where it does not run by decades: what hardly differs is drawn so.
    pub least: f64,
}

/// A point of a chart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Point {
    /// Along the horizontal axis.
    pub x: f64,
    /// Along the vertical axis.
    pub y: f64,
    /// What stands beside it; may be empty.
    pub label: String,
}

/// Points that belong together, joined by a line in the order given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// What the key says of it; may be empty.
    pub name: String,
    /// Its points.
    pub points: Vec<Point>,
    /// Whether it is a curve, marked where a point has a label and nowhere else.
    pub smooth: bool,
}

/// A chart of one or more series.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chart {
    /// The line above.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn.
    pub series: Vec<Series>,
    /// What must be said because the chart does not show it, below it.
    pub notes: Vec<String>,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 480.0;
const RIGHT: f64 = WIDTH - 36.0;
const BOTTOM: f64 = HEIGHT - 64.0;
const LETTER: f64 = 11.0;
/// Base line of the vertical axis' label.
const TITLE: f64 = 34.0;

impl Chart {
    /// The chart as SVG, 760 by 480 pixels and a line for each note, in dark mode where the reader prefers that.
    pub fn svg(&self) -> String {
        let shown: Vec<Vec<&Point>> =
            self.series.iter().map(|s| s.points.iter().filter(|p| self.shows(p)).collect()).collect();
        let left_out =
            self.series.iter().map(|s| s.points.len()).sum::<usize>() - shown.iter().flatten().count();
        let keyed = self.series.iter().any(|s| !s.name.is_empty());
        let top = if keyed { 92.0 } else { 68.0 };
        let y = scale(&self.y, shown.iter().flatten().map(|p| p.y), [BOTTOM, top]);
        let labels = y.ticks(8).iter().map(|(_, label)| width(label)).fold(0.0, f64::max);
        // The axis' own label stands left of those of its ticks.
        let left = (TITLE + 18.0 + LETTER * labels).max(84.0);
        let x = scale(&self.x, shown.iter().flatten().map(|p| p.x), [left, RIGHT]);
        let mut notes = self.notes.clone();
        if left_out > 0 {
            notes.push(format!("Points that the axes cannot show: {left_out}."));
        }
        let height = HEIGHT + if notes.is_empty() { 0.0 } else { 8.0 + 17.0 * notes.len() as f64 };

        let mut svg = Svg::new(true);
        svg.rect([0.0, 0.0, WIDTH, height], Ink::Page);
        let title = Type { bold: true, ..Type::new(17.0, Anchor::Start, Ink::Text) };
        svg.text_within(28.0, 36.0, title, &self.title, WIDTH - 56.0);
        self.draw_axes(&mut svg, &x, &y, [left, top]);
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let mut key = 28.0;
        for (index, (series, points)) in self.series.iter().zip(&shown).enumerate() {
            let ink = Ink::Row { index, of: self.series.len() };
            let mut path = Path::default();
            for point in points {
                path.to(x.at(point.x), y.at(point.y));
            }
            svg.stroke(&path, ink, 1.4);
            for pair in points.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|p| (x.at(p.x), y.at(p.y)));
                taken.extend(along(a, b));
            }
            for point in points.iter().filter(|point| !series.smooth || !point.label.is_empty()) {
                let (px, py) = (x.at(point.x), y.at(point.y));
                mark(&mut svg, index, ink, px, py);
                taken.push([px - 5.0, py - 5.0, px + 5.0, py + 5.0]);
            }
            if !series.name.is_empty() {
                mark(&mut svg, index, ink, key + 5.0, 62.0);
                svg.text(key + 16.0, 66.0, Type::new(12.0, Anchor::Start, Ink::Text), &series.name);
                key += 44.0 + 12.0 * width(&series.name);
            }
        }
        for point in shown.iter().flatten().filter(|p| !p.label.is_empty()) {
            let (px, py, anchor) =
                free(&mut taken, x.at(point.x), y.at(point.y), LETTER * width(&point.label), [left, top]);
            svg.text(px, py, Type::new(LETTER, anchor, Ink::Text), &point.label);
        }
        for (i, note) in notes.iter().enumerate() {
            let set = Type::new(12.0, Anchor::Start, Ink::Limit);
            svg.text_within(28.0, HEIGHT + 6.0 + 17.0 * i as f64, set, note, WIDTH - 56.0);
        }
        svg.finish(WIDTH, height, &self.title, "")
    }

    fn shows(&self, point: &Point) -> bool {
        let fits = |v: f64, axis: &Axis| v.is_finite() && (!axis.log || v > 0.0);
        fits(point.x, &self.x) && fits(point.y, &self.y)
    }

    fn draw_axes(&self, svg: &mut Svg, x: &Scale, y: &Scale, [left, top]: [f64; 2]) {
        let dim = |anchor| Type::new(LETTER, anchor, Ink::Dim);
        for (at, label) in x.ticks(10) {
            let at = x.at(at);
            svg.line([at, top, at, BOTTOM], Ink::Grid, 0.8, 0.0);
            svg.text(at, BOTTOM + 18.0, dim(Anchor::Middle), &label);
        }
        for (at, label) in y.ticks(8) {
            let at = y.at(at);
            svg.line([left, at, RIGHT, at], Ink::Grid, 0.8, 0.0);
            svg.text(left - 9.0, at + 4.0, dim(Anchor::End), &label);
        }
        svg.line([left, BOTTOM, RIGHT, BOTTOM], Ink::Axis, 1.0, 0.0);
        svg.line([left, top, left, BOTTOM], Ink::Axis, 1.0, 0.0);
        let label = |anchor| Type::new(12.0, anchor, Ink::Text);
        svg.text((left + RIGHT) / 2.0, BOTTOM + 42.0, label(Anchor::Middle), &self.x.label);
        svg.text_up(TITLE, (top + BOTTOM) / 2.0, label(Anchor::Middle), &self.y.label);
    }
}

/// A scale that holds all values and ends at ticks.
pub(super) fn scale(axis: &Axis, values: impl Iterator<Item = f64>, [low, high]: [f64; 2]) -> Scale {
    let [least, most] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |all, v| [all[0].min(v), all[1].max(v)]);
    if axis.log {
        let decade = |v: f64| 10f64.powf(v);
        let [from, to] = [least.log10().floor(), most.log10().ceil()];
        return Scale::log([decade(from), decade(if to > from { to } else { from + 1.0 })], low, high);
    }
    // What hardly differs is widened about its middle.
    let wider = 0.5 * (axis.least - (most - least)).max(0.0);
    let [least, most] = if wider.is_finite() { [least - wider, most + wider] } else { [least, most] };
    // One value alone, or equal ones, stand in the middle.
    let spread = if most > least { most - least } else { most.abs().max(1.0) };
    let step = nice(spread / 8.0);
    let [from, to] = [(least / step).floor() * step, (most / step).ceil() * step];
    Scale::linear(if to > from { [from, to] } else { [from - step, to + step] }, low, high)
}

/// A mark whose shape tells the series where colour cannot.
pub(in crate::report) fn mark(svg: &mut Svg, index: usize, ink: Ink, x: f64, y: f64) {
    let around: &[(f64, f64)] = match index % 4 {
        0 => &[
            (-1.7, -4.1),
            (1.7, -4.1),
            (4.1, -1.7),
            (4.1, 1.7),
            (1.7, 4.1),
            (-1.7, 4.1),
            (-4.1, 1.7),
            (-4.1, -1.7),
        ],
        1 => &[(-3.8, -3.8), (3.8, -3.8), (3.8, 3.8), (-3.8, 3.8)],
        2 => &[(0.0, -5.0), (4.6, 3.6), (-4.6, 3.6)],
        _ => &[(0.0, -5.2), (5.2, 0.0), (0.0, 5.2), (-5.2, 0.0)],
    };
    let mut path = Path::default();
    around.iter().for_each(|(dx, dy)| path.to(x + dx, y + dy));
    svg.area(&path, ink, 1.0, 0.0);
}

/// Small boxes along a line, for labels to keep clear of.
pub(super) fn along(a: (f64, f64), b: (f64, f64)) -> impl Iterator<Item = [f64; 4]> {
    let pieces = ((b.0 - a.0).abs().max((b.1 - a.1).abs()) / 4.0).ceil().clamp(1.0, 400.0);
    (0..=pieces as usize).map(move |i| {
        let share = i as f64 / pieces;
        let (x, y) = (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share);
        [x - 1.5, y - 1.5, x + 1.5, y + 1.5]
    })
}

/// The first place beside a point where its label touches neither mark nor label nor frame; the first of all where none is.
fn free(taken: &mut Vec<[f64; 4]>, x: f64, y: f64, wide: f64, [left, top]: [f64; 2]) -> (f64, f64, Anchor) {
    let around = [
        (x + 10.0, y + 4.0, Anchor::Start),
        (x - 10.0, y + 4.0, Anchor::End),
        (x, y - 10.0, Anchor::Middle),
        (x, y + 18.0, Anchor::Middle),
        (x + 9.0, y - 8.0, Anchor::Start),
        (x + 9.0, y + 16.0, Anchor::Start),
        (x - 9.0, y - 8.0, Anchor::End),
        (x - 9.0, y + 16.0, Anchor::End),
    ];
    let frame = |(x, y, anchor): (f64, f64, Anchor)| {
        let left = match anchor {
            Anchor::Start => x,
            Anchor::Middle => x - wide / 2.0,
            Anchor::End => x - wide,
        };
        [left, y - 0.8 * LETTER, left + wide, y + 0.25 * LETTER]
    };
    let apart = |a: &[f64; 4], b: &[f64; 4]| a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1];
    let inside = |a: &[f64; 4]| a[0] > left && a[2] < RIGHT + 24.0 && a[1] > top - 14.0 && a[3] < BOTTOM;
    let place = around
        .into_iter()
        .find(|at| {
            let own = frame(*at);
            inside(&own) && taken.iter().all(|other| apart(&own, other))
        })
        .unwrap_or(around[0]);
    taken.push(frame(place));
    place
}

#[cfg(test)]
mod tests {
    use super::{Axis, Chart, Point, Series, scale};

    fn chart(log: bool, points: &[(f64, f64, &str)]) -> Chart {
        let points =
            points.iter().map(|(x, y, label)| Point { x: *x, y: *y, label: label.to_string() }).collect();
        Chart {
            title: "Error <against> run time".into(),
            x: Axis { label: "run time (s)".into(), log, least: 0.0 },
            y: Axis { label: "error & more".into(), log, least: 0.0 },
            series: vec![Series { name: "a \"b\"".into(), points, smooth: false }],
            notes: Vec::new(),
        }
    }

    fn texts(svg: &str) -> Vec<String> {
        let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
        document.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).map(str::to_string).collect()
    }

    #[test]
    fn labels_names_and_axes_are_text() {
        for log in [false, true] {
            let texts = texts(&chart(log, &[(0.01, 1e-5, "fast"), (2.0, 1e-9, "<slow>")]).svg());
            for text in
                ["Error <against> run time", "run time (s)", "error & more", "a \"b\"", "fast", "<slow>"]
            {
                assert!(texts.iter().any(|t| t == text), "{text} in {texts:?}");
            }
        }
    }

    #[test]
    fn points_that_cannot_be_shown_are_counted() {
        let points =
            [(1.0, 1.0, ""), (0.0, 1.0, ""), (1.0, -1.0, ""), (f64::NAN, 1.0, ""), (1.0, f64::INFINITY, "")];
        let note = |n| format!("Points that the axes cannot show: {n}.");
        assert!(texts(&chart(true, &points).svg()).contains(&note(4)));
        assert!(texts(&chart(false, &points).svg()).contains(&note(2)));
    }

    #[test]
    fn empty_single_and_extreme_charts_are_valid() {
        let sets: [&[(f64, f64, &str)]; 5] = [
            &[],
            &[(3.0, 3.0, "one")],
            &[(1e-300, 1e300, ""), (1e300, 1e-300, "")],
            &[(f64::MAX, f64::MIN, ""), (f64::MIN, f64::MAX, "")],
            &[(5e-324, 5e-324, "least")],
        ];
        for points in sets {
            for log in [false, true] {
                let svg = chart(log, points).svg();
                texts(&svg);
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            }
        }
        texts(&Chart::default().svg());
    }

    #[test]
    fn what_hardly_differs_is_drawn_so_and_its_ticks_keep_off_the_label() {
        let points: Vec<(f64, f64, &str)> =
            (0..3).map(|i| (f64::from(i), -93.1 - 0.001 * f64::from(i), "")).collect();
        let mut chart = chart(false, &points);
        chart.y.least = 10.0;
        let axis = scale(&chart.y, points.iter().map(|p| p.1), [400.0, 100.0]);
        assert!((axis.at(-93.1) - axis.at(-93.102)).abs() < 1.0, "2 mB are no difference");
        for least in [0.0, 10.0] {
            chart.y.least = least;
            let svg = chart.svg();
            let document = roxmltree::Document::parse(&svg).unwrap();
            let ticks: Vec<(f64, &str)> = document
                .descendants()
                .filter(|n| n.attribute("text-anchor") == Some("end") && n.attribute("x").is_some())
                .filter_map(|n| Some((n.attribute("x")?.parse().ok()?, n.text()?)))
                .collect();
            assert!(ticks.len() > 2);
            for (right, text) in ticks {
                assert!(right - 11.0 * super::width(text) > super::TITLE + 4.0, "{text} at {right}");
            }
        }
    }

    #[test]
    fn notes_stand_below_the_chart() {
        let mut chart = chart(true, &[(1.0, 1.0, ""), (0.0, 1.0, "")]);
        chart.notes = vec!["the limiter acted".into()];
        let svg = chart.svg();
        assert!(svg.contains("height=\"522\"") && svg.contains("the limiter acted"), "{svg}");
        assert!(svg.contains("Points that the axes cannot show: 1."));
    }

    #[test]
    fn an_axis_holds_every_value() {
        for values in [vec![1.0, 2.5, 7.3], vec![-4.0, 1e6], vec![0.2], vec![3e-4, 0.9]] {
            for log in [false, true] {
                if log && values[0] <= 0.0 {
                    continue;
                }
                let axis = Axis { label: String::new(), log, least: 0.0 };
                let scale = scale(&axis, values.iter().copied(), [100.0, 700.0]);
                assert!(values.iter().all(|v| (99.99..=700.01).contains(&scale.at(*v))), "{values:?}");
            }
        }
    }
}
