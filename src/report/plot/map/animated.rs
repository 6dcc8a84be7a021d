//! One map that plays by itself, in the time that it took.

use std::fmt::Write;

use super::super::axis::short;
use super::super::colour::Ink;
use super::super::picture::{MARGIN, Style, wide};
use super::super::svg::{Anchor, Type};
use super::frames::Scale;
use super::view::Views;
use super::{Map, page};

/// Frames a second, and the most in all.
const SMOOTH: f64 = 30.0;
const MOST: usize = 600;
/// Height of the map at most.
const TALL: f64 = 520.0;
/// Levels that are told apart.
const LEVELS: f64 = 50.0;

impl Map {
    /// The picture: one map that shows again and again, as fast as it is felt, what shakes; where pictures do not move, how strongly each tactor ever did.
    pub fn animated(&self, style: &Style) -> String {
        let (views, width) = (Views::new(&self.sites), wide(style));
        let seconds = self.seconds().max(1e-3);
        let count = ((SMOOTH * seconds).ceil() as usize).clamp(2, MOST);
        let (strengths, most) = self.strengths(count);
        let inner = width - 2.0 * MARGIN;
        let named = format!("{} to the right, {} up", views.axes[0], views.axes[1]);
        let head = self.head(style, &named, most);
        let views_count = views.list.len() as f64;
        let scale = Scale::of(&views, [(inner - 8.0 * (views_count - 1.0)) / views_count, TALL]);
        let top = 104.0;
        let height = top + scale.labels + scale.height + 44.0;

        let mut svg = page(style, [width, height], &head);
        let at = [MARGIN + 0.5 * (inner - scale.width).max(0.0), top];
        scale.backs(&mut svg, &views, at);
        let lasts = format!("dur=\"{}s\" repeatCount=\"indefinite\"", plain(seconds));
        let names = (0.3 * scale.radius).clamp(7.0, 12.0);
        for (n, place) in scale.places(&views, at) {
            svg.disc(place, scale.radius, Ink::Axis, 0.35, "");
            let shares: Vec<u32> =
                strengths.iter().map(|all| level(all.get(n).copied().unwrap_or(0.0), most)).collect();
            let peak = shares.iter().copied().max().unwrap_or(0);
            if peak > 0 {
                let inside = changes(&shares, scale.radius, &lasts);
                let share = f64::from(peak) / LEVELS;
                svg.disc(place, radius(scale.radius, peak), Ink::Heat, share, &inside);
            }
            if scale.radius > 14.0 {
                let name = self.sites.get(n).map_or("", |site| &site.name);
                svg.text_within(
                    place[0],
                    place[1] + 0.36 * names,
                    Type::new(names, Anchor::Middle, Ink::Text),
                    name,
                    1.9 * scale.radius,
                );
            }
        }
        let bar = top + scale.labels + scale.height + 16.0;
        svg.rect([MARGIN, bar, inner, 4.0], Ink::Grid);
        let grow = format!("<animate attributeName=\"width\" from=\"0\" to=\"{}\" {lasts}/>", inner.round());
        svg.bar([MARGIN, bar, inner, 4.0], Ink::Heat, &grow);
        let times = Type::new(11.0, Anchor::Start, Ink::Dim);
        svg.text(MARGIN, bar + 18.0, times, "0 s");
        svg.text(
            width - MARGIN,
            bar + 18.0,
            Type { anchor: Anchor::End, ..times },
            &format!("{} s", short(seconds)),
        );
        svg.finish(width, height, &style.title, &head.join(". "))
    }
}

/// A strength in levels of the greatest.
fn level(strength: f64, most: f64) -> u32 {
    if most > 0.0 { (LEVELS * strength / most).round() as u32 } else { 0 }
}

/// How large a disc is at a level.
fn radius(full: f64, level: u32) -> f64 {
    full * (0.35 + 0.65 * f64::from(level) / LEVELS)
}

/// A number as animations take it.
fn plain(x: f64) -> String {
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

/// How opacity and radius go through levels; times are written only where a level is not that of before and after.
fn changes(levels: &[u32], full: f64, lasts: &str) -> String {
    let last = levels.len() - 1;
    let needed =
        |k: &usize| *k == 0 || *k == last || levels[k - 1] != levels[*k] || levels[k + 1] != levels[*k];
    let kept: Vec<usize> = (0..levels.len()).filter(needed).collect();
    let (mut times, mut shares, mut sizes) = (String::new(), String::new(), String::new());
    for (n, k) in kept.iter().enumerate() {
        let end = if n + 1 < kept.len() { ";" } else { "" };
        let _ = write!(times, "{}{end}", plain(*k as f64 / last as f64));
        let _ = write!(shares, "{}{end}", plain(f64::from(levels[*k]) / LEVELS));
        let _ = write!(sizes, "{:.1}{end}", radius(full, levels[*k]));
    }
    let animate = |what: &str, values: &str| {
        format!("<animate attributeName=\"{what}\" values=\"{values}\" keyTimes=\"{times}\" {lasts}/>")
    };
    animate("fill-opacity", &shares) + &animate("r", &sizes)
}
