//! Width, against the Gaussian's definition.

use super::super::spread::LEAST;
use super::{Array, arrays, filled, grid, largest_difference, points, ring, vest, weights};
use crate::space::law::Law;
use crate::space::point::distance;

#[test]
fn from_half_of_the_spacing_on_it_is_a_gaussian() {
    for positions in
        [grid(4, 5, 0.06), ring(12, 0.15), vest(), (0..9).map(|n| [0.0, 0.0, 0.04 * f64::from(n)]).collect()]
    {
        let array = Array::new(&positions).unwrap();
        for (k, point) in points(&positions, 200).into_iter().enumerate() {
            if array.outside(point) > 1e-12 {
                continue;
            }
            let s = array.spacing() * [0.5, 0.7, 1.0, 3.0, 30.0][k % 5];
            let all = filled(&array, point, s, Law::Energy, &mut array.row());
            let squares: Vec<f64> = positions.iter().map(|p| distance(*p, point).powi(2)).collect();
            let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
            let gaussian: Vec<f64> = squares.iter().map(|r| ((least - r) / (2.0 * s * s)).exp()).collect();
            let cut: Vec<f64> = gaussian.iter().map(|w| (w - LEAST).max(0.0)).collect();
            let (sum, sum_cut): (f64, f64) = (gaussian.iter().sum(), cut.iter().sum());
            for (tactor, weight) in all.iter().enumerate() {
                assert!((weight - cut[tactor] / sum_cut).abs() < 1e-12, "{point:?} {tactor}: {weight}");
                let off = (weight - gaussian[tactor] / sum).abs();
                assert!(off < positions.len() as f64 * LEAST, "{point:?} {tactor}: {off}");
            }
        }
    }
}

#[test]
fn it_begins_with_the_law_between_neighbours_and_never_jumps() {
    for (name, array, positions) in arrays() {
        let mut row = array.row();
        for point in points(&positions, 60) {
            let mut last = weights(&array, point);
            let narrow = filled(&array, point, 1e-12 * array.spacing(), Law::Energy, &mut row);
            assert!(largest_difference(&last, &narrow) < 1e-9, "{name} {point:?}");
            assert!(largest_difference(&last, &filled(&array, point, 5e-324, Law::Energy, &mut row)) < 1e-9);
            // Over in 2000 steps to twice the spacing: no step may change more than some of them.
            for step in 1..=2000 {
                let next =
                    filled(&array, point, array.spacing() * f64::from(step) * 1e-3, Law::Energy, &mut row);
                let change = largest_difference(&last, &next);
                assert!(change < 0.012, "{name} {point:?} {step}: {change}");
                last = next;
            }
        }
    }
}

#[test]
fn below_that_it_is_so_much_of_each() {
    let array = Array::new(&grid(4, 5, 0.06)).unwrap();
    let point = [0.013, -0.031, 0.0];
    let own = weights(&array, point);
    let s = 0.012;
    // What is left once the share of the law between neighbours, 1 − 2 s / spacing, is taken off.
    let all = filled(&array, point, s, Law::Energy, &mut array.row());
    let positions = grid(4, 5, 0.06);
    let squares: Vec<f64> = positions.iter().map(|p| distance(*p, point).powi(2)).collect();
    let sum: f64 = squares.iter().map(|r| (-r / (2.0 * s * s)).exp()).sum();
    for tactor in 0..20 {
        let wanted = 0.6 * own[tactor] + 0.4 * (-squares[tactor] / (2.0 * s * s)).exp() / sum;
        assert!((all[tactor] - wanted).abs() < 3e-6, "{tactor}: {} {wanted}", all[tactor]);
    }
}

#[test]
fn of_no_end_it_sounds_all_alike_and_off_the_plane_it_stays_the_same() {
    for (name, array, _) in arrays() {
        for width in [1e9, 1e30, f64::INFINITY] {
            let all = filled(&array, [0.01, 0.02, 0.03], width, Law::Energy, &mut array.row());
            let sites = all.iter().filter(|w| **w > 0.0).count();
            assert_eq!(sites, array.tactors(), "{name}");
        }
    }
    let array = Array::new(&grid(4, 5, 0.06)).unwrap();
    let near = filled(&array, [0.01, 0.02, 0.0], 0.05, Law::Energy, &mut array.row());
    let far = filled(&array, [0.01, 0.02, 1e4], 0.05, Law::Energy, &mut array.row());
    assert_eq!(near, far);
}

#[test]
fn by_the_law_of_the_nearest_the_whole_spread_hops() {
    let positions = grid(4, 5, 0.06);
    let array = Array::new(&positions).unwrap();
    for point in points(&positions, 100) {
        let nearest =
            (0..20).min_by(|a, b| distance(positions[*a], point).total_cmp(&distance(positions[*b], point)));
        let all = filled(&array, point, 0.05, Law::Nearest, &mut array.row());
        let wanted = filled(&array, positions[nearest.unwrap()], 0.05, Law::Energy, &mut array.row());
        assert!(largest_difference(&all, &wanted) < 1e-12);
    }
}
