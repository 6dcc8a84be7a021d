//! A first guess of the law of a rotor, from the speeds that were followed.
//!
//! ω′ = g u − r ω − c, integrated over time, is linear in g, r and c: ω = ω₀ + g ∫u − r ∫ω − c t, with an ω₀ for every run.

use super::least::linear;
use super::spin::{Law, Push, Run};
use super::track::Stretch;

/// A leap of the drive is more than this share of its range.
const LEAP: f64 = 0.05;

/// The times over which the rotor was seen to turn.
pub(super) fn runs(stretches: &[Stretch], push: &Push) -> Vec<Run> {
    let mut runs = Vec::new();
    for stretch in stretches {
        let (first, last) = (stretch.knots[0], stretch.knots[stretch.knots.len() - 1]);
        let samples = first.at.ceil() as usize..(last.at as usize).min(push.samples.len());
        // What drove it until it was fastest; where nothing did, what drove it before.
        let fastest =
            stretch.knots.iter().max_by(|a, b| a.speed.total_cmp(&b.speed)).map_or(first.at, |k| k.at);
        let sum: f64 = push.samples
            [samples.start..=(fastest as usize).clamp(samples.start, push.samples.len() - 1)]
            .iter()
            .sum();
        let before = || push.samples[..samples.start].iter().rev().find(|u| **u != 0.0).copied();
        let sense = 1.0f64.copysign(if sum == 0.0 { before().unwrap_or(1.0) } else { sum });
        runs.push(Run { samples, sense, start: first.speed / push.period });
    }
    runs
}

/// Whether the drive leaps while the rotor turns.
pub(super) fn switches(runs: &[Run], push: &Push) -> bool {
    let (least, most) = push.samples.iter().fold((0.0_f64, 0.0_f64), |(l, m), u| (l.min(*u), m.max(*u)));
    runs.iter().any(|run| {
        let inner = &push.samples[run.samples.clone()];
        let count = inner.len() / 8;
        let leap = inner.windows(2).skip(count).any(|u| (u[1] - u[0]).abs() > LEAP * (most - least));
        leap && inner.len() > 16
    })
}

/// The law by the speeds along stretches; without drag where the drive is `steady`.
pub(super) fn first(stretches: &[Stretch], runs: &[Run], push: &Push, steady: bool) -> Option<Law> {
    let points = stretches.iter().map(|stretch| {
        let pair = stretch.knots.windows(2).map(|k| {
            let span = k[1].at - k[0].at;
            (k[0].at + 0.5 * span, (k[1].angle - k[0].angle) / (span * push.period))
        });
        pair.collect::<Vec<_>>()
    });
    law(&points.collect::<Vec<_>>(), runs, push, steady)
}

/// The law under a drive, by runs that another law knows.
pub(super) fn of_spun(spun: &[(Run, Vec<f64>)], push: &Push) -> Option<Law> {
    let points = spun.iter().map(|(run, speed)| {
        let every = (speed.len() / 400).max(1);
        let pair = speed.iter().enumerate().step_by(every).map(|(n, w)| ((run.samples.start + n) as f64, *w));
        pair.collect::<Vec<_>>()
    });
    let runs: Vec<Run> = spun.iter().map(|(run, _)| run.clone()).collect();
    law(&points.collect::<Vec<_>>(), &runs, push, false)
}

/// By points of each run: samples and speeds.
fn law(points: &[Vec<(f64, f64)>], runs: &[Run], push: &Push, steady: bool) -> Option<Law> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for n in 0..push.samples.len() {
        sum += push.mean(n, 0.0).unwrap_or(0.0) * push.period;
        sums.push(sum);
    }
    let driven = |at: f64| {
        let n = (at.max(0.0) as usize).min(push.samples.len() - 1);
        sums[n] + (at - n as f64) * (sums[n + 1] - sums[n])
    };
    let size = if steady { 2 } else { 3 };
    let mut rows = Vec::new();
    for (points, run) in points.iter().zip(runs) {
        let Some(&(begin, _)) = points.first() else { continue };
        let (mut last, mut turned) = (points[0], 0.0);
        let mut own = Vec::new();
        for &(at, speed) in points {
            // Open terminals are another law.
            if push.open.iter().any(|open| open.contains(&(at as usize))) {
                break;
            }
            turned += 0.5 * (speed + last.1) * (at - last.0) * push.period;
            last = (at, speed);
            own.push((
                [run.sense * (driven(at) - driven(begin)), -turned, (begin - at) * push.period],
                speed,
            ));
        }
        let count = own.len().max(1) as f64;
        let mean: [f64; 3] = std::array::from_fn(|i| own.iter().map(|(row, _)| row[i]).sum::<f64>() / count);
        let middle = own.iter().map(|(_, speed)| speed).sum::<f64>() / count;
        let free =
            |(row, speed): &([f64; 3], f64)| ((0..size).map(|i| row[i] - mean[i]).collect(), speed - middle);
        rows.extend(own.iter().map(free));
    }
    let found = linear(rows.into_iter(), size)?;
    let drag = found.get(2).map_or(0.0, |c| *c);
    let top = points.iter().flatten().fold(0.0_f64, |m, p| m.max(p.1));
    // Noise may make a rate of nothing or less: it stands still within the recording then.
    let least = 1e-2 / (push.samples.len() as f64 * push.period);
    let rate = found[1].max(least);
    (top > 0.0).then_some(Law {
        gain: found[0],
        rate,
        drag: drag.max(0.0),
        late: 0.0,
        coast: 0.5 * rate,
        gravity: 0.0,
        damping: 0.0,
    })
}
