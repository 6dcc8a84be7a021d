//! A small writer of SVG: rounded numbers, escaped text, short paths, the same bytes for the same calls.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::colour::Ink;
use super::path::{Path, number};

/// The font stack of every picture.
const FONTS: &str = "'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";

/// Which end of a text lies at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy)]
pub(in crate::report) struct Type {
    pub size: f64,
    pub anchor: Anchor,
    pub ink: Ink,
    pub bold: bool,
}

impl Type {
    pub fn new(size: f64, anchor: Anchor, ink: Ink) -> Self {
        Self { size, anchor, ink, bold: false }
    }
}

/// An SVG document being written. Light colours stand in attributes, which every reader understands; where dark mode is
/// followed, a style sheet overrides them.
#[derive(Debug)]
pub(in crate::report) struct Svg {
    body: String,
    /// Colours in use, for the style sheet: by class, what the dark rule says.
    dark: Option<BTreeMap<String, String>>,
}

impl Svg {
    pub fn new(dark: bool) -> Self {
        Self { body: String::new(), dark: dark.then(BTreeMap::new) }
    }

    /// The attributes that fill with an ink.
    fn fill(&mut self, ink: Ink) -> String {
        self.paint(ink, "fill", "")
    }

    /// The class and attribute of an ink used as `property`; `and` is a further class.
    fn paint(&mut self, ink: Ink, property: &str, and: &str) -> String {
        let initial = &property[..1];
        let class = format!("{initial}{}", ink.class());
        if let Some(dark) = &mut self.dark {
            dark.insert(class.clone(), format!("{property}:{}", ink.dark()));
            return format!(" class=\"{class}{and}\" {property}=\"{}\"", ink.light());
        }
        format!(" {property}=\"{}\"", ink.light())
    }

    /// A filled rectangle.
    pub fn rect(&mut self, [x, y, width, height]: [f64; 4], ink: Ink) {
        let paint = self.fill(ink);
        let [x, y, width, height] = [x, y, width.max(0.0), height.max(0.0)].map(number);
        let _ =
            writeln!(self.body, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{paint}/>");
    }

    /// The same that something is animated in.
    pub fn bar(&mut self, [x, y, width, height]: [f64; 4], ink: Ink, inside: &str) {
        let paint = self.fill(ink);
        let [x, y, width, height] = [x, y, width.max(0.0), height.max(0.0)].map(number);
        let _ = writeln!(
            self.body,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{paint}>{inside}</rect>"
        );
    }

    /// A filled disc, with an opacity; `inside` may animate it.
    pub fn disc(&mut self, [x, y]: [f64; 2], radius: f64, ink: Ink, opacity: f64, inside: &str) {
        let paint = self.fill(ink);
        let [x, y, radius, opacity] = [x, y, radius, opacity.clamp(0.0, 1.0)].map(hundredths);
        let end = if inside.is_empty() { "/>".into() } else { format!(">{inside}</circle>") };
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{paint} fill-opacity=\"{opacity}\"{end}"
        );
    }

    /// A straight line; `dash` is the length of its dashes, 0 for none.
    pub fn line(&mut self, [x1, y1, x2, y2]: [f64; 4], ink: Ink, width: f64, dash: f64) {
        let paint = self.paint(ink, "stroke", "");
        let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(number);
        let dash = if dash > 0.0 { format!(" stroke-dasharray=\"{}\"", number(dash)) } else { String::new() };
        let _ = writeln!(
            self.body,
            "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\"{paint} stroke-width=\"{width}\"{dash}/>"
        );
    }

    /// A closed shape: filled (with an opacity) and, where `edge` is not 0, edged with the same ink.
    pub fn area(&mut self, path: &Path, ink: Ink, opacity: f64, edge: f64) {
        if path.is_empty() {
            return;
        }
        let mut paint = self.fill(ink);
        if edge > 0.0 {
            let stroke = self.paint(ink, "stroke", "");
            // One class attribute an element: the stroke's class joins the fill's.
            paint = match (paint.split_once("\" "), stroke.split_once("\" ")) {
                (Some((class, fill)), Some((other, stroke))) if self.dark.is_some() => {
                    format!("{class} {}\" {fill} {stroke}", other.trim_start_matches(" class=\""))
                }
                _ => format!("{paint}{stroke}"),
            };
            let _ = write!(paint, " stroke-width=\"{edge}\" stroke-linejoin=\"round\"");
        }
        if opacity < 1.0 {
            let _ = write!(paint, " fill-opacity=\"{opacity}\"");
        }
        let _ = writeln!(self.body, "<path d=\"{}\"{paint}/>", path.closed());
    }

    /// An open line along a path.
    pub fn stroke(&mut self, path: &Path, ink: Ink, width: f64) {
        self.dashed(path, ink, width, "");
    }

    /// An open line along a path, with dashes and gaps of these lengths; "": unbroken.
    pub fn dashed(&mut self, path: &Path, ink: Ink, width: f64, dashes: &str) {
        if path.is_empty() {
            return;
        }
        let paint = self.paint(ink, "stroke", "");
        let dashes =
            if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") };
        let _ = writeln!(
            self.body,
            "<path d=\"{}\" fill=\"none\"{paint} stroke-width=\"{width}\" stroke-linejoin=\"round\"{dashes}/>",
            path.data()
        );
    }

    /// A line of text with its base line at (x, y).
    pub fn text(&mut self, x: f64, y: f64, set: Type, text: &str) {
        self.text_at(&format!("x=\"{}\" y=\"{}\"", number(x), number(y)), set, text, None);
    }

    /// A line of text, cut to about `width`; the whole of it stays as the tool tip.
    pub fn text_within(&mut self, x: f64, y: f64, set: Type, text: &str, width: f64) {
        let cut = within(text, width / set.size);
        let whole = (cut != text).then_some(text);
        self.text_at(&format!("x=\"{}\" y=\"{}\"", number(x), number(y)), set, &cut, whole);
    }

    /// A line of text that reads upward.
    pub fn text_up(&mut self, x: f64, y: f64, set: Type, text: &str) {
        self.text_at(
            &format!("transform=\"translate({} {}) rotate(-90)\"", number(x), number(y)),
            set,
            text,
            None,
        );
    }

    fn text_at(&mut self, place: &str, set: Type, text: &str, whole: Option<&str>) {
        let paint = self.fill(set.ink);
        let anchor = match set.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if set.bold { " font-weight=\"600\"" } else { "" };
        let tip = whole.map(|w| format!("<title>{}</title>", escape(w))).unwrap_or_default();
        let _ = writeln!(
            self.body,
            "<text {place} font-size=\"{}\"{anchor}{weight}{paint}>{tip}{}</text>",
            number(set.size),
            escape(text)
        );
    }

    /// The whole document; `title` and `description` are what a screen reader says.
    pub fn finish(self, width: f64, height: f64, title: &str, description: &str) -> String {
        let (w, h) = (number(width), number(height));
        let mut out = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" role=\"img\" font-family=\"{FONTS}\">\n"
        );
        if !title.is_empty() {
            let _ = writeln!(out, "<title>{}</title>", escape(title));
        }
        if !description.is_empty() {
            let _ = writeln!(out, "<desc>{}</desc>", escape(description));
        }
        if let Some(dark) = &self.dark {
            out.push_str("<style>@media (prefers-color-scheme:dark){");
            for (class, rule) in dark {
                let _ = write!(out, ".{class}{{{rule}}}");
            }
            out.push_str("}</style>\n");
        }
        out.push_str(&self.body);
        out.push_str("</svg>\n");
        out
    }
}

/// A number to two digits.
fn hundredths(x: f64) -> String {
    let text = format!("{x:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// A text for the inside of an element or attribute. What XML cannot hold becomes U+FFFD; breaks become spaces.
pub(in crate::report) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\r' | '\t' => out.push(' '),
            '\0'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// About how wide a text is, in its own size: no font is at hand, so a guess on the wide side.
pub(in crate::report) fn width(text: &str) -> f64 {
    text.chars().map(advance).sum()
}

fn advance(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' => 0.32,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.95,
        'A'..='Z' => 0.7,
        c if u32::from(c) >= 0x1100 => 1.0,
        _ => 0.6,
    }
}

/// A text cut, with an ellipsis, to `most` of its own size.
fn within(text: &str, most: f64) -> String {
    if width(text) <= most {
        return text.to_string();
    }
    let mut left = most - 0.9;
    let mut cut: String = text
        .chars()
        .take_while(|c| {
            left -= advance(*c);
            left >= 0.0
        })
        .collect();
    cut.truncate(cut.trim_end().len());
    cut.push('…');
    cut
}

#[cfg(test)]
mod tests {
    use super::{escape, width, within};

    #[test]
    fn text_is_escaped_and_holds_only_what_xml_can() {
        assert_eq!(
            escape("a<b>&\"c\"\0\u{1b}\n\u{ffff}é"),
            "a&lt;b&gt;&amp;&quot;c&quot;\u{fffd}\u{fffd} \u{fffd}é"
        );
    }

    #[test]
    fn long_text_is_cut_to_its_room() {
        let cut = within("left index fingertip, the second one", 10.0);
        assert!(cut.ends_with('…') && width(&cut) <= 10.0 && cut.starts_with("left index"), "{cut}");
        assert_eq!(within("thumb", 10.0), "thumb");
        assert_eq!(within("thumb", 0.0), "…");
    }
}
