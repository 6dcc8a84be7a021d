//! What cannot be.

use super::super::program::{Any, Program};
use super::super::{
    constant, damper, detent, friction, hertz, inertia, magnet, snap, spin, spring, table, texture,
    transient, wall,
};

#[test]
fn what_cannot_be_is_refused() {
    let fault =
        |any: Any| Program::new(vec![Any::from(constant::Constant { torque: 0.0 }), any]).unwrap_err();
    let d = detent::Detent::with_stiffness(24.0, 0.1);
    let f = friction::Friction { torque: 1e-3, stretch: 0.01, law: friction::Law::Adhesion };
    let r = transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.01, least: 0.5, most: 0.05 };
    let cases: Vec<(Any, &str)> = vec![
        (spring::Spring { stiffness: -1.0, centre: 0.0 }.into(), "stiffness"),
        (spring::Spring { stiffness: 1.0, centre: f64::NAN }.into(), "centre"),
        (damper::Damper { damping: f64::INFINITY }.into(), "damping"),
        (wall::Stops { low: 1.0, high: 0.0, stiffness: 1.0, damping: 0.0 }.into(), "high"),
        (detent::Detent { count: 0.0, ..d.clone() }.into(), "count"),
        (detent::Detent { hysteresis: 0.5, ..d.clone() }.into(), "hysteresis"),
        (detent::Detent { shape: detent::Shape::Table([0.5].into()), ..d.clone() }.into(), "table"),
        (detent::Detent { shape: detent::Shape::Table([0.5, 2.0].into()), ..d }.into(), "table"),
        (snap::Snap { width: 0.1, stiffness: 1.0, most: 1.0, point: 0.4, centre: 0.0 }.into(), "point"),
        (magnet::Magnet { centre: 0.0, stiffness: 1.0, reach: 0.0 }.into(), "reach"),
        (friction::Friction { stretch: 0.0, ..f }.into(), "stretch"),
        (inertia::Inertia { inertia: 0.0, stiffness: 1.0, damping: 0.0 }.into(), "inertia"),
        (texture::Ripple { amplitude: 1.0, wavelength: 0.0 }.into(), "wavelength"),
        (texture::Fed { scale: f64::NAN }.into(), "scale"),
        (hertz::Hertz { angle: 0.0, below: false, factor: 0.0, most: 1.0 }.into(), "factor"),
        (spin::Spin { speed: 1.0, damping: 1.0, most: 0.0 }.into(), "most"),
        (transient::Transient { hertz: 19.0, ..r }.into(), "hertz"),
    ];
    for (any, field) in cases {
        let (which, fault) = fault(any);
        assert_eq!((which, fault.field), (1, field));
    }
    for (points, field) in [
        (vec![(0.0, 1.0)], "points"),
        (vec![], "points"),
        (vec![(0.0, 1.0), (0.0, 2.0)], "angle"),
        (vec![(1.0, 1.0), (0.0, 2.0)], "angle"),
        (vec![(0.0, f64::NAN), (1.0, 2.0)], "torque"),
    ] {
        assert_eq!(table::Table::new(&points).unwrap_err().field, field);
    }
    assert!(Program::new(vec![Any::from(constant::Constant { torque: 0.0 }); 65]).is_err());
}
