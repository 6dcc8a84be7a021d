//! placeholder
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::graph::plan::Plan;
use crate::schedule::Instant;
/// stage
pub struct Stage<R> { channels: usize, ratio: usize, _r: std::marker::PhantomData<R> }
impl<R: Real> Stage<R> {
    /// new
    pub fn new(plan: &Plan, _isa: Isa) -> Self { Self { channels: plan.channels, ratio: plan.ratio, _r: std::marker::PhantomData } }
    /// p
    pub fn process(&mut self, mix: &[Vec<[R; LANES]>], _fed: &[bool], samples: usize, _clock: u64, out: &mut [f32]) {
        for n in 0..samples { for p in 0..self.ratio { for c in 0..self.channels {
            out[(n * self.ratio + p) * self.channels + c] = mix[c / LANES][n][c % LANES].wide() as f32;
        }}}
    }
    /// m
    pub fn mark(&mut self, _name: u32, _at: Instant, _clock: u64) {}
    /// a
    pub fn is_asleep(&self) -> bool { true }
}
