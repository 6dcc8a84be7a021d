//! Least squares against closed forms, and intervals against repeated draws.

use super::super::noise::Noise;
use super::{descend, inverse, linear};

#[test]
fn an_inverse_is_one() {
    let a = vec![vec![4.0, 1e-6, -1.0], vec![1e-6, 1e-9, 2e-7], vec![-1.0, 2e-7, 3.0]];
    let b = inverse(&a).unwrap();
    for i in 0..3 {
        for j in 0..3 {
            let is: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
            let scale = (a[i][i] / a[j][j]).sqrt();
            assert!((is - f64::from(u8::from(i == j))).abs() < 1e-12 * scale.max(1.0), "{i} {j} {is}");
        }
    }
    assert!(inverse(&vec![vec![1.0, 2.0], vec![2.0, 4.0]]).is_none());
    assert!(inverse(&vec![vec![0.0]]).is_none() && inverse(&vec![vec![f64::NAN]]).is_none());
}

#[test]
fn a_line_is_found_exactly() {
    let rows = (0..10).map(|n| (vec![1.0, f64::from(n)], 3.0 - 0.5 * f64::from(n)));
    let x = linear(rows, 2).unwrap();
    assert!((x[0] - 3.0).abs() < 1e-12 && (x[1] + 0.5).abs() < 1e-13, "{x:?}");
}

/// A decay with white, and with connected noise: the true values lie inside of the intervals as often as these say, within what so many
/// draws allow (binomial: 95 % of 200, three deviations below: 181), and the intervals are not wide for nothing.
#[test]
fn intervals_hold_what_is_true() {
    for connected in [0.0, 0.9] {
        let (mut inside, mut wide) = ([0; 2], 0.0);
        for seed in 0..200 {
            let mut noise = Noise::new(seed);
            let mut last = 0.0;
            let data: Vec<f64> = (0..600)
                .map(|n| {
                    last = connected * last + 0.05 * noise.normal();
                    2.0 * (-f64::from(n) / 100.0).exp() + last
                })
                .collect();
            let fit = descend(&[1.0, 50.0], &[1e-6, 1e-5], |p| {
                let (a, t) = (p[0], p[1]);
                (t > 1.0)
                    .then(|| data.iter().enumerate().map(|(n, x)| a * (-(n as f64) / t).exp() - x).collect())
            })
            .unwrap();
            let off = [fit.off(&[1.0, 0.0]), fit.off(&[0.0, 1.0])];
            inside[0] += usize::from((fit.values[0] - 2.0).abs() <= off[0]);
            inside[1] += usize::from((fit.values[1] - 100.0).abs() <= off[1]);
            wide += off[1] / 200.0;
            let same = fit.off_of(|p| 3.0 * p[1] - p[0]);
            assert!((same - fit.off(&[-1.0, 3.0])).abs() < 1e-6 * same);
        }
        let least = if connected > 0.0 { 185 } else { 181 };
        assert!(inside.iter().all(|n| *n >= least), "{connected}: {inside:?}");
        let due = if connected > 0.0 { 30.0 } else { 2.5 };
        assert!(wide < due, "{connected}: {wide}");
    }
}

#[test]
fn what_nothing_depends_on_is_refused() {
    assert!(
        descend(&[1.0, 1.0], &[1e-6, 1e-6], |p| Some(vec![p[0] - 3.0, p[0] + 1.0, 2.0 * p[0]])).is_none()
    );
    assert!(descend(&[1.0], &[1e-6], |_| None).is_none());
    assert!(descend(&[1.0], &[1e-6], |p| Some(vec![p[0]])).is_none());
}
