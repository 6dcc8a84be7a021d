//! Eigenvalues, one by one.

use super::super::roots::Characteristic;
use super::super::sampled::{Loop, Shaft};
use super::{J, rigid};
use crate::dsp::complex::Complex;

/// Radii of the reference trajectories `knob_k2_*`, computed there with 50 digits.
#[test]
fn the_spectral_radius_is_that_of_the_reference() {
    for (rate, delay, b, radius) in [
        (1000.0, 0.0, 0.0, 1.016_530_045_465_127),
        (1000.0, 0.0, 2e-5, 1.014_855_441_835_992_6),
        (1000.0, 1.0, 0.0, 1.046_487_016_105_973),
        (1000.0, 1.0, 2e-5, 1.044_856_532_547_532),
        (1000.0, 2.0, 0.0, 1.068_806_462_256_171_7),
        (1000.0, 2.0, 2e-5, 1.067_271_417_121_78),
        (10_000.0, 0.0, 0.0, 1.000_166_652_780_092),
        (10_000.0, 0.0, 2e-5, 0.999_999_990_742_283_8),
        (10_000.0, 1.0, 0.0, 1.000_499_597_829_888_4),
        (10_000.0, 1.0, 2e-5, 1.000_332_991_210_633),
        (10_000.0, 2.0, 2e-5, 1.000_664_886_598_066),
        (48_000.0, 0.0, 0.0, 1.000_007_233_770_132_6),
        (48_000.0, 0.0, 2e-5, 0.999_972_512_066_996_4),
        (48_000.0, 1.0, 2e-5, 0.999_986_979_429_353_8),
        (48_000.0, 2.0, 2e-5, 1.000_001_445_494_206_4),
    ] {
        let got = rigid(b, rate, delay).radius(0.4, 0.0);
        assert!((got - radius).abs() < 1e-13, "{rate} {delay} {b}: {got} {radius}");
        // Without losses and delay: sqrt(1 + K T² / 2 J).
        if b == 0.0 && delay == 0.0 {
            assert!((got - (1.0 + 0.4 / (rate * rate) / (2.0 * J)).sqrt()).abs() < 1e-14);
        }
    }
}

fn determinant(m: &[Vec<f64>], z: Complex) -> Complex {
    let n = m.len();
    let mut a: Vec<Vec<Complex>> =
        m.iter().map(|row| row.iter().map(|x| Complex::from(-*x)).collect()).collect();
    (0..n).for_each(|i| a[i][i] = a[i][i] + z);
    let mut product = Complex::from(1.0);
    for i in 0..n {
        let pivot = (i..n).max_by(|p, q| a[*p][i].abs().total_cmp(&a[*q][i].abs())).unwrap();
        if pivot != i {
            a.swap(pivot, i);
            product = -product;
        }
        product = product * a[i][i];
        if a[i][i].abs() == 0.0 {
            return Complex::default();
        }
        for k in i + 1..n {
            let factor = a[k][i] / a[i][i];
            for l in i..n {
                a[k][l] = a[k][l] - factor * a[i][l];
            }
        }
    }
    product
}

/// The matrix is built from the state's step, the roots from polynomials.
#[test]
fn the_roots_are_the_eigenvalues_of_the_matrix() {
    let shaft = Shaft { motor: 0.95e-6, knob: 5.05e-6, clamped: 600.0, loss: 6.57e-5, damping: 2e-5 };
    for (rate, delay, k, b) in [
        (1000.0, 0.0, 0.4, 0.0),
        (10_000.0, 1.0, 0.4, 1e-5),
        (10_000.0, 2.37, 1.4, 3e-5),
        (48_000.0, 20.5, 0.4, 2e-5),
    ] {
        let two = Loop::shaft(&shaft, 1.0 / rate, delay).unwrap();
        for l in [rigid(2e-5, rate, delay), two] {
            let m = l.matrix(k, b).unwrap();
            let roots = l.eigenvalues(k, b);
            assert!(roots.len() <= m.len());
            for z in roots.iter().filter(|z| z.abs() > 0.3) {
                let aside = determinant(&m, *z + 1e-5).abs();
                assert!(determinant(&m, *z).abs() < 1e-5 * aside, "{rate} {delay}: {z:?}");
            }
            // And there is none besides: their product and that of the rest is the determinant's argument over the circle.
            let outside = roots.iter().filter(|z| z.abs() > 1.0).count();
            let mut turned = 0.0;
            let steps = 40_000;
            let mut last = determinant(&m, Complex::from(1.0));
            for i in 1..=steps {
                let next =
                    determinant(&m, Complex::turned(std::f64::consts::TAU * f64::from(i) / f64::from(steps)));
                turned += (next / last).angle();
                last = next;
            }
            let inside = (turned / std::f64::consts::TAU).round() as usize;
            assert_eq!(inside + outside, m.len(), "{rate} {delay}");
        }
    }
}

#[test]
fn roots_of_a_known_equation() {
    // z⁵⁰⁰ = 0.5 has 500 roots on one circle.
    let c =
        Characteristic { delayed: vec![1.0], lag: 500, fed_back: vec![-0.5], ..Characteristic::default() };
    let roots = c.roots();
    assert_eq!(roots.len(), 500);
    let radius = 0.5f64.powf(1.0 / 500.0);
    let mut angles: Vec<f64> = roots.iter().map(|w| (*w + 1.0).angle()).collect();
    angles.sort_by(f64::total_cmp);
    assert!(roots.iter().all(|w| ((*w + 1.0).abs() - radius).abs() < 1e-14));
    assert!(angles.windows(2).all(|p| (p[1] - p[0] - std::f64::consts::TAU / 500.0).abs() < 1e-12));
}
