//! What nobody should do to an array.

use super::super::{FARTHEST, MOST_TACTORS};
use super::{Array, Shape, anywhere, filled, grid, jump, number, points};
use crate::space::fault::Fault;
use crate::space::law::Law;
use crate::space::point::Point;

#[test]
fn positions_that_cannot_be_are_refused() {
    assert_eq!(Array::new(&[]).unwrap_err(), Fault::NoTactor);
    assert_eq!(Array::new(&vec![[0.0; 3]; MOST_TACTORS + 1]).unwrap_err(), Fault::TooMany(MOST_TACTORS + 1));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.001 * FARTHEST] {
        let positions = [[0.0; 3], [0.0, bad, 0.0]];
        assert!(matches!(Array::new(&positions), Err(Fault::Position(1, _))), "{bad}");
    }
}

#[test]
fn points_that_are_no_numbers_give_numbers() {
    for (name, array, _) in super::arrays() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 5e-324] {
            for k in 0..3 {
                let mut point = [0.01, -0.02, 0.03];
                point[k] = bad;
                for width in [0.0, 0.02, bad] {
                    for law in Law::ALL {
                        let all = filled(&array, point, width, law, &mut array.row());
                        if bad.is_nan() {
                            let mut zero = point;
                            zero[k] = 0.0;
                            let wanted = filled(&array, zero, width.max(0.0), law, &mut array.row());
                            assert_eq!(all, wanted, "{name}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn lines_may_tremble_as_they_like() {
    for exponent in 3..=12 {
        let tremble = 10_f64.powi(-exponent);
        for count in [3, 10, 60] {
            let positions: Vec<Point> = (0..count)
                .map(|n| {
                    let [x, y, z] = anywhere(u64::from(exponent.unsigned_abs()), n, tremble);
                    [0.05 * n as f64 + x, 0.03 * n as f64 + y, z]
                })
                .collect();
            let array = Array::new(&positions).unwrap();
            assert_eq!(array.shape(), Shape::Line);
            check(&array, &positions);
        }
        // Two rows so near to each other that some of them are all but one.
        let rows: Vec<Point> =
            (0..20).map(|n| [0.05 * f64::from(n / 2), tremble * f64::from(n % 2), 0.0]).collect();
        check(&Array::new(&rows).unwrap(), &rows);
    }
}

#[test]
fn grids_may_tremble_as_they_like() {
    for exponent in 2..=16 {
        let tremble = 10_f64.powi(-exponent);
        for turn in 0..3 {
            let positions: Vec<Point> = grid(6, 7, 0.06)
                .into_iter()
                .enumerate()
                .map(|(n, [x, y, _])| {
                    let d = anywhere(40 + turn, n as u64, tremble);
                    let (s, c) = (turn as f64 * 0.7).sin_cos();
                    [c * x - s * y + d[0], s * x + c * y + d[1], d[2]]
                })
                .collect();
            let array = Array::new(&positions).unwrap();
            assert_eq!(array.shape(), Shape::Surface, "{tremble} {turn}");
            check(&array, &positions);
            // Along the rim, a nanometre outside, every tactor of the row is passed.
            if tremble < 2e-4 && turn == 0 {
                let mut heard = [0.0_f64; 7];
                for step in 0..=600 {
                    let all = super::weights(&array, [-0.18 + 6e-4 * f64::from(step), 0.15 + tremble, 0.0]);
                    (0..7).for_each(|n| heard[n] = heard[n].max(all[n]));
                }
                assert!(heard.iter().all(|most| *most > 0.98), "{tremble}: {heard:?}");
            }
        }
    }
}

#[test]
fn distances_may_be_of_any_size() {
    for unit in [5e-324, 1e-310, 1e-30, 1e-10, 1e-8, 1.0, 1e3, 2e5] {
        let grid: Vec<Point> = grid(3, 4, 1.0).iter().map(|p| p.map(|x| x * unit)).collect();
        let line: Vec<Point> = (0..5).map(|n| [0.0, f64::from(n) * unit, 0.0]).collect();
        let cloud: Vec<Point> = (0..12).map(|n| anywhere(8, n, unit)).collect();
        for positions in [grid, line, cloud] {
            check(&Array::new(&positions).unwrap(), &positions);
        }
    }
    // A hand here and a foot on the moon's orbit, as it were.
    let positions =
        [[0.0; 3], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [1e5, 2e5, 0.0], [1e5, 2e5, 1e-3], [-1e6, 0.0, 1e6]];
    check(&Array::new(&positions).unwrap(), &positions);
}

#[test]
fn four_thousand_tactors_are_an_array() {
    let flat: Vec<Point> = (0..4096).map(|n| [number(1, 2 * n), number(1, 2 * n + 1), 0.0]).collect();
    let clustered = flat.iter().map(|p| [p[0].powi(8), p[1].powi(8), 0.0]).collect();
    let cloud = (0..4096).map(|n| anywhere(2, n, 1.0)).collect();
    let even = grid(64, 64, 0.01);
    for (positions, shape) in
        [(flat, Shape::Surface), (clustered, Shape::Surface), (even, Shape::Surface), (cloud, Shape::Cloud)]
    {
        let array = Array::new(&positions).unwrap();
        assert_eq!(array.shape(), shape);
        let mut row = array.row();
        for point in points(&positions, 200) {
            filled(&array, point, 0.0, Law::Energy, &mut row);
        }
        for n in (0..4096).step_by(97) {
            let all = filled(&array, positions[n], 0.0, Law::Energy, &mut row);
            assert!((all[n] - 1.0).abs() < 1e-12, "{n}: {}", all[n]);
        }
    }
}

/// All that holds for every array, on this one.
fn check(array: &Array, positions: &[Point]) {
    let mut row = array.row();
    let all = points(positions, 60);
    for (k, point) in all.iter().enumerate() {
        for law in [Law::Nearest, Law::Energy] {
            let width = array.spacing() * [0.0, 0.2, 2.0][k % 3];
            filled(array, *point, width, law, &mut row);
        }
    }
    for pair in all.windows(2).take(12) {
        let jump = jump(array, pair[0], pair[1]);
        // Distinct places that are nearer than 1e-4 of the extent share so steeply that rounding shows.
        let least = if array.spacing() < 1e-4 * array.frame.unit { 1e-1 } else { 1e-5 };
        assert!(jump < least, "{:?} from {:?} to {:?}: {jump}", array.shape(), pair[0], pair[1]);
    }
}
