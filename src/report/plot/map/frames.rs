//! A map for each of many instants, side by side.

use super::super::axis::short;
use super::super::colour::Ink;
use super::super::picture::{MARGIN, Style, wide};
use super::super::svg::{Anchor, Svg, Type};
use super::view::Views;
use super::{Map, page};

/// Room below each frame for its time, and between frames.
const LABEL: f64 = 18.0;
const GAP: f64 = 14.0;
/// Height of a frame that is as wide as high.
const TALL: f64 = 112.0;

impl Map {
    /// The picture: so many maps, 1 to 400, each of what was in its time, row by row as one reads.
    pub fn frames(&self, style: &Style, count: usize) -> String {
        let count = count.clamp(1, 400);
        let (views, width) = (Views::new(&self.sites), wide(style));
        let (strengths, most) = self.strengths(count);
        let inner = width - 2.0 * MARGIN;
        let each = self.seconds() / count as f64;
        let named = format!(
            "{} frames of {} ms, {} to the right, {} up",
            count,
            short(1e3 * each),
            views.axes[0],
            views.axes[1]
        );
        let head = self.head(style, &named, most);
        let scale = Scale::fit(&views, inner);
        let columns = (((inner + GAP) / (scale.width + GAP)) as usize).clamp(1, count);
        let top = 112.0;
        let row = scale.height + LABEL + GAP + scale.labels;
        let height = top + row * count.div_ceil(columns) as f64 + 10.0;

        let mut svg = page(style, [width, height], &head);
        for (k, strengths) in strengths.iter().enumerate() {
            let left = MARGIN + (k % columns) as f64 * (scale.width + GAP);
            let upper = top + (k / columns) as f64 * row;
            scale.backs(&mut svg, &views, [left, upper]);
            for (n, at) in scale.places(&views, [left, upper]) {
                let share =
                    strengths.get(n).map_or(0.0, |strength| if most > 0.0 { strength / most } else { 0.0 });
                svg.disc(at, scale.radius, Ink::Axis, 0.35, "");
                if share >= 0.01 {
                    svg.disc(at, scale.radius * (0.35 + 0.65 * share), Ink::Heat, share, "");
                }
            }
            let time = Type::new(11.0, Anchor::Start, Ink::Dim);
            svg.text(
                left,
                upper + scale.labels + scale.height + 13.0,
                time,
                &format!("{} s", short(k as f64 * each)),
            );
        }
        svg.finish(width, height, &style.title, &head.join(". "))
    }
}

/// How a map lies on paper.
pub(super) struct Scale {
    /// Pixels a metre.
    pixels: f64,
    /// Of a disc.
    pub radius: f64,
    /// Of a view.
    view: [f64; 2],
    /// Of all views of a frame, and below their labels.
    pub width: f64,
    pub height: f64,
    /// Room above for labels.
    pub labels: f64,
}

impl Scale {
    /// Small frames, several of which fit side by side.
    fn fit(views: &Views, inner: f64) -> Self {
        let [wide, high] = views.size.map(|metres| metres.max(views.spacing).max(1e-3));
        let count = views.list.len() as f64;
        // Of one area, whatever their shape, and none wider than the page.
        let side = TALL * (wide / high).sqrt().clamp(0.35, 4.0);
        let width = side.min((inner - GAP * count) / count).max(20.0);
        Self::of(views, [width, (width * high / wide).clamp(12.0, 3.0 * TALL)])
    }

    /// Views of up to so many pixels each.
    pub fn of(views: &Views, [width, height]: [f64; 2]) -> Self {
        let across = views.size.map(|metres| metres + if views.spacing > 0.0 { views.spacing } else { 0.01 });
        let pixels = (width / across[0]).min(height / across[1]);
        let spacing = if views.spacing > 0.0 { views.spacing } else { 0.01 };
        let radius = (0.42 * spacing * pixels).clamp(1.5, 0.5 * width.min(height).max(3.0));
        let view = across.map(|metres| metres * pixels);
        let count = views.list.len() as f64;
        let labels = if views.list.len() > 1 { 14.0 } else { 0.0 };
        Self { pixels, radius, view, width: view[0] * count + 8.0 * (count - 1.0), height: view[1], labels }
    }

    fn corner(&self, view: usize, [left, upper]: [f64; 2]) -> [f64; 2] {
        [left + view as f64 * (self.view[0] + 8.0), upper + self.labels]
    }

    /// What lies behind the tactors: a field for each view.
    pub fn backs(&self, svg: &mut Svg, views: &Views, at: [f64; 2]) {
        for (n, view) in views.list.iter().enumerate() {
            let [left, upper] = self.corner(n, at);
            svg.rect([left, upper, self.view[0], self.view[1]], Ink::Shade);
            if !view.label.is_empty() {
                svg.text_within(
                    left,
                    upper - 3.0,
                    Type::new(10.0, Anchor::Start, Ink::Dim),
                    view.label,
                    self.view[0],
                );
            }
        }
    }

    /// Each tactor's number, and where its disc is.
    pub fn places(&self, views: &Views, at: [f64; 2]) -> Vec<(usize, [f64; 2])> {
        let margin = 0.5 * if views.spacing > 0.0 { views.spacing } else { 0.01 };
        let mut places = Vec::new();
        for (k, view) in views.list.iter().enumerate() {
            let [left, upper] = self.corner(k, at);
            places.extend(view.tactors.iter().map(|(n, [right, up])| {
                let x = left + (right + margin) * self.pixels;
                (*n, [x, upper + self.view[1] - (up + margin) * self.pixels])
            }));
        }
        places
    }
}
