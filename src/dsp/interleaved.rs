//! Twins of filters that are defined at the engine's rate.
//!
//! A linear filter H(z) at the engine's rate is H(z^m) at m times that rate: m filters that take the samples in turn. What it
//! does within the engine's band is the same to the last bit of the definition.

/// `m` copies of a filter, used in turn.
#[derive(Debug, Clone)]
pub struct Interleaved<T> {
    phases: Vec<T>,
    next: usize,
}

impl<T: Clone> Interleaved<T> {
    /// Copies of `filter` for a twin at `rate` in an engine at `engine_rate`.
    pub fn new(filter: T, rate: f64, engine_rate: f64) -> Self {
        Self { phases: vec![filter; (rate / engine_rate).round().max(1.0) as usize], next: 0 }
    }

    /// The one whose turn it is.
    pub fn turn(&mut self) -> &mut T {
        let now = self.next;
        self.next = (self.next + 1) % self.phases.len();
        &mut self.phases[now]
    }
}
