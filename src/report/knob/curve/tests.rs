use super::Curve;
use crate::knob::effect::detent::Detent;
use crate::knob::effect::friction::{Friction, Law};
use crate::knob::effect::program::Any;
use crate::knob::effect::snap::Snap;
use crate::knob::effect::spring::Spring;
use crate::knob::effect::wall::Stops;

const SNAP: Snap = Snap { width: 0.3, stiffness: 0.05, most: 1.0, point: 0.75, centre: 0.0 };
const RUB: Friction = Friction { torque: 2e-3, stretch: 0.01, law: Law::Adhesion };

fn of(effects: Vec<Any>, range: [f64; 2]) -> Curve {
    Curve::new(effects, range, 801).unwrap()
}

fn sound(name: &str, curve: &Curve) {
    let svg = curve.svg(name);
    roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(svg.len() < 60_000, "{}", svg.len());
    if let Ok(folder) = std::env::var("PACINIAN_PICTURES") {
        std::fs::write(format!("{folder}/curve {name}.svg"), svg).unwrap();
    }
}

#[test]
fn torque_is_the_energy_s_slope() {
    let stops = Stops { low: -0.6, high: 0.6, stiffness: 0.4, damping: 1e-3 };
    let curve = of(vec![Detent::with_stiffness(24.0, 0.1).into(), stops.into()], [-0.7, 0.7]);
    assert!(!curve.remembers() && curve.loss().abs() < 1e-12);
    let most = curve.points().iter().fold(0.0, |m: f64, p| m.max(p.forward.abs()));
    for w in curve.points().windows(3) {
        let slope = (w[2].energy - w[0].energy) / (w[2].angle - w[0].angle);
        // Of second order, but for the corner at a stop.
        assert!((slope + w[1].forward).abs() < 0.02 * most, "{:?}", w[1]);
    }
    sound("Detents and stops", &curve);
}

#[test]
fn what_remembers_is_another_on_the_way_back() {
    let curve = of(vec![SNAP.into()], [-0.5, 0.5]);
    assert!(curve.remembers());
    // From the place at 0 it snaps at 0.75 widths: 0.225 forward, and back at 0.3 − 0.225.
    let jump = |of: &dyn Fn(&super::Point) -> f64, from: f64| {
        let w = curve.points().windows(2).filter(|w| w[0].angle > from);
        let mut w = w.filter(|w| (of(&w[1]) - of(&w[0])).abs() > 5e-3);
        w.next().unwrap()[1].angle
    };
    assert!((jump(&|p| p.forward, 0.0) - 0.225).abs() < 3e-3);
    assert!((jump(&|p| p.backward, 0.0) - 0.075).abs() < 3e-3);
    assert!(curve.loss() > 0.0);
    sound("Snap", &curve);
}

/// Sliding there and back over a range R takes 2 f_c (R − 2 z_max): at each turn the point of adhesion stays for 2 z_max.
#[test]
fn friction_takes_its_torque_times_the_way() {
    let curve = of(vec![RUB.into()], [0.0, 1.0]);
    assert!((curve.loss() / (2.0 * 2e-3 * (1.0 - 0.02)) - 1.0).abs() < 1e-3, "{}", curve.loss());
    let middle = curve.points()[400];
    assert_eq!((middle.forward, middle.backward, middle.energy), (-2e-3, 2e-3, 0.0));
    let spring = Spring { stiffness: 0.02, centre: 0.5 };
    sound("Friction on a spring", &of(vec![RUB.into(), spring.into()], [0.0, 1.0]));
}

#[test]
fn extremes_are_still_a_curve_or_refused() {
    sound("nothing", &of(Vec::new(), [0.0, 1.0]));
    let steep = Detent::with_stiffness(1e4, 1e3);
    sound("many", &Curve::new(vec![steep.into()], [-10.0, 10.0], 50_000).unwrap());
    sound("far", &of(vec![SNAP.into()], [-1e6, 1e6]));
    for (range, points, field) in [
        ([1.0, 0.0], 100, "to"),
        ([f64::NAN, 0.0], 100, "from"),
        ([0.0, f64::INFINITY], 100, "to"),
        ([0.0, 1.0], 1, "points"),
        ([0.0, 1.0], 1_000_000, "points"),
    ] {
        assert_eq!(Curve::new(Vec::new(), range, points).unwrap_err().1.field, field);
    }
    let bad = Friction { stretch: 0.0, ..RUB };
    let (which, fault) = Curve::new(vec![SNAP.into(), bad.into()], [0.0, 1.0], 10).unwrap_err();
    assert_eq!((which, fault.field), (1, "stretch"));
    let csv = of(vec![RUB.into()], [0.0, 1.0]).csv();
    assert_eq!(csv.lines().count(), 802);
    assert!(csv.lines().all(|line| line.matches(',').count() == 3));
}
