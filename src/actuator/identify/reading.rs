//! What all windows of a recording say together: gravity, amplitude, noise; and which parts of it to use.

use super::least::descend;
use super::rotor::Told;
use super::spin::{Run, Spun, Window};

/// Windows of a run, at least.
pub(super) const LEAST_WINDOWS: usize = 3;

/// Keeps those that are marked.
pub(super) fn kept<T>(all: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    all.retain(|_| keep.next() == Some(&true));
}

/// The windows of each run.
pub(super) fn windows(runs: &[Run], spun: &[Spun], x: &[f64]) -> Vec<Vec<Window>> {
    runs.iter().zip(spun).map(|(run, spun)| spun.windows(&x[run.samples.clone()])).collect()
}

/// Parts of runs that are fast enough for gravity to be but a ripple.
pub(super) fn fast(runs: &[Run], spun: &[Spun], slowest: f64) -> Vec<Run> {
    let mut parts = Vec::new();
    for (run, spun) in runs.iter().zip(spun) {
        let mut begin = None;
        for n in 0..=spun.speed.len() {
            let goes = spun.speed.get(n).is_some_and(|speed| *speed > slowest);
            match (begin, goes) {
                (None, true) => begin = Some(n),
                (Some(from), false) => {
                    let turned: f64 = spun.angle[n - 1] - spun.angle[from];
                    if turned > std::f64::consts::TAU * (LEAST_WINDOWS + 1) as f64 {
                        let samples = run.samples.start + from..run.samples.start + n;
                        parts.push(Run { samples, sense: run.sense, start: spun.speed[from] });
                    }
                    begin = None;
                }
                _ => {}
            }
        }
    }
    parts
}

/// γ from the second harmonic, which is 2 γ/ω² of the first: of all windows of a run with their phases, then of all runs.
pub(super) fn gravity(spun: &[Spun], read: &[Vec<Window>]) -> Told {
    let (mut sum, mut weights, mut scatter) = (0.0, 0.0, 0.0);
    for (windows, spun) in read.iter().zip(spun) {
        // Each window's γ with its phase, and the weight of that.
        let each: Vec<([f64; 2], f64)> = windows
            .iter()
            .map(|w| {
                let per = 0.5 * spun.speed[w.middle].powi(2);
                (w.second.map(|h| per * h), 1.0 / (w.noise * per).powi(2).max(1e-300))
            })
            .collect();
        let weight: f64 = each.iter().map(|(_, one)| one).sum();
        let mean = [0, 1].map(|n| each.iter().map(|(both, one)| one * both[n]).sum::<f64>() / weight);
        let off = |both: &[f64; 2]| (both[0] - mean[0]).powi(2) + (both[1] - mean[1]).powi(2);
        scatter += each.iter().map(|(both, one)| one * one * off(both)).sum::<f64>();
        (sum, weights) = (sum + weight * mean[0].hypot(mean[1]), weights + weight);
    }
    // What wanders makes harmonics too: by the scatter, not by the noise alone.
    let off = 3.0 * scatter.max(weights).sqrt() / weights;
    if sum.is_finite() && off.is_finite() { (sum / weights, off) } else { (0.0, 0.0) }
}

/// The amplitude over √(ω⁴ + α²).
pub(super) fn arm(read: &[Vec<Window>]) -> Option<Told> {
    let all: Vec<Window> = read.iter().flatten().copied().collect();
    let start = all.first()?.arm;
    let rest = |p: &[f64]| all.iter().map(|w| (w.arm - p[0]) / (w.arm * w.noise.max(1e-9))).collect();
    let fit = descend(&[start], &[1e-6 * start], |p| Some(rest(p)))?;
    Some((fit.values[0], fit.off(&[1.0])))
}

/// Signal to noise, dB.
pub(super) fn ratio(read: &[Vec<Window>]) -> f64 {
    let sum = |n: usize| read.iter().flatten().map(|w| w.squares[n]).sum::<f64>();
    10.0 * (sum(0) / sum(1).max(1e-300)).log10()
}
