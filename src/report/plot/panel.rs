//! The panel of a picture that shows the spectrum.

use super::axis::{Scale, signed};
use super::colour::Ink;
use super::path::Path;
use super::spectrum::Spectrum;
use super::svg::{Anchor, Svg, Type};

/// The engine's limit, hertz.
const LIMIT: f64 = 1000.0;
/// Hertz at the left edge, and at the right one where the rate allows.
const SPAN: [f64; 2] = [10.0, 10_000.0];
/// Decibels at the lower edge.
const FLOOR: f64 = -120.0;

/// Room that a narrow panel needs above itself for what stands below its heading.
pub(super) const LINES: f64 = 32.0;

/// Draws a spectrum into the frame `left`, `top`, `right`, `bottom`, with its labels outside of it. `sounding` is the
/// number of channels it is the mean of. A narrow one has all that is said of it below its heading.
pub(super) fn draw(
    svg: &mut Svg,
    spectrum: &Spectrum,
    [left, top, right, bottom]: [f64; 4],
    sounding: usize,
    narrow: bool,
) {
    let nyquist = spectrum.bin_hertz * spectrum.power.len().saturating_sub(1) as f64;
    let dim = |anchor| Type::new(11.0, anchor, Ink::Dim);
    let heading = Type { bold: true, ..Type::new(13.0, Anchor::Start, Ink::Text) };
    svg.text(left, top - 14.0 - if narrow { LINES } else { 0.0 }, heading, "Spectrum");
    if nyquist < 2.0 * SPAN[0] {
        svg.text(left, top + 14.0, dim(Anchor::Start), "none: the rate is too low for one");
        return;
    }
    let x = Scale::log([SPAN[0], nyquist.min(SPAN[1])], left, right);
    let columns = ((right - left) as usize).max(2);
    let edges: Vec<f64> = (0..=columns).map(|i| left + (right - left) * i as f64 / columns as f64).collect();
    let levels: Vec<(f64, f64)> = edges
        .windows(2)
        .map(|edge| (0.5 * (edge[0] + edge[1]), spectrum.peak_level(x.value(edge[0]), x.value(edge[1]))))
        .collect();
    let loudest = levels.iter().map(|l| l.1).fold(0.0, f64::max);
    let ceiling = if loudest <= 0.5 { 0.0 } else { (loudest / 20.0).ceil() * 20.0 };
    let y = Scale::linear([FLOOR, ceiling], bottom, top);

    if nyquist > LIMIT {
        svg.rect([x.at(LIMIT), top, right - x.at(LIMIT), bottom - top], Ink::Shade);
    }
    for minor in x.minor() {
        svg.line([x.at(minor), top, x.at(minor), bottom], Ink::Grid, 0.5, 0.0);
    }
    for (hertz, label) in x.ticks(if narrow { 4 } else { 14 }) {
        svg.line([x.at(hertz), bottom, x.at(hertz), bottom + 4.0], Ink::Axis, 1.0, 0.0);
        svg.text(x.at(hertz), bottom + 17.0, dim(Anchor::Middle), &label);
    }
    for (db, label) in y.ticks(7) {
        svg.line([left, y.at(db), right, y.at(db)], Ink::Grid, 0.8, 0.0);
        svg.text(left - 8.0, y.at(db) + 4.0, dim(Anchor::End), &label);
    }
    svg.text((left + right) / 2.0, bottom + 35.0, dim(Anchor::Middle), "Frequency (Hz)");
    svg.text_up(left - 44.0, (top + bottom) / 2.0, dim(Anchor::Middle), "dB re full-scale sine");

    let ink = Ink::Curve;
    let (mut area, mut edge) = (Path::default(), Path::default());
    area.to(left, bottom);
    for (i, (pixel, db)) in levels.iter().enumerate() {
        let at = y.at(db.max(FLOOR));
        if i == 0 {
            area.to(left, at);
            edge.to(left, at);
        }
        area.to(*pixel, at);
        edge.to(*pixel, at);
    }
    area.to(right, bottom);
    if sounding > 0 {
        svg.area(&area, ink, 0.16, 0.0);
        svg.stroke(&edge, ink, 1.1);
    }
    svg.line([left, bottom, right, bottom], Ink::Axis, 1.0, 0.0);
    if nyquist > LIMIT {
        let at = x.at(LIMIT);
        svg.line([at, top, at, bottom], Ink::Limit, 1.2, 4.0);
        // Beside the line, on the side that has room.
        let (beside, anchor) =
            if right - at > 200.0 || narrow { (at + 7.0, Anchor::Start) } else { (at - 7.0, Anchor::End) };
        let label = Type { bold: true, ..Type::new(11.5, anchor, Ink::Limit) };
        svg.text(beside, top + 15.0, label, "1 kHz");
        if narrow {
            svg.text(left, top - 12.0, dim(Anchor::Start), &above(spectrum));
        } else {
            svg.text(beside, top + 30.0, dim(anchor), &above(spectrum));
        }
    }
    let (at, below, anchor) =
        if narrow { (left, top - 28.0, Anchor::Start) } else { (right, top - 14.0, Anchor::End) };
    svg.text(at, below, dim(anchor), &meaning(spectrum, sounding));
}

/// What is said of the power above the limit.
fn above(spectrum: &Spectrum) -> String {
    match spectrum.above(LIMIT) {
        None => "silent".into(),
        Some(db) if db < -200.0 => "power above: none".into(),
        Some(db) if db > -0.05 => "power above: 0.0 dB of the total".into(),
        Some(db) => format!("power above: {} dB of the total", signed(format!("{db:.1}"))),
    }
}

/// What a point of the curve is.
fn meaning(spectrum: &Spectrum, sounding: usize) -> String {
    let of = match sounding {
        0 => return "all channels are silent".into(),
        1 => "one channel".to_string(),
        n => format!("mean of the {n} channels that sound"),
    };
    format!("{of}, power in bands of {:.1} Hz", spectrum.band_hertz())
}
