//! Random numbers as data: what a number is depends on its names alone, never on what was drawn before.
//!
//! Philox4x32-10 (Salmon, Moraes, Dror, Shaw: "Parallel random numbers: as easy as 1, 2, 3", SC 2011). A stream is the key,
//! the place in it the counter, so the same seed gives the same bits on every machine and in any order.

use super::lanes::{LANES, Real};

const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
const ROUNDS: usize = 10;

/// Four random words for a counter and a key: the published block function.
#[inline(always)]
pub fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let (mut c, mut k) = (counter, key);
    for _ in 0..ROUNDS {
        let a = u64::from(MULTIPLIERS[0]) * u64::from(c[0]);
        let b = u64::from(MULTIPLIERS[1]) * u64::from(c[2]);
        c = [(b >> 32) as u32 ^ c[1] ^ k[0], b as u32, (a >> 32) as u32 ^ c[3] ^ k[1], a as u32];
        k = [k[0].wrapping_add(WEYL[0]), k[1].wrapping_add(WEYL[1])];
    }
    c
}

/// The stream of a node in a voice: what [`crate::node::kernel::Onset::stream`] holds. Any change of one name gives an
/// unrelated stream.
pub fn stream(seed: u64, voice: u64, node: u64) -> u64 {
    let w = philox(
        [voice as u32, (voice >> 32) as u32, node as u32, (node >> 32) as u32],
        [seed as u32, (seed >> 32) as u32],
    );
    u64::from(w[0]) | u64::from(w[1]) << 32
}

/// Words `4 × block` to `4 × block + 3` of a stream.
#[inline(always)]
pub fn words(stream: u64, block: u64) -> [u32; 4] {
    philox([block as u32, (block >> 32) as u32, 0, 0], [stream as u32, (stream >> 32) as u32])
}

/// The same for eight streams at a time: four rows.
#[inline(always)]
pub fn rows(streams: &[u64; LANES], blocks: &[u64; LANES]) -> [[u32; LANES]; 4] {
    // Words sit in 64-bit lanes, since that is how vector units multiply 32 by 32 bits.
    const LOW: u64 = 0xFFFF_FFFF;
    let mut c = [[0_u64; LANES]; 4];
    let mut k = [[0_u64; LANES]; 2];
    for l in 0..LANES {
        c[0][l] = blocks[l] & LOW;
        c[1][l] = blocks[l] >> 32;
        k[0][l] = streams[l] & LOW;
        k[1][l] = streams[l] >> 32;
    }
    for _ in 0..ROUNDS {
        for l in 0..LANES {
            let a = u64::from(MULTIPLIERS[0]) * (c[0][l] & LOW);
            let b = u64::from(MULTIPLIERS[1]) * (c[2][l] & LOW);
            let (second, fourth) = (c[1][l], c[3][l]);
            c[0][l] = (b >> 32) ^ second ^ k[0][l];
            c[1][l] = b & LOW;
            c[2][l] = (a >> 32) ^ fourth ^ k[1][l];
            c[3][l] = a & LOW;
            k[0][l] = (k[0][l] + u64::from(WEYL[0])) & LOW;
            k[1][l] = (k[1][l] + u64::from(WEYL[1])) & LOW;
        }
    }
    let mut words = [[0; LANES]; 4];
    for (row, wide) in words.iter_mut().zip(&c) {
        for l in 0..LANES {
            row[l] = wide[l] as u32;
        }
    }
    words
}

/// Word number `index` of a stream.
pub fn bits(stream: u64, index: u64) -> u32 {
    words(stream, index / 4)[(index % 4) as usize]
}

/// Uniform in [−1, 1), in steps of 2^−31; mean 0, RMS 1/√3.
#[inline(always)]
pub fn signed(word: u32) -> f64 {
    f64::from(word as i32) * (1.0 / 2_147_483_648.0)
}

/// Number `index` of a stream, uniform in [−1, 1).
pub fn uniform(stream: u64, index: u64) -> f64 {
    signed(bits(stream, index))
}

/// White noise on eight lanes, each with its own stream from its first sample on.
#[derive(Debug, Clone)]
pub struct Source {
    streams: [u64; LANES],
    blocks: [u64; LANES],
    /// Words that are ready, and which row comes next.
    ready: [[u32; LANES]; 4],
    slot: usize,
    /// Where in the row of four a lane began, and the last words it got: it uses them that much later.
    offset: [usize; LANES],
    carry: [[u32; LANES]; 4],
}

impl Default for Source {
    fn default() -> Self {
        Self {
            streams: [0; LANES],
            blocks: [0; LANES],
            ready: [[0; LANES]; 4],
            slot: 0,
            offset: [0; LANES],
            carry: [[0; LANES]; 4],
        }
    }
}

impl Source {
    /// The next number of `lane` is the first of `stream`.
    pub fn start(&mut self, lane: usize, stream: u64) {
        self.streams[lane] = stream;
        self.offset[lane] = self.slot;
        self.blocks[lane] = 0;
        if self.slot > 0 {
            let first = words(stream, 0);
            for (row, word) in first.into_iter().enumerate() {
                self.carry[row][lane] = word;
                if let Some(ready) = self.ready.get_mut(self.slot + row) {
                    ready[lane] = word;
                }
            }
            self.blocks[lane] = 1;
        }
    }

    /// The next number of each lane, uniform in [−1, 1].
    #[inline(always)]
    pub fn draw<R: Real>(&mut self) -> [R; LANES] {
        if self.slot == 0 {
            self.refill();
        }
        let mut row = [R::ZERO; LANES];
        for l in 0..LANES {
            row[l] = R::of(signed(self.ready[self.slot][l]));
        }
        self.slot = (self.slot + 1) % 4;
        row
    }

    #[inline(always)]
    fn refill(&mut self) {
        let new = rows(&self.streams, &self.blocks);
        for l in 0..LANES {
            let late = self.offset[l];
            for row in 0..4 {
                self.ready[row][l] =
                    if row < late { self.carry[4 - late + row][l] } else { new[row - late][l] };
            }
            self.blocks[l] = self.blocks[l].wrapping_add(1);
        }
        self.carry = new;
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, Source, bits, philox, rows, stream, uniform, words};

    /// `kat_vectors` of the authors' Random123 distribution.
    #[test]
    fn the_published_answers() {
        assert_eq!(philox([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        let ones = u32::MAX;
        assert_eq!(philox([ones; 4], [ones; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        assert_eq!(
            philox([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn rows_are_the_words_of_each_lane() {
        let (mut streams, mut blocks) = ([0; LANES], [0; LANES]);
        for l in 0..LANES {
            streams[l] = stream(7, l as u64, 3);
            blocks[l] = (l as u64) << (7 * l);
        }
        let rows = rows(&streams, &blocks);
        for l in 0..LANES {
            for (w, row) in rows.iter().enumerate() {
                assert_eq!(row[l], words(streams[l], blocks[l])[w]);
                assert_eq!(row[l], bits(streams[l], 4 * blocks[l] + w as u64));
            }
        }
    }

    #[test]
    fn a_source_plays_each_stream_from_its_start() {
        let mut source = Source::default();
        for n in 0..40_u64 {
            if n < 8 {
                source.start(n as usize, 100 + n);
            }
            let row = source.draw::<f64>();
            for (l, value) in row.iter().enumerate().take(n as usize + 1) {
                assert_eq!(*value, uniform(100 + l as u64, n - l as u64), "lane {l}, sample {n}");
            }
        }
    }

    #[test]
    fn a_million_numbers_are_uniform_and_uncorrelated() {
        let (a, b) = (stream(1, 2, 3), stream(1, 2, 4));
        let n = 1_000_000;
        let (mut sum, mut square, mut next, mut cross) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..n {
            let x = uniform(a, i);
            assert!((-1.0..1.0).contains(&x));
            sum += x;
            square += x * x;
            next += x * uniform(a, i + 1);
            cross += x * uniform(b, i);
        }
        let n = n as f64;
        // Five standard deviations each.
        assert!((sum / n).abs() < 5.0 * (1.0 / 3.0 / n).sqrt());
        assert!((square / n - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / n).sqrt());
        for product in [next, cross] {
            assert!((product / n).abs() < 5.0 / 3.0 / n.sqrt());
        }
    }

    #[test]
    fn every_name_of_a_stream_counts() {
        let all = [stream(0, 0, 0), stream(1, 0, 0), stream(0, 1, 0), stream(0, 0, 1), stream(1 << 32, 0, 0)];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b));
        }
    }
}
