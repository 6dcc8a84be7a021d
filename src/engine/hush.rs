//! Exact silence, where all that sounded is told to be silent at once.
//!
//! A voice that falls silent in 3 ms leaves the band limit and the up-sampling ringing, at less than a hundredth of what it was.
//! Where nothing else sounds nobody is robbed of anything if the output itself goes to zero; and zero is what a sender means that is
//! gone or says "all sound off". It opens with the next voice, within less than what that takes
//! through the output stage.

use super::edges::Edges;

/// Seconds from open to shut; back takes half of it.
const RAMP: f64 = 0.002;

/// Seconds after which it opens if nothing plays: what rang has become exact zero by then.
const RINGS: f64 = 0.25;

/// The gain of everything that a mix becomes, between 1 and 0. What it does depends on engine time alone.
#[derive(Debug, Clone)]
pub struct Hush {
    ratio: usize,
    /// Frames from open to shut.
    ramp: u32,
    /// Frames from shut.
    at: u32,
    open: bool,
    /// Engine samples until it opens by itself, and how many they are at first.
    left: u32,
    rings: u32,
    edges: Edges,
}

impl Hush {
    /// Open. `device_rate` in frames a second, `ratio` of them for an engine sample.
    pub fn new(device_rate: f64, ratio: usize) -> Self {
        let ramp = (RAMP * device_rate).round().max(1.0) as u32;
        let rings = (RINGS * device_rate / ratio.max(1) as f64).round() as u32;
        Self { ratio, ramp, at: ramp, open: true, left: 0, rings, edges: Edges::default() }
    }

    /// Goes to zero from an engine sample of the next block on.
    pub fn shut(&mut self, clock: u64) {
        self.edges.shut(clock);
    }

    /// Comes back from an engine sample of the next block on.
    pub fn open(&mut self, clock: u64) {
        self.edges.open(clock);
    }

    /// Weighs frames of `channels`: those of the next `samples` engine samples (at most a block). The sample after those
    /// for which `output` has room is in `rest`.
    pub fn apply(&mut self, samples: usize, channels: usize, output: &mut [f32], rest: &mut [f32]) {
        let [mut shuts, mut opens] = self.edges.take(samples);
        if self.open && self.at == self.ramp && shuts == 0 {
            return;
        }
        let step = (self.ratio * channels).max(1);
        let mut blocks = output.chunks_exact_mut(step).chain(rest.chunks_exact_mut(step));
        for _ in 0..samples {
            if shuts & 1 == 1 {
                (self.open, self.left) = (false, self.rings);
            } else if opens & 1 == 1 || self.left == 0 {
                self.open = true;
            }
            (shuts, opens, self.left) = (shuts >> 1, opens >> 1, self.left.saturating_sub(1));
            let Some(block) = blocks.next() else { return };
            for frame in block.chunks_exact_mut(channels) {
                self.at = if self.open { (self.at + 2).min(self.ramp) } else { self.at.saturating_sub(1) };
                let x = self.at as f32 / self.ramp as f32;
                let gain = x * x * (3.0 - 2.0 * x);
                // A product with 0 may be a negative zero.
                frame.iter_mut().for_each(|value| *value = if self.at == 0 { 0.0 } else { *value * gain });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Hush;
    use crate::engine::workspace::BLOCK;

    /// Ones through it in blocks of these sizes, with edges (engine sample, opens) that are told before the block they fall in.
    fn weighed(blocks: &[usize], edges: &[(u64, bool)]) -> Vec<f32> {
        let (mut hush, mut clock, mut all) = (Hush::new(48_000.0, 6), 0, Vec::new());
        for &samples in blocks {
            for &(at, opens) in edges.iter().filter(|(at, _)| (clock..clock + samples as u64).contains(at)) {
                if opens { hush.open(at) } else { hush.shut(at) }
            }
            let (mut output, mut rest) = (vec![1.0; samples * 12 - 5], [1.0; 12]);
            hush.apply(samples, 2, &mut output, &mut rest);
            output.truncate((samples - 1) * 12);
            all.extend_from_slice(&output);
            all.extend_from_slice(&rest);
            clock += samples as u64;
        }
        all
    }

    #[test]
    fn it_is_zero_two_milliseconds_after_it_shuts_and_until_it_opens() {
        let all = weighed(&[64; 20], &[(100, false), (700, true)]);
        let frames: Vec<&[f32]> = all.chunks_exact(2).collect();
        assert!(frames.iter().all(|frame| frame[0].to_bits() == frame[1].to_bits()));
        let is = |from: usize, to: usize, value: f32| {
            frames[from..to].iter().all(|f| f[0].to_bits() == value.to_bits())
        };
        assert!(is(0, 600, 1.0) && is(696, 4200, 0.0) && is(4248, frames.len(), 1.0));
        assert!(
            frames[599..696]
                .windows(2)
                .all(|pair| pair[1][0] < pair[0][0] && pair[0][0] - pair[1][0] < 0.017)
        );
        assert!(frames[4199..4248].windows(2).all(|pair| pair[1][0] > pair[0][0]));
    }

    #[test]
    fn it_opens_by_itself_when_nothing_rings() {
        let all = weighed(&[64; 40], &[(10, false)]);
        let open = all.iter().rposition(|value| *value == 0.0).unwrap() / 2;
        // A quarter of a second is 2,000 engine samples.
        assert_eq!(open, 60 + 12_000 - 1);
    }

    /// Also where one falls upon another, and where it would open by itself in the same block.
    #[test]
    fn blocks_make_no_difference() {
        let edges = [
            (3, false),
            (5, true),
            (6, false),
            (6, true),
            (9, true),
            (9, false),
            (2008, false),
            (2030, true),
            (2300, false),
        ];
        let whole = weighed(&[BLOCK; 40], &edges);
        assert_eq!(weighed(&[1; BLOCK * 40], &edges), whole);
        let odd: Vec<usize> = [7, 64, 1, 33, 23].into_iter().cycle().take(100).collect();
        assert_eq!(weighed(&odd, &edges)[..], whole[..odd.iter().sum::<usize>() * 12]);
    }
}
