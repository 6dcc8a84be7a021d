//! Motors that are to stand at once.
//!
//! They are braked actively for as long as there is time, and then nothing is sent any more: exact zeros. At a voltage, zero is a short circuit through
//! the amplifier and goes on braking, with the mechanical time constant; at a current, zero lets a motor roll, and the pulse before it is all that
//! brakes it.

use super::super::edges::Edges;
use super::super::workspace::BLOCK;

/// Seconds of braking before nothing is sent.
pub const BRAKING: f64 = 0.004;

/// What is done with motors at an engine sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Halt {
    /// What is played.
    #[default]
    None,
    /// They are braked, as fast as may be.
    Brakes,
    /// Nothing is sent.
    Rests,
}

/// Who wants them to stand, and since when.
#[derive(Debug, Clone)]
pub(super) struct Halts {
    /// Samples of braking, and those that are left.
    brakes: u32,
    left: u32,
    /// Nothing may leave; nothing plays.
    held: bool,
    hushed: bool,
    edges: Edges,
}

impl Halts {
    /// Of motors that play, at so many engine samples a second.
    pub fn new(rate: f64) -> Self {
        let brakes = (BRAKING * rate).floor() as u32;
        Self { brakes, left: brakes, held: false, hushed: false, edges: Edges::default() }
    }

    /// From the next sample on, until it is taken back.
    pub fn hold(&mut self, held: bool) {
        self.held = held;
    }

    /// From an engine sample of the next block on, until something begins.
    pub fn shut(&mut self, clock: u64) {
        self.edges.shut(clock);
    }

    /// Something begins at an engine sample of the next block.
    pub fn open(&mut self, clock: u64) {
        self.edges.open(clock);
    }

    /// What is done at each of the next samples.
    pub fn next(&mut self, samples: usize, halts: &mut [Halt; BLOCK]) {
        let [shuts, opens] = self.edges.take(samples);
        for (n, halt) in halts.iter_mut().enumerate().take(samples) {
            self.hushed = (self.hushed && opens >> n & 1 == 0) || shuts >> n & 1 == 1;
            *halt = match self.left {
                _ if !(self.held || self.hushed) => {
                    self.left = self.brakes;
                    Halt::None
                }
                0 => Halt::Rests,
                _ => {
                    self.left -= 1;
                    Halt::Brakes
                }
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, Halt, Halts};

    /// What is done at each of 200 samples, of edges at samples (shut or open) and of a hold from one sample to another, in blocks of a size.
    fn done(edges: &[(u64, bool)], held: [u64; 2], size: usize) -> Vec<Halt> {
        let (mut halts, mut all) = (Halts::new(8000.0), Vec::new());
        while all.len() < 200 {
            let clock = all.len() as u64;
            let size = size.min(200 - all.len());
            for &(at, shuts) in edges.iter().filter(|(at, _)| (clock..clock + size as u64).contains(at)) {
                if shuts { halts.shut(at) } else { halts.open(at) }
            }
            halts.hold((held[0]..held[1]).contains(&clock));
            let mut block = [Halt::None; BLOCK];
            halts.next(size, &mut block);
            all.extend_from_slice(&block[..size]);
        }
        all
    }

    #[test]
    fn they_brake_for_four_milliseconds_and_rest_until_something_begins() {
        for size in [1, 7, 64] {
            let all = done(&[(20, true), (90, false), (100, true), (110, false)], [0, 0], size);
            let is = |from: usize, to: usize, what: Halt| all[from..to].iter().all(|halt| *halt == what);
            assert!(is(0, 20, Halt::None) && is(20, 52, Halt::Brakes) && is(52, 90, Halt::Rests), "{size}");
            assert!(is(90, 100, Halt::None) && is(100, 110, Halt::Brakes) && is(110, 200, Halt::None));
        }
        // Of two at the same sample the last counts.
        let all = done(&[(5, true), (5, false), (9, false), (9, true)], [0, 0], 64);
        assert_eq!((all[8], all[9]), (Halt::None, Halt::Brakes));
    }

    /// What may not leave does not begin, and whoever holds it down twice does not brake twice.
    #[test]
    fn held_down_they_rest_whatever_begins() {
        let all = done(&[(20, true), (90, false)], [30, 150], 1);
        let first =
            |what: Halt, from: usize| all[from..].iter().position(|halt| *halt == what).map(|n| from + n);
        assert_eq!(first(Halt::Rests, 20), Some(52));
        assert_eq!(first(Halt::None, 20), Some(150));
        assert_eq!(first(Halt::Brakes, 52), None);
    }
}
