//! Where on the body something happens: how strongly each tactor shakes over time, drawn where it sits.

mod animated;
mod frames;
#[cfg(test)]
mod tests;
mod view;

use super::axis::short;
use super::colour::Ink;
use super::picture::{MARGIN, Style};
use super::svg::{Anchor, Svg, Type};

/// A tactor on a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Its name.
    pub name: String,
    /// Its channel, from 0.
    pub channel: usize,
    /// Where it sits, m: x to the right, y up, z ahead.
    pub position: [f64; 3],
}

/// Stretches of time that are told apart, at most.
const BINS: usize = 4096;

/// Takes the frames of a rendering of any length and keeps how strongly each tactor shakes over time, in some 32 kB a tactor.
///
/// However the frames are cut into pieces, the picture has the same bytes.
///
/// ```
/// use pacinian::report::plot::{Map, Site, Style};
///
/// let site = |n: u8| Site { name: format!("t{n}"), channel: n.into(), position: [0.03 * f64::from(n), 0.0, 0.0] };
/// let mut map = Map::new(&[site(0), site(1)], 2, 8000.0);
/// for n in 0..8000 {
///     let x = (n as f32 * 0.2).sin();
///     map.push(&[x, 0.5 * x]);
/// }
/// assert!((map.strength(1, 0.0, 1.0) - 0.5 * 0.5_f64.sqrt()).abs() < 1e-3);
/// assert!(map.frames(&Style::new("Two"), 12).contains("<svg"));
/// ```
pub struct Map {
    sites: Vec<Site>,
    /// By channel, the site that it is.
    of: Vec<Option<usize>>,
    rate: f64,
    /// By site: sums of squares over stretches of `bin` frames.
    squares: Vec<Vec<f64>>,
    bin: u64,
    frames: u64,
    /// The channel of the next sample.
    next: usize,
    /// Samples that were not numbers, counted as 0.
    unsound: u64,
}

impl Map {
    /// Tactors among so many channels; of two on one channel the first counts. `rate` in samples a second (what is not a number above 0 counts as 1).
    pub fn new(sites: &[Site], channels: usize, rate: f64) -> Self {
        let known = |site: &&Site| site.channel < channels && site.position.iter().all(|x| x.is_finite());
        let mut of = vec![None; channels];
        let mut kept: Vec<Site> = Vec::new();
        for site in sites.iter().filter(known) {
            if of[site.channel].is_none() {
                of[site.channel] = Some(kept.len());
                kept.push(site.clone());
            }
        }
        Self {
            squares: vec![Vec::new(); kept.len()],
            sites: kept,
            of,
            rate: if rate.is_finite() && rate > 0.0 { rate } else { 1.0 },
            bin: 1,
            frames: 0,
            next: 0,
            unsound: 0,
        }
    }

    /// Takes interleaved samples; a piece may end within a frame, which the next one then completes. Samples that are not finite count as 0, and
    /// the picture says how many they were.
    pub fn push(&mut self, interleaved: &[f32]) {
        for sample in interleaved {
            if let Some(site) = self.of[self.next] {
                let at = (self.frames / self.bin) as usize;
                let x = f64::from(*sample);
                let squares = &mut self.squares[site];
                if squares.len() <= at {
                    squares.resize(at + 1, 0.0);
                }
                if x.is_finite() {
                    squares[at] += x * x;
                } else {
                    self.unsound += 1;
                }
            }
            self.next += 1;
            if self.next == self.of.len() {
                self.next = 0;
                self.frames += 1;
                if self.frames == BINS as u64 * self.bin {
                    self.halve();
                }
            }
        }
    }

    /// Makes stretches twice as long.
    fn halve(&mut self) {
        self.bin *= 2;
        for squares in &mut self.squares {
            *squares = squares.chunks(2).map(|pair| pair.iter().sum()).collect();
        }
    }

    /// Length of what has come, in seconds.
    pub fn seconds(&self) -> f64 {
        self.frames as f64 / self.rate
    }

    /// The tactors on it.
    pub fn sites(&self) -> &[Site] {
        &self.sites
    }

    /// The root mean square of a tactor's samples from one time to another, in seconds; 1 is full scale. Times fall into stretches of at most a 2048th of
    /// what has come.
    pub fn strength(&self, site: usize, from: f64, to: f64) -> f64 {
        let end = self.frames as f64;
        let [from, to] = [from, to].map(|seconds| (seconds * self.rate).clamp(0.0, end));
        // Nor where one of them is not a number.
        if from.is_nan() || to.is_nan() || to <= from {
            return 0.0;
        }
        let bin = self.bin as f64;
        let squares = self.squares.get(site).map_or(&[][..], |squares| squares);
        let (first, last) = ((from / bin) as usize, (to / bin).ceil() as usize);
        let mut sum = 0.0;
        for (k, square) in squares.iter().enumerate().take(last).skip(first) {
            let (begin, after) = (k as f64 * bin, ((k + 1) as f64 * bin).min(end));
            let share = (to.min(after) - from.max(begin)) / (after - begin);
            sum += square * share.clamp(0.0, 1.0);
        }
        (sum / (to - from)).sqrt()
    }

    /// The strengths of all tactors over so many frames of equal length, frame by frame, and the greatest of them.
    fn strengths(&self, frames: usize) -> (Vec<Vec<f64>>, f64) {
        let each = self.seconds() / frames as f64;
        let of = |k: usize| {
            let (from, to) = (k as f64 * each, (k + 1) as f64 * each);
            (0..self.sites.len()).map(|site| self.strength(site, from, to)).collect::<Vec<f64>>()
        };
        let all: Vec<Vec<f64>> = (0..frames).map(of).collect();
        let most = all.iter().flatten().copied().fold(0.0, f64::max);
        (all, most)
    }

    /// What stands below the title, and what must be said because the picture does not show it.
    fn head(&self, style: &Style, each: &str, most: f64) -> [String; 2] {
        let tactors = match self.sites.len() {
            1 => "1 tactor".to_string(),
            n => format!("{n} tactors"),
        };
        let mut parts = vec![tactors, format!("{} s", short(self.seconds())), each.to_string()];
        if !style.subtitle.is_empty() {
            parts.insert(0, style.subtitle.clone());
        }
        let mut said = if most > 0.0 {
            format!(
                "Discs are filled as far as a tactor shakes: the fullest {} of full scale (root mean square)",
                short(most)
            )
        } else {
            "Nothing shakes".to_string()
        };
        if self.unsound > 0 {
            said += &format!("; samples that are not finite numbers, counted as 0: {}", self.unsound);
        }
        [parts.join("  ·  "), said + "."]
    }
}

/// A page with its title and what stands below that.
fn page(style: &Style, [width, height]: [f64; 2], head: &[String; 2]) -> Svg {
    let inner = width - 2.0 * MARGIN;
    let mut svg = Svg::new(style.dark);
    svg.rect([0.0, 0.0, width, height], Ink::Page);
    let title = Type { bold: true, ..Type::new(21.0, Anchor::Start, Ink::Text) };
    svg.text_within(MARGIN, 40.0, title, &style.title, inner);
    for (line, below) in head.iter().zip([62.0, 80.0]) {
        svg.text_within(MARGIN, below, Type::new(13.0, Anchor::Start, Ink::Dim), line, inner);
    }
    svg
}
