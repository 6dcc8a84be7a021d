//! Width: a Gaussian about a point.

use super::super::point::{Point, dot};
use crate::dsp::elementary::exp;

/// A weight below this share of the largest is none.
pub(super) const LEAST: f64 = 1e-6;
/// −ln of it.
const FARTHEST: f64 = 13.815_510_557_964_274;

/// Fills weights by site with exp(−(r² − r_min²) / 2 s²), 1 in sum.
///
/// What is below a millionth of the largest is left out; that millionth is taken off the others, so that none of them jumps where it
/// comes in.
pub(super) fn gaussian([x, y, z]: [&[f64]; 3], p: Point, s: f64, dense: &mut [f64]) {
    let n = x.len().min(y.len()).min(z.len()).min(dense.len());
    let (x, y, z, dense) = (&x[..n], &y[..n], &z[..n], &mut dense[..n]);
    for k in 0..n {
        let d = [x[k] - p[0], y[k] - p[1], z[k] - p[2]];
        dense[k] = dot(d, d);
    }
    let nearest =
        dense.iter().fold(f64::INFINITY, |least, square| if *square < least { *square } else { least });
    // Held, so that 0 times it stays 0 for the narrowest.
    let rate = (0.5 / (s * s)).min(1e300);
    for four in dense.chunks_mut(4) {
        four.iter_mut().for_each(|square| *square = (*square - nearest) * rate);
        if four.iter().all(|exponent| *exponent >= FARTHEST) {
            four.fill(0.0);
            continue;
        }
        // Without a branch, so that several are computed at a time.
        for weight in four {
            let exponent = if *weight < FARTHEST { *weight } else { FARTHEST };
            let above = exp(-exponent) - LEAST;
            *weight = if above > 0.0 { above } else { 0.0 };
        }
    }
    let share = 1.0 / dense.iter().sum::<f64>();
    dense.iter_mut().for_each(|weight| *weight *= share);
}

#[cfg(test)]
mod tests {
    use super::gaussian;

    #[test]
    fn the_narrowest_leaves_the_nearest_alone() {
        for s in [1e-3, 1e-100, 1e-170, 5e-324] {
            let mut weights = [7.0; 5];
            gaussian([&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0; 5], &[0.0; 5]], [2.2, 9.0, 0.0], s, &mut weights);
            let off = weights.iter().zip([0.0, 0.0, 1.0, 0.0, 0.0]).map(|(w, wanted)| (w - wanted).abs());
            assert!(off.fold(0.0, f64::max) < 1e-15, "{s}: {weights:?}");
        }
    }
}
