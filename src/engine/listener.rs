//! Audio input: from device frames down to the engine's rate.

use crate::dsp::interpolator::Interpolator;
use crate::knob::angle::decoder::NOT_HEARD;

/// Brings input channels down to the engine's rate with the filter that brings output up, turned round. Engine sample n uses input
/// up to device frame n × ratio and no further.
#[derive(Debug)]
pub struct Listener {
    ratio: usize,
    taps: Vec<f32>,
    channels: usize,
    /// By channel: the last frames, oldest first, as many as the filter is long.
    past: Vec<Vec<f32>>,
    next: usize,
    /// Frames until the next engine sample is due.
    until: usize,
}

impl Listener {
    /// For so many channels, by the filter of an up-sampling of `ratio`.
    pub fn new(channels: usize, taps: usize, ratio: usize, rate: f64) -> Self {
        let filter = Interpolator::design(taps, ratio, rate);
        let sum: f64 = filter.response.iter().sum();
        let taps: Vec<f32> = filter.response.iter().map(|x| (x / sum) as f32).collect();
        let past = vec![vec![0.0; taps.len()]; channels];
        Self { ratio, taps, channels, past, next: 0, until: 0 }
    }

    /// Channels it listens to.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Device frames by which its signal is late.
    pub fn delay(&self) -> f64 {
        (self.taps.len() as f64 - 1.0) / 2.0
    }

    /// Takes a device frame (`None`: silence). Where an engine sample is due with it, `give` gets each channel's value.
    pub fn hear(&mut self, frame: Option<&[f32]>, mut give: impl FnMut(usize, f32)) {
        let length = self.taps.len();
        for (channel, past) in self.past.iter_mut().enumerate() {
            let value = frame.and_then(|f| f.get(channel)).copied().unwrap_or(0.0);
            past[self.next] = if value.abs() < NOT_HEARD { value } else { 0.0 };
        }
        self.next = (self.next + 1) % length;
        if self.until == 0 {
            for (channel, past) in self.past.iter().enumerate() {
                let (newer, older) = past.split_at(self.next);
                let ring = older.iter().chain(newer);
                give(channel, ring.zip(&self.taps).map(|(x, t)| x * t).sum());
            }
            self.until = self.ratio;
        }
        self.until -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::Listener;

    fn heard(hertz: f64) -> Vec<f32> {
        let mut listener = Listener::new(1, 8, 6, 8000.0);
        let mut out = Vec::new();
        for n in 0..48_000 {
            let x = (std::f64::consts::TAU * hertz * f64::from(n) / 48_000.0).sin() as f32;
            listener.hear(Some(&[x]), |_, y| out.push(y));
        }
        out
    }

    #[test]
    fn the_band_passes_and_what_would_fold_into_it_does_not() {
        let level = |hertz: f64| {
            let all = heard(hertz);
            assert_eq!(all.len(), 8000);
            (all[4000..].iter().map(|x| f64::from(x * x)).sum::<f64>() / 2000.0).sqrt()
        };
        assert!((level(200.0) - 1.0).abs() < 0.003 && (level(840.0) - 1.0).abs() < 0.003);
        for hertz in [7300.0, 8200.0, 15_900.0, 23_500.0] {
            assert!(level(hertz) < 1e-5, "{hertz}: {}", level(hertz));
        }
    }

    #[test]
    fn it_hears_nothing_before_its_time() {
        let mut listener = Listener::new(2, 6, 6, 8000.0);
        let mut out = Vec::new();
        for n in 0..60 {
            let frame = [if n == 13 { 1.0 } else { 0.0 }, f32::NAN];
            listener.hear(Some(&frame), |channel, y| out.push((channel, y)));
        }
        let first: Vec<f32> = out.iter().filter(|o| o.0 == 0).map(|o| o.1).collect();
        // Frame 13 lies after engine sample 2 (frame 12) and before sample 3 (frame 18).
        assert!(first[..3].iter().all(|x| *x == 0.0) && first[3] != 0.0);
        assert!(out.iter().all(|o| o.1.is_finite()));
    }
}
