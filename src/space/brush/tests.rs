use super::{Burst, MEASURED, SHORTEST_FLANK, Stroke};
use crate::dsp::random::uniform;
use crate::space::apparent::onset;
use crate::space::array::Array;
use crate::space::fault::Fault;
use crate::space::law::Law;
use crate::space::path::{Path, Timing};
use crate::space::point::{Point, distance};

/// Three rows of four: x 0, 1.5, 3, 4.5, y 0, 1.5, 3.
fn published() -> Vec<Point> {
    (0..12).map(|n| [1.5 * f64::from(n % 4), 1.5 * f64::from(n / 4), 0.0]).collect()
}

fn stroke(positions: &[Point], points: &[Point], seconds: f64) -> Stroke {
    let path = Path::new(points, seconds, Timing::Linear).unwrap();
    Stroke::new(&Array::new(positions).unwrap(), &path).unwrap()
}

/// The tactors that sound in a burst, with their gains.
fn gains(positions: &[Point], burst: &Burst) -> Vec<(u32, f64)> {
    let array = Array::new(positions).unwrap();
    let mut row = array.row();
    array.weights(burst.place, 0.0, Law::Energy, &mut row);
    row.shares().iter().map(|share| (share.tactor, Law::Energy.gain(share.weight))).collect()
}

#[test]
fn the_published_example_comes_out() {
    let stroke = stroke(&published(), &[[1.0, 3.0, 0.0], [4.5, 1.0, 0.0]], 1.0);
    // Arrival, start, duration in ms; two tactors by column and row, with their gains.
    let wanted = [
        (0.0, 0.0, 72.3918, [(0, 2, 0.577_350), (1, 2, 0.816_497)]),
        (142.857, 70.4654, 398.527, [(1, 1, 0.436_436), (1, 2, 0.899_735)]),
        (571.429, 245.294, 593.592, [(2, 1, 0.872_872), (2, 2, 0.487_950)]),
        (750.0, 482.543, 558.798, [(2, 1, 0.763_763), (3, 1, 0.645_497)]),
        (1000.0, 708.659, 291.341, [(3, 0, 0.577_350), (3, 1, 0.816_497)]),
    ];
    assert_eq!((stroke.bursts.len(), stroke.left_out.len()), (5, 0));
    for (burst, (arrival, start, duration, gains)) in stroke.bursts.iter().zip(wanted) {
        assert!((burst.arrival() * 1e3 - arrival).abs() < 1e-3, "{burst:?}");
        assert!((burst.start * 1e3 - start).abs() < 1e-3, "{burst:?}");
        assert!((burst.seconds() * 1e3 - duration).abs() < 1e-3, "{burst:?}");
        let found = self::gains(&published(), burst);
        assert_eq!(found.len(), 2);
        for (column, row, gain) in gains {
            let here = found.iter().find(|(tactor, _)| *tactor == row * 4 + column).unwrap();
            assert!((here.1 - gain).abs() < 1e-5, "{here:?}");
        }
    }
    assert!((stroke.seconds() - 1.0).abs() < 1e-12 && stroke.outside < 1e-12);
    // All but the first are longer than what was measured.
    assert_eq!((stroke.unmeasured(), MEASURED), (4, (0.04, 0.2)));
    assert!((stroke.range().1 - 0.593_592).abs() < 1e-6);
}

#[test]
fn every_onset_keeps_to_the_law_and_every_peak_to_the_path() {
    let arrays: Vec<Vec<Point>> = vec![
        published(),
        (0..8).map(|n| [f64::from(n), 0.0, 0.0]).collect(),
        (0..25).map(|n| [0, 1, 2].map(|k| 2.0 + 2.0 * uniform(n, k))).collect(),
    ];
    for (which, positions) in arrays.iter().enumerate() {
        let array = Array::new(positions).unwrap();
        for n in 0..200 {
            let points: Vec<Point> =
                (0..2 + n % 3).map(|k| [0, 1, 2].map(|c| 2.0 + 3.0 * uniform(100 + n, 3 * k + c))).collect();
            let seconds = 0.06 * 1.02_f64.powi(n as i32);
            let timing = if n % 2 == 0 { Timing::Linear } else { Timing::Smooth };
            let path = Path::new(&points, seconds, timing).unwrap();
            let stroke = Stroke::new(&array, &path).unwrap();
            let bursts = &stroke.bursts;
            assert!(bursts.len() >= 2);
            assert_eq!((bursts[0].start, bursts[0].rise, bursts[bursts.len() - 1].fall), (0.0, 0.0, 0.0));
            assert_eq!(
                [bursts[0].place, bursts[bursts.len() - 1].place],
                [points[0], points[points.len() - 1]]
            );
            for pair in bursts.windows(2) {
                let soa = pair[1].start - pair[0].start;
                assert!((soa - onset(pair[0].seconds())).abs() < 1e-12, "{which} {n} {pair:?}");
                assert!((pair[0].fall - pair[1].rise).abs() < 1e-12);
                assert!(pair[0].arrival() < pair[1].arrival() && soa > 0.0);
                assert!(bursts.len() == 2 || pair[0].fall >= SHORTEST_FLANK * (1.0 - 1e-12), "{pair:?}");
            }
            for burst in bursts {
                assert!(distance(path.at(burst.arrival()), burst.place) < 1e-6, "{which} {n}");
            }
            assert!((stroke.seconds() - seconds).abs() < 1e-12);
        }
    }
}

#[test]
fn virtual_points_are_where_edges_are_crossed() {
    // Along a row from tactor to tactor: they themselves.
    let row = stroke(&published(), &[[0.0, 1.5, 0.0], [4.5, 1.5, 0.0]], 2.0);
    let places: Vec<f64> = row.bursts.iter().map(|burst| burst.place[0]).collect();
    assert_eq!(places.len(), 4, "{places:?}");
    assert!(places.iter().zip([0.0, 1.5, 3.0, 4.5]).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!(row.bursts.iter().all(|burst| gains(&published(), burst).len() == 1));
    // Through a tactor cornerwise: it is crossed by four edges, and is one point.
    let diagonal = stroke(&published(), &[[0.0, 0.0, 0.0], [3.0, 3.0, 0.0]], 2.0);
    assert_eq!(diagonal.bursts.len(), 3);
    // Over a line, off it: at its tactors.
    let line: Vec<Point> = (0..5).map(|n| [0.1 * f64::from(n), 0.0, 0.0]).collect();
    let over = stroke(&line, &[[-0.05, 0.2, 0.0], [0.35, -0.2, 0.1]], 2.0);
    let wanted = [-0.05, 0.0, 0.1, 0.2, 0.3, 0.35];
    assert_eq!(over.bursts.len(), wanted.len());
    assert!(over.bursts.iter().zip(wanted).all(|(burst, x)| (burst.place[0] - x).abs() < 1e-12));
    assert!((over.outside - 0.05).abs() < 1e-12);
    // Along a grid, outside of it: where the nearest point of the hull passes a tactor.
    let along = stroke(&published(), &[[0.5, 4.0, 0.0], [5.5, 4.0, 0.0]], 2.0);
    let places: Vec<f64> = along.bursts.iter().map(|burst| burst.place[0]).collect();
    assert_eq!(places.len(), 5, "{places:?}");
    assert!(places.iter().zip([0.5, 1.5, 3.0, 4.5, 5.5]).all(|(a, b)| (a - b).abs() < 1e-9), "{places:?}");
    assert!((along.outside - 2.0_f64.sqrt()).abs() < 1e-9);
    // Within one cell no edge is crossed, though the lines that leave its corners outward would, backward.
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.3, 0.0]];
    assert_eq!(stroke(&corners, &[[0.3, 0.08, 0.0], [0.7, 0.1, 0.0]], 2.0).bursts.len(), 2);
    // Over a cloud: steps of its spacing.
    let cube: Vec<Point> = (0..8).map(|n| [n & 1, n >> 1 & 1, n >> 2].map(f64::from)).collect();
    assert_eq!(stroke(&cube, &[[0.0; 3], [3.5, 0.0, 0.0]], 2.0).bursts.len(), 5);
    // At one tactor alone there are only the ends.
    assert_eq!(stroke(&cube[..1], &[[0.0; 3], [3.5, 0.0, 0.0]], 2.0).bursts.len(), 2);
}

#[test]
fn a_stroke_too_fast_for_its_points_has_fewer() {
    let line: Vec<Point> = (0..10).map(|n| [0.1 * f64::from(n), 0.0, 0.0]).collect();
    let ends = [line[0], line[9]];
    let fast = stroke(&line, &ends, 0.1);
    assert_eq!((fast.bursts.len(), fast.left_out.len()), (2, 8));
    // Two bursts of (T − 47.3 ms) / 1.32.
    assert!(fast.bursts.iter().all(|burst| (burst.seconds() - 0.0527 / 1.32).abs() < 1e-12));
    let path = |seconds| Path::new(&ends, seconds, Timing::Linear).unwrap();
    let array = Array::new(&line).unwrap();
    let fault = Stroke::new(&array, &path(0.0473)).unwrap_err();
    assert!(
        matches!(fault, Fault::TooFast(seconds, least) if seconds == 0.0473 && (least - 0.0473).abs() < 1e-15)
    );
    assert!(Stroke::new(&array, &path(0.0474)).is_ok());
    // The slower, the more points: all of them from some time on, and never one twice.
    let mut last = 2;
    for n in 0..400 {
        let stroke = Stroke::new(&array, &path(0.05 + 0.002 * f64::from(n))).unwrap();
        assert_eq!(stroke.bursts.len() + stroke.left_out.len(), 10);
        assert!(stroke.bursts.len() + 1 >= last, "{n}: {last} and then {}", stroke.bursts.len());
        last = stroke.bursts.len();
    }
    assert_eq!(last, 10);
}

#[test]
fn a_path_that_rests_and_begins_late_keeps_its_times() {
    let line: Vec<Point> = (0..3).map(|n| [0.1 * f64::from(n), 0.0, 0.0]).collect();
    let path = Path::new(&[line[0], line[1], line[2]], 0.0, Timing::At(vec![0.5, 1.0, 3.0])).unwrap();
    let stroke = Stroke::new(&Array::new(&line).unwrap(), &path).unwrap();
    let arrivals: Vec<f64> = stroke.bursts.iter().map(|burst| burst.arrival()).collect();
    assert!(arrivals.iter().zip([0.5, 1.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{arrivals:?}");
    assert!((stroke.bursts[0].start - 0.5).abs() < 1e-15 && (stroke.seconds() - 3.0).abs() < 1e-12);
}

/// To and fro over a line so often that it passes more tactors than a stroke may have bursts.
#[test]
fn it_has_an_end() {
    let line: Vec<Point> = (0..5).map(|k| [0.05 * f64::from(k), 0.0, 0.0]).collect();
    let array = Array::new(&line).unwrap();
    let of = |times: usize| {
        let points: Vec<Point> = (0..=times).map(|n| [0.2 * (n % 2) as f64, 0.0, 0.0]).collect();
        Stroke::new(&array, &Path::new(&points, times as f64, Timing::Linear).unwrap())
    };
    assert!(of(1000).is_ok_and(|stroke| stroke.bursts.len() > 3000));
    assert!(matches!(of(1100), Err(Fault::TooManyBursts(4401, 4096))), "{:?}", of(1100).err());
    assert!(matches!(of(9000), Err(Fault::TooManyBursts(..))));
}
