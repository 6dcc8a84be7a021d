//! The picture of a rendering: a row for each tactor over time, and the spectrum below.

use super::axis::{Scale, nice, short};
use super::collector::{Collector, ROWS};
use super::colour::Ink;
use super::panel;
use super::svg::{Anchor, Svg, Type, width};
use super::wave::{self, Place};

/// What a picture says above, and how it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// The first line, large.
    pub title: String,
    /// The second line, such as the patch and the rig; channels, rate and length follow it by themselves.
    pub subtitle: String,
    /// Width in pixels, 500 to 4,000; the height follows from the rows.
    pub width: f64,
    /// Whether the picture turns light on dark where the reader's system prefers that.
    pub dark: bool,
}

impl Style {
    /// A picture 1,200 pixels wide that follows the reader's preference.
    pub fn new(title: &str) -> Self {
        Self { title: title.into(), subtitle: String::new(), width: 1200.0, dark: true }
    }
}

pub(super) const MARGIN: f64 = 28.0;
/// Height of the spectrum.
const PANEL: f64 = 210.0;
/// Room at the right of the rows, for the peaks.
const PEAKS: f64 = 52.0;

/// Below this width, what stands side by side stands one below the other.
const NARROW: f64 = 700.0;
/// Height of a row of a channel that is silent throughout, where there are others.
const SILENT: f64 = 14.0;

/// Where things lie.
struct Layout {
    width: f64,
    left: f64,
    right: f64,
    /// The first row's upper edge.
    top: f64,
    /// Middle and height of each row.
    rows: Vec<[f64; 2]>,
    /// The last row's lower edge.
    bottom: f64,
    narrow: bool,
}

impl Collector {
    /// The picture of what has come so far.
    pub fn svg(&self, style: &Style) -> String {
        let layout = self.layout(style);
        let mut svg = Svg::new(style.dark);
        let panel_top = layout.bottom + if layout.narrow { 104.0 + panel::LINES } else { 104.0 };
        let height = if self.rows.is_empty() { layout.top + 40.0 } else { panel_top + PANEL + 54.0 };
        svg.rect([0.0, 0.0, layout.width, height], Ink::Page);
        let inner = layout.width - 2.0 * MARGIN;
        let title = Type { bold: true, ..Type::new(21.0, Anchor::Start, Ink::Text) };
        svg.text_within(MARGIN, 40.0, title, &style.title, inner);
        let subtitle = self.subtitle(style);
        let mut below = 62.0;
        for line in self.head(style) {
            svg.text_within(MARGIN, below, Type::new(13.0, Anchor::Start, Ink::Dim), &line, inner);
            below += 18.0;
        }
        for (i, note) in self.notes().iter().enumerate() {
            let set = Type::new(12.0, Anchor::Start, Ink::Limit);
            svg.text_within(MARGIN, below + 2.0 + 17.0 * i as f64, set, note, inner);
        }
        if self.rows.is_empty() {
            svg.text(MARGIN, layout.top, Type::new(13.0, Anchor::Start, Ink::Dim), "There are no channels.");
        } else {
            self.draw_rows(&mut svg, &layout);
            let sounding = self.sounding();
            let frame = [layout.left, panel_top, layout.right, panel_top + PANEL];
            panel::draw(&mut svg, &self.spectrum(), frame, sounding, layout.narrow);
        }
        svg.finish(layout.width, height, &style.title, &subtitle)
    }

    fn layout(&self, style: &Style) -> Layout {
        let wide = wide(style);
        let names = self.names.iter().take(ROWS).map(|n| width(n)).fold(0.0, f64::max);
        let left = MARGIN + (names * self.name_size() + 14.0).clamp(52.0, 0.2 * wide);
        let top = 94.0 + 18.0 * self.head(style).len() as f64 + 17.0 * self.notes().len() as f64;
        let (all, sounding) = (self.rows.len(), self.sounding());
        let silent = if sounding == 0 {
            (640.0 / all.max(1) as f64).clamp(11.0, 40.0).floor()
        } else {
            SILENT.min(640.0 / all as f64).max(11.0).floor()
        };
        let left_over = 640.0 - silent * (all - sounding) as f64;
        let row = (left_over / sounding.max(1) as f64).clamp(11.0, 150.0).floor();
        let mut bottom = top;
        let rows = self.peaks.iter().take(all).map(|peak| {
            let height = if *peak > 0.0 { row } else { silent };
            bottom += height;
            [bottom - 0.5 * height, height]
        });
        let rows: Vec<[f64; 2]> = rows.collect();
        Layout { width: wide, left, right: wide - MARGIN - PEAKS, top, rows, bottom, narrow: wide < NARROW }
    }

    /// The lines below the title.
    fn head(&self, style: &Style) -> Vec<String> {
        if wide(style) < NARROW && !style.subtitle.is_empty() {
            let own = Style { subtitle: String::new(), ..style.clone() };
            return vec![style.subtitle.clone(), self.subtitle(&own)];
        }
        vec![self.subtitle(style)]
    }

    fn name_size(&self) -> f64 {
        match self.rows.len() {
            0..=24 => 12.5,
            25..=40 => 11.0,
            _ => 9.5,
        }
    }

    fn subtitle(&self, style: &Style) -> String {
        let channels = match self.names.len() {
            1 => "1 channel".to_string(),
            n => format!("{n} channels"),
        };
        let rate = format!("{} kHz", short(self.rate / 1000.0));
        let mut parts = vec![channels, rate, format!("{} s", short(self.seconds()))];
        if !style.subtitle.is_empty() {
            parts.insert(0, style.subtitle.clone());
        }
        parts.join("  ·  ")
    }

    /// What must be said because the picture does not show it.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.names.len() > ROWS {
            let beyond = self.peaks.get(ROWS..).unwrap_or_default();
            let sounding = beyond.iter().filter(|p| **p > 0.0).count();
            let peak = beyond.iter().copied().fold(0.0, f32::max);
            let rest = match sounding {
                0 => "the others are silent".to_string(),
                n => format!("of the others {n} sound, with peaks up to {}", short(f64::from(peak))),
            };
            notes.push(format!("Shown: the first {ROWS} of {} channels; {rest}.", self.names.len()));
        }
        if self.unsound > 0 {
            notes.push(format!("Samples that are not finite numbers, drawn as 0: {}.", self.unsound));
        }
        if self.frames == 0 && !self.names.is_empty() {
            notes.push("There are no samples.".to_string());
        }
        notes
    }

    fn draw_rows(&self, svg: &mut Svg, at: &Layout) {
        let dim = |anchor| Type::new(11.0, anchor, Ink::Dim);
        let loudest = self.peaks.iter().take(ROWS).copied().fold(0.0, f32::max);
        let full = if loudest > 0.0 { amplitude(f64::from(loudest)) } else { 1.0 };
        let time = Scale::linear([0.0, self.seconds()], at.left, at.right);

        let heading = Type { bold: true, ..Type::new(13.0, Anchor::Start, Ink::Text) };
        svg.text(at.left, at.top - 12.0, heading, if self.names.len() == 1 { "Tactor" } else { "Tactors" });
        let scale = format!("each row ±{}, 1 = full scale", short(full));
        svg.text(at.right, at.top - 12.0, dim(Anchor::End), &scale);
        svg.text(at.width - MARGIN, at.top - 12.0, dim(Anchor::End), "peak");

        for (seconds, label) in time.ticks(10) {
            let x = time.at(seconds);
            svg.line([x, at.top, x, at.bottom], Ink::Grid, 0.8, 0.0);
            svg.line([x, at.bottom, x, at.bottom + 4.0], Ink::Axis, 1.0, 0.0);
            svg.text(x, at.bottom + 17.0, dim(Anchor::Middle), &label);
        }
        svg.text((at.left + at.right) / 2.0, at.bottom + 35.0, dim(Anchor::Middle), "Time (s)");

        for (index, name) in self.names.iter().take(ROWS).enumerate() {
            let Some([middle, height]) = at.rows.get(index).copied() else { continue };
            let peak = self.peaks.get(index).copied().unwrap_or(0.0);
            let size = self.name_size().min(height - 2.0);
            let below = middle + 0.36 * size;
            let ink = if peak > 0.0 { Ink::Text } else { Ink::Dim };
            svg.text_within(
                at.left - 12.0,
                below,
                Type::new(size, Anchor::End, ink),
                name,
                at.left - MARGIN - 12.0,
            );
            svg.line(
                [at.left, middle, at.right, middle],
                if peak > 0.0 { Ink::Grid } else { Ink::Axis },
                0.8,
                0.0,
            );
            let said = if peak > 0.0 { level(f64::from(peak)) } else { "silent".into() };
            svg.text(at.width - MARGIN, below, Type::new(size.min(11.0), Anchor::End, Ink::Dim), &said);
            if peak > 0.0 {
                let ink = Ink::Row { index, of: self.rows.len() };
                if let Some(row) = self.rows.get(index) {
                    // The more rows, the fewer columns, for the file's sake.
                    let pixels = (at.right - at.left) * (24.0 / self.rows.len() as f64).clamp(0.4, 1.0);
                    let place = Place { time: &time, rate: self.rate, middle, unit: 0.46 * height / full };
                    wave::draw(svg, row, &place, ink, pixels);
                }
            }
        }
        svg.line([at.left, at.bottom, at.right, at.bottom], Ink::Axis, 1.0, 0.0);
    }
}

/// The width of a picture in pixels.
pub(super) fn wide(style: &Style) -> f64 {
    if style.width.is_finite() { style.width.clamp(500.0, 4000.0).round() } else { 1200.0 }
}

/// The amplitude at the edge of a row: a little above the greatest, and round.
fn amplitude(peak: f64) -> f64 {
    // A peak of 1.0 is the most that is put out, and 0.5 and the like are common; they should fill the row.
    let step = nice(peak / 5.0) / 2.0;
    (peak / step - 1e-6).ceil() * step
}

/// A peak, so that a column of them is easy to read.
fn level(peak: f64) -> String {
    if (0.0005..1000.0).contains(&peak) { format!("{peak:.3}") } else { short(peak) }
}

#[cfg(test)]
mod tests {
    use super::{Collector, Style, amplitude};
    use std::f64::consts::TAU;

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("tactor {i}")).collect()
    }

    /// All texts of a picture, which must be well-formed.
    fn texts(svg: &str) -> Vec<String> {
        let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
        document.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).map(str::to_string).collect()
    }

    #[test]
    fn hostile_names_come_through_as_text() {
        let names: Vec<String> =
            ["<b>&\"'", "]]>", "a\0b\u{1b}", "", "日本語", "\u{202e}up", "👆🏽", "&amp;", "one\ntwo"]
                .map(String::from)
                .into();
        let mut collector = Collector::new(&names, 8000.0, None);
        collector.push(&[0.5; 9]);
        for dark in [true, false] {
            let style = Style { dark, title: "<T>".into(), subtitle: "-->&".into(), ..Style::new("") };
            let texts = texts(&collector.svg(&style));
            for name in [
                "<b>&\"'",
                "]]>",
                "a\u{fffd}b\u{fffd}",
                "日本語",
                "\u{202e}up",
                "👆🏽",
                "&amp;",
                "one two",
                "<T>",
            ] {
                assert!(texts.iter().any(|t| t == name), "{name:?} in {texts:?}");
            }
        }
    }

    #[test]
    fn a_long_name_is_cut_and_kept_as_the_tip() {
        let name = "left hand ".repeat(20);
        let mut collector = Collector::new(std::slice::from_ref(&name), 8000.0, None);
        collector.push(&[0.5; 9]);
        let texts = texts(&collector.svg(&Style::new("")));
        assert!(
            texts.contains(&name) && texts.iter().any(|t| t.starts_with("left hand") && t.ends_with('…'))
        );
    }

    #[test]
    fn nothing_at_all_is_still_a_picture() {
        for (channels, rate, samples) in [
            (0, 48e3, vec![]),
            (0, 48e3, vec![1.0; 5]),
            (1, 48e3, vec![]),
            (1, 48e3, vec![1.0]),
            (3, 8e3, vec![1.0; 2]),
            (2, f64::NAN, vec![0.5; 9]),
            (2, 0.0, vec![0.5; 9]),
            (1, 1e-9, vec![0.5; 9]),
            (1, 1e300, vec![0.5; 9]),
            (1, 30.0, vec![0.5; 9]),
            (1, 48e3, vec![f32::MAX, f32::MIN]),
            (1, 48e3, vec![f32::from_bits(1)]),
            (4096, 48e3, vec![0.5; 4096]),
        ] {
            for expected in [None, Some(f64::NAN), Some(1e300), Some(-1.0)] {
                let mut collector = Collector::new(&names(channels), rate, expected);
                collector.push(&samples);
                let svg = collector.svg(&Style { width: f64::NAN, ..Style::new("") });
                texts(&svg);
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            }
        }
    }

    #[test]
    fn samples_that_are_no_numbers_are_counted_and_spoil_nothing() {
        let mut clean: Vec<f32> = (0..8000).map(|n| (n as f32 * 0.3).sin()).collect();
        let mut dirty = clean.clone();
        for (at, bad) in [(5, f32::NAN), (500, f32::INFINITY), (7000, f32::NEG_INFINITY)] {
            (clean[at], dirty[at]) = (0.0, bad);
        }
        let [clean, dirty] = [clean, dirty].map(|samples| {
            let mut collector = Collector::new(&names(1), 8000.0, None);
            collector.push(&samples);
            collector
        });
        assert_eq!(clean.spectrum(), dirty.spectrum());
        let texts = texts(&dirty.svg(&Style::new("")));
        assert!(
            texts.contains(&"Samples that are not finite numbers, drawn as 0: 3.".to_string()),
            "{texts:?}"
        );
    }

    #[test]
    fn silence_is_named_and_channels_beyond_the_rows_are_counted() {
        let mut collector = Collector::new(&names(1024), 8000.0, None);
        let mut frame = vec![0.0; 1024];
        (frame[3], frame[100], frame[1023]) = (1.0, 0.25, -0.5);
        collector.push(&frame);
        let texts = texts(&collector.svg(&Style::new("")));
        assert_eq!(texts.iter().filter(|t| *t == "silent").count(), 63);
        let note = "Shown: the first 64 of 1024 channels; of the others 2 sound, with peaks up to 0.5.";
        assert!(texts.iter().any(|t| t == note), "{texts:?}");
    }

    /// Texts with their boxes, as far as a guess of their width goes: left, top, right, bottom.
    fn boxes(svg: &str) -> Vec<(String, [f64; 4])> {
        let document = roxmltree::Document::parse(svg).unwrap();
        let number = |n: &roxmltree::Node, key: &str| n.attribute(key).and_then(|v| v.parse::<f64>().ok());
        let boxed = |n: roxmltree::Node| {
            let (x, y, size) = (number(&n, "x")?, number(&n, "y")?, number(&n, "font-size")?);
            let text = n.children().filter(|c| c.is_text()).filter_map(|c| c.text()).collect::<String>();
            let wide = 0.9 * size * super::width(&text);
            let left = match n.attribute("text-anchor") {
                Some("middle") => x - wide / 2.0,
                Some("end") => x - wide,
                _ => x,
            };
            Some((text, [left, y - 0.7 * size, left + wide, y + 0.2 * size]))
        };
        document.descendants().filter(|n| n.has_tag_name("text")).filter_map(boxed).collect()
    }

    #[test]
    fn no_text_lies_on_another_however_narrow_the_picture_is() {
        let (rate, channels) = (48e3, 16);
        let mut collector = Collector::new(&names(channels), rate, None);
        let frames: Vec<f32> = (0..9_600)
            .flat_map(|n| (0..channels).map(move |c| 0.9 * (0.02 * n as f32 * (1 + c) as f32).sin()))
            .collect();
        collector.push(&frames);
        for width in [500.0, 640.0, 699.0, 700.0, 900.0, 1200.0] {
            let subtitle = "patches/demo.toml on Back array, 4 by 4".to_string();
            let svg = collector.svg(&Style { width, subtitle, ..Style::new("Showcase for sixteen tactors") });
            let boxes = boxes(&svg);
            assert!(boxes.len() > 40);
            for (i, (a, [l, t, r, b])) in boxes.iter().enumerate() {
                assert!(*l >= 0.0 && *r <= width, "{width}: {a} leaves the picture");
                for (other, [l2, t2, r2, b2]) in &boxes[i + 1..] {
                    assert!(r < l2 || r2 < l || b < t2 || b2 < t, "{width}: `{a}` lies on `{other}`");
                }
            }
        }
    }

    #[test]
    fn silent_channels_take_little_room() {
        let mut collector = Collector::new(&names(8), 8000.0, None);
        collector.push(&[0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5].repeat(800));
        let layout = collector.layout(&Style::new(""));
        let heights: Vec<f64> = layout.rows.iter().map(|r| r[1]).collect();
        assert!(heights[0] == heights[7] && heights[0] > 5.0 * heights[1], "{heights:?}");
        assert_eq!(layout.bottom - layout.top, heights.iter().sum::<f64>());
        assert!(layout.rows.windows(2).all(|w| (w[1][0] - w[0][0] - 0.5 * (w[0][1] + w[1][1])).abs() < 1e-9));
    }

    #[test]
    fn the_loudest_picture_is_small() {
        for (channels, most) in [(16, 600_000), (64, 1_000_000)] {
            let mut collector = Collector::new(&names(channels), 8000.0, None);
            let noise =
                |n: usize| ((n as u32).wrapping_mul(2_654_435_761).rotate_left(7) as f32) / 2.2e9 - 1.0;
            let frames: Vec<f32> = (0..channels * 160_000).map(|n| noise(n) * noise(n / 7)).collect();
            collector.push(&frames);
            let size = collector.svg(&Style::new("noise")).len();
            assert!(size < most, "{size} bytes for {channels} channels");
        }
    }

    #[test]
    fn the_power_above_the_band_is_stated() {
        let rate = 48e3;
        let mut collector = Collector::new(&names(1), rate, None);
        let tone = |hertz: f64, n: usize| (TAU * hertz * n as f64 / rate).sin();
        let frames: Vec<f32> =
            (0..96_000).map(|n| (0.5 * tone(250.0, n) + 0.005 * tone(2000.0, n)) as f32).collect();
        collector.push(&frames);
        let texts = texts(&collector.svg(&Style::new("")));
        assert!(texts.iter().any(|t| t == "power above: −40.0 dB of the total"), "{texts:?}");
    }

    #[test]
    fn rows_are_filled_to_a_round_amplitude() {
        for (peak, edge) in [(1.0, 1.0), (0.5, 0.5), (0.948, 1.0), (1.19, 1.25), (0.34, 0.35), (0.001, 0.001)]
        {
            assert!((amplitude(peak) - edge).abs() < 1e-9, "{peak}: {}", amplitude(peak));
        }
    }
}
