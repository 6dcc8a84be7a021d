//! What nodes that order something of a motor have in common: they make no sound, and say how long their order lasts.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use crate::dsp::lanes::{LANES, Real};

/// Eight lanes of silence; with `HOLDS` each lasts until its release, else it is over as soon as it begins.
#[derive(Debug, Clone)]
pub struct Lanes<R, const HOLDS: bool> {
    held: [bool; LANES],
    silence: R,
}

impl<R: Real, const HOLDS: bool> Kernel<R> for Lanes<R, HOLDS> {
    fn new(_setup: &Setup) -> Self {
        Self { held: [false; LANES], silence: R::ZERO }
    }

    fn start(&mut self, lane: usize, _onset: &Onset) {
        self.held[lane] = HOLDS;
    }

    fn release(&mut self, lane: usize, _at: f64) {
        self.held[lane] = false;
    }

    #[inline(always)]
    fn run(&mut self, io: &mut Io<R>) {
        io.pointwise().fill([self.silence; LANES]);
    }

    fn sounding(&self, lane: usize) -> Option<bool> {
        Some(self.held[lane])
    }
}

/// The definition: nothing, for as long as the order lasts.
#[derive(Debug)]
pub struct Exact<const HOLDS: bool> {
    held: bool,
}

impl<const HOLDS: bool> Exact<HOLDS> {
    /// For one voice.
    pub fn new(_setup: &Setup, _onset: &Onset) -> Self {
        Self { held: HOLDS }
    }
}

impl<const HOLDS: bool> Twin for Exact<HOLDS> {
    fn step(&mut self, _t: f64, _inputs: &[f64]) -> f64 {
        0.0
    }

    fn release(&mut self, _t: f64) {
        self.held = false;
    }

    fn sounding(&self) -> Option<bool> {
        Some(self.held)
    }
}

#[cfg(test)]
mod tests {
    use crate::node::harness::Bench;

    #[test]
    fn orders_are_silent_and_last_as_long_as_they_hold() {
        for (node, holds) in [
            ("drive-click", false),
            ("drive-spin", true),
            ("drive-on", true),
            ("drive-swell", false),
            ("drive-brake", false),
            ("drive-home", false),
        ] {
            let bench = Bench::new(node, 8000.0).released(0.05);
            bench.check_contract();
            assert!(bench.kernel::<f32>(1000, &[64]).iter().all(|x| *x == 0.0), "{node}");
            assert!(bench.twin(1000, 1).iter().all(|x| *x == 0.0), "{node}");
            let ends = if holds { 401..=403 } else { 1..=1 };
            assert!(bench.ends::<f32>(1000).is_some_and(|at| ends.contains(&at)), "{node}");
        }
    }
}
