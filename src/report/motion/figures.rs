//! Figures of what a motor did.

use super::bench::{Bench, Run};
use super::wish::Wish;

/// Rise, peak, stop and error of a run. The amplitude of a vibration is m_e r ω²/M_t; only the peak has the rotor's own acceleration in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Until the amplitude is 50 % and 90 % of what is wanted at most, s; `None`: it never is, or nothing is wanted, or nothing can be felt.
    pub rise: [Option<f64>; 2],
    /// The most that is felt, in the bench's unit.
    pub peak: f64,
    /// When that is, s.
    pub peak_at: f64,
    /// From the end of the wish until the rotor stands, s; `None`: it still moved when it was given up.
    pub stop: Option<f64>,
    /// From when on the amplitude is a tenth of what is wanted at most, or of its own most where nothing is wanted, and until when, s.
    pub felt: Option<[f64; 2]>,
    /// By how much the amplitude misses what is wanted: root mean square over the wish, as a share of the most that is wanted.
    pub error: Option<f64>,
}

/// Shares of what is wanted at which a rise is told, and from which on something is felt.
const RISE: [f64; 2] = [0.5, 0.9];
const FELT: f64 = 0.1;

impl Figures {
    /// Of a run under a wish that ends at `end` (s); without one nothing is wanted.
    pub fn new(bench: &Bench, run: &Run, wish: Option<&Wish>, end: f64) -> Self {
        let speeds = &run.traces.speeds;
        let amplitude = |n: usize| speeds.get(n).map_or(0.0, |speed| bench.per_square() * speed * speed);
        // Where the mass is not eccentric nothing is felt, whatever is wanted.
        let wish = wish.filter(|_| bench.rated() > 0.0);
        let most = wish.map(|wish| wish.level * bench.rated());
        let first = |value: f64| {
            let n = (0..speeds.len()).find(|n| amplitude(*n) >= value)?;
            let before = if n == 0 { 0.0 } else { amplitude(n - 1) };
            let part = (value - before) / (amplitude(n) - before);
            Some((n as f64 + part) / run.rate)
        };
        let (at, peak) = run
            .traces
            .felt
            .iter()
            .enumerate()
            .fold((0, 0.0), |most, (n, felt)| if *felt > most.1 { (n, *felt) } else { most });
        let own = speeds.iter().enumerate().fold(0.0_f64, |most, (n, _)| most.max(amplitude(n)));
        let tenth = FELT * most.unwrap_or(own);
        let last = speeds.iter().enumerate().rev().find(|(n, _)| amplitude(*n) >= tenth).map(|(n, _)| n);
        let felt = if tenth > 0.0 { first(tenth).zip(last.map(|n| run.time(n))) } else { None };
        Self {
            rise: RISE.map(|share| most.and_then(|most| first(share * most))),
            peak,
            peak_at: if peak > 0.0 { run.time(at) } else { 0.0 },
            stop: run.stands.map(|stands| (stands - end).max(0.0)),
            felt: felt.map(|(from, until)| [from, until]),
            error: wish.map(|wish| {
                let shares = wish.shares(run.rate);
                // Between the ends, where it leaps.
                let within = shares.get(1..shares.len() - 1).unwrap_or_default();
                let off = |(n, share): (usize, &f64)| (amplitude(n) / bench.rated() - share).powi(2);
                let sum: f64 = within.iter().enumerate().map(off).sum();
                (sum / within.len().max(1) as f64).sqrt() / wish.level
            }),
        }
    }
}

#[cfg(test)]
mod tests;
