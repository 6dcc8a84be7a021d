//! What nodes that order something of a motor have in common: they make no sound, and say how long their order lasts.

use super::kernel::{Io, Kernel, Onset, Setup, Twin};
use crate::dsp::lanes::{LANES, Real};

/// Eight lanes of silence; with `HOLDS` each lasts until its release, else it is over as soon as it begins.
#[derive(Debug)]
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
pub struct Exact {
    held: bool,
}

impl Exact {
    /// For one voice: whether it lasts until its release.
    pub fn new(holds: bool) -> Self {
        Self { held: holds }
    }
}

impl Twin for Exact {
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
