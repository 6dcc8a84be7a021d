//! Arrays of many kinds.

use super::{anywhere, number};
use crate::space::array::Shape;
use crate::space::point::{Point, dot};

pub(in super::super) fn grid(rows: usize, columns: usize, spacing: f64) -> Vec<Point> {
    let at = |n: usize, of: usize| (n as f64 - 0.5 * (of - 1) as f64) * spacing;
    (0..rows * columns).map(|n| [at(n % columns, columns), -at(n / columns, rows), 0.0]).collect()
}

pub(in super::super) fn ring(n: usize, radius: f64) -> Vec<Point> {
    (0..n)
        .map(|k| (k as f64 / n as f64 * std::f64::consts::TAU).sin_cos())
        .map(|(s, c)| [radius * s, 0.0, radius * c])
        .collect()
}

/// Two curved panels, some 0.25 m apart: nothing flat about it.
pub(in super::super) fn vest() -> Vec<Point> {
    (0..40)
        .map(|n| {
            let (side, row, column) = (n / 20, n % 20 / 4, n % 4);
            let (s, c) = ((column as f64 - 1.5) * 0.45).sin_cos();
            let z = 0.125 * c;
            [0.14 * s, 0.12 - 0.06 * row as f64, if side == 0 { z } else { -z }]
        })
        .collect()
}

/// Turned and moved.
pub(in super::super) fn turned(points: &[Point]) -> Vec<Point> {
    let turn = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    points.iter().map(|p| turn.map(|axis| 0.37 + dot(axis, *p))).collect()
}

/// Names, positions and shapes of arrays of many kinds.
pub(in super::super) fn many() -> Vec<(&'static str, Vec<Point>, Shape)> {
    let mut incomplete = grid(4, 5, 0.06);
    incomplete.remove(7);
    incomplete.truncate(17);
    let mut coincident = grid(3, 3, 0.05);
    coincident.extend([coincident[4], coincident[4], coincident[0]]);
    let scattered: Vec<Point> =
        (0..40).map(|n| [0.2 * number(1, 2 * n), 0.3 * number(1, 2 * n + 1), 0.0]).collect();
    let jittered: Vec<Point> = grid(4, 5, 0.06)
        .into_iter()
        .enumerate()
        .map(|(n, p)| {
            let d = anywhere(2, n as u64, 2e-7);
            [p[0] + d[0], p[1] + d[1], p[2] + d[2]]
        })
        .collect();
    let sagging = grid(4, 5, 0.06).into_iter().map(|[x, y, _]| [x, y, 0.5 * x * x]).collect();
    let trapezoid = vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [-0.5, 1.0, 0.0]];
    let uneven =
        [0.0_f64, 0.5, 1.7, 2.1, 3.5, 5.0].map(|angle| [0.1 * angle.cos(), 0.1 * angle.sin(), 0.0]).to_vec();
    let mut staggered = grid(8, 8, 0.01);
    staggered.extend(grid(8, 8, 0.01).iter().map(|p| [p[0] + 0.005, p[1] + 0.005, 0.004]));
    vec![
        ("one", vec![[0.1, 0.2, 0.3]], Shape::One),
        ("all at one place", vec![[0.1, 0.2, 0.3]; 5], Shape::One),
        ("two", vec![[0.0; 3], [0.0, 0.04, 0.0]], Shape::Line),
        ("line", [0.0, 0.03, 0.07, 0.08, 0.2].map(|x| [x, 2.0 * x, -x]).to_vec(), Shape::Line),
        (
            "bent line",
            (0..9).map(|n| [0.05 * f64::from(n), 0.002 * f64::from(n % 3), 0.0]).collect(),
            Shape::Line,
        ),
        ("triangle", vec![[0.0; 3], [0.1, 0.0, 0.0], [0.03, 0.08, 0.0]], Shape::Surface),
        ("grid", grid(4, 5, 0.06), Shape::Surface),
        ("two rows", grid(2, 40, 0.02), Shape::Surface),
        ("turned grid", turned(&grid(4, 5, 0.06)), Shape::Surface),
        ("incomplete grid", turned(&incomplete), Shape::Surface),
        ("jittered grid", jittered, Shape::Surface),
        ("sagging grid", sagging, Shape::Surface),
        (
            "curved panel",
            grid(4, 5, 0.06).into_iter().map(|[x, y, _]| [x, y, 1.8 * x * x]).collect(),
            Shape::Surface,
        ),
        (
            "roof",
            grid(11, 21, 0.01).into_iter().map(|[x, y, _]| [x, y, 0.49 * x.abs()]).collect(),
            Shape::Cloud,
        ),
        ("trapezoid", trapezoid, Shape::Surface),
        ("scattered", scattered, Shape::Surface),
        ("ring", ring(12, 0.15), Shape::Surface),
        ("ring with a middle", ring(7, 0.15).into_iter().chain([[0.0; 3]]).collect(), Shape::Surface),
        ("coincident", coincident, Shape::Surface),
        ("lens", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.005, 0.0], [0.5, -0.004, 0.0]], Shape::Surface),
        ("uneven ring", uneven, Shape::Surface),
        ("staggered layers", staggered, Shape::Cloud),
        ("vest", vest(), Shape::Cloud),
        ("cube", (0..8).map(|n| [n & 1, n >> 1 & 1, n >> 2].map(f64::from)).collect(), Shape::Cloud),
        (
            "two layers",
            grid(3, 3, 0.05).into_iter().flat_map(|[x, y, _]| [[x, y, 0.0], [x, y, 4e-3]]).collect(),
            Shape::Cloud,
        ),
        ("cloud", (0..30).map(|n| anywhere(3, n, 0.4)).collect(), Shape::Cloud),
    ]
}
