use super::{Map, POINTS};
use crate::knob::effect::Bound;
use crate::knob::governor::MARGIN;
use crate::knob::governor::device::{Delay, Device, Resonance};
use crate::knob::stability::work;
use crate::knob::velocity::choice::Choice;

fn device() -> Device {
    Device {
        inertia: 6e-6,
        damping: 2e-5,
        friction: Some(1e-3),
        count: std::f64::consts::TAU / 4000.0,
        period: 1e-4,
        delay: Delay::ticks(1.0),
        resonance: None,
        low_pass: None,
        velocity: Choice::Difference,
        peak: 0.15,
    }
}

fn ask(stiffness: f64, damping: f64) -> Option<Bound> {
    Some(Bound { stiffness, damping })
}

fn sound(svg: &str) {
    roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

/// Keeps a picture where one asks for it, to be looked at.
fn keep(name: &str, svg: &str) {
    if let Ok(folder) = std::env::var("PACINIAN_PICTURES") {
        std::fs::write(format!("{folder}/{name}.svg"), svg).unwrap();
    }
}

#[test]
fn the_edge_parts_what_rests_from_what_swings() {
    let shaft = Some(Resonance { clamped: 600.0, knob: 5e-6, loss: 6.5e-5 });
    for (delay, resonance, low_pass) in [
        (0.0, None, None),
        (1.0, None, None),
        (2.37, None, Some(800.0)),
        (32.0, None, None),
        (1.0, shaft, None),
    ] {
        let device = Device { delay: Delay::ticks(delay), resonance, low_pass, ..device() };
        let map = Map::new(&device, MARGIN, None).unwrap();
        assert!((POINTS - 2..=POINTS).contains(&map.points.len()));
        let sampled = device.sampled().unwrap().latest().cloned().unwrap();
        let mut seen = 0;
        for point in map.points.iter().step_by(12).filter(|p| p.edge.gain > 0.0) {
            let radius = |share: f64| sampled.radius(share * point.edge.gain, point.damping);
            assert!(
                radius(0.999) < 1.0 && radius(1.001) > 1.0,
                "{delay} {point:?}: {} {}",
                radius(0.999),
                radius(1.001)
            );
            seen += 1;
        }
        assert!(seen >= 6, "{delay}: {seen}");
        // Beyond the damping's edge nothing rests, with a spring or without.
        let last = map.points.last().unwrap();
        assert!(last.damping > map.damping_edge.gain && last.edge.gain == 0.0);
        assert!(sampled.radius(1e-3 * map.points[1].edge.gain, last.damping) > 1.0);
        assert!(map.points.windows(2).all(|pair| pair[0].damping < pair[1].damping));
    }
}

#[test]
fn the_operating_point_is_where_it_was_asked() {
    let map = Map::new(&device(), MARGIN, ask(0.5, 4e-5)).unwrap();
    assert_eq!(map.asked, ask(0.5, 4e-5));
    let granted = map.granted.unwrap();
    assert_eq!(granted.damping, 4e-5);
    let edge = device().sampled().unwrap().edge(4e-5).gain;
    assert!((granted.stiffness / (0.5 * edge) - 1.0).abs() < 0.02, "{} {edge}", granted.stiffness);
    assert!(map.csv().contains("asked,4.000000e-5,5.000000e-1,\n"));
    assert!(map.points.last().unwrap().damping >= 1e-4);
    let svg = map.svg("A knob at 10 kHz");
    keep("map", &svg);
    sound(&svg);
    // And on the picture: a triangle that begins 5 pixels above its place, a disc that begins 1.7 left of its own and 4.1 above.
    let document = roxmltree::Document::parse(&svg).unwrap();
    let last = |class: &str| {
        let mut shapes =
            document.descendants().filter(|n| n.has_tag_name("path") && n.attribute("class") == Some(class));
        let from = shapes.next_back().unwrap().attribute("d").unwrap().trim_start_matches('M');
        let end = from.find(['l', 'h', 'v']).unwrap();
        let mut at = from[..end].split(' ').map(|x| x.parse::<f64>().unwrap());
        (at.next().unwrap(), at.next().unwrap())
    };
    let (asked, left) = (last("fe"), last("ft"));
    let x = 96.0 + 724.0 * 4e-5 / map.points.last().unwrap().damping;
    assert!((asked.0 - x).abs() < 0.11 && (left.0 + 1.7 - x).abs() < 0.11, "{asked:?} {left:?} {x}");
    let [low, high] = map.range();
    let apart = 380.0 * (0.5 / granted.stiffness).ln() / (high / low).ln();
    assert!(((left.1 + 4.1) - (asked.1 + 5.0) - apart).abs() < 0.21, "{asked:?} {left:?} {apart}");
    // Within what is granted nothing is taken.
    let little = Map::new(&device(), MARGIN, ask(0.01, 1e-5)).unwrap();
    assert_eq!(little.granted, little.asked);
    let svg = little.svg("little");
    assert!(svg.contains("asked, and granted") && !svg.contains("what is left of it"));
}

#[test]
fn extremes_are_still_a_map() {
    let far = Delay { fixed: 1.4, block: 256, frames: 1.0, blocks: 2.0, local: None };
    let lossless = Some(Resonance { clamped: 600.0, knob: 5e-6, loss: 0.0 });
    let cases = [
        ("undamped", Device { damping: 0.0, ..device() }, None),
        ("undamped, asked", Device { damping: 0.0, delay: Delay::ticks(0.0), ..device() }, ask(1.0, 0.0)),
        ("no region", Device { damping: 0.0, resonance: lossless, ..device() }, ask(0.1, 1e-5)),
        ("friction not known", Device { friction: None, ..device() }, ask(0.4, 0.0)),
        ("without friction", Device { friction: Some(0.0), ..device() }, ask(0.4, 0.0)),
        ("endless friction", Device { friction: Some(f64::MAX), peak: f64::MAX, ..device() }, ask(0.4, 0.0)),
        ("no number", device(), ask(f64::NAN, f64::INFINITY)),
        ("less than nothing", device(), ask(-1.0, -1.0)),
        ("nothing", device(), ask(0.0, 0.0)),
        ("huge", device(), ask(1e300, 1e300)),
        ("tiny", device(), ask(1e-300, 1e-300)),
        ("fine counts", Device { count: 1e-12, ..device() }, ask(1.0, 1e-4)),
        ("coarse counts", Device { count: 1.0, ..device() }, ask(1.0, 1e-4)),
        ("far", Device { period: 1.0 / 48e3, delay: far, ..device() }, ask(0.4, 1e-6)),
        ("heavy", Device { inertia: 1e3, ..device() }, None),
        ("light", Device { inertia: 1e-12, damping: 1e3, ..device() }, None),
    ];
    for (name, device, asked) in cases {
        let map = Map::new(&device, MARGIN, asked).unwrap_or_else(|e| panic!("{name}: {e}"));
        let svg = map.svg(name);
        keep(&format!("map {name}"), &svg);
        sound(&svg);
        let csv = map.csv();
        assert!(
            csv.lines().count() > POINTS - 2 && csv.lines().all(|l| l.matches(',').count() == 3),
            "{name}"
        );
        assert!(!csv.contains("NaN") && !csv.contains("inf"), "{name}");
    }
    let off = Device { inertia: f64::NAN, ..device() };
    assert_eq!(Map::new(&off, MARGIN, None).unwrap_err().field, "inertia");
    assert_eq!(Map::new(&device(), 0.0, None).unwrap_err().field, "margin");
    assert_eq!(Map::up_to(&device(), MARGIN, None, f64::NAN).unwrap_err().field, "damping");
}

#[test]
fn an_undamped_knob_rests_by_computed_damping_alone() {
    let map = Map::new(&Device { damping: 0.0, ..device() }, MARGIN, None).unwrap();
    assert_eq!(map.points[0].edge.gain, 0.0);
    assert!(map.points[4].edge.gain > 0.0);
    assert!(map.svg("undamped").contains("no stiffness comes to rest"));
}

#[test]
fn what_binds_and_what_would_lift_it_stand_below() {
    let far = Delay { fixed: 0.0, block: 64, frames: 1.0, blocks: 2.0, local: None };
    let slow = Device { period: 1.0 / 48e3, delay: far, damping: 0.21e-3, inertia: 1e-5, ..device() };
    let map = Map::new(&slow, MARGIN, ask(0.4, 1e-4)).unwrap();
    let svg = map.svg("48 kHz, blocks of 64");
    keep("map blocks", &svg);
    assert!(svg.contains("bound by the delay") && svg.contains("block 16 would allow"), "{svg}");
}

/// The eigenvalues of a loop with 512 samples of delay take seconds, and none are computed: each edge costs a grid of 48 points a turn and
/// a few for what lies between.
#[test]
fn a_long_delay_does_not_take_long() {
    let far = Delay { fixed: 0.0, block: 256, frames: 1.0, blocks: 2.0, local: None };
    let device = Device { period: 1.0 / 48e3, delay: far, damping: 0.21e-3, inertia: 1e-5, ..device() };
    let ((map, svg), work) = work::of(|| {
        let map = Map::new(&device, MARGIN, ask(0.4, 1e-4)).unwrap();
        let svg = map.svg("512 samples");
        (map, svg)
    });
    println!("{work:?}");
    sound(&svg);
    keep("map 512", &svg);
    let edges = map.points.iter().filter(|p| p.edge.gain > 0.0).count() as u64;
    let grid = 48 * 514;
    assert!(work.points > edges * grid, "{work:?}");
    assert!(work.points < 8 * POINTS as u64 * grid, "{work:?}");
    assert!(work.eigenvalues < 16, "{work:?}");
}
