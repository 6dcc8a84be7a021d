use super::super::Style;
use super::view::Views;
use super::{BINS, Map, Site};
use crate::space::layout::{Hand, Layout, grid, hand, ring, sleeve, vest};

fn sites(positions: &[[f64; 3]]) -> Vec<Site> {
    positions
        .iter()
        .enumerate()
        .map(|(n, at)| Site { name: format!("t{n}"), channel: n, position: *at })
        .collect()
}

fn views(layout: &Layout) -> Views {
    Views::new(&sites(&layout.positions()))
}

/// A tone on one channel after the other, for a second each.
fn tones(channels: usize, rate: f64, seconds: usize) -> Vec<f32> {
    let of = |n: usize| {
        let t = n as f64 / rate;
        let x = (std::f64::consts::TAU * 50.0 * t).sin() as f32;
        (0..channels)
            .map(move |c| if c == t as usize % channels { x * (c + 1) as f32 / channels as f32 } else { 0.0 })
    };
    (0..seconds * rate as usize).flat_map(of).collect()
}

#[test]
fn strengths_are_those_of_the_samples() {
    let rate = 8000.0;
    let mut map = Map::new(&sites(&[[0.0; 3], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]), 3, rate);
    map.push(&tones(3, rate, 6));
    assert_eq!(map.seconds(), 6.0);
    for site in 0..3 {
        let rms = (site + 1) as f64 / 3.0 * 0.5_f64.sqrt();
        for second in 0..6 {
            let (from, to) = (second as f64 + 0.1, second as f64 + 0.9);
            let found = map.strength(site, from, to);
            let wanted = if second % 3 == site { rms } else { 0.0 };
            assert!((found - wanted).abs() < 0.01, "{site} {second}: {found} {wanted}");
        }
        // A third of the time.
        assert!((map.strength(site, 0.0, 6.0) - rms / 3.0_f64.sqrt()).abs() < 1e-3);
    }
    assert_eq!(map.strength(7, 0.0, 1.0), 0.0);
    assert_eq!(map.strength(0, 1.0, 1.0), 0.0);
    assert_eq!(map.strength(0, f64::NAN, 1.0), 0.0);
}

#[test]
fn memory_is_bounded_and_nothing_is_lost() {
    let mut map = Map::new(&sites(&[[0.0; 3]]), 1, 10.0);
    for _ in 0..40 {
        map.push(&[1.0; 1000]);
    }
    assert!(map.squares[0].len() <= BINS);
    assert!((map.strength(0, 0.0, 4000.0) - 1.0).abs() < 1e-12);
    assert!((map.strength(0, 1234.5, 1300.25) - 1.0).abs() < 1e-12);
}

#[test]
fn pieces_do_not_matter_and_what_is_no_number_is_told() {
    let mut frames = tones(2, 4000.0, 2);
    frames[777] = f32::NAN;
    frames[1001] = f32::INFINITY;
    let of = |cuts: &[usize]| {
        let mut map = Map::new(&sites(&[[0.0; 3], [0.1, 0.0, 0.0]]), 2, 4000.0);
        let mut rest = frames.as_slice();
        for cut in cuts.iter().cycle() {
            let (now, later) = rest.split_at(rest.len().min(*cut));
            map.push(now);
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        [map.frames(&Style::new("t"), 9), map.animated(&Style::new("t"))]
    };
    let whole = of(&[usize::MAX]);
    assert_eq!(whole, of(&[1]));
    assert_eq!(whole, of(&[333, 2, 4097]));
    assert!(whole[0].contains("counted as 0: 2"));
}

/// What is flat has one view, what goes around something two; each tactor is in one of them, once, and right is right.
#[test]
fn views_show_every_tactor_once() {
    let layouts = [
        (grid(4, 5, 0.03).unwrap(), 1, ["x", "y"]),
        (ring(12, 0.1).unwrap(), 1, ["x", "z"]),
        (sleeve(4, 6).unwrap(), 2, ["x", "z"]),
        (vest(), 2, ["x", "y"]),
    ];
    for (layout, count, axes) in layouts {
        let views = views(&layout);
        assert_eq!((views.list.len(), views.axes), (count, axes), "{}", layout.title);
        let mut seen: Vec<usize> =
            views.list.iter().flat_map(|view| view.tactors.iter().map(|(n, _)| *n)).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..layout.tactors.len()).collect::<Vec<_>>(), "{}", layout.title);
        let axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name).unwrap();
        for (n, at) in views.list.iter().flat_map(|view| &view.tactors) {
            let position = layout.tactors[*n].position;
            let first = layout.tactors[0].position;
            let origin = views.list.iter().flat_map(|v| &v.tactors).find(|(m, _)| *m == 0).unwrap().1[1];
            assert!((at[1] - origin - (position[axis(axes[1])] - first[axis(axes[1])])).abs() < 1e-12);
            assert!(at.iter().zip(views.size).all(|(x, size)| (-1e-12..=size + 1e-12).contains(x)));
        }
    }
    assert_eq!(views(&vest()).list.iter().map(|view| view.label).collect::<Vec<_>>(), ["ahead", "behind"]);
    assert_eq!(views(&hand(Hand::Right)).list.len(), 1);
}
