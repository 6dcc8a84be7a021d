use super::{Group, Hand, Layout, belt, grid, hand, line, ring, sleeve, vest};
use crate::space::array::{Array, Shape};
use crate::space::fault::Fault;
use crate::space::point::{Point, distance};
use std::collections::BTreeSet;

fn all() -> Vec<(Layout, usize, Shape)> {
    vec![
        (grid(4, 5, 0.06).unwrap(), 20, Shape::Surface),
        (grid(1, 1, 0.06).unwrap(), 1, Shape::One),
        (line(8, 0.04).unwrap(), 8, Shape::Line),
        (ring(12, 0.15).unwrap(), 12, Shape::Surface),
        (ring(4, 0.03).unwrap(), 4, Shape::Surface),
        (belt(8).unwrap(), 8, Shape::Surface),
        (vest(), 40, Shape::Cloud),
        (sleeve(5, 6).unwrap(), 30, Shape::Cloud),
        (hand(Hand::Left), 13, Shape::Surface),
        (hand(Hand::Right), 13, Shape::Surface),
    ]
}

fn at(layout: &Layout, name: &str) -> Point {
    layout.tactors.iter().find(|tactor| tactor.name == name).unwrap_or_else(|| panic!("{name}")).position
}

#[test]
fn every_layout_is_an_array_with_names_of_its_own() {
    for (layout, count, shape) in all() {
        let title = &layout.title;
        assert_eq!(layout.tactors.len(), count, "{title}");
        assert_eq!(Array::new(&layout.positions()).unwrap().shape(), shape, "{title}");
        let names = layout.tactors.iter().map(|tactor| &tactor.name);
        let names: Vec<&String> = names.chain(layout.groups.iter().map(|group| &group.name)).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{title}: {names:?}");
        for name in names {
            let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(name.chars().all(fine) && name.starts_with(|c: char| c.is_ascii_lowercase()), "{name}");
        }
        for Group { name, tactors } in &layout.groups {
            assert!(!tactors.is_empty() && tactors.windows(2).all(|p| p[0] < p[1]), "{title} {name}");
            assert!(tactors.iter().all(|tactor| *tactor < count));
        }
        for (n, tactor) in layout.tactors.iter().enumerate() {
            // Written with four digits, it is read back as it was.
            for x in tactor.position {
                assert_eq!(format!("{x:.4}").parse::<f64>().unwrap(), x, "{title} {}", tactor.name);
                assert!(x != 0.0 || x.is_sign_positive());
            }
            for other in &layout.tactors[n + 1..] {
                assert!(
                    distance(tactor.position, other.position) > 0.01,
                    "{title} {} {}",
                    tactor.name,
                    other.name
                );
            }
        }
        assert!(!layout.notes.is_empty() && layout.notes.iter().all(|note| note.ends_with('.')));
    }
}

#[test]
fn halves_are_mirrors_and_what_is_in_the_middle_is_in_none() {
    for (layout, ..) in all() {
        for (below, above, k) in [
            ("left", "right", 0),
            ("left-half", "right-half", 0),
            ("lower", "upper", 1),
            ("back", "front", 2),
            ("back-half", "front-half", 2),
        ] {
            let (Some(below), Some(above)) = (layout.group(below), layout.group(above)) else { continue };
            assert_eq!(below.tactors.len(), above.tactors.len(), "{} {}", layout.title, below.name);
            for tactor in &below.tactors {
                let p = layout.tactors[*tactor].position;
                assert!(p[k] < 0.0);
                let mut mirrored = p;
                mirrored[k] = -p[k];
                // A vest tapers: what is upper is narrower.
                let near = if layout.title.starts_with("Vest") && k == 1 { 0.02 } else { 1.1e-4 };
                let found =
                    above.tactors.iter().any(|n| distance(layout.tactors[*n].position, mirrored) < near);
                assert!(found, "{} {} {p:?}", layout.title, below.name);
            }
            let middle = layout.tactors.iter().filter(|tactor| tactor.position[k] == 0.0).count();
            assert_eq!(2 * below.tactors.len() + middle, layout.tactors.len(), "{}", layout.title);
        }
    }
}

#[test]
fn a_grid_is_numbered_from_its_top_left() {
    let layout = grid(4, 4, 0.06).unwrap();
    // As the rig of the back array has it.
    for (name, x, y) in
        [("r1c1", -0.09, 0.09), ("r1c4", 0.09, 0.09), ("r2c3", 0.03, 0.03), ("r4c1", -0.09, -0.09)]
    {
        assert_eq!(at(&layout, name), [x, y, 0.0], "{name}");
    }
    assert_eq!(layout.group("r2").unwrap().tactors, [4, 5, 6, 7]);
    assert_eq!(layout.group("c2").unwrap().tactors, [1, 5, 9, 13]);
    assert_eq!(layout.group("upper").unwrap().tactors, (0..8).collect::<Vec<_>>());
    assert_eq!(at(&line(3, 0.05).unwrap(), "t1"), [-0.05, 0.0, 0.0]);
}

#[test]
fn a_ring_begins_in_front_and_goes_to_the_right() {
    let layout = belt(8).unwrap();
    // As the rig of the belt has it, whose second number is what is ahead.
    for (name, x, ahead) in [
        ("front", 0.0, 0.15),
        ("front-right", 0.127, 0.106),
        ("right", 0.18, 0.0),
        ("back", 0.0, -0.15),
        ("left", -0.18, 0.0),
    ] {
        assert!(distance(at(&layout, name), [x, 0.0, ahead]) < 5e-4, "{name}");
    }
    let names: Vec<&str> = layout.tactors.iter().map(|tactor| tactor.name.as_str()).collect();
    assert_eq!(&names[..3], ["front", "front-right", "right"]);
    assert_eq!(layout.group("right-half").unwrap().tactors, [1, 2, 3]);
    let twelve = ring(12, 0.1).unwrap();
    assert_eq!((at(&twelve, "t1"), at(&twelve, "t4")), ([0.0, 0.0, 0.1], [0.1, 0.0, 0.0]));
    assert!(twelve.tactors.iter().all(|t| (distance(t.position, [0.0; 3]) - 0.1).abs() < 1e-4));
}

#[test]
fn a_vest_lies_around_a_trunk() {
    let layout = vest();
    assert_eq!(
        (layout.tactors[0].name.as_str(), layout.tactors[39].name.as_str()),
        ("front-r1c1", "back-r5c4")
    );
    assert!(at(&layout, "front-r1c1")[0] < 0.0 && at(&layout, "back-r1c1")[0] < 0.0, "both from the left");
    assert!(at(&layout, "front-r1c2")[2] > 0.11 && at(&layout, "back-r1c2")[2] < -0.11);
    for row in 1..=5 {
        let names: Vec<Point> = (1..=4).map(|c| at(&layout, &format!("front-r{row}c{c}"))).collect();
        // 60 mm around are a little less straight across.
        let steps: Vec<f64> = names.windows(2).map(|p| distance(p[0], p[1])).collect();
        assert!(steps.iter().all(|d| (0.058..0.0602).contains(d)), "{steps:?}");
        assert!(names[0][2] < names[1][2] - 0.01, "it curves");
    }
    assert!((at(&layout, "front-r1c1")[1] - at(&layout, "front-r5c1")[1] - 0.213).abs() < 1.1e-4);
    let mut both = layout.group("front-left").unwrap().tactors.clone();
    both.extend(&layout.group("back-left").unwrap().tactors);
    assert_eq!(both, layout.group("left").unwrap().tactors);
    assert_eq!(layout.group("r3").unwrap().tactors.len(), 8);
}

#[test]
fn a_sleeve_tapers_to_the_hand() {
    let layout = sleeve(4, 6).unwrap();
    let radius = |name: &str| at(&layout, name)[1].hypot(at(&layout, name)[0]);
    assert!(at(&layout, "r1a1")[2] > at(&layout, "r4a1")[2] && radius("r1a1") < radius("r4a1"));
    assert!((radius("r1a2") * std::f64::consts::TAU - 0.1772).abs() < 1e-3);
    assert!(at(&layout, "r1a1")[1] > 0.0 && at(&layout, "r1a1")[0] == 0.0, "on top");
    assert!(at(&layout, "r1a2")[0] > 0.0, "then to the right");
    assert_eq!(layout.group("a1").unwrap().tactors, [0, 6, 12, 18]);
    assert_eq!(layout.group("hand-side").unwrap().tactors.len(), 12);
}

#[test]
fn hands_are_mirrors_of_each_other() {
    let (left, right) = (hand(Hand::Left), hand(Hand::Right));
    for (a, b) in left.tactors.iter().zip(&right.tactors) {
        assert_eq!(a.name, b.name);
        assert_eq!([-a.position[0] + 0.0, a.position[1], a.position[2]], b.position, "{}", a.name);
    }
    // Palm down, the right thumb points to the left.
    assert!(at(&right, "thumb-tip")[0] < at(&right, "index-tip")[0]);
    assert!(at(&right, "middle-tip")[2] > at(&right, "ring-tip")[2] && at(&right, "heel")[2] > 0.0);
    assert_eq!(right.group("tips").unwrap().tactors, [0, 1, 2, 3, 4]);
    assert_eq!(right.group("index").unwrap().tactors.len(), 2);
}

/// Nothing is printed that a rig cannot hold.
#[test]
fn what_no_rig_can_hold_is_refused() {
    assert!(matches!(line(1024, 10.0), Err(Fault::Range("position", ..))));
    assert!(line(200, 10.0).is_ok());
    assert!(matches!(ring(1024, 0.001), Err(Fault::OnePlace(..))));
    assert!(ring(8, 0.001).is_ok());
}

#[test]
fn what_cannot_be_built_is_refused() {
    let name = |layout: Result<Layout, Fault>| match layout {
        Err(Fault::Range(name, ..)) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(name(grid(0, 5, 0.06)), "rows");
    assert_eq!(name(grid(33, 32, 0.06)), "rows × columns");
    assert_eq!(name(grid(usize::MAX, usize::MAX, 0.06)), "rows");
    for bad in [0.0, f64::NAN, f64::INFINITY, -0.1, 11.0] {
        assert_eq!(name(grid(2, 2, bad)), "spacing");
        assert_eq!(name(ring(5, bad)), "radius");
    }
    assert_eq!(
        (name(line(0, 0.1)), name(ring(2, 0.1)), name(belt(2)), name(sleeve(0, 4)), name(sleeve(3, 2))),
        ("tactors", "tactors", "tactors", "rows", "around")
    );
    assert!(grid(32, 32, 0.01).is_ok() && sleeve(1, 3).is_ok());
}
