//! Each shape against its own definition.

use super::{Array, Form, filled, grid, largest_difference, number, points, ring, turned, vest, weights};
use crate::space::law::Law;
use crate::space::point::{Point, distance, dot, minus};

#[test]
fn between_two_tactors_the_published_laws_hold() {
    let array = Array::new(&[[0.1, 0.0, 0.0], [0.3, 0.0, 0.0]]).unwrap();
    for n in 0..=100 {
        let beta = f64::from(n) / 100.0;
        let all = weights(&array, [0.1 + 0.2 * beta, 7.0, -3.0]);
        assert!((all[0] - (1.0 - beta)).abs() < 1e-14 && (all[1] - beta).abs() < 1e-14);
        assert!((Law::Logarithmic.gain(all[0]) - (2.0 - beta).log2()).abs() < 1e-14);
        assert!((Law::Energy.gain(all[1]) - beta.sqrt()).abs() < 1e-7);
    }
    let half = weights(&array, [0.2, 0.0, 0.0]);
    let gains = [Law::Linear, Law::Logarithmic, Law::Energy].map(|law| law.gain(half[0]));
    for (gain, wanted) in gains.into_iter().zip([0.5, 0.584_963, 0.5_f64.sqrt()]) {
        assert!((gain - wanted).abs() < 1e-6);
    }
    assert_eq!(weights(&array, [-9.0, 1.0, 0.0]), [1.0, 0.0]);
    assert_eq!(weights(&array, [1e30, 1.0, 0.0]), [0.0, 1.0]);
}

#[test]
fn a_grid_is_bilinear_everywhere() {
    let (rows, columns, spacing) = (4, 5, 0.06);
    let positions = turned(&grid(rows, columns, spacing));
    let array = Array::new(&positions).unwrap();
    let Form::Surface(surface) = &array.form else { panic!("a grid is a surface") };
    assert_eq!(surface.count(), [0, 12, 0, 0]);
    for n in 0..2000 {
        let (x, y) = (number(1, 2 * n) * 4.0, number(1, 2 * n + 1) * 3.0);
        let point = turned(&[[(x - 2.0) * spacing, (1.5 - y) * spacing, 0.0]])[0];
        let wanted: Vec<f64> = (0..rows * columns)
            .map(|k| {
                let hat = |d: f64| (1.0 - d.abs()).max(0.0);
                hat(x - (k % columns) as f64) * hat(y - (k / columns) as f64)
            })
            .collect();
        assert!(largest_difference(&weights(&array, point), &wanted) < 1e-13, "{x} {y}");
    }
    // The middle of a cell sounds its four tactors alike.
    let middle = weights(&Array::new(&grid(4, 5, 0.06)).unwrap(), [-0.03, 0.0, 0.0]);
    for (tactor, weight) in middle.into_iter().enumerate() {
        assert!(
            (weight - if [6, 7, 11, 12].contains(&tactor) { 0.25 } else { 0.0 }).abs() < 1e-14,
            "{tactor}"
        );
    }
}

#[test]
fn a_triangle_is_barycentric_and_an_incomplete_grid_has_both() {
    let corners = [[0.0; 3], [0.1, 0.0, 0.0], [0.03, 0.08, 0.0]];
    let array = Array::new(&corners).unwrap();
    for n in 0..500 {
        let (u, v) = (number(2, 2 * n), number(2, 2 * n + 1));
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let point = [0, 1, 2].map(|k| u * corners[1][k] + v * corners[2][k]);
        assert!(largest_difference(&weights(&array, point), &[1.0 - u - v, u, v]) < 1e-13);
    }
    let mut incomplete = grid(4, 5, 0.06);
    incomplete.truncate(17);
    let array = Array::new(&incomplete).unwrap();
    let Form::Surface(surface) = &array.form else { panic!("it is a surface") };
    // The last row has two of five: nine cells, and triangles up to its end.
    let [triangles, rectangles, polygons, margins] = surface.count();
    assert!(rectangles == 9 && triangles >= 1 && polygons == 0 && margins == 0, "{:?}", surface.count());
}

#[test]
fn a_grid_measured_with_a_tape_still_is_a_grid() {
    for (error, spread) in [(1e-7, 1e-4), (1e-3, 0.12)] {
        let positions: Vec<Point> = grid(4, 5, 0.06)
            .into_iter()
            .enumerate()
            .map(|(n, [x, y, _])| {
                [
                    x + error * (number(8, 2 * n as u64) - 0.5),
                    y + error * (number(8, 2 * n as u64 + 1) - 0.5),
                    0.0,
                ]
            })
            .collect();
        let array = Array::new(&positions).unwrap();
        let Form::Surface(surface) = &array.form else { panic!("it is a surface") };
        let [triangles, rectangles, polygons, _] = surface.count();
        assert_eq!((triangles, rectangles + polygons), (0, 12), "{:?}", surface.count());
        // The middle of each cell sounds its four tactors nearly alike.
        for cell in 0..12 {
            let corner = cell / 4 * 5 + cell % 4;
            let four = [corner, corner + 1, corner + 5, corner + 6];
            let middle = [0, 1, 2].map(|k| four.iter().map(|n| positions[*n][k]).sum::<f64>() / 4.0);
            let all = weights(&array, middle);
            assert!(four.iter().all(|n| (all[*n] - 0.25).abs() < spread), "{error} {cell}: {all:?}");
        }
    }
}

#[test]
fn a_ring_is_one_cell_whose_middle_sounds_all_alike() {
    for n in [3, 5, 6, 7, 8, 12, 16, 31, 64] {
        let positions = turned(&ring(n, 0.15));
        let array = Array::new(&positions).unwrap();
        let Form::Surface(surface) = &array.form else { panic!("a ring is a surface") };
        assert_eq!(surface.count(), if n == 3 { [1, 0, 0, 0] } else { [0, 0, 1, 0] }, "{n}");
        let middle = weights(&array, turned(&[[0.0; 3]])[0]);
        assert!(middle.iter().all(|w| (w * n as f64 - 1.0).abs() < 1e-10), "{n} {middle:?}");
        // On the circle two neighbours share.
        for k in 0..10 * n {
            let angle = (k as f64 + 0.3) / (10 * n) as f64 * std::f64::consts::TAU;
            let point = turned(&[[0.15 * angle.sin(), 0.0, 0.15 * angle.cos()]])[0];
            assert_eq!(weights(&array, point).iter().filter(|w| **w > 0.0).count(), 2, "{n} {k}");
        }
    }
    // More corners than a cell may have: triangles, and nothing breaks.
    let array = Array::new(&ring(200, 0.2)).unwrap();
    weights(&array, [0.01, 0.0, 0.02]);
}

#[test]
fn outside_the_hull_counts_its_nearest_point() {
    for positions in [
        grid(4, 5, 0.06),
        ring(9, 0.1),
        (0..30).map(|n| [number(7, 2 * n), number(7, 2 * n + 1), 0.0]).collect(),
    ] {
        let array = Array::new(&positions).unwrap();
        let mut outside = 0;
        for point in points(&positions, 1500) {
            // Of all segments between tactors, the hull's nearest point lies on one; none is nearer.
            let mut best = (f64::INFINITY, [0.0; 3]);
            let normal = if positions[0][1] == 0.0 && positions[1][1] == 0.0 && positions[2][1] == 0.0 {
                1
            } else {
                2
            };
            let flat = [0, 1, 2].map(|k| if k == normal { 0.0 } else { point[k] });
            for a in &positions {
                for b in &positions {
                    let d = minus(*b, *a);
                    let t = if a == b { 0.0 } else { (dot(minus(flat, *a), d) / dot(d, d)).clamp(0.0, 1.0) };
                    let foot: Point = [0, 1, 2].map(|k| a[k] + t * d[k]);
                    if distance(foot, flat) < best.0 {
                        best = (distance(foot, flat), foot);
                    }
                }
            }
            if array.outside(point) > 1e-9 {
                outside += 1;
                assert!((array.outside(point) - best.0).abs() < 1e-9 * (1.0 + best.0), "{point:?}");
                let difference = largest_difference(&weights(&array, point), &weights(&array, best.1));
                assert!(difference < 1e-9 * (1.0 + best.0 * 1e2), "{point:?} {difference}");
            }
        }
        assert!(outside > 300, "{outside}");
    }
}

#[test]
fn the_nearest_tactor_is_the_nearest() {
    for (name, array, positions) in super::arrays() {
        for point in points(&positions, 300) {
            let all = filled(&array, point, 0.0, Law::Nearest, &mut array.row());
            let least = positions.iter().map(|p| distance(*p, point)).fold(f64::INFINITY, f64::min);
            for (tactor, weight) in all.iter().enumerate() {
                let far = distance(positions[tactor], point);
                assert!(*weight == 0.0 || far <= least * (1.0 + 1e-9) + 1e-9, "{name} {point:?} {tactor}");
            }
        }
    }
    // A point between four goes to the first of them.
    let array = Array::new(&grid(4, 5, 0.5)).unwrap();
    let all = filled(&array, [-0.25, 0.0, 0.0], 0.0, Law::Nearest, &mut array.row());
    assert_eq!(all.iter().position(|w| *w == 1.0), Some(6));
    // Far away, direction decides.
    let line = Array::new(&[[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]).unwrap();
    assert_eq!(filled(&line, [0.11, 1e12, 0.0], 0.0, Law::Nearest, &mut line.row()), [0.0, 1.0, 0.0]);
}

#[test]
fn a_cloud_shares_locally_and_alike_what_is_alike() {
    let cube: Vec<Point> = (0..8).map(|n| [n & 1, n >> 1 & 1, n >> 2].map(f64::from)).collect();
    let array = Array::new(&cube).unwrap();
    assert!(weights(&array, [0.5; 3]).iter().all(|w| (w - 0.125).abs() < 1e-15));
    let face = weights(&array, [0.5, 0.5, 0.0]);
    assert!(face[..4].iter().all(|w| (w - face[0]).abs() < 1e-15) && face[0] > 0.2, "{face:?}");
    // In front of the chest nothing is felt on the back.
    let array = Array::new(&vest()).unwrap();
    for point in [[0.0, 0.0, 0.12], [0.05, 0.1, 0.13], [0.0, 0.0, 1.0], [0.03, -0.05, 50.0]] {
        let all = weights(&array, point);
        assert!(all[20..].iter().all(|w| *w == 0.0), "{point:?}: {:?}", &all[20..]);
        assert!(all.iter().filter(|w| **w > 0.0).count() >= 2);
    }
}

#[test]
fn tactors_at_one_place_share_its_weight() {
    let mut positions = grid(2, 2, 0.06);
    positions.extend([positions[0], positions[0], positions[3]]);
    let array = Array::new(&positions).unwrap();
    let all = weights(&array, [0.0, 0.01, 0.0]);
    assert!(all[0] == all[4] && all[0] == all[5] && all[3] == all[6]);
    let plain = weights(&Array::new(&positions[..4]).unwrap(), [0.0, 0.01, 0.0]);
    assert!((3.0 * all[0] - plain[0]).abs() < 1e-15 && (all[1] - plain[1]).abs() < 1e-15);
}

#[test]
fn power_stays_the_same_along_every_motion() {
    let cloud = (0..24).map(|n| super::anywhere(9, n, 0.3)).collect();
    let line = (0..8).map(|n| [0.05 * f64::from(n), 0.0, 0.0]).collect();
    for positions in [line, grid(4, 5, 0.06), cloud, vest()] {
        let array = Array::new(&positions).unwrap();
        let mut row = array.row();
        for speed in [0.1, 1.0, 10.0, 50.0] {
            for sample in 0..8000 {
                let t = f64::from(sample) / 8000.0 * speed;
                // Through the array and out on its far side, and back.
                let point = [0.25 * (7.0 * t).sin(), 0.2 * (5.0 * t).cos(), 0.15 * (3.0 * t).sin()];
                array.weights(point, 0.0, Law::Energy, &mut row);
                let power: f64 =
                    row.shares().iter().map(|share| Law::Energy.gain(share.weight).powi(2)).sum();
                assert!((power - 1.0).abs() < 1e-12, "{point:?} {power}");
            }
        }
    }
}

/// Tactors at one place: the nearest is one of them, the first, at its whole gain; by the energy law they share the power.
#[test]
fn tactors_at_one_place() {
    for count in [2, 8, 64] {
        let mut points = vec![[0.1, 0.0, 0.0]];
        points.extend(vec![[0.0; 3]; count]);
        let array = Array::new(&points).unwrap();
        for width in [0.0, 0.01] {
            let power = |law: Law| {
                let all = filled(&array, [0.0; 3], width, law, &mut array.row());
                all.iter().map(|weight| law.gain(*weight).powi(2)).sum::<f64>()
            };
            assert!((power(Law::Energy) - 1.0).abs() < 1e-12, "{count} {width}");
            assert!((power(Law::Nearest) - 1.0).abs() < 1e-6, "{count} {width}: {}", power(Law::Nearest));
        }
        let all = filled(&array, [0.01, 0.0, 0.0], 0.0, Law::Nearest, &mut array.row());
        assert_eq!((all[1], all.iter().sum::<f64>()), (1.0, 1.0));
    }
}
