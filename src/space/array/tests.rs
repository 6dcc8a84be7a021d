//! What all arrays must keep to, on many.

mod hostile;
mod laws;
mod many;
mod width;

use super::{Array, Form, Shape};
use crate::dsp::random::uniform;
use crate::space::law::Law;
use crate::space::point::{Point, between, distance, dot, minus};
use crate::space::row::Row;
use many::{grid, many, ring, turned, vest};

/// Numbers within 0 and 1 that look random.
pub(super) fn number(stream: u64, n: u64) -> f64 {
    0.5 + 0.5 * uniform(stream, n)
}

/// A point within ±half a cube's edge.
pub(super) fn anywhere(stream: u64, n: u64, edge: f64) -> Point {
    [0, 1, 2].map(|k| (number(stream, 3 * n + k) - 0.5) * edge)
}

/// Weights by tactor, once what must hold for every row was seen to hold.
pub(super) fn filled(array: &Array, point: Point, width: f64, law: Law, row: &mut Row) -> Vec<f64> {
    array.weights(point, width, law, row);
    let mut all = vec![0.0; array.tactors()];
    for share in row.shares() {
        assert!(share.weight > 0.0 && share.weight <= 1.0 + 1e-12, "{point:?} {width}: {share:?}");
        assert_eq!(all[share.tactor as usize], 0.0, "{point:?} {width}: {} twice", share.tactor);
        all[share.tactor as usize] = share.weight;
    }
    let sum: f64 = all.iter().sum();
    assert!((sum - 1.0).abs() < 1e-12, "{point:?} {width}: {sum}");
    all
}

pub(super) fn weights(array: &Array, point: Point) -> Vec<f64> {
    filled(array, point, 0.0, Law::Energy, &mut array.row())
}

pub(super) fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

pub(super) fn arrays() -> Vec<(&'static str, Array, Vec<Point>)> {
    let made = many().into_iter().map(|(name, positions, shape)| {
        let array = Array::new(&positions).unwrap();
        assert_eq!(array.shape(), shape, "{name}");
        (name, array, positions)
    });
    made.collect()
}

/// Points within an array and around it, and some far from it.
pub(super) fn points(positions: &[Point], count: u64) -> Vec<Point> {
    let n = positions.len() as f64;
    let middle = [0, 1, 2].map(|k| positions.iter().map(|p| p[k]).sum::<f64>() / n);
    let extent = positions.iter().map(|p| distance(*p, middle)).fold(0.01, f64::max);
    let around = |k: u64| {
        let d = anywhere(5, k, extent * if k % 10 == 9 { 1e3 } else { 2.5 });
        [0, 1, 2].map(|c| middle[c] + d[c])
    };
    // Half of them between three tactors, where an array is flat.
    let among = |k: u64| {
        let [a, b, c] = [0, 1, 2].map(|j| positions[(number(6, 5 * k + j) * n) as usize % positions.len()]);
        between(a, between(b, c, number(6, 5 * k + 3)), number(6, 5 * k + 4))
    };
    (0..count).map(|k| if k % 2 == 0 { around(k) } else { among(k) }).collect()
}

#[test]
fn weights_are_one_in_sum_and_none_is_below_nothing() {
    for (_, array, positions) in arrays() {
        let mut row = array.row();
        for (k, point) in points(&positions, 400).into_iter().enumerate() {
            for law in [Law::Nearest, Law::Energy] {
                let width = array.spacing() * [0.0, 0.0, 1e-9, 0.3, 0.5, 1.0, 20.0][k % 7];
                filled(&array, point, width, law, &mut row);
            }
        }
    }
}

#[test]
fn on_a_tactor_nothing_else_sounds() {
    for (name, array, positions) in arrays() {
        for (number, position) in positions.iter().enumerate() {
            let here: Vec<usize> =
                (0..positions.len()).filter(|n| distance(positions[*n], *position) < 1e-9).collect();
            for law in [Law::Nearest, Law::Energy] {
                let all = filled(&array, *position, 0.0, law, &mut array.row());
                for (other, weight) in all.iter().enumerate() {
                    // Tactors at one place share; the nearest is the first of them.
                    let wanted = match law {
                        Law::Nearest => f64::from(other == here[0]),
                        _ if here.contains(&other) => 1.0 / here.len() as f64,
                        _ => 0.0,
                    };
                    assert!((weight - wanted).abs() <= 1e-14, "{name} {number}: {other} has {weight}");
                }
            }
        }
    }
}

#[test]
fn a_point_is_the_mean_of_the_tactors_by_their_weights() {
    for (name, array, positions) in arrays() {
        if !matches!(array.form, Form::Line(_) | Form::Surface(_)) {
            continue;
        }
        // In the array's own axes, in which a line has one and a surface two.
        let axes = if matches!(array.form, Form::Line(_)) { 1 } else { 2 };
        let mut within = 0;
        for point in points(&positions, 1000) {
            if array.outside(point) > 1e-12 {
                continue;
            }
            within += 1;
            let all = weights(&array, point);
            let mean = [0, 1, 2].map(|k| all.iter().zip(&positions).map(|(w, p)| w * p[k]).sum::<f64>());
            let off = minus(array.frame.local(mean), array.frame.local(point));
            let off = off[..axes].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            // At a rim that is nearly straight the point goes to the row.
            let most = if name == "jittered grid" {
                2e-6
            } else if name == "scattered" {
                0.02
            } else {
                1e-12
            };
            assert!(off < most, "{name} {point:?}: {off}");
        }
        assert!(within > 100, "{name}: {within}");
    }
}

#[test]
fn nothing_jumps_anywhere() {
    for (name, array, positions) in arrays() {
        let all = points(&positions, 160);
        for pair in all.windows(2) {
            let jump = jump(&array, pair[0], pair[1]);
            assert!(jump < 1e-6, "{name}, from {:?} to {:?}: {jump}", pair[0], pair[1]);
        }
        // Along the rim, a little within and without, where a path is most likely to run.
        for pair in positions.windows(2) {
            for off in [-1e-9, 1e-9, 1e-4] {
                let [a, b] = [pair[0], pair[1]].map(|p| p.map(|x| x + off));
                assert!(jump(&array, a, b) < 1e-6, "{name}, from {a:?} to {b:?}");
            }
        }
    }
}

/// The change of a weight over a piece of a way that is no longer than rounding allows: of 40 pieces the one with the largest change is
/// cut again, and again. What is continuous comes to nothing.
pub(super) fn jump(array: &Array, a: Point, b: Point) -> f64 {
    let mut row = array.row();
    let mut at = |share: f64| filled(array, between(a, b, share), 0.0, Law::Energy, &mut row);
    let (mut from, mut to, mut change) = (0.0, 1.0, 1.0);
    while to - from > 1e-13 * 40.0 {
        let mut last = at(from);
        let mut worst = (from, to, -1.0);
        for piece in 0..40 {
            let [begin, end] = [piece, piece + 1].map(|n| from + (to - from) * f64::from(n) / 40.0);
            let next = at(end);
            let change = largest_difference(&last, &next);
            if change > worst.2 {
                worst = (begin, end, change);
            }
            last = next;
        }
        (from, to, change) = worst;
        if change < 1e-7 {
            break;
        }
    }
    change
}

#[test]
fn turned_moved_and_mirrored_an_array_shares_alike() {
    for (name, array, positions) in arrays() {
        let mirrored = |points: &[Point]| points.iter().map(|p| [-p[0], p[1], p[2]]).collect::<Vec<_>>();
        let there = points(&positions, 200);
        for (positions, there) in
            [(turned(&positions), turned(&there)), (mirrored(&positions), mirrored(&there))]
        {
            let other = Array::new(&positions).unwrap();
            assert_eq!(other.shape(), array.shape(), "{name}");
            for (a, b) in points(&many_of(name), 200).iter().zip(&there) {
                let difference = largest_difference(&weights(&array, *a), &weights(&other, *b));
                assert!(difference < 1e-9 * (1.0 + dot(*a, *a).sqrt() * 10.0), "{name} {a:?}: {difference}");
            }
        }
    }
}

fn many_of(name: &str) -> Vec<Point> {
    many().into_iter().find(|(other, ..)| *other == name).map(|(_, positions, _)| positions).unwrap()
}

#[test]
fn what_comes_out_does_not_depend_on_what_was_asked_before() {
    for (name, array, positions) in arrays() {
        let mut kept = array.row();
        for point in points(&positions, 1000) {
            array.weights(point, 0.0, Law::Energy, &mut kept);
            let mut fresh = array.row();
            array.weights(point, 0.0, Law::Energy, &mut fresh);
            assert_eq!(kept.shares(), fresh.shares(), "{name} {point:?}");
            for hint in [1, 3, 17, u32::MAX] {
                fresh.hint = hint;
                array.weights(point, 0.0, Law::Energy, &mut fresh);
                assert_eq!(kept.shares(), fresh.shares(), "{name} {point:?} {hint}");
            }
        }
    }
}
