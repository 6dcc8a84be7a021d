//! What a picture needs to know of a rendering, gathered while it passes.

use super::extremes::Extremes;
use super::spectrum::{Spectrum, Welch};

/// Rows a picture has at most; of the channels beyond, only their peak is kept.
pub const ROWS: usize = 64;

/// Takes the frames of a rendering of any length and keeps what a picture shows, in some 150 kB a channel: the least and
/// greatest samples of at most 4,000 stretches of time, and the power spectrum.
///
/// However the frames are cut into pieces, the picture has the same bytes.
///
/// ```
/// use pacinian::report::plot::{Collector, Style};
///
/// let mut collector = Collector::new(&["index".into(), "thumb".into()], 8000.0, None);
/// for n in 0..8000 {
///     let x = (n as f32 * 0.2).sin();
///     collector.push(&[x, 0.5 * x]);
/// }
/// let svg = collector.svg(&Style::new("Two fingers"));
/// assert!(svg.contains(">thumb<"));
/// ```
pub struct Collector {
    pub(super) names: Vec<String>,
    pub(super) rate: f64,
    pub(super) rows: Vec<Extremes>,
    pub(super) peaks: Vec<f32>,
    pub(super) frames: u64,
    /// Samples that were not numbers, counted as 0.
    pub(super) unsound: u64,
    /// The beginning of a frame whose rest has not come.
    part: Vec<f32>,
    clean: Vec<f32>,
    welch: Welch,
}

impl Collector {
    /// One channel for each name; `rate` in samples a second (what is not a number above 0 counts as 1). `expected_seconds` is a
    /// guess of the length; a wrong one costs resolution at most.
    pub fn new(names: &[String], rate: f64, expected_seconds: Option<f64>) -> Self {
        let rate = if rate.is_finite() && rate > 0.0 { rate } else { 1.0 };
        let expected = (expected_seconds.unwrap_or(0.0) * rate).max(0.0) as u64;
        let shown = names.len().min(ROWS);
        Self {
            names: names.to_vec(),
            rate,
            rows: vec![Extremes::new(expected); shown],
            peaks: vec![0.0; names.len()],
            frames: 0,
            unsound: 0,
            part: Vec::new(),
            clean: Vec::new(),
            welch: Welch::new(shown, rate),
        }
    }

    /// Takes interleaved samples; a piece may end within a frame, which the next one then completes. Samples that are not
    /// finite count as 0, and the picture says how many they were.
    pub fn push(&mut self, interleaved: &[f32]) {
        let channels = self.names.len();
        if channels == 0 {
            return;
        }
        let mut rest = interleaved;
        if !self.part.is_empty() {
            let (first, later) = rest.split_at(rest.len().min(channels - self.part.len()));
            self.part.extend_from_slice(first);
            rest = later;
            if self.part.len() < channels {
                return;
            }
            let frame = std::mem::take(&mut self.part);
            self.take(&frame);
        }
        let (whole, part) = rest.split_at(rest.len() - rest.len() % channels);
        self.part.extend_from_slice(part);
        // In bounded pieces, so that a whole file may be pushed at once.
        for frames in whole.chunks(channels * 4096) {
            self.take(frames);
        }
    }

    /// Takes whole frames.
    fn take(&mut self, frames: &[f32]) {
        let channels = self.names.len();
        let mut clean = std::mem::take(&mut self.clean);
        clean.clear();
        clean.extend(frames.iter().map(|x| if x.is_finite() { *x } else { 0.0 }));
        self.unsound += frames.iter().filter(|x| !x.is_finite()).count() as u64;
        self.frames += (frames.len() / channels) as u64;
        for (c, row) in self.rows.iter_mut().enumerate() {
            clean.iter().skip(c).step_by(channels).for_each(|x| row.push(*x));
        }
        for frame in clean.chunks_exact(channels) {
            self.peaks.iter_mut().zip(frame).for_each(|(peak, x)| *peak = peak.max(x.abs()));
        }
        self.welch.push(&clean, channels);
        self.clean = clean;
    }

    /// Greatest size of a sample, by channel; 1 is full scale.
    pub fn peaks(&self) -> &[f32] {
        &self.peaks
    }

    /// Length of what has come, in seconds.
    pub fn seconds(&self) -> f64 {
        self.frames as f64 / self.rate
    }

    /// The spectrum of what has come: the mean of the channels that sound, of the first [`ROWS`].
    pub(crate) fn spectrum(&self) -> Spectrum {
        self.welch.finish(self.sounding())
    }

    /// Channels shown that are not silent.
    pub(super) fn sounding(&self) -> usize {
        self.peaks.iter().take(ROWS).filter(|p| **p > 0.0).count()
    }
}

#[cfg(test)]
mod tests {
    use super::{Collector, ROWS};
    use crate::report::plot::Style;
    use proptest::prelude::{Strategy, any, proptest};

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("tactor {i}")).collect()
    }

    #[test]
    fn peaks_and_extremes_are_those_of_the_data() {
        let frames: Vec<f32> = (0..30_000).map(|n| ((n * 7919 % 2003) as f32 / 1001.0 - 1.0) * 0.8).collect();
        let mut collector = Collector::new(&names(3), 1000.0, Some(10.0));
        collector.push(&frames);
        for c in 0..3 {
            let own = frames.iter().skip(c).step_by(3);
            let range = [own.clone().copied().fold(9.0, f32::min), own.copied().fold(-9.0, f32::max)];
            assert_eq!(collector.rows[c].at_most(1).1, [range]);
            assert_eq!(collector.peaks()[c], range[1].max(-range[0]));
        }
        assert_eq!(collector.seconds(), 10.0);
    }

    #[test]
    fn channels_beyond_the_rows_keep_their_peak() {
        let mut collector = Collector::new(&names(100), 8000.0, None);
        let mut frame = vec![0.0; 100];
        frame[90] = -0.75;
        collector.push(&frame);
        assert_eq!((collector.rows.len(), collector.peaks()[90]), (ROWS, 0.75));
    }

    proptest! {
        #[test]
        fn pieces_do_not_matter(
            channels in 1usize..5,
            cuts in proptest::collection::vec(1usize..9000, 1..12),
            seed in any::<u16>().prop_map(u32::from),
        ) {
            let frames: Vec<f32> = (0..20_000u32)
                .map(|n| (n.wrapping_mul(2_654_435_761) ^ seed).rotate_left(9) as f32 / 4e9 - 0.5)
                .collect();
            let mut whole = Collector::new(&names(channels), 8000.0, None);
            whole.push(&frames);
            let mut pieces = Collector::new(&names(channels), 8000.0, None);
            let mut rest = frames.as_slice();
            for cut in cuts.iter().cycle() {
                let (now, later) = rest.split_at(rest.len().min(*cut));
                pieces.push(now);
                rest = later;
                if rest.is_empty() {
                    break;
                }
            }
            let style = Style::new("pieces");
            assert_eq!(whole.svg(&style), pieces.svg(&style));
        }
    }
}
