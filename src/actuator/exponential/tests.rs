use super::{MOST, Square, exponential};

fn square(rows: &[&[f64]]) -> Square {
    let mut a = [[0.0; MOST]; MOST];
    for (row, from) in a.iter_mut().zip(rows) {
        row[..from.len()].copy_from_slice(from);
    }
    a
}

#[test]
fn a_rotation_turns() {
    let d = exponential(&square(&[&[0.0, 1.0], &[-1.0, 0.0]]), 2, 100.0);
    assert!((d[0][0] + 1.0 - 100f64.cos()).abs() < 1e-13 && (d[0][1] - 100f64.sin()).abs() < 1e-13);
}

#[test]
fn a_chain_of_integrators_makes_powers_of_time() {
    let mut a = [[0.0; MOST]; MOST];
    for i in 0..MOST - 1 {
        a[i][i + 1] = 1.0;
    }
    let d = exponential(&a, MOST, 3.0);
    let mut expected = 1.0;
    for j in 1..MOST {
        expected *= 3.0 / j as f64;
        assert!((d[0][j] / expected - 1.0).abs() < 1e-15, "{j}: {}", d[0][j]);
        assert_eq!(d[j][0], 0.0);
    }
}

/// The column of a held input is A⁻¹(e^At − 1) b, here of a decay: (1 − e^(−t/τ)) gain.
#[test]
fn a_held_input_is_taken_along() {
    for rate in [1e-6, 1.0, 1e3, 1e9, 1e15] {
        let d = exponential(&square(&[&[-rate, 5.0 * rate], &[0.0, 0.0]]), 2, 0.01);
        let expected = -(-rate * 0.01).exp_m1();
        assert!((d[0][0] / -expected - 1.0).abs() < 1e-14, "{rate}");
        assert!((d[0][1] / (5.0 * expected) - 1.0).abs() < 1e-14, "{rate}");
    }
}

/// A fast decay that feeds a slow one: the slow eigenvalue keeps its digits however fast the other is.
#[test]
fn slow_rates_survive_beside_fast_ones() {
    for fast in [1e3, 1e7, 1e11, 1e15] {
        let a = square(&[&[-fast, 1e-3 * fast.sqrt()], &[1e-3 * fast.sqrt(), -1.0]]);
        let t = 0.01;
        // Eigenvalues of a symmetric matrix; the slow one from the product of both, so that nothing cancels.
        let half = 0.5 * (fast + 1.0);
        let quick = -half - ((0.5 * (fast - 1.0)).powi(2) + 1e-6 * fast).sqrt();
        let slow = (fast - 1e-6 * fast) / quick;
        let share = (1e-3 * fast.sqrt()).powi(2) / ((slow + fast).powi(2) + 1e-6 * fast);
        let expected = (1.0 - share) * (slow * t).exp_m1() + share * (quick * t).exp_m1();
        let is = exponential(&a, 2, t)[1][1];
        assert!((is / expected - 1.0).abs() < 1e-12, "{fast}: {is} {expected}");
    }
}

/// e^(A 2t) = (e^At)², for matrices whose units are far apart.
#[test]
fn twice_the_time_is_the_square() {
    let a = square(&[
        &[-28_000.0, 0.0, -4_800.0, 4_000.0],
        &[0.0, 0.0, 1.0, 0.0],
        &[750.0, -2.7e6, -1_300.0, 0.0],
        &[0.0, 0.0, 0.0, 0.0],
    ]);
    for t in [1e-9, 1e-5, 1e-3, 0.1] {
        let (one, two) = (exponential(&a, 4, t), exponential(&a, 4, 2.0 * t));
        for i in 0..3 {
            for j in 0..4 {
                let sum: f64 = (0..4).map(|k| one[i][k] * one[k][j]).sum();
                let expected = 2.0 * one[i][j] + sum;
                let size: f64 =
                    2.0 * one[i][j].abs() + (0..4).map(|k| (one[i][k] * one[k][j]).abs()).sum::<f64>();
                assert!(
                    (two[i][j] - expected).abs() <= 1e-13 * size,
                    "{t} {i} {j}: {} {expected}",
                    two[i][j]
                );
            }
        }
    }
}

#[test]
fn nonsense_gives_nothing() {
    let a = square(&[&[f64::NAN, 1.0], &[0.0, 1.0]]);
    assert_eq!(exponential(&a, 2, 1.0), [[0.0; MOST]; MOST]);
    assert_eq!(exponential(&square(&[&[1.0]]), 1, f64::INFINITY), [[0.0; MOST]; MOST]);
    assert_eq!(exponential(&square(&[&[1.0]]), 0, 1.0), [[0.0; MOST]; MOST]);
}

#[test]
fn no_decay_is_too_fast() {
    let d = exponential(&square(&[&[-1e300, 1.0], &[0.0, -1.0]]), 2, 1.0);
    assert_eq!((d[0][0], d[1][0]), (-1.0, 0.0));
    assert!((d[1][1] / (-1f64).exp_m1() - 1.0).abs() < 1e-12 && d[0][1].abs() < 1e-290, "{d:?}");
}
