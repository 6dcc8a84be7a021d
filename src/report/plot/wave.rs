//! The signal of one row of a picture.

use super::axis::Scale;
use super::colour::Ink;
use super::extremes::Extremes;
use super::path::Path;
use super::svg::Svg;

/// Where a row lies.
pub(super) struct Place<'a> {
    /// From seconds to pixels.
    pub time: &'a Scale,
    /// Samples a second.
    pub rate: f64,
    /// The pixel of 0.
    pub middle: f64,
    /// Pixels of full scale.
    pub unit: f64,
}

/// Draws a signal in about `pixels` columns: a line while samples are far apart, else the area between least and greatest.
pub(super) fn draw(svg: &mut Svg, signal: &Extremes, at: &Place, ink: Ink, pixels: f64) {
    let x = |sample: f64| at.time.at(sample / at.rate);
    let y = |sample: f32| at.middle - f64::from(sample) * at.unit;
    let (samples, columns) = signal.at_most((2.0 * pixels) as usize);
    let mut path = Path::default();
    if samples == 1 {
        columns.iter().enumerate().for_each(|(n, [_, sample])| path.to(x(n as f64), y(*sample)));
        if let [[_, only]] = columns.as_slice() {
            path.to(x(1.0), y(*only));
        }
        svg.stroke(&path, ink, 1.2);
        return;
    }
    let (samples, columns) = signal.at_most(pixels as usize);
    let x = |column: usize| x((column as f64 + 0.5) * samples as f64);
    let met = met(&columns);
    // Out along the greatest, back along the least; a stretch of silence is left to the base line.
    let mut from = 0;
    for run in met.chunk_by(|a, b| (*a == [0.0; 2]) == (*b == [0.0; 2])) {
        let mut shape = Path::default();
        run.iter().enumerate().for_each(|(i, [_, high])| shape.to(x(from + i), y(*high)));
        run.iter().enumerate().rev().for_each(|(i, [low, _])| shape.to(x(from + i), y(*low)));
        from += run.len();
        if run.first().is_some_and(|first| *first != [0.0; 2]) {
            path.append(shape);
        }
    }
    svg.area(&path, ink, 1.0, 0.7);
}

/// Columns that reach as far as the one before them, or a steep line would fall into pieces.
fn met(columns: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let before = columns.first().into_iter().chain(columns);
    columns
        .iter()
        .zip(before)
        .map(|([low, high], [low_before, high_before])| [low.min(*high_before), high.max(*low_before)])
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::report::plot::{Collector, Style};

    /// The corners of a path of relative steps.
    fn corners(data: &str) -> Vec<(f64, f64)> {
        let (mut at, mut begin, mut corners) = ((0.0, 0.0), (0.0, 0.0), Vec::new());
        for piece in data.split_inclusive(|c: char| c.is_ascii_alphabetic()).collect::<Vec<_>>().windows(2) {
            let letter = piece[0].chars().last().unwrap();
            let numbers = piece[1].trim_end_matches(|c: char| c.is_ascii_alphabetic()).replace('-', " -");
            let numbers: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
            let steps: Vec<(f64, f64)> = match letter {
                'h' => numbers.iter().map(|n| (*n, 0.0)).collect(),
                'v' => numbers.iter().map(|n| (0.0, *n)).collect(),
                'z' => {
                    at = begin;
                    continue;
                }
                _ => numbers.chunks(2).map(|n| (n[0], n[1])).collect(),
            };
            for (dx, dy) in steps {
                at = if letter == 'M' { (dx, dy) } else { (at.0 + dx, at.1 + dy) };
                if letter == 'M' {
                    begin = at;
                }
                corners.push(at);
            }
        }
        corners
    }

    /// The corners of the only path in the colour of row 0.
    fn row_0(svg: &str) -> Vec<(f64, f64)> {
        let document = roxmltree::Document::parse(svg).unwrap();
        let class = |n: &roxmltree::Node| {
            n.attribute("class").unwrap_or_default().split(' ').any(|c| c == "f0" || c == "s0")
        };
        let path = document.descendants().find(|n| n.has_tag_name("path") && class(n)).expect("a row");
        corners(path.attribute("d").unwrap())
    }

    #[test]
    fn a_row_shows_the_extremes_where_they_are() {
        for length in [1500, 4001, 60_000, 1_000_000] {
            let mut signal = vec![0.01; length];
            (signal[length / 4], signal[length / 2]) = (0.8, -0.4);
            let mut collector = Collector::new(&[String::from("one")], 8000.0, None);
            collector.push(&signal);
            let corners = row_0(&collector.svg(&Style::new("")));
            let by = |at: fn(&(f64, f64)) -> f64, greater: bool| {
                let order = |a: &&(f64, f64), b: &&(f64, f64)| at(a).total_cmp(&at(b));
                *if greater { corners.iter().max_by(order) } else { corners.iter().min_by(order) }.unwrap()
            };
            let (high, low) = (by(|c| c.1, false), by(|c| c.1, true));
            let (left, right) = (by(|c| c.0, false).0, by(|c| c.0, true).0);
            // 1.2 of amplitude, in a row of 150 pixels of which ±0.8 takes 92 %.
            assert!((low.1 - high.1 - 1.2 * 0.46 * 150.0 / 0.8).abs() < 0.2, "{length}: {high:?} {low:?}");
            assert!(
                (high.0 - left - 0.25 * (right - left)).abs() < 2.0,
                "{length}: {high:?} of {left} to {right}"
            );
            assert!(
                (low.0 - left - 0.5 * (right - left)).abs() < 2.0,
                "{length}: {low:?} of {left} to {right}"
            );
        }
    }

    #[test]
    fn a_jump_is_joined_and_silence_is_not_drawn() {
        let mut signal = vec![0.0; 100_000];
        signal[40_000..50_000].fill(0.5);
        signal[50_000..60_000].fill(-0.5);
        let mut collector = Collector::new(&[String::from("one")], 8000.0, None);
        collector.push(&signal);
        let corners = row_0(&collector.svg(&Style::new("")));
        let (left, right) = (corners[0].0, corners.iter().map(|c| c.0).fold(0.0, f64::max));
        assert!((right - left) / (1120.0 - 80.0) < 0.21, "only the sounding fifth: {left} to {right}");
        // One shape from the one to the other: the column of the jump reaches over both.
        let jump = 0.5 * (left + right);
        let near: Vec<f64> = corners.iter().filter(|c| (c.0 - jump).abs() < 2.5).map(|c| c.1).collect();
        let reach =
            near.iter().copied().fold(f64::MIN, f64::max) - near.iter().copied().fold(f64::MAX, f64::min);
        assert!(reach > 130.0, "{reach}");
    }
}
