//! Curves over time, a panel for each quantity, what belongs to one time beside what belongs to another.

use super::axis::{Scale, nice};
use super::colour::Ink;
use super::path::Path;
use super::svg::{Anchor, Svg, Type, width};

/// Panels below and beside each other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Strips {
    /// The first line, large.
    pub title: String,
    /// The second line.
    pub subtitle: String,
    /// From left to right.
    pub columns: Vec<Column>,
}

/// Panels over one stretch of time, from 0 on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Column {
    /// What stands above.
    pub heading: String,
    /// How long it is, s.
    pub seconds: f64,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

/// One quantity.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// What it shows, with its unit: "speed (rad/s)".
    pub label: String,
    /// Its curves. Those of one name have one colour in all panels.
    pub curves: Vec<Curve>,
}

/// A curve.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// What the key says of it.
    pub name: String,
    /// Values a second, above 0.
    pub rate: f64,
    /// What it is at the end of each step; what is not finite is passed over.
    pub values: Vec<f64>,
    /// Whether it is what is wanted rather than what is done: then it is broad and grey, and lies below the others.
    pub wanted: bool,
}

const WIDTH: f64 = 1100.0;
const MARGIN: f64 = 28.0;
/// Height of a panel, and what lies between two.
const PANEL: f64 = 170.0;
const GAP: f64 = 22.0;
/// Between two columns, with the labels of the right one.
const BESIDE: f64 = 76.0;
const TOP: f64 = 132.0;
/// Dashes of curves, so that they are told apart without colour.
const DASHES: [&str; 6] = ["", "7 3", "2 2.5", "10 3 2 3", "4 2", "14 4"];
/// Changes of direction within a few pixels, and steps for each of those, from which on a curve is drawn as the band that it fills,
/// and its mean.
const BUSY: usize = 4;
const DENSE: usize = 2;
/// What is said of that.
const BAND: &str = "; shaded: back and forth too fast for a line, which is its mean";
/// Pixels to each side that are a few.
const FEW: usize = 2;

/// What a curve does within a pixel.
#[derive(Debug, Clone, Copy)]
struct Bin {
    x: f64,
    /// In the order in which they come.
    ends: [f64; 2],
    mean: f64,
    busy: bool,
}

impl Strips {
    /// The picture as SVG, 1,100 pixels wide, in dark mode where the reader prefers that.
    pub fn svg(&self) -> String {
        let names = self.names();
        let rows = self.columns.iter().map(|column| column.panels.len()).max().unwrap_or(0);
        let height = TOP + rows as f64 * (PANEL + GAP) + 34.0;
        let mut svg = Svg::new(true);
        svg.rect([0.0, 0.0, WIDTH, height], Ink::Page);
        let inner = WIDTH - 2.0 * MARGIN;
        let title = Type { bold: true, ..Type::new(19.0, Anchor::Start, Ink::Text) };
        svg.text_within(MARGIN, 38.0, title, &self.title, inner);
        self.key(&mut svg, &names);
        let left = MARGIN + 58.0;
        let all = WIDTH - MARGIN - left - BESIDE * self.columns.len().saturating_sub(1) as f64;
        let (mut from, mut has_bands) = (left, false);
        for (n, column) in self.columns.iter().enumerate() {
            // The first is what is looked at first.
            let share = match self.columns.len() {
                2 => [0.6, 0.4][n],
                many => 1.0 / many as f64,
            };
            let to = from + all * share;
            has_bands |= column.draw(&mut svg, [from, to], &names);
            from = to + BESIDE;
        }
        let subtitle = if has_bands { format!("{}{BAND}", self.subtitle) } else { self.subtitle.clone() };
        svg.text_within(MARGIN, 59.0, Type::new(12.5, Anchor::Start, Ink::Dim), &subtitle, inner);
        svg.finish(WIDTH, height, &self.title, &subtitle)
    }

    /// Of all that is done, in the order in which they come first.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for curve in self.columns.iter().flat_map(|c| &c.panels).flat_map(|p| &p.curves) {
            if !curve.wanted && !names.contains(&curve.name.as_str()) {
                names.push(&curve.name);
            }
        }
        names
    }

    fn key(&self, svg: &mut Svg, names: &[&str]) {
        let curves = || self.columns.iter().flat_map(|c| &c.panels).flat_map(|p| &p.curves);
        let wanted = curves().find(|curve| curve.wanted).map(|curve| curve.name.as_str());
        let mut x = MARGIN;
        let mut entry = |svg: &mut Svg, name: &str, index: Option<usize>| {
            let mut path = Path::default();
            path.to(x, 84.0);
            path.to(x + 26.0, 84.0);
            match index {
                Some(index) => svg.dashed(&path, ink(index), 2.0, dash(index)),
                None => svg.stroke(&path, Ink::Axis, WANTED),
            }
            svg.text(x + 33.0, 88.0, Type::new(12.0, Anchor::Start, Ink::Text), name);
            x += 62.0 + 12.0 * width(name);
        };
        if let Some(name) = wanted {
            entry(svg, name, None);
        }
        for (index, name) in names.iter().enumerate() {
            entry(svg, name, Some(index));
        }
    }
}

/// How broad what is wanted is.
const WANTED: f64 = 5.0;

fn ink(index: usize) -> Ink {
    Ink::Kind { index }
}

fn dash(index: usize) -> &'static str {
    DASHES[index % DASHES.len()]
}

impl Column {
    /// Whether any of it is a band.
    fn draw(&self, svg: &mut Svg, [left, right]: [f64; 2], names: &[&str]) -> bool {
        let mut has_bands = false;
        let dim = |anchor| Type::new(11.0, anchor, Ink::Dim);
        let heading = Type { bold: true, ..Type::new(13.0, Anchor::Start, Ink::Text) };
        svg.text_within(left, TOP - 14.0, heading, &self.heading, right - left);
        let seconds = if self.seconds > 0.0 { self.seconds } else { 1.0 };
        let time = Scale::linear([0.0, 1e3 * seconds], left, right);
        for (row, panel) in self.panels.iter().enumerate() {
            let top = TOP + row as f64 * (PANEL + GAP);
            let bottom = top + PANEL;
            let y = panel.scale(seconds, [bottom, top]);
            let last = row + 1 == self.panels.len();
            for (at, label) in time.ticks(((right - left) / 70.0) as usize) {
                let x = time.at(at);
                svg.line([x, top, x, bottom], Ink::Grid, 0.8, 0.0);
                if last {
                    svg.text(x, bottom + 16.0, dim(Anchor::Middle), &label);
                }
            }
            for (at, label) in y.ticks(5) {
                let at = y.at(at);
                svg.line([left, at, right, at], Ink::Grid, 0.8, 0.0);
                svg.text(left - 7.0, at + 4.0, dim(Anchor::End), &label);
            }
            svg.line([left, y.at(0.0), right, y.at(0.0)], Ink::Axis, 1.0, 0.0);
            let label = Type::new(11.5, Anchor::Middle, Ink::Text);
            svg.text_up(left - 46.0, 0.5 * (top + bottom), label, &panel.label);
            for curve in panel.curves.iter().filter(|curve| curve.wanted) {
                has_bands |= curve.draw(svg, &time, &y, (Ink::Axis, "", WANTED), [left, right]);
            }
            for curve in panel.curves.iter().filter(|curve| !curve.wanted) {
                let index = names.iter().position(|name| *name == curve.name).unwrap_or(0);
                let set = (ink(index), dash(index), 1.6);
                has_bands |= curve.draw(svg, &time, &y, set, [left, right]);
            }
            if last {
                let at = 0.5 * (left + right);
                svg.text(at, bottom + 33.0, dim(Anchor::Middle), "Time (ms)");
            }
        }
        has_bands
    }
}

impl Panel {
    /// From values to pixels: all that is shown, and 0.
    fn scale(&self, seconds: f64, [bottom, top]: [f64; 2]) -> Scale {
        let shown = |curve: &Curve| (seconds * curve.rate).ceil().clamp(0.0, 1e9) as usize;
        let values = self.curves.iter().flat_map(|c| c.values.iter().take(shown(c))).copied();
        let [least, most] = values
            .filter(|v| v.is_finite())
            .fold([0.0_f64, 0.0_f64], |[least, most], v| [least.min(v), most.max(v)]);
        let spread = if most > least { most - least } else { 1.0 };
        let (step, room) = (nice(spread / 10.0), 0.04 * spread);
        let down = |v: f64| (v / step).floor() * step;
        let to = -down(-(most + room));
        Scale::linear([if least < 0.0 { down(least - room) } else { 0.0 }, to], bottom, top)
    }
}

impl Curve {
    /// Whether any of it is a band.
    fn draw(
        &self,
        svg: &mut Svg,
        time: &Scale,
        y: &Scale,
        (ink, dash, broad): (Ink, &str, f64),
        [left, right]: [f64; 2],
    ) -> bool {
        let bins = self.bins(time, [left, right]);
        // What is too fast for a line is a band, and its mean.
        for run in bins.chunk_by(|a, b| a.busy && b.busy).filter(|run| run[0].busy) {
            let mut band = Path::default();
            run.iter().for_each(|bin| band.to(bin.x, y.at(bin.ends[0].max(bin.ends[1]))));
            run.iter().rev().for_each(|bin| band.to(bin.x, y.at(bin.ends[0].min(bin.ends[1]))));
            svg.area(&band, ink, 0.16, 0.0);
        }
        let mut path = Path::default();
        for bin in &bins {
            if bin.busy {
                path.to(bin.x, y.at(bin.mean));
            } else {
                bin.ends.iter().for_each(|value| path.to(bin.x, y.at(*value)));
            }
        }
        svg.dashed(&path, ink, broad, dash);
        bins.iter().any(|bin| bin.busy)
    }

    /// What it does in each pixel, or at each step where those are farther apart.
    fn bins(&self, time: &Scale, [left, right]: [f64; 2]) -> Vec<Bin> {
        // At a rate that is none, all of it lies beyond the right end.
        let x = |n: usize| time.at(1e3 * (n + 1) as f64 / self.rate);
        let values = self.values.iter().copied().enumerate().filter(|(_, v)| v.is_finite());
        let shown: Vec<(f64, f64)> =
            values.map(|(n, v)| (x(n), v)).take_while(|(x, _)| *x <= right + 0.5).collect();
        // Where it stays as it is, it keeps its direction.
        let (mut rises, mut turns) = (None, vec![false; shown.len()]);
        for n in 1..shown.len() {
            let step = shown[n].1 - shown[n - 1].1;
            if step != 0.0 {
                turns[n] = rises.replace(step > 0.0).is_some_and(|before| before != (step > 0.0));
            }
        }
        let pixel = |x: f64| (x - left).floor();
        let runs: Vec<&[(f64, f64)]> = shown.chunk_by(|a, b| pixel(a.0) == pixel(b.0)).collect();
        let begins: Vec<usize> =
            runs.iter().scan(0, |at, run| Some(std::mem::replace(at, *at + run.len()))).collect();
        let bin = |(n, run): (usize, &&[(f64, f64)])| {
            let extreme =
                |better: fn(f64, f64) -> bool| {
                    run.iter().enumerate().fold((0, run[0].1), |best, (n, (_, v))| {
                        if better(*v, best.1) { (n, *v) } else { best }
                    })
                };
            let (low, high) = (extreme(|a, b| a < b), extreme(|a, b| a > b));
            let last = (n + FEW).min(runs.len() - 1);
            let few = begins[n.saturating_sub(FEW)]..begins[last] + runs[last].len();
            let pixels = last - n.saturating_sub(FEW) + 1;
            let turned = turns[few.clone()].iter().filter(|turn| **turn).count();
            let busy = turned >= BUSY && few.len() >= DENSE * pixels;
            let meant = if busy { &shown[few] } else { run };
            Bin {
                x: run.iter().map(|(x, _)| x).sum::<f64>() / run.len() as f64,
                ends: if low.0 < high.0 { [low.1, high.1] } else { [high.1, low.1] },
                mean: meant.iter().map(|(_, v)| v).sum::<f64>() / meant.len() as f64,
                busy,
            }
        };
        runs.iter().enumerate().map(bin).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Column, Curve, Panel, Scale, Strips};

    fn curve(name: &str, values: Vec<f64>) -> Curve {
        Curve { name: name.into(), rate: 1000.0, values, wanted: false }
    }

    fn strips(curves: Vec<Curve>, seconds: f64) -> Strips {
        let panel = |label: &str| Panel { label: label.into(), curves: curves.clone() };
        let panels = vec![panel("volts (V)"), panel("speed (rad/s)")];
        let column = Column { heading: "A <burst>".into(), seconds, panels };
        Strips { title: "T & T".into(), subtitle: "s".into(), columns: vec![column.clone(), column] }
    }

    /// Well-formed, with every name in the key once, headings for each column and labels for each panel.
    #[test]
    fn a_picture_says_what_it_shows() {
        let rise: Vec<f64> = (0..100).map(f64::from).collect();
        let wanted = Curve { wanted: true, ..curve("wanted", vec![50.0; 100]) };
        let svg = strips(vec![wanted, curve("plain", rise.clone()), curve("click", rise)], 0.1).svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<&str> =
            document.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).collect();
        for (text, times) in [
            ("plain", 1),
            ("click", 1),
            ("wanted", 1),
            ("A <burst>", 2),
            ("speed (rad/s)", 2),
            ("Time (ms)", 2),
        ] {
            assert_eq!(texts.iter().filter(|t| **t == text).count(), times, "{text}: {texts:?}");
        }
        // Three entries of the key, and a line for each curve of each panel.
        let lines = document.descendants().filter(|n| n.attribute("fill") == Some("none")).count();
        assert_eq!(lines, 3 + 3 * 4);
        assert!(!svg.contains("shaded"));
        // What is too fast for a line is said to be drawn otherwise.
        let chatter = Curve { rate: 48_000.0, ..curve("a", (0..4800).map(|n| f64::from(n % 2)).collect()) };
        assert!(strips(vec![chatter], 0.1).svg().contains("s; shaded: back and forth"));
    }

    #[test]
    fn nothing_and_nonsense_are_still_a_picture() {
        for curves in [
            vec![],
            vec![curve("a", vec![])],
            vec![curve("a", vec![f64::NAN, f64::INFINITY, 1.0])],
            vec![Curve { rate: 0.0, ..curve("a", vec![1.0; 9]) }],
            vec![Curve { rate: f64::NAN, ..curve("a", vec![1.0; 9]) }],
            vec![curve("a", vec![1e300, -1e300])],
        ] {
            for seconds in [0.1, 0.0, f64::NAN] {
                let svg = strips(curves.clone(), seconds).svg();
                roxmltree::Document::parse(&svg).unwrap();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{curves:?} {seconds}");
            }
        }
        roxmltree::Document::parse(&Strips::default().svg()).unwrap();
    }

    /// No value between two pixels is lost: a single step away from the others is still there, and what chatters has its mean.
    #[test]
    fn a_pixel_keeps_the_extremes_of_what_it_holds() {
        let time = Scale::linear([0.0, 100.0], 0.0, 10.0);
        let mut values = vec![1.0; 100];
        values[37] = 9.0;
        let bins = curve("a", values).bins(&time, [0.0, 10.0]);
        assert_eq!(bins.iter().filter(|bin| bin.ends.contains(&9.0) && !bin.busy).count(), 1);
        // One way for two steps, the other for one: the mean is a third of the most.
        let chatter = (0..100).map(|n| if n % 3 == 0 { -3.0 } else { 3.0 }).collect();
        let bins = curve("a", chatter).bins(&time, [0.0, 10.0]);
        assert!(bins[3].busy && (bins[3].mean - 1.0).abs() < 0.15, "{bins:?}");
        assert_eq!([bins[3].ends[0].min(bins[3].ends[1]), bins[3].ends[0].max(bins[3].ends[1])], [-3.0, 3.0]);
    }
}
